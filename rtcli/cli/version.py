"""The version of rtcli, with the commit in a development build."""

from __future__ import annotations

from pathlib import Path

from rtcli import __version__

_ROOT = Path(__file__).resolve().parents[2]


def version() -> str:
    """Return the version; in a checkout also the commit, with `-dirty` if files differ from it."""
    if not ((_ROOT / ".git").exists() and (_ROOT / "pyproject.toml").exists()):
        return __version__
    import subprocess  # takes longer to import than most commands need

    describe = ["git", "-C", str(_ROOT), "describe", "--always", "--dirty", "--exclude=*", "--abbrev=9"]
    try:
        result = subprocess.run(describe, capture_output=True, text=True, check=True, timeout=10)
    except (OSError, subprocess.SubprocessError):  # no git, or a checkout that another user owns
        return __version__
    return f"{__version__} ({result.stdout.strip()})"
