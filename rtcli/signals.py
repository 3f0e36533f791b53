"""The response of rtcli, its threads and its worker processes to signals that ask them to end."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Iterator, Sequence
from types import FrameType
from typing import NoReturn

# Windows has no SIGHUP, no SIGPIPE and no signal masks.
_NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGPIPE")
TERMINATING = tuple(getattr(signal, name) for name in _NAMES if hasattr(signal, name))
BROKEN_PIPE = tuple(number for number in TERMINATING if number.name == "SIGPIPE")


class Interrupted(BaseException):
    """A terminating signal arrived. A BaseException, so that only cleanup code sees it."""

    def __init__(self, number: int) -> None:
        self.number = number


def exit_silently_on_interrupt() -> None:
    """Let Ctrl-C end the process without a traceback until `interruptible` handles it."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


@contextlib.contextmanager
def interruptible() -> Iterator[None]:
    """Raise `Interrupted` in the block when a terminating signal arrives, once; restore the handlers after it.

    A signal that is ignored stays ignored, as `nohup` requires, except for SIGPIPE, which Python itself ignores.
    """
    handled = [
        number for number in TERMINATING if number in BROKEN_PIPE or signal.getsignal(number) is not signal.SIG_IGN
    ]

    def interrupt(number: int, frame: FrameType | None) -> NoReturn:
        for other in handled:
            signal.signal(other, signal.SIG_IGN)  # a second signal must not interrupt the cleanup
        raise Interrupted(number)

    try:
        previous = {number: signal.signal(number, interrupt) for number in handled}
    except ValueError:  # Python sets handlers in the main thread only
        previous = {}
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


def ignore_broken_pipes() -> None:
    """Let a server outlive connections that the other side closes; a write to one raises OSError instead."""
    for number in BROKEN_PIPE:
        signal.signal(number, signal.SIG_IGN)


def exit_by_signal(number: int) -> NoReturn:
    """End the process as if the signal had not been caught, so that the calling shell sees it."""
    signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)
    os._exit(128 + number)  # only if the signal is blocked


@contextlib.contextmanager
def blocked(signals: Sequence[signal.Signals] = TERMINATING) -> Iterator[None]:
    """Defer signals until the block ends; processes and threads that it starts keep them blocked for good.

    A terminal sends signals to every process of a program, but only the first should handle them and end the
    others. A SIGPIPE that arrives meanwhile is dropped, because losing a worker must not end the program.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    previous = signal.pthread_sigmask(signal.SIG_BLOCK, signals)
    try:
        yield
    finally:
        if signal.SIGPIPE in signal.sigpending():
            signal.sigwait([signal.SIGPIPE])
        signal.pthread_sigmask(signal.SIG_SETMASK, previous)


def accept_termination() -> None:
    """Let SIGTERM end this worker process, which inherited it blocked."""
    if hasattr(signal, "pthread_sigmask"):
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGTERM])


def terminate(pid: int | None) -> None:
    """Ask a process to end, if it is running."""
    if pid is not None:
        with contextlib.suppress(OSError):
            os.kill(pid, signal.SIGTERM)
