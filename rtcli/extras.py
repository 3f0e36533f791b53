"""Optional dependencies, imported on first use."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

# By the name of each extra, a module of its package, and the feature that needs it.
EXTRAS = {
    "exr": ("OpenEXR", "reading and writing EXR"),
    "flip": ("flip_evaluator", "comparing pictures with FLIP"),
    "preview": ("textual_image", "showing pictures in the terminal"),
    "dask": ("distributed", "rendering on a Dask cluster"),
}


class MissingExtraError(OSError):
    """An optional package is not installed, or cannot be loaded."""


def require_extra(module: str, extra: str, purpose: str) -> ModuleType:
    """Import a module of an optional package.

    Parameters
    ----------
    module
        The module. Its package has the same name, with `-` for `_`.
    extra
        The extra of rtcli that installs the package, as in `pyproject.toml`.
    purpose
        The feature that needs it, which starts the error message: `reading EXR`.

    Raises
    ------
    MissingExtraError
        If the package is not installed, with the command that installs it; or cannot be loaded, with the reason.
    """
    top = module.partition(".")[0]
    package = top.replace("_", "-")
    try:
        return import_module(module)
    except Exception as error:  # a broken package may raise anything
        if isinstance(error, ModuleNotFoundError) and error.name == top:
            message = f"{purpose} needs the package {package}: pip install 'rtcli[{extra}]'"
        else:
            message = f"{purpose} needs the package {package}, which is installed but cannot be loaded: {error}"
        raise MissingExtraError(message) from error
