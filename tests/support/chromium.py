"""A real browser for tests: Debian's Chromium, headless, driven by Selenium."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from typing import Any

import pytest

PACKAGES = ("chromium", "chromium-driver")
PROGRAMS = ("chromium", "chromedriver")

# No sandbox, which a container does not allow; the pages are our own. The browser itself fetches nothing.
OPTIONS = (
    *("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars"),
    *("--disable-background-networking", "--disable-component-update", "--no-first-run", "--lang=en"),
)


def programs() -> tuple[str, str]:
    """Return Chromium and its driver, installed by apt-get if necessary, or skip the test."""
    if not all(map(shutil.which, PROGRAMS)):
        _install()
    browser, driver = map(shutil.which, PROGRAMS)
    if not (browser and driver):
        pytest.skip(f"{' and '.join(PACKAGES)} are not installed, and apt-get could not: NO BROWSER IS TRIED")
    return browser, driver


def _install() -> None:
    apt_get, sudo = shutil.which("apt-get"), shutil.which("sudo")
    is_root = hasattr(os, "geteuid") and os.geteuid() == 0
    if not apt_get or not (is_root or sudo):
        return
    as_root = [] if is_root else [str(sudo), "--non-interactive"]
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    for command in (["update"], ["install", "--yes", "--no-install-recommends", *PACKAGES]):
        with contextlib.suppress(subprocess.TimeoutExpired):
            subprocess.run([*as_root, apt_get, *command], capture_output=True, env=environment, timeout=300)


@contextlib.contextmanager
def browser() -> Iterator[Any]:
    """Yield a browser that records its console messages and network requests."""
    webdriver = pytest.importorskip("selenium.webdriver", reason="Selenium is not installed: NO BROWSER IS TRIED")
    program, driver = programs()
    options = webdriver.ChromeOptions()
    options.binary_location = program
    for option in OPTIONS:
        options.add_argument(option)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    chromium = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    try:
        yield chromium
    finally:
        chromium.quit()


def prefer(chromium: Any, scheme: str) -> None:
    """Emulate a system that prefers `light` or `dark`."""
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})


def resize(chromium: Any, width: int, height: int) -> None:
    """Give the page a size in pixels, which may be smaller than a window can be."""
    size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    chromium.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)


def requested(chromium: Any) -> list[str]:
    """Return the addresses requested since the last call, long ones cut."""
    messages = [json.loads(entry["message"])["message"] for entry in chromium.get_log("performance")]
    requests = [each["params"] for each in messages if each["method"] == "Network.requestWillBeSent"]
    return [request["request"]["url"][:200] for request in requests]


def said(chromium: Any) -> list[str]:
    """Return the console messages since the last call, including violations of the page's policy."""
    return [entry["message"] for entry in chromium.get_log("browser")]
