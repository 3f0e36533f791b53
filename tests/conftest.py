"""Settings that hold for all tests."""

import os

from hypothesis import settings

# `RTCLI_HYPOTHESIS=thorough make test` looks harder; CI repeats its examples, so that it never fails by chance.
settings.register_profile("default", max_examples=60)
settings.register_profile("ci", max_examples=60, derandomize=True)
settings.register_profile("thorough", max_examples=2000)
settings.load_profile(os.environ.get("RTCLI_HYPOTHESIS", "ci" if os.environ.get("CI") else "default"))
