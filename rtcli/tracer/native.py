"""The native tracer: pass a `World` to the compiled module, and return arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from rtcli.tracer._native import COVERAGE_STEPS, METER_GRID, BudgetExceededError, Tracer, WorkBudget
from rtcli.tracer.passes import RADIANCE, new_arrays
from rtcli.tracer.world import CameraFrame, Checkers, Lights, MeterReading, Progress, Shapes, Window, World

if TYPE_CHECKING:
    from rtcli.tracer.passes import Arrays


class NativeTracer:
    """A world prepared for the compiled tracer, and the number of threads to trace it with."""

    def __init__(self, world: World, threads: int) -> None:
        self._tracer = Tracer(*world_parts(world), threads)

    def film(
        self, window: Window, passes: tuple[str, ...] = (), progress: Progress | None = None
    ) -> tuple[Arrays, int]:
        """Return radiance and passes by name, and the number of rays."""
        arrays = new_arrays((RADIANCE, *passes), window)
        return arrays, self._tracer.film(window, arrays, progress)

    def passes(self, window: Window, names: Iterable[str], progress: Progress | None = None) -> Arrays:
        """Return passes by name, the same as a film's, without the work for radiance."""
        arrays = new_arrays(names, window)
        self._tracer.film(window, arrays, progress)
        return arrays

    def levels(
        self, window: Window, transform: tuple[float, str, int], budget: WorkBudget | None = None
    ) -> bytearray:
        """Return the developed picture, a small one: red, green and blue of each pixel, row by row.

        Raises
        ------
        rtcli.tracer._native.BudgetExceededError
            If the budget does not suffice.
        """
        return self._tracer.levels(window, transform, budget)

    def coverage(self, window: Window) -> list[int] | None:
        """Return the number of pixel centers that each object covers, including those hidden by others.

        Returns
        -------
        list of int or None
            None if counting takes too long: the outlines are too many and too long.
        """
        try:
            return self._tracer.coverage(window, WorkBudget(COVERAGE_STEPS))
        except BudgetExceededError:
            return None

    def exposure(self, grid: int = METER_GRID, budget: WorkBudget | None = None) -> MeterReading:
        """Meter the whole picture; a smaller grid gives a rough result.

        Raises
        ------
        rtcli.tracer._native.BudgetExceededError
            If the budget does not suffice.
        """
        return MeterReading(*self._tracer.exposure(grid, budget))

    def picture(
        self,
        window: Window,
        transform: tuple[float, str, int],
        texts: list[tuple[str, str]],
        write: Callable[[bytes], Any],
        progress: Progress | None = None,
        compress: str = "fast",
    ) -> tuple[int, dict[str, float]]:
        """Write a PNG piece by piece; return the number of rays, and the seconds of all threads in each stage.

        `texts` are the keywords and values to store in the file, `compress` its compression, `fast` or `small`.
        """
        rays, trace, develop, encode = self._tracer.picture(window, transform, (texts, compress), write, progress)
        return rays, {"trace": trace, "develop": develop, "write": encode}


def world_parts(world: World) -> tuple[Any, Any, Any, Any, Any]:
    """Return a world as the compiled module takes it: camera, objects, checkers, lights and settings."""
    settings = world.settings
    return (
        camera_numbers(world.camera),
        _columns(world.shapes),
        _columns(world.checkers),
        _columns(world.lights),
        (
            settings.samples,
            settings.background,
            settings.ambient,
            settings.max_depth > 0,
            settings.shadow_samples,
            settings.eye_falloff,
        ),
    )


def camera_numbers(camera: CameraFrame) -> tuple[Any, ...]:
    """Return a camera as the compiled module takes it."""
    return (
        camera.width,
        camera.height,
        camera.projection,
        camera.half_height,
        camera.pixel_aspect,
        camera.center,
        camera.position,
        camera.right,
        camera.up,
        camera.forward,
    )


def _columns(rows: Shapes | Checkers | Lights) -> tuple[bytes, ...]:
    # A view is one of all its bytes, which are passed without a copy.
    return tuple(bytes(column.obj if isinstance(column, memoryview) else column) for column in rows)
