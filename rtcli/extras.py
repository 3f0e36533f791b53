"""Optional packages: what most people do not need, and is imported when it is asked for."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType


class MissingExtraError(OSError):
    """An optional package is not installed, or cannot be loaded."""


def require_extra(module: str, extra: str, purpose: str) -> ModuleType:
    """Import a module of an optional package.

    Parameters
    ----------
    module
        Its name, which is that of its package but for `_` in place of `-`.
    extra
        The extra of rtcli that installs it, as `pyproject.toml` names it.
    purpose
        What needs it, as the message starts: `reading EXR`.

    Raises
    ------
    MissingExtraError
        If it is not installed, with how to install it; or cannot be loaded, with the reason.
    """
    top = module.partition(".")[0]
    package = top.replace("_", "-")
    try:
        return import_module(module)
    except Exception as error:  # a package that is broken raises anything
        if isinstance(error, ModuleNotFoundError) and error.name == top:
            message = f"{purpose} needs the package {package}: pip install 'rtcli[{extra}]'"
        else:
            message = f"{purpose} needs the package {package}, which is installed but cannot be loaded: {error}"
        raise MissingExtraError(message) from error
