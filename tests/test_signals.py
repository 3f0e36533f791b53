"""Signals that ask for an end: raised, deferred, dropped or ignored. `tests/cli` tests how the program ends."""

import os
import signal

import pytest

from rtcli.signals import Interrupted, blocked, interruptible

pytestmark = pytest.mark.skipif(os.name == "nt", reason="POSIX only: signal masks")


def test_signal_is_raised_once_and_its_handler_is_restored():
    before = signal.getsignal(signal.SIGTERM)

    @interruptible()
    def interrupt_twice():
        try:
            signal.raise_signal(signal.SIGTERM)
        finally:
            signal.raise_signal(signal.SIGTERM)

    with pytest.raises(Interrupted) as interrupt:
        interrupt_twice()
    assert interrupt.value.number == signal.SIGTERM
    assert interrupt.value.__context__ is None
    assert signal.getsignal(signal.SIGTERM) == before


def test_ignored_signal_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with interruptible():
            signal.raise_signal(signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)


def test_blocked_signal_arrives_after_the_block():
    steps = []

    @interruptible()
    def interrupt():
        with blocked():
            signal.raise_signal(signal.SIGTERM)
            steps.append("in the block")
        steps.append("after it")

    with pytest.raises(Interrupted):
        interrupt()
    assert steps == ["in the block"]


def test_broken_pipe_in_the_block_is_dropped():
    with interruptible(), blocked():
        signal.raise_signal(signal.SIGPIPE)
