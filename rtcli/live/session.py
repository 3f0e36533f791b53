"""The state of one scene while it is edited: the last good picture, and the problems of the file as it is now."""

from __future__ import annotations

import contextlib
import json
import math
import shlex
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from rtcli.atomic import atomic_write
from rtcli.live.camera import camera_of, with_pose
from rtcli.live.details import Details, changed_objects, lights_of, objects_of, problems_text
from rtcli.live.rendering import Rendering, render, small_picture
from rtcli.live.view import MAX_RAYS, CameraPose, RequestError, ViewRequest
from rtcli.live.watch import GRACE, SETTLED, FileWatcher, SupersededError, Version
from rtcli.rendering.load import load
from rtcli.rendering.pack import PackedScene
from rtcli.rendering.stopwatch import Stopwatch
from rtcli.scene.diagnostics.problems import Problem, SceneError
from rtcli.scene.files import read_file
from rtcli.scene.overrides import Overrides

# The status of the file: its picture is shown, or is on its way, or the last good one is shown.
OK, RENDERING, INVALID, MISSING = "ok", "rendering", "invalid", "missing"

# Seconds for which a picture waits for the details of its scene, so that one event tells of both.
_PATIENCE = 0.015

# Seconds of a picture that is shown small first, and seconds that a small one takes.
_LONG, _SHORT = 0.15, 0.04

_CHANGED = "the file changed since this picture, or is invalid: nothing was written"

_FEWEST = 4096  # pixels of a small picture

# The most pixels of a picture that is kept as a film: a gigabyte.
MAX_PIXELS = 1 << 26

# The most pixels of all views of a version that are kept: half a gigabyte.
_KEPT_PIXELS = 1 << 25


class ConflictError(ValueError):
    """The file is not as a request expects it."""


class _TakesLongError(Exception):
    """A picture takes so long that a small one is shown first."""


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
    views: dict[ViewRequest, Rendering] = field(default_factory=dict)

    @property
    def known_details(self) -> Details | None:
        """The details if they are known already."""
        is_known = self.details.done() and self.details.exception() is None
        return self.details.result() if is_known else None

    @property
    def warnings(self) -> tuple[Problem, ...]:
        """The warnings about the scene, if they are known already."""
        return () if self.known_details is None else self.known_details.problems

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


class _Work:
    """The rendering of one version of the file.

    Parameters
    ----------
    scene
        The scene.
    rate
        Samples that were traced a second for the picture before; None without one.
    is_current
        Whether the file still holds this version.
    """

    def __init__(self, scene: PackedScene, rate: float | None, is_current: Callable[[], bool]) -> None:
        self.scene = scene
        self.rate = rate
        self._is_current = is_current
        self._started = 0.0
        self._has_small = False
        camera = scene.world.camera
        self._samples = camera.width * camera.height * scene.world.settings.samples

    def whole(self) -> Rendering:
        """Return the rendering of the whole picture.

        Raises
        ------
        _TakesLongError
            If that takes long, and no small picture is there yet.
        SupersededError
            If the file changes meanwhile.
        """
        if not self._has_small and self.rate is not None and self._samples / self.rate > _LONG:
            raise _TakesLongError
        self._started = time.perf_counter()
        rendering = render(self.scene, self._on_progress)
        self.rate = self._samples / (time.perf_counter() - self._started)
        return rendering

    def small(self) -> bytes:
        """Return a small picture, which takes about `_SHORT` seconds, as a PNG."""
        self._has_small = True
        camera, samples = self.scene.world.camera, max(_FEWEST, (self.rate or 0.0) * _SHORT)
        factor = min(1.0, math.sqrt(samples / (camera.width * camera.height)))
        size = max(1, round(camera.width * factor)), max(1, round(camera.height * factor))
        return small_picture(self.scene, size, self._on_progress)

    def _on_progress(self, done: int, total: int) -> None:
        if not self._is_current():
            raise SupersededError
        seconds, share = time.perf_counter() - self._started, done / total
        if not self._has_small and seconds > _LONG / 2 and share < 0.5:
            self.rate = self._samples * share / seconds
            raise _TakesLongError


class Session:
    """Follows a scene file, and keeps its state.

    Parameters
    ----------
    path
        The file, as given on the command line.
    overrides
        The changes that options make to the scene.
    writes
        Whether requests may write the pose of the camera into the file.
    editor
        The command that opens an object in an editor, with `{file}`, `{line}` and `{column}`; None without one.
    """

    def __init__(
        self, path: str, overrides: Overrides | None = None, writes: bool = False, editor: str | None = None
    ) -> None:
        self.path = path
        self.writes = writes
        self.editor = editor
        self.overrides = overrides or Overrides()
        self.stopped = threading.Event()
        self.changed = threading.Condition()
        self._state = State()
        self._watcher = FileWatcher(path, self.stopped)
        self._thread = threading.Thread(target=self._follow, name="follow", daemon=True)
        self._tracing = threading.Lock()
        self._detailing = threading.Lock()
        self._newest_details: Future[Details] | None = None
        self._telling = threading.Lock()
        self._told = State(-1), b""
        # Samples traced a second, once a picture was.
        self._rate: float | None = None

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

    def rendering(self, good: Good, view: ViewRequest) -> Rendering:
        """Return a view of a good version; a few are kept.

        Raises
        ------
        RequestError
            If the view is too much work.
        SupersededError
            If the session ends meanwhile.
        """
        whole = self._whole(good) if view.traced == ViewRequest() else None
        if whole is not None:
            base = whole
        else:
            with self._tracing:
                known = good.views.pop(view.traced, None)
                base = self._trace(good, view.traced) if known is None else known
                good.views[view.traced] = base  # the newest is the last
                while len(good.views) > 1 and sum(map(_pixels, good.views.values())) > _KEPT_PIXELS:
                    del good.views[next(iter(good.views))]
        return base if view.exposure is None else base.exposed(view.exposure)

    def _whole(self, good: Good) -> Rendering | None:
        """Return the whole picture of a version, for which a small one may still stand in; None without one."""
        with self.changed:
            self.changed.wait_for(lambda: self._state.good is not good or self._state.status != RENDERING)
            newest = self._state.good
        return newest.rendering if newest is not None and newest.raw == good.raw else good.rendering

    def _trace(self, good: Good, view: ViewRequest) -> Rendering:
        scene = good.scene
        if view.size is not None:
            scene = load(good.raw, self.path, replace(self.overrides, size=view.size), Stopwatch())
        return render(view.of_scene(scene), self._until_stopped)

    def picture(self, good: Good, view: ViewRequest) -> bytes:
        """Return the picture of a view of a good version as a PNG."""
        return good.png if view == ViewRequest() else self.rendering(good, view).png

    def details(self, good: Good) -> Details:
        """Return the details of a good version, once they are known."""
        try:
            return good.details.result()
        except SupersededError:  # a newer version came first
            return Details.of(good.raw, self.path, self.overrides)

    def write_pose(self, pose: CameraPose, version: int) -> None:
        """Write another pose of the camera into the file.

        Parameters
        ----------
        pose
            The pose.
        version
            The number of the state, or of its picture, that shows the file as whoever asks knows it.

        Raises
        ------
        ConflictError
            If the file changed since, or is invalid.
        RequestError
            If the file does not give the pose by numbers.
        OSError
            If the file cannot be written.
        """
        state = self._state
        good = state.good
        if good is None or state.raw != good.raw or version not in (state.version, good.version):
            raise ConflictError(_CHANGED)
        written = with_pose(good.raw, self.path, pose)
        with atomic_write(Path(self.path)) as file:
            file.write(written)
            if read_file(self.path) != good.raw:
                raise ConflictError(_CHANGED)

    def _until_stopped(self, done: int, total: int) -> None:
        if self.stopped.is_set():
            raise SupersededError

    # --- Following the file ------------------------------------------------------------------------------

    def _follow(self) -> None:
        while (version := self._watcher.next()) is not None:
            try:
                self._take(version)
            except SupersededError:
                if self._state.status == RENDERING:
                    self._watcher.accept(None)  # only a small picture was shown
            except BaseException as error:  # a panic of the compiled tracer is no Exception
                self._watcher.accept(version)
                report = f"this is a bug in rtcli: {type(error).__name__}: {error}\n"
                self._publish(status=INVALID, raw=version.raw, problems=(), report=report)

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
            try:
                self._show(version, scene)
            except MemoryError:
                self._fail(version, INVALID, report="there is not enough memory for this picture\n")

    def _fail(self, version: Version, status: str, problems: tuple[Problem, ...] = (), report: str = "") -> None:
        """Keep the last good picture, if the file stays without a valid scene."""
        if self._watcher.stays(version, version.noticed + GRACE):
            self._watcher.accept(version)
            self._publish(status=status, raw=version.raw, problems=problems, report=report)

    def _show(self, version: Version, scene: PackedScene) -> None:
        """Show a valid scene, and first a small picture of it if it takes long."""
        assert version.raw is not None
        camera = scene.world.camera
        if camera.width * camera.height > MAX_PIXELS:
            size = f"{camera.width}x{camera.height}"
            self._fail(
                version, INVALID, report=f"a picture of {size} pixels is too large to be shown: use --size\n"
            )
            return
        known = self._state.good
        if known is not None and known.rendering is not None and known.raw == version.raw:  # a mistake was undone
            self._watcher.accept(version)
            self._publish(status=OK, raw=version.raw, problems=known.warnings, report="")
            return
        details = self._start_details(version.raw)
        if known is not None and known.rendering is not None and known.scene == scene:
            rendering = known.rendering  # a comment changed, for example
        else:
            work = _Work(scene, self._rate, lambda: self._watcher.is_current(version))
            try:
                rendering = work.whole()
            except _TakesLongError:
                self._publish_good(version, scene, None, work.small(), details)
                rendering = work.whole()
            self._rate = work.rate
        if not self._watcher.stays(version, version.saved + SETTLED):
            raise SupersededError
        with contextlib.suppress(FutureTimeoutError):
            details.exception(_PATIENCE)
        are_known = details.done()
        good = self._publish_good(version, scene, rendering, rendering.png, details)
        if not are_known:
            details.add_done_callback(lambda _: self._complete(good))

    def _publish_good(
        self,
        version: Version,
        scene: PackedScene,
        rendering: Rendering | None,
        png: bytes,
        details: Future[Details],
    ) -> Good:
        """Publish a valid scene: with its whole picture, or a small one that stands in for it."""
        assert version.raw is not None
        self._watcher.accept(version)
        with self.changed:
            state = self._state
            # The version before the last save: one that was never whole is passed over.
            is_whole = state.good is not None and state.good.rendering is not None
            previous = state.good if is_whole else state.previous
            good = Good(
                state.version + 1,
                version.raw,
                scene,
                rendering,
                png,
                time.strftime("%H:%M:%S"),
                round((time.perf_counter() - version.saved) * 1e3, 1),
                details,
                None if previous is None else previous.scene,
            )
            status = RENDERING if rendering is None else OK
            self._publish(
                status=status, raw=version.raw, problems=good.warnings, report="", good=good, previous=previous
            )
        return good

    def _start_details(self, raw: bytes) -> Future[Details]:
        """Find the details of a version in a thread: one at a time, and only of the newest that waits."""
        details: Future[Details] = Future()
        self._newest_details = details

        def find() -> None:
            with self._detailing:
                try:
                    if self._newest_details is not details:
                        raise SupersededError
                    details.set_result(Details.of(raw, self.path, self.overrides))
                except BaseException as error:  # whoever asks for the details gets it
                    details.set_exception(error)

        threading.Thread(target=find, name="details", daemon=True).start()
        return details

    def _complete(self, good: Good) -> None:
        """Publish the details of a version that is still shown."""
        with self.changed:
            if self._state.good is good and self._state.status == OK and good.known_details is not None:
                self._publish(problems=good.warnings)

    def _publish(self, **changes: Any) -> None:
        with self.changed:
            self._state = replace(self._state, version=self._state.version + 1, **changes)
            self.changed.notify_all()

    # --- The state as JSON -------------------------------------------------------------------------------

    def command(self) -> str:
        """Return the command that writes the same picture."""
        return shlex.join(["rtcli", "render", self.path, "-o", "out.png", *self.overrides.as_options()])

    def as_json(self) -> bytes:
        """Return the state as docs/live.md describes it, computed once for all pages."""
        with self._telling:
            state, json_text = self._told
            if state is not self._state:
                state = self._state
                json_text = json.dumps(self._as_dict(state), allow_nan=False).encode()
                self._told = state, json_text
            return json_text

    def _as_dict(self, state: State) -> dict[str, Any]:
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
            "write": self.writes,
            "editor": self.editor is not None,
            "limits": {"pixels": MAX_RAYS // (1 if good is None else good.scene.world.settings.samples)},
        }


def _pixels(rendering: Rendering) -> int:
    camera = rendering.scene.world.camera
    return camera.width * camera.height


def _of_good(good: Good | None, text: str | None) -> dict[str, Any]:
    """Return the part of the state that tells of the last good version."""
    if good is None:
        empty: dict[str, Any] = {"objects": [], "lights": [], "changed": []}
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
