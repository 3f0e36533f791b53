"""The accessibility checks of axe-core (https://github.com/dequelabs/axe-core) for a page in the browser."""

from __future__ import annotations

from typing import Any

import npm
import pytest

VERSION = "4.10.3"

_RUN = """
const done = arguments[arguments.length - 1];
Promise.all(document.getAnimations().map((animation) => animation.finished)).then(
  () => axe.run(document, {resultTypes: ["violations"]})).then(
  (results) => done(results.violations.flatMap(
    ({id, nodes}) => nodes.map((node) => `${id}: ${node.html.slice(0, 200)}: ${node.failureSummary}`))),
  (error) => done([String(error)]));
"""


def violations(chromium: Any, cache: pytest.Cache) -> list[str]:
    """Return each violation of the page that the browser shows; skip the test without axe-core."""
    source = npm.installed(cache, "axe-core", VERSION) / "axe-core" / "axe.min.js"
    chromium.execute_script(source.read_text(encoding="utf-8"))
    found: list[str] = chromium.execute_async_script(_RUN)
    return found
