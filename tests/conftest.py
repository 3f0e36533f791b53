"""Settings of all tests, and the fixtures that run a test with each engine."""

import functools
import os
from pathlib import Path

import pytest
import worlds
from freshness import FreshnessReport, native_sources
from hypothesis import settings

from rtcli.tracer import _native
from rtcli.tracer.engines import ENGINES

# The same examples each time, so that no test fails by chance; `RTCLI_HYPOTHESIS=thorough make test` searches.
# No deadline, since a busy machine is not a failure.
settings.register_profile("default", max_examples=60, derandomize=True, deadline=None)
settings.register_profile("thorough", max_examples=2000, deadline=None)
settings.load_profile(os.environ.get("RTCLI_HYPOTHESIS", "default"))


def pytest_configure(config):
    """Warn, loudly, if the tests would run an outdated compiled module."""
    config.pluginmanager.register(FreshnessReport(Path(_native.__file__), native_sources()))


# Session scope, as Hypothesis requires: every example of a test uses the same fixture.
@pytest.fixture(scope="session", params=ENGINES)
def engine(request):
    """Each engine in turn, for tests that must hold with both."""
    return request.param


@pytest.fixture(scope="session")
def render(engine):
    """Render a scene, or its data, with each engine in turn: `render(scene, passes=...)`."""
    return functools.partial(worlds.render, engine=engine)
