"""Optional dependencies, imported on first use."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

# By the name of each extra, a module of its package, and the feature that needs it.
EXTRAS = {
    "exr": ("OpenEXR", "reading and writing EXR"),
    "flip": ("flip_evaluator", "comparing pictures with FLIP"),
    "preview": ("textual_image", "showing pictures in the terminal"),
    "dask": ("distributed", "rendering on a Dask cluster"),
    "hdf5": ("h5py", "writing HDF5"),
    "parquet": ("pyarrow", "writing Parquet"),
}


class MissingExtraError(OSError):
    """An optional package is not installed, or cannot be loaded."""


def install_command(package: str) -> str:
    """Return the command that installs a package where rtcli is installed."""
    is_pipx = Path(sys.prefix, "pipx_metadata.json").exists()  # its environments have no pip of their own
    return f"pipx inject rtcli {package}" if is_pipx else f"pip install {package}"


def require_extra(module: str, purpose: str) -> ModuleType:
    """Import a module of an optional package.

    Parameters
    ----------
    module
        The module. Its package has the same name, with `-` for `_`.
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
            message = f"{purpose} needs the package {package}: {install_command(package)}"
        else:
            message = f"{purpose} needs the package {package}, which is installed but cannot be loaded: {error}"
        raise MissingExtraError(message) from error
