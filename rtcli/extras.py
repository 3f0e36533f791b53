"""Optional packages: named with the command that installs them when they are missing."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType


class MissingExtraError(OSError):
    """An optional package is not installed."""


def need(module: str, extra: str, purpose: str) -> ModuleType:
    """Import a module of an optional package.

    Parameters
    ----------
    module
        Its name, such as `OpenEXR`.
    extra
        The extra of rtcli that brings it, such as `exr`.
    purpose
        What it is needed for, as the beginning of a sentence: `writing .exr files`.

    Raises
    ------
    MissingExtraError
        If it is not installed; the message says what to do.
    """
    try:
        return import_module(module)
    except ImportError as error:
        message = f"{purpose} needs {module}, which is not installed: pip install 'rtcli[{extra}]'"
        raise MissingExtraError(message) from error
