"""Settings that hold for all tests."""

import os

from hypothesis import settings

# The same examples each time, so that no test fails by chance: `RTCLI_HYPOTHESIS=thorough make test` searches.
settings.register_profile("default", max_examples=60, derandomize=True)
settings.register_profile("thorough", max_examples=2000)
settings.load_profile(os.environ.get("RTCLI_HYPOTHESIS", "default"))
