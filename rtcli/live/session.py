"""The state of one scene while it is edited: the last good picture, and the problems of the file as it is now."""

from __future__ import annotations

import contextlib
import shlex
import threading
import time
from collections.abc import Iterator
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NoReturn

from rtcli.live.camera import camera_of
from rtcli.live.details import Details, changed_objects, lights_of, objects_of, problems_text
from rtcli.live.rendering import Rendering, render, small_picture
from rtcli.live.view import MAX_RAYS, RequestError, View
from rtcli.live.watch import GRACE, SETTLED, FileWatcher, Version
from rtcli.rendering.load import load
from rtcli.rendering.pack import PackedScene
from rtcli.rendering.stopwatch import Stopwatch
from rtcli.scene.diagnostics.problems import Problem, SceneError
from rtcli.scene.overrides import Overrides

# The status of the file: its picture is shown, or is on its way, or the last good one is shown.
OK, RENDERING, INVALID, MISSING = "ok", "rendering", "invalid", "missing"

# Seconds for which a picture waits for the details of its scene, so that one event tells of both.
_PATIENCE = 0.015

# Seconds after which a picture that is not nearly finished is shown small first; the seconds that a small one takes.
_LONG, _SHORT = 0.15, 0.04

# Views that are kept: two for the pictures beside each other, and two for a camera that moves.
_VIEWS = 4


class Superseded(Exception):  # noqa: N818 - not an error
    """The work is of no use any more: the file changed, or the session ended."""


@dataclass(frozen=True, eq=False)
class Good:
    """A version of the file that is a valid scene.

    Parameters
    ----------
    version
        The number of the state that first showed it.
    raw
        The bytes of the file.
    scene
        The scene as numbers.
    rendering
        Its film and its picture; None while only a small picture is there.
    png
        The picture, or the small one that stands in for it.
    shown
        When the picture was there, as hours, minutes and seconds.
    milliseconds
        From the save to the event.
    details
        What the file says beside its numbers, when they are known.
    before
        The good version that this one replaced, as numbers.
    """

    version: int
    raw: bytes
    scene: PackedScene
    rendering: Rendering | None
    png: bytes
    shown: str
    milliseconds: float
    details: Future[Details]
    before: PackedScene | None = None
    views: dict[View, Rendering] = field(default_factory=dict)

    @property
    def known_details(self) -> Details | None:
        """The details if they are known already."""
        is_known = self.details.done() and self.details.exception() is None
        return self.details.result() if is_known else None

    @cached_property
    def changed(self) -> list[int]:
        """The indices of the objects that this version changed or added."""
        return changed_objects(self.scene, self.before)


@dataclass(frozen=True)
class State:
    """Everything that a page shows, at one time.

    Parameters
    ----------
    version
        Counts the states.
    status
        Of the file as it is now.
    raw
        Its bytes; None if it cannot be read.
    problems
        Its errors, or its warnings.
    report
        Why it is not shown, if the problems do not say it.
    good, previous
        The last version that is a valid scene, and the one before it.
    """

    version: int = 0
    status: str = RENDERING
    raw: bytes | None = None
    problems: tuple[Problem, ...] = ()
    report: str = ""
    good: Good | None = None
    previous: Good | None = None


class Session:
    """Follows a scene file, and keeps its state.

    Parameters
    ----------
    path
        The file, as given on the command line.
    overrides
        The changes that options make to the scene.
    """

    def __init__(self, path: str, overrides: Overrides | None = None) -> None:
        self.path = path
        self.overrides = overrides or Overrides()
        self.stopped = threading.Event()
        self.changed = threading.Condition()
        self._state = State()
        self._watcher = FileWatcher(path, self.stopped)
        self._thread = threading.Thread(target=self._follow, name="follow", daemon=True)
        self._tracing = threading.Lock()
        self._seconds_per_ray: float | None = None

    def start(self) -> None:
        """Start to follow the file."""
        self._thread.start()

    def stop(self, seconds: float = 0.5) -> None:
        """End all work, and wait for that for some seconds."""
        self.stopped.set()
        with self.changed:
            self.changed.notify_all()
        self._thread.join(seconds)

    @property
    def state(self) -> State:
        """The current state."""
        return self._state

    def wait(self, version: int, seconds: float) -> State:
        """Return the state once its version is another one, or after some seconds."""
        with self.changed:
            self.changed.wait_for(lambda: self._state.version != version or self.stopped.is_set(), seconds)
            return self._state

    # --- What requests ask for ---------------------------------------------------------------------------

    def good(self, which: str = "current") -> Good:
        """Return a good version: `current`, `previous`, or that of a number.

        Raises
        ------
        RequestError
            If it is not there, or not any more.
        """
        state = self._state
        for name, good in (("current", state.good), ("previous", state.previous)):
            if good is not None and which in (name, str(good.version)):
                return good
        raise RequestError("there is no picture yet" if state.good is None else f"version {which} is not kept")

    def rendering(self, good: Good, view: View) -> Rendering:
        """Return a view of a good version; a few are kept.

        Raises
        ------
        RequestError
            If the view is too much work.
        Superseded
            If the session ends meanwhile.
        """
        if view.traced == View() and good.rendering is not None:
            base = good.rendering
        else:
            with self._tracing:
                base = good.views.get(view.traced) or render(good.scene, view.traced, self._until_stopped)
                good.views[view.traced] = base
                while len(good.views) > _VIEWS:
                    del good.views[next(iter(good.views))]
        return base if view.exposure is None else base.exposed(view.exposure)

    def picture(self, good: Good, view: View) -> bytes:
        """Return the picture of a view of a good version as a PNG."""
        return good.png if view == View() else self.rendering(good, view).png

    def _until_stopped(self, done: int, total: int) -> None:
        if self.stopped.is_set():
            raise Superseded

    # --- Following the file ------------------------------------------------------------------------------

    def _follow(self) -> None:
        while (version := self._watcher.next()) is not None:
            with contextlib.suppress(Superseded):
                self._take(version)

    def _take(self, version: Version) -> None:
        """Take a version of the file into the state, unless it changes meanwhile."""
        if version.raw is None:
            self._fail(version, MISSING, report=f"{self.path}: {version.reason}\n")
            return
        try:
            scene = load(version.raw, self.path, self.overrides, Stopwatch())
        except SceneError as error:
            self._fail(version, INVALID, error.problems)
        except ValueError as error:  # a change by an option that this scene does not allow
            self._fail(version, INVALID, report=f"{error}\n")
        else:
            self._show(version, scene)

    def _fail(self, version: Version, status: str, problems: tuple[Problem, ...] = (), report: str = "") -> None:
        """Keep the last good picture, if the file stays without a valid scene."""
        if self._watcher.stays(version, GRACE):
            self._watcher.accept(version)
            self._publish(status=status, raw=version.raw, problems=problems, report=report)

    def _show(self, version: Version, scene: PackedScene) -> None:
        assert version.raw is not None
        details = self._start_details(version.raw)
        started = time.perf_counter()
        try:
            rendering = render(scene, View(), self._while_current(version))
        except MemoryError:
            self._fail(version, INVALID, report="there is not enough memory for this picture\n")
            return
        self._seconds_per_ray = (time.perf_counter() - started) / max(1, rendering.film.rays)
        if not self._watcher.stays(version, SETTLED):
            raise Superseded
        with contextlib.suppress(FutureTimeoutError):
            details.exception(_PATIENCE)
        self._watcher.accept(version)
        state = self._state
        milliseconds = (time.perf_counter() - version.saved) * 1e3
        before = state.good
        good = Good(
            state.version + 1,
            version.raw,
            scene,
            rendering,
            rendering.png,
            time.strftime("%H:%M:%S"),
            round(milliseconds, 1),
            details,
            None if before is None else before.scene,
        )
        self._publish(
            status=OK, raw=version.raw, problems=self._warnings(good), report="", good=good, previous=before
        )
        if not details.done():
            details.add_done_callback(lambda _: self._complete(good))

    def _while_current(self, version: Version) -> Any:
        def check(done: int, total: int) -> None:
            if not self._watcher.is_current(version):
                raise Superseded

        return check

    def _start_details(self, raw: bytes) -> Future[Details]:
        details: Future[Details] = Future()

        def find() -> None:
            try:
                details.set_result(Details.of(raw, self.path, self.overrides))
            except BaseException as error:  # whoever asks gets it
                details.set_exception(error)

        threading.Thread(target=find, name="details", daemon=True).start()
        return details

    def _warnings(self, good: Good) -> tuple[Problem, ...]:
        return () if good.known_details is None else good.known_details.problems

    def _complete(self, good: Good) -> None:
        """Tell of the details of a version that is still shown."""
        with self.changed:
            if self._state.good is good and self._state.status == OK:
                self._publish(problems=self._warnings(good))

    def _publish(self, **changes: Any) -> None:
        with self.changed:
            self._state = replace(self._state, version=self._state.version + 1, **changes)
            self.changed.notify_all()

    # --- The state as JSON -------------------------------------------------------------------------------

    def command(self) -> str:
        """Return the command that writes the same picture."""
        return shlex.join(["rtcli", "render", self.path, "-o", "out.png"])

    def as_dict(self) -> dict[str, Any]:
        """Return the state as docs/live.md describes it."""
        state = self._state
        good, text = state.good, _text(state.raw)
        return {
            "version": state.version,
            "status": state.status,
            "scene": self.path,
            "text": text,
            "problems": [problem.as_dict() for problem in state.problems],
            "report": state.report or problems_text(self.path, state.problems),
            "command": self.command(),
            **_of_good(good, text),
            "limits": {"pixels": MAX_RAYS // (1 if good is None else good.scene.world.settings.samples)},
        }


def _of_good(good: Good | None, text: str | None) -> dict[str, Any]:
    """Return the part of the state that tells of the last good version."""
    if good is None:
        empty = {"objects": [], "lights": [], "changed": []}
        return {"picture": None, "text_of_picture": None, "camera": None, **empty}
    details, scene = good.known_details, good.scene
    pixels = [] if good.rendering is None else good.rendering.visible_pixels
    objects = objects_of(scene, pixels, details)
    camera, old = scene.world.camera, _text(good.raw)
    return {
        "picture": {
            "version": good.version,
            "time": good.shown,
            "width": camera.width,
            "height": camera.height,
            "exposure": None if good.rendering is None else good.rendering.film.exposure,
            "tone": scene.tone,
            "milliseconds": good.milliseconds,
            "preview": good.rendering is None,
        },
        "text_of_picture": None if old == text else old,
        "objects": objects,
        "lights": lights_of(scene, objects, details),
        "camera": camera_of(scene, details),
        "changed": good.changed,
    }


def _text(raw: bytes | None) -> str | None:
    return None if raw is None else raw.decode("utf-8-sig", errors="replace")


def _unused() -> NoReturn | Iterator[None]:
    raise NotImplementedError(small_picture, _LONG, _SHORT)
