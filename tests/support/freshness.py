"""Whether the compiled module is as new as its sources: tests of an old one say nothing about the new code."""

from collections.abc import Iterable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def native_sources(crate: Path = ROOT / "tracer") -> list[Path]:
    """Return the files that the compiled module is built from; none where there are no sources."""
    crates = (crate, crate / "python", crate / "reader")
    manifests = [crate / "Cargo.lock", *(each / "Cargo.toml" for each in crates)]
    code = [path for each in crates for path in (each / "src").rglob("*.rs")]
    # A file of unit tests is not part of the module.
    return sorted(path for path in [*manifests, *code] if path.is_file() and path.name != "tests.rs")


def newest_change(module: Path, sources: Iterable[Path]) -> Path | None:
    """Return the newest of the sources that are newer than the compiled module, or None."""
    built = module.stat().st_mtime_ns
    newer = [path for path in sources if path.stat().st_mtime_ns > built]
    return max(newer, key=lambda path: (path.stat().st_mtime_ns, path), default=None)


def _shown(path: Path) -> Path:
    return path.relative_to(ROOT) if ROOT in path.parents else path


class FreshnessReport:
    """A plugin of pytest that warns of an outdated compiled module, before the tests and after them.

    Parameters
    ----------
    module
        The compiled module.
    sources
        What it is built from.
    """

    def __init__(self, module: Path, sources: Iterable[Path]) -> None:
        changed = newest_change(module, sources)
        self._warning = changed and (
            f"the compiled module is older than {_shown(changed)}: these tests run the code from before that "
            "change. Run `make dev` first."
        )

    @pytest.hookimpl(tryfirst=True)
    def pytest_report_header(self):
        return f"WARNING: {self._warning}" if self._warning else None

    @pytest.hookimpl(trylast=True)
    def pytest_terminal_summary(self, terminalreporter):
        if self._warning:
            terminalreporter.section("OUTDATED COMPILED MODULE", sep="!", red=True, bold=True)
            terminalreporter.line(f"WARNING: {self._warning}", red=True, bold=True)
