"""Draw the pictures of pages in the documentation, with the Chromium of the tests.

Run it as `python tools/page_pictures.py`. They depend on the fonts of the machine, so no test compares them.
"""

from __future__ import annotations

import io
import sys
import tempfile
from pathlib import Path

from click.testing import CliRunner
from PIL import Image

from rtcli.cli import main

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "support"))

import chromium  # noqa: E402 - a module of the tests

_SCENE, _PIXEL, _SIZE = "scenes/first.yaml", "386,330", (1180, 760)

# The symbol that is pointed at.
_POINT = "document.querySelector('.steps [data-light=\"0\"] button.symbol').focus({preventScroll: true})"


def save_story(path: Path) -> None:
    """Write the picture of a story's page."""
    with tempfile.TemporaryDirectory() as folder, chromium.browser() as browser:
        page = Path(folder) / "story.html"
        result = CliRunner().invoke(main, ["explain", _SCENE, "--pixel", _PIXEL, "--html", str(page)])
        if result.exit_code:
            raise RuntimeError(result.output)
        chromium.resize(browser, *_SIZE)
        chromium.prefer(browser, "light")
        browser.get(page.as_uri())
        browser.execute_script(_POINT)
        with Image.open(io.BytesIO(browser.get_screenshot_as_png())) as image:
            image.convert("RGB").quantize(128, dither=Image.Dither.NONE).save(path, optimize=True)


if __name__ == "__main__":
    save_story(ROOT / "docs" / "explain.png")
