"""The wheel and the source distribution, built and installed."""

import os
import re
import subprocess
import sys
import tarfile
import venv
import zipfile
from importlib import metadata
from pathlib import Path

import pytest

import rtcli

ROOT = Path(__file__).resolve().parent.parent
SCENE = ROOT / "scenes" / "first.yaml"
# The folder of `maturin` and the interpreter.
BIN = Path(sys.executable).parent


def maturin(*arguments):
    command = [str(BIN / "maturin"), *arguments]
    # A separate build, which must not touch the module that the tests use.
    result = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert result.returncode == 0, result.stdout


def test_version_is_that_of_the_package_and_the_crate():
    manifest = (ROOT / "tracer" / "python" / "Cargo.toml").read_text()
    assert f'\nversion = "{rtcli.__version__}"\n' in manifest
    assert metadata.version("rtcli") == rtcli.__version__
    assert f"\nversion: {rtcli.__version__}\n" in (ROOT / "CITATION.cff").read_text()


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel that `pip install .` builds, in the release profile."""
    folder = tmp_path_factory.mktemp("wheel")
    maturin("build", "--out", str(folder))
    (path,) = folder.glob("*.whl")
    return path


@pytest.mark.integration
def test_wheel_is_for_all_pythons_from_the_oldest_on(wheel):
    assert re.fullmatch(rf"rtcli-{re.escape(rtcli.__version__)}-cp310-abi3-\w+\.whl", wheel.name)


@pytest.mark.integration
def test_wheel_holds_the_package_and_nothing_else(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    info = f"rtcli-{rtcli.__version__}.dist-info/"
    (compiled,) = [name for name in names if name.endswith((".so", ".pyd"))]
    assert re.fullmatch(r"rtcli/tracer/_native(\.abi3)?\.(so|pyd)", compiled)
    sources = {
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "rtcli").rglob("*")
        if path.parent != ROOT / "rtcli" / "gallery"  # which an editable installation copies there
        if path.suffix in (".py", ".pyi", ".typed", ".yaml", ".html", ".css", ".js", ".svg")
    }
    gallery = {f"rtcli/gallery/{path.name}" for path in (ROOT / "scenes").iterdir()}
    expected = {*sources, "rtcli/py.typed", compiled, *gallery}
    assert {name for name in names if not name.startswith(info)} == expected
    assert {f"{info}METADATA", f"{info}entry_points.txt", f"{info}licenses/LICENSE"} <= names


@pytest.mark.integration
def test_wheel_installs_into_a_bare_environment_and_renders(wheel, tmp_path):
    venv.create(tmp_path / "bare", with_pip=True)
    scripts = tmp_path / "bare" / ("Scripts" if os.name == "nt" else "bin")
    bare = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}

    def run(program, *arguments):
        command = [str(scripts / program), *arguments]
        return subprocess.run(command, cwd=tmp_path, env=bare, check=True, capture_output=True, text=True).stdout

    run("pip", "install", "--quiet", "--disable-pip-version-check", str(wheel))
    assert run("rtcli", "--version") == f"rtcli {rtcli.__version__}\n"
    assert "\ncornell " in run("rtcli", "new", "--list")
    run("rtcli", "new", "--from", "cornell", "my.yaml")
    assert rtcli.load_scene(tmp_path / "my.yaml") == rtcli.load_scene(ROOT / "scenes" / "cornell.yaml")
    run("rtcli", "render", str(SCENE), "-o", "out.png", "--size", "160x120")
    rtcli.render(rtcli.load_scene(SCENE), crop=(0, 0, 1, 1)).save(tmp_path / "pixel.png")
    run("rtcli", "render", str(SCENE), "-o", "crop.png", "--crop", "0,0,1,1")
    assert (tmp_path / "crop.png").read_bytes() == (tmp_path / "pixel.png").read_bytes()
    assert (tmp_path / "out.png").stat().st_size > 1000


@pytest.mark.integration
def test_source_distribution_can_be_built_and_tested(tmp_path):
    maturin("sdist", "--out", str(tmp_path))
    (path,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(path) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    needed = {
        *(
            "pyproject.toml",
            "Makefile",
            "README.md",
            "CHANGELOG.md",
            "CITATION.cff",
            "LICENSE",
            "rtcli/__init__.py",
        ),
        *("tracer/Cargo.toml", "tracer/Cargo.lock", "tracer/src/lib.rs", "tracer/python/src/lib.rs"),
        "tracer/reader/src/table.rs",
        "tracer/python/build.rs",
        *("scenes/first.yaml", "schemas/scene.schema.json", "tools/refresh.py", "tests/test_package.py"),
        *("docs/tracer.md", "docs/conf.py", "docs/tutorial/step-8.yaml"),
    }
    assert needed - names == set()
    stray = re.compile(r"(^|/)(target|__pycache__|out|failed|\.venv|\.git)/|\.(so|pyd|pyc)$")
    assert [name for name in names if stray.search(name)] == []
