"""Settings that hold for all tests, and the engines of those that hold for each."""

import functools
import os
from pathlib import Path

import pytest
import worlds
from freshness import FreshnessReport, native_sources
from hypothesis import settings

from rtcli.tracer import _native
from rtcli.tracer.engines import ENGINES

# The same examples each time, so that no test fails by chance: `RTCLI_HYPOTHESIS=thorough make test` searches.
# And without a deadline: a busy machine is no failure.
settings.register_profile("default", max_examples=60, derandomize=True, deadline=None)
settings.register_profile("thorough", max_examples=2000, deadline=None)
settings.load_profile(os.environ.get("RTCLI_HYPOTHESIS", "default"))


def pytest_configure(config):
    """Warn, loudly, if the tests would run an outdated compiled module."""
    config.pluginmanager.register(FreshnessReport(Path(_native.__file__), native_sources()))


# For the whole session, as Hypothesis wants it: each example of a test uses the same.
@pytest.fixture(scope="session", params=ENGINES)
def engine(request):
    """Each engine in turn: what a test with this fixture says holds for both."""
    return request.param


@pytest.fixture(scope="session")
def render(engine):
    """Render a scene, or data of one, with each engine in turn: `render(scene, passes=...)`."""
    return functools.partial(worlds.render, engine=engine)
