"""A thousand saves in five styles: none is lost, none is taken for an error, and none is rendered twice."""

import time

import pytest
from live_client import LiveClient, as_vim_does, by_rename, in_halves, in_place, scene_text, touched

from rtcli.live.session import INVALID, MISSING

STYLES = (in_place, by_rename, as_vim_does, in_halves, touched)

# Seconds within which a file must be whole again for what it holds meanwhile never to count.
_STALLED = 0.02


@pytest.mark.integration
@pytest.mark.parametrize("style", STYLES, ids=lambda style: style.__name__)
def test_each_of_two_hundred_saves_is_shown_once(tmp_path, monkeypatch, style):
    path = tmp_path / "scene.yaml"
    path.write_text(scene_text())
    with LiveClient(path) as live:
        first = live.session.state
        states, stalled = record_states(live.session, monkeypatch), 0
        for number in range(200):
            if style is touched:
                touched(path)
                time.sleep(0.03)
                continue
            text = scene_text(number / 100 - 1)
            began = time.perf_counter()
            style(path, text)
            stalled += time.perf_counter() - began > _STALLED
            live.wait_for_text(text)
        if style is touched:
            assert live.session.state is first
        else:
            assert sum(state.status in (INVALID, MISSING) for state in states) <= 2 * stalled
            # On a busy machine a small picture may come first, which is a version of its own.
            whole = {state.good.version for state in states if state.good.rendering is not None}
            assert 200 <= len(whole) <= 200 + stalled


def record_states(session, monkeypatch):
    """Return a list that takes each state that is published."""
    states, publish = [], session._publish

    def record(**changes):
        publish(**changes)
        states.append(session.state)

    monkeypatch.setattr(session, "_publish", record)
    return states
