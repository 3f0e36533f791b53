"""The native tracer: a `World` as the compiled module takes it, and what that gives as arrays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import TYPE_CHECKING, Any

from rtcli.tracer._native import METER_GRID, BudgetExceededError, Tracer, WorkBudget
from rtcli.tracer.passes import new_arrays
from rtcli.tracer.world import Lights, MeterReading, Progress, Shapes, Window, World

if TYPE_CHECKING:
    from rtcli.tracer.passes import Arrays

# Steps of work to find the coverage, about a second's on two cores: 100,000 spheres apart from each other take a
# sixth.
_COVERAGE_STEPS = 120_000_000


class NativeTracer:
    """A world made ready for the compiled tracer, which works with so many threads."""

    def __init__(self, world: World, threads: int) -> None:
        camera, settings = world.camera, world.settings
        self._tracer = Tracer(
            (
                camera.width,
                camera.height,
                camera.half_height,
                camera.pixel_aspect,
                camera.center,
                camera.position,
                camera.right,
                camera.up,
                camera.forward,
            ),
            _columns(world.shapes),
            _columns(world.lights),
            (settings.samples, settings.background, settings.max_depth > 0, settings.eye_falloff),
            threads,
        )

    def film(
        self, window: Window, passes: tuple[str, ...] = (), progress: Progress | None = None
    ) -> tuple[Arrays, int]:
        """Return radiance and passes by name, and the number of rays."""
        arrays = new_arrays(passes, window)
        return arrays, self._tracer.film(window, arrays, progress)

    def levels(
        self, window: Window, transform: tuple[float, str, int], budget: WorkBudget | None = None
    ) -> bytearray:
        """Return the developed picture, a small one: red, green and blue of each pixel, row by row.

        Raises
        ------
        rtcli.tracer._native.BudgetExceededError
            If it is more work than the budget allows.
        """
        return self._tracer.levels(window, transform, budget)

    def coverage(self, window: Window) -> list[int] | None:
        """Return of each object how many pixel centres of a window it covers, what others hide included.

        Returns
        -------
        list of int or None
            None if it is too much work, of objects whose outlines are too many and too long.
        """
        try:
            return self._tracer.coverage(window, WorkBudget(_COVERAGE_STEPS))
        except BudgetExceededError:
            return None

    def exposure(self, grid: int = METER_GRID, budget: WorkBudget | None = None) -> MeterReading:
        """Return what the meter finds for the whole picture, with fewer points if a rough result will do.

        Raises
        ------
        rtcli.tracer._native.BudgetExceededError
            If it is more work than the budget allows.
        """
        return MeterReading(*self._tracer.exposure(grid, budget))

    def picture(
        self,
        window: Window,
        transform: tuple[float, str, int],
        texts: list[tuple[str, str]],
        write: Callable[[bytes], Any],
        progress: Progress | None = None,
    ) -> tuple[int, dict[str, float]]:
        """Write a PNG piece by piece; return the number of rays, and the seconds of all threads in each stage.

        `texts` are keywords, and what the file tells under them.
        """
        rays, trace, develop, encode = self._tracer.picture(window, transform, texts, write, progress)
        return rays, {"trace": trace, "develop": develop, "write": encode}


def _columns(rows: Shapes | Lights) -> tuple[bytes, ...]:
    return tuple(getattr(rows, field.name).tobytes() for field in fields(rows))
