"""Draw the pictures of pages in the documentation, with the Chromium of the tests.

Run it as `python tools/page_pictures.py`. They depend on the fonts of the machine, so no test compares them.
"""

from __future__ import annotations

import io
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from click.testing import CliRunner
from PIL import Image

from rtcli.cli import main
from rtcli.live.server import LiveServer
from rtcli.live.session import Session

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "support"))

import chromium  # noqa: E402 - a module of the tests

_SCENE, _PIXEL, _SIZE = "scenes/first.yaml", "386,330", (1180, 760)
_LIVE_SIZE = (1280, 800)

# The symbol that is pointed at.
_POINT = "document.querySelector('.steps [data-light=\"0\"] button.symbol').focus({preventScroll: true})"

_SECONDS = 3.0  # until a page has followed a save


def save_story(browser: Any, path: Path) -> None:
    """Write the picture of a story's page."""
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "story.html"
        result = CliRunner().invoke(main, ["explain", _SCENE, "--pixel", _PIXEL, "--html", str(page)])
        if result.exit_code:
            raise RuntimeError(result.output)
        chromium.resize(browser, *_SIZE)
        chromium.prefer(browser, "light")
        browser.get(page.as_uri())
        browser.execute_script(_POINT)
        _save(browser, path, Image.Quantize.MAXCOVERAGE)


def save_live(browser: Any, folder: Path) -> None:
    """Write the pictures of the page of `rtcli live`: the story of a pixel, and an edit that is not valid."""
    scenes = {
        name: (ROOT / "scenes" / f"{name}.yaml").read_text(encoding="utf-8") for name in ("first", "still-life")
    }
    with tempfile.TemporaryDirectory() as work:
        os.chdir(work)  # so that the page shows a short name
        file = Path("scene.yaml")
        file.write_text(scenes["first"], encoding="utf-8")
        session = Session(str(file))
        server = LiveServer(session, 0)
        session.start()
        server.start()
        chromium.resize(browser, *_LIVE_SIZE)
        chromium.prefer(browser, "light")
        browser.get(f"{server.address}#pixel={_PIXEL}")
        time.sleep(_SECONDS)
        browser.execute_script("location.hash = arguments[0]", f"#pixel={_PIXEL}")
        time.sleep(_SECONDS)
        _save(browser, folder / "page.png", Image.Quantize.MEDIANCUT)
        chromium.prefer(browser, "dark")
        file.write_text(scenes["still-life"], encoding="utf-8")
        time.sleep(_SECONDS)
        browser.find_element("id", "tab-objects").click()
        wrong = scenes["still-life"].replace("radius: 0.42", "radius: 0.42.", 1).replace("fov: 28", "fov: 280")
        file.write_text(wrong, encoding="utf-8")
        time.sleep(_SECONDS)
        _save(browser, folder / "invalid.png", Image.Quantize.MEDIANCUT)
        session.stop()
        os.chdir(ROOT)


def _save(browser: Any, path: Path, method: Image.Quantize) -> None:
    with Image.open(io.BytesIO(browser.get_screenshot_as_png())) as image:
        colors = image.convert("RGB").quantize(256, method, dither=Image.Dither.NONE)
        colors.save(path, optimize=True)


if __name__ == "__main__":
    with chromium.browser() as started:
        save_story(started, ROOT / "docs" / "explain.png")
        save_live(started, ROOT / "docs" / "live")
