"""The whole program: exit codes, streams, signals, terminals; with real processes where it matters."""

import contextlib
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import rtcli
from rtcli.cli import main
from rtcli.cli.program import SUMMARIES
from rtcli.lint.check import check

needs_posix = pytest.mark.skipif(os.name == "nt", reason="POSIX only: signals and terminals")

COMMANDS = ["render", "live", "watch", "batch", "validate", "explain", "compare", "new", "schema", "doctor"]


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


# --- Help, version, usage --------------------------------------------------------------------------------


@pytest.mark.parametrize(("typed", "meant"), [("rendr", "render"), ("Validate", "validate"), ("help", "--help")])
def test_unknown_command_is_told_with_the_one_that_is_meant(run, typed, meant):
    result = run(typed)
    assert result.exit_code == 2
    assert result.stderr.endswith(f"Error: No such command '{typed}'. Did you mean '{meant}'?\n")


@pytest.mark.parametrize(
    ("option", "told"), [("SAMPLES", "'x' is not a valid integer"), ("SIZE", "'x' is not a size such as 640x480")]
)
def test_wrong_value_of_a_variable_is_told_with_its_name(run, scene, option, told):
    result = run("render", scene, "-o", "out.png", env={f"RTCLI_RENDER_{option}": "x"})
    assert result.exit_code == 2
    assert f"Error: Invalid value for RTCLI_RENDER_{option}: {told}" in result.stderr


def test_version_is_printed(run):
    result = run("--version")
    assert result.exit_code == 0
    assert re.fullmatch(rf"rtcli {re.escape(rtcli.__version__)}( \([0-9a-f]{{9,}}(-dirty)?\))?\n", result.stdout)


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A repository with a commit, from which the version is read."""
    root = tmp_path / "checkout"
    root.mkdir()
    (root / "pyproject.toml").touch()
    identity = ["-c", "user.name=a", "-c", "user.email=a@example.org"]
    for command in (["init", "-q"], ["add", "."], [*identity, "commit", "-qm", "first"]):
        subprocess.run(["git", *command], cwd=root, check=True)
    monkeypatch.setattr("rtcli.cli.version._ROOT", root)
    return root


def test_version_of_a_development_build_has_the_commit(run, checkout):
    head = subprocess.run(["git", "rev-parse", "HEAD"], cwd=checkout, capture_output=True, text=True, check=True)
    assert run("--version").stdout == f"rtcli {rtcli.__version__} ({head.stdout[:9]})\n"
    (checkout / "pyproject.toml").write_text("changed")
    assert run("--version").stdout == f"rtcli {rtcli.__version__} ({head.stdout[:9]}-dirty)\n"


@pytest.mark.parametrize("missing", [".git", "pyproject.toml"])
def test_version_of_a_release_is_the_version_alone(run, checkout, missing):
    (checkout / missing).rename(checkout / "gone")
    assert run("--version").stdout == f"rtcli {rtcli.__version__}\n"


def test_version_without_git_is_the_version_alone(run, checkout, monkeypatch):
    monkeypatch.setenv("PATH", "")
    assert run("--version").stdout == f"rtcli {rtcli.__version__}\n"


@pytest.mark.parametrize("option", ["--help", "-h"])
def test_help_names_each_command(run, option):
    result = run(option)
    assert result.exit_code == 0
    assert all(re.search(rf"^  {command} ", result.stdout, re.MULTILINE) for command in COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_has_help(run, command):
    result = run(command, "--help")
    assert result.exit_code == 0
    assert result.stdout.startswith(f"Usage: rtcli {command} ")


def test_no_command_prints_help_as_wrong_usage(run):
    result = run()
    assert result.exit_code == 2
    assert result.stdout == ""
    assert "Usage: rtcli" in result.stderr


def test_commands_to_start_with_stand_before_the_list_and_work(run, folder):
    text = run().stderr
    first = re.findall(r"^  (rtcli (?:\S+ )*\S+)  ", text.partition("Start with:")[2], re.MULTILINE)
    assert [command.split()[1] for command in first] == ["new", "render", "validate"]
    assert text.index("Start with:") < text.index("Commands:")
    for command in first:
        assert run(*command.split()[1:]).exit_code == 0
    assert names_in(folder) == ["my.png", "my.yaml"]


@pytest.mark.parametrize("arguments", [["paint"], ["--paint"], ["render", "--paint"], ["rende"]])
def test_unknown_command_or_option_is_wrong_usage(run, arguments):
    result = run(*arguments)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert arguments[-1] in result.stderr


class PanicException(BaseException):
    """The error that PyO3 raises when Rust panics: no Exception."""


@pytest.mark.parametrize("failure", [RuntimeError, PanicException])
def test_failure_that_nobody_expected_exits_with_4_and_asks_for_a_report(run, scene, monkeypatch, failure):
    def fail(*arguments):
        raise failure("broken")

    monkeypatch.setattr("rtcli.cli.commands.validate.check", fail)
    result = run("validate", scene)
    assert result.exit_code == 4
    assert result.stdout == ""
    assert f"{failure.__name__}: broken" in result.stderr
    assert "bug" in result.stderr


LACKS = [
    (MemoryError(), "not enough memory"),
    (MemoryError("not enough memory for the objects"), "not enough memory for the objects"),
    (MemoryError("Unable to allocate 9. GiB"), "not enough memory"),
    (RuntimeError("can't start new thread"), "not enough memory for a thread, or too many of them"),
    (ImportError("a.so: failed to map segment from shared object"), "not enough memory to load a library"),
]


@pytest.mark.parametrize(("error", "told"), LACKS)
def test_lack_of_memory_exits_with_3_without_a_traceback(run, scene, monkeypatch, error, told):
    def fail(*arguments):
        raise error

    monkeypatch.setattr("rtcli.cli.commands.render.write_film", fail)
    result = run("render", scene, "-o", "out.png", "-q")
    assert (result.exit_code, result.stdout) == (3, "")
    assert result.stderr.startswith(f"Error: {told}; make the picture or the scene smaller")
    assert names_in(Path()) == [scene]


def test_scene_that_memory_does_not_hold_exits_with_3_and_the_others_are_checked(run, scene, monkeypatch):
    def fail(raw, name, ignore):
        if name == scene:
            raise MemoryError
        return check(raw, name, ignore)

    monkeypatch.setattr("rtcli.cli.commands.validate.check", fail)
    Path("wrong.yaml").write_text("camera: 1\n")
    result = run("validate", scene, "wrong.yaml")
    assert result.exit_code == 3
    assert result.stderr == "Error: scene.yaml: not enough memory\n"
    assert "wrong.yaml" in result.stdout


# --- Processes -------------------------------------------------------------------------------------------


def test_module_and_script_agree(spawn):
    script = shutil.which("rtcli", path=str(Path(sys.executable).parent))
    assert script, "the package is to be installed for its tests"
    for arguments in (["--version"], ["render"], ["schema"]):
        by_script = subprocess.run([script, *arguments], capture_output=True, check=False)
        by_module = spawn(*arguments)
        assert by_module.communicate() == (by_script.stdout, by_script.stderr)
        assert by_module.returncode == by_script.returncode


def test_exit_codes_reach_the_shell(spawn, scene, folder):
    (folder / "wrong.yaml").write_text("camera: 1")
    expected = {
        ("validate", scene): 0,
        ("validate", "wrong.yaml"): 1,
        ("validate",): 2,
        ("validate", "none.yaml"): 3,
    }
    processes = {arguments: spawn(*arguments) for arguments in expected}
    assert {arguments: process.wait() for arguments, process in processes.items()} == expected


# Each way to print to standard output.
PRINTING = [
    ["explain", "scene.yaml", "--pixel", "20,15"],
    ["explain", "scene.yaml", "--pixel", "20,15", "--json"],
    ["compare", "a.npz", "b.npz"],
    ["compare", "a.npz", "b.npz", "--json"],
    ["validate", "wrong.yaml"],
    ["validate", "wrong.yaml", "--format", "github"],
    ["validate", "scene.yaml", "--format", "json"],
    ["schema"],
    ["new", "-"],
    ["render", "scene.yaml", "-q", "-o", "-"],
    ["render", "scene.yaml", "-q", "-o", "out.png", "--stats", "-"],
    ["render", "scene.yaml", "--check", "golden.png"],
    ["batch", "scene.yaml", "-o", "out", "--dry-run"],
    ["--help"],
    ["--version"],
    ["render", "--help"],
    [],  # with the variable that a shell sets to get completions
]


def printing(spawn, arguments, **options):
    """Run rtcli so that it prints; return its exit code and the last line of standard error."""
    Path("wrong.yaml").write_text("camera: 1\nobjects:\n" + "  - 1\n" * 5000)  # more problems than a pipe holds
    layers = {f"layer{i}": np.full((4, 4), i) for i in range(9)}
    np.savez("a.npz", **layers)
    np.savez("b.npz", **{name: values + 1 for name, values in layers.items()})
    Image.new("RGB", (40, 30)).save("golden.png")
    env = {**os.environ, **({} if arguments else {"_RTCLI_COMPLETE": "bash_source"})}
    process = spawn(*arguments, env=env, **options)
    _, errors = process.communicate(timeout=20)
    assert b"Traceback" not in errors
    return process.returncode, (errors.decode().splitlines() or [""])[-1]


@needs_posix
@pytest.mark.parametrize("arguments", PRINTING, ids=" ".join)
def test_reader_that_goes_away_causes_no_word(spawn, scene, arguments):
    reader, writer = os.pipe()
    os.close(reader)
    code, told = printing(spawn, arguments, stdout=writer)
    os.close(writer)
    assert code in (0, -signal.SIGPIPE)
    assert told in ("", "rendering: 100 %")


@needs_posix
@pytest.mark.parametrize("arguments", PRINTING, ids=" ".join)
def test_closed_standard_output_that_is_printed_to_exits_with_3(spawn, scene, arguments):
    told = printing(spawn, arguments, prelude="exec 1>&-")
    assert told == (3, "Error: standard output: is closed")
    assert not Path("out.png").exists()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("arguments", PRINTING, ids=" ".join)
def test_full_disk_behind_standard_output_exits_with_3(spawn, scene, arguments):
    with Path("/dev/full").open("wb") as full:
        told = printing(spawn, arguments, stdout=full)
    assert told == (3, "Error: standard output: No space left on device")


@needs_posix
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_picture_that_does_not_fit_behind_standard_output_exits_with_3(spawn, scene, folder, unbuffered):
    # Without Python's buffer, a system call may write only part of the data, and reports that by its return value.
    # Under that limit, Python would write truncated bytecode files that it cannot load later.
    env = {**os.environ, "PYTHONUNBUFFERED": unbuffered, "PYTHONDONTWRITEBYTECODE": "1"}
    with (folder / "out.png").open("wb") as out:
        arguments = ["render", scene, "-q", "-o", "-", "--size", "600x600", "--bits", "16"]
        process = spawn(*arguments, prelude="ulimit -f 1", stdout=out, env=env)
        _, errors = process.communicate(timeout=20)
    assert process.returncode == 3
    assert errors == b"Error: standard output: File too large\n"


@needs_posix
@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize(
    "arguments",
    [
        ["explain", "scene.yaml", "--pixel", "20,15"],
        ["explain", "scene.yaml", "--pixel", "20,15", "--json"],
        ["compare", "a.npz", "b.npz"],
        ["compare", "a.npz", "b.npz", "--json"],
        ["validate", "wrong.yaml"],
        ["schema"],
        ["new", "-"],
        ["render", "--help"],
    ],
    ids=" ".join,
)
def test_report_that_does_not_fit_behind_standard_output_exits_with_3(spawn, scene, folder, arguments, unbuffered):
    (folder / "wrong.yaml").write_text("camera: 1")
    layers = {f"layer{i}": np.full((4, 4), i) for i in range(9)}
    np.savez("a.npz", **layers)
    np.savez("b.npz", **{name: values + 1 for name, values in layers.items()})
    env = {**os.environ, "PYTHONUNBUFFERED": unbuffered, "PYTHONDONTWRITEBYTECODE": "1"}
    (folder / "out").write_bytes(b"x" * 1000)  # of 1,024, so that part of the report fits
    with (folder / "out").open("ab") as out:
        process = spawn(*arguments, prelude="ulimit -f 2", stdout=out, env=env)
        _, errors = process.communicate(timeout=20)
    assert process.returncode == 3
    assert errors.decode().splitlines()[-1] == "Error: standard output: File too large"


@needs_posix
@pytest.mark.parametrize("closing", ["exec 0<&-", "exec 1>&-", "exec 2>&-"], ids=["input", "output", "errors"])
def test_stream_that_is_closed_and_not_needed_does_not_matter(spawn, scene, folder, closing):
    process = spawn("render", scene, "-o", "out.png", prelude=closing)
    _, errors = process.communicate(timeout=20)
    assert b"Traceback" not in errors
    assert process.returncode == 0
    assert names_in(folder) == ["out.png", "scene.yaml"]


@needs_posix
@pytest.mark.parametrize(
    ("arguments", "closing"),
    [
        (["validate", "-"], "exec 0<&-"),
        (["render", "-", "-o", "out.png"], "exec 0<&-"),
        (["render", "scene.yaml", "-o", "-"], "exec 1>&-"),
    ],
)
def test_stream_that_is_closed_and_needed_is_an_error_of_the_caller(spawn, scene, folder, arguments, closing):
    process = spawn(*arguments, prelude=closing)
    _, errors = process.communicate(timeout=20)
    assert b"Traceback" not in errors
    assert process.returncode in (1, 2, 3)
    assert names_in(folder) == ["scene.yaml"]


@needs_posix
def test_file_names_that_are_not_utf_8_work(spawn, scene, folder):
    if sys.platform == "darwin":
        pytest.skip("file names are UTF-8 there")
    name = os.fsencode(folder) + b"/\xff.yaml"
    shutil.copy(scene, name)
    process = spawn("render", name, "-o", b"\xff.png")
    _, errors = process.communicate(timeout=20)
    assert process.returncode == 0
    assert rb"wrote \udcff.png" in errors


# --- What is imported ------------------------------------------------------------------------------------

IMPORTED = """
import sys
sys.argv = ["rtcli", *sys.argv[1:]]
try:
    from rtcli.__main__ import run
    run()
finally:
    print(*sys.modules, sep="\\n")
"""


def imported_by(*arguments):
    result = subprocess.run([sys.executable, "-c", IMPORTED, *arguments], stdout=subprocess.PIPE, text=True)
    assert result.returncode == 0
    return set(result.stdout.split("\n"))


@pytest.mark.parametrize("options", [[], ["--exposure", "auto"], ["--bits", "16"], ["--crop", "1,1,9,9"]])
def test_picture_of_the_native_engine_takes_neither_numpy_nor_pillow(scene, options):
    modules = imported_by("render", scene, "-o", "out.png", *options)
    assert "rtcli.tracer._native" in modules
    unneeded = {
        *("numpy", "PIL", "concurrent.futures", "traceback", "asyncio"),
        *(
            "rtcli.rendering.film",
            "rtcli.image.develop",
            "rtcli.tracer.reference",
            "rtcli.scene.schema",
            "rtcli.cli.commands.new",
            "rtcli.live",
            "http.server",
        ),
    }
    assert modules & unneeded == set()


# Of rtcli, the parts that a picture takes. Whoever adds one asks first whether every picture needs it.
PARTS_OF_A_PICTURE = """
    rtcli rtcli.__main__ rtcli.atomic rtcli.cli rtcli.cli.commands rtcli.cli.commands.render rtcli.cli.console
    rtcli.cli.exit_codes rtcli.cli.help rtcli.cli.memory_limit rtcli.cli.options rtcli.cli.options.bounds
    rtcli.cli.options.cluster
    rtcli.cli.options.golden rtcli.cli.options.scene rtcli.cli.options.types rtcli.cli.paths rtcli.cli.program
    rtcli.cli.progress rtcli.compare rtcli.compare.bounds rtcli.extras rtcli.image rtcli.image.display
    rtcli.image.formats rtcli.image.write rtcli.rendering rtcli.rendering.job rtcli.rendering.load
    rtcli.rendering.metadata rtcli.rendering.pack rtcli.rendering.stopwatch rtcli.rendering.stream rtcli.scene
    rtcli.scene.bounds rtcli.scene.diagnostics rtcli.scene.diagnostics.quoting rtcli.scene.files
    rtcli.scene.overrides rtcli.scene.vectors rtcli.signals rtcli.tracer rtcli.tracer._native rtcli.tracer.engines
    rtcli.tracer.native rtcli.tracer.passes rtcli.tracer.world
"""
# What the standard library and others have that takes long to import.
HEAVY = {
    *("numpy", "PIL", "pydantic", "yaml", "typing_extensions", "concurrent.futures", "importlib.metadata"),
    *("secrets", "random", "zipfile", "tempfile", "shutil", "shlex", "traceback", "asyncio", "subprocess"),
}


@pytest.mark.parametrize("options", [[], ["--set", "camera.fov=30"], ["--size", "9x9", "--samples", "4"]])
def test_picture_takes_only_what_it_needs(scene, options):
    modules = imported_by("render", scene, "-o", "out.png", *options)
    expected = {*PARTS_OF_A_PICTURE.split(), *(["rtcli.scene.key_paths"] if "--set" in options else [])}
    assert {name for name in modules if name.partition(".")[0] == "rtcli"} == expected
    assert modules & HEAVY == set()


@pytest.mark.parametrize("option", ["--help", "--version"])
def test_help_and_version_take_no_command(option, tmp_path):
    modules = imported_by(option)
    assert not [name for name in modules if name.startswith(("rtcli.cli.commands", "rtcli.scene.model"))]
    # Click asks `shutil` for the width of the terminal; the version in a checkout asks git.
    assert modules & HEAVY <= ({"shutil"} if option == "--help" else {"subprocess"})


@pytest.mark.parametrize("command", COMMANDS)
def test_summary_of_a_command_is_that_of_its_help(command):
    assert SUMMARIES[command] == main.get_command(None, command).get_short_help_str(limit=200)


def test_reference_engine_takes_numpy_but_not_pillow(scene):
    modules = imported_by("render", scene, "-o", "out.png", "--engine", "reference")
    assert {"numpy", "rtcli.tracer.reference"} <= modules
    assert "PIL" not in modules


# What a plainly valid scene does without: models, readers in Python, and all that makes films.
NOT_FOR_VALID_SCENES = {
    *("numpy", "PIL", "pydantic", "yaml", "rtcli.scene.model", "rtcli.scene.reading.parse"),
    *("rtcli.scene.validation", "rtcli.template", "rtcli.dataset", "rtcli.rendering.film"),
}


@pytest.mark.parametrize("more", ["", "image: {exposure: -30}\n"])
def test_validation_takes_no_models_though_it_looks_at_a_small_picture(scene, more):
    with Path(scene).open("a", encoding="utf-8") as file:
        file.write(more)  # a warning, which has its place in the file
    assert imported_by("validate", scene) & NOT_FOR_VALID_SCENES == set()


def test_validation_takes_yaml_for_comments_that_ignore_warnings(scene):
    with Path(scene).open("a", encoding="utf-8") as file:
        file.write("# rtcli: ignore W004\n")
    assert imported_by("validate", scene) & NOT_FOR_VALID_SCENES == {"yaml"}


def test_characters_that_the_output_cannot_encode_are_escaped(spawn, folder):
    (folder / "wrong.yaml").write_text("größe赤: 1", encoding="utf-8")
    process = spawn("validate", "wrong.yaml", env={**os.environ, "PYTHONIOENCODING": "latin-1"})
    out, err = process.communicate()
    assert (process.returncode, err) == (1, b"")
    assert "unknown key `größe\\u8d64`".encode("latin-1") in out


# --- Signals ---------------------------------------------------------------------------------------------


def wait_for_progress(process):
    """Wait until the rendering reports progress."""
    assert process.stderr.readline().startswith(b"rendering: ")


# A tenth of it takes about a second, all of it longer than this test waits.
LONG = {
    "native": ["--engine", "native", "--size", "6000x6000", "--samples", "256"],
    "reference": ["--engine", "reference", "--size", "3000x3000", "--samples", "4"],
}


@needs_posix
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
@pytest.mark.parametrize("threads", ["1", "2"])
def test_signal_ends_a_rendering_by_that_very_signal_and_leaves_no_file(
    spawn, scene, folder, engine, name, threads
):
    number = getattr(signal, name)
    (folder / "old.png").write_bytes(b"old")
    process = spawn("render", scene, "-o", "old.png", "--threads", threads, *LONG[engine])
    wait_for_progress(process)
    assert len(names_in(folder)) == 3  # the temporary file among them
    process.send_signal(number)
    start = time.perf_counter()
    output, errors = process.communicate(timeout=20)
    assert time.perf_counter() - start < 5
    assert process.returncode == -number
    assert output == b""
    assert b"Traceback" not in errors
    assert names_in(folder) == ["old.png", "scene.yaml"]
    assert (folder / "old.png").read_bytes() == b"old"


@needs_posix
def test_signal_is_heeded_at_once_where_each_tile_takes_minutes(spawn, folder, engine):
    size = ["--size", "400x300"] if engine == "reference" else ["--size", "20000x20000"]
    spheres = "".join(
        f"  - {{type: sphere, position: [{i % 50 - 25}, {i // 50 - 25}, -60], radius: 0.4, color: white}}\n"
        for i in range(2500)
    )
    (folder / "crowd.yaml").write_text(f"camera: {{resolution: [400, 300], fov: 40}}\nobjects:\n{spheres}")
    process = spawn("render", "crowd.yaml", "-o", "out.png", "--engine", engine, "--samples", "1024", *size)
    for _ in range(100):
        if len(names_in(folder)) == 2:  # the temporary file: the work has started
            break
        time.sleep(0.1)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=5)
    assert process.returncode == -signal.SIGINT
    assert names_in(folder) == ["crowd.yaml"]


@needs_posix
def test_signal_that_was_ignored_stays_ignored(spawn, scene, folder):
    as_nohup_does_it = "trap '' HUP"
    options = ["--engine", "reference", "--size", "1300x1280", "--threads", "1"]
    process = spawn("render", scene, "-o", "out.png", *options, prelude=as_nohup_does_it)
    wait_for_progress(process)
    process.send_signal(signal.SIGHUP)
    process.communicate(timeout=30)
    assert process.returncode == 0
    assert names_in(folder) == ["out.png", "scene.yaml"]


def test_signal_handlers_are_given_back(run, scene):
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    run("validate", scene)
    assert {number: signal.getsignal(number) for number in before} == before


# --- Terminals -------------------------------------------------------------------------------------------


def on_terminal(command, stream):
    """Run a command with one stream on a terminal; return its exit code and the terminal's text."""
    import pty

    ours, theirs = pty.openpty()
    streams = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, stream: theirs}
    process = subprocess.Popen([sys.executable, *command], **streams)
    os.close(theirs)
    shown = b""
    with contextlib.suppress(OSError):  # Linux: the other side is closed
        while piece := os.read(ours, 4096):
            shown += piece
    os.close(ours)
    return process.wait(timeout=20), shown.decode()


RENDER = ["-m", "rtcli", "render", "scene.yaml", "-o"]

# A rendering of a known duration: click shows the remaining time only after a second.
SLOW_PROGRESS = """
import time
from rtcli.cli.progress import progress
with progress("rendering", quiet=False) as told:
    for done in (10, 20, 30, 100):
        time.sleep(0.4)
        told(done, 100)
"""


@needs_posix
def test_terminal_sees_a_bar_with_percentage_and_remaining_time():
    code, shown = on_terminal(["-c", SLOW_PROGRESS], "stderr")
    assert code == 0
    assert re.search(r"rendering +\[#+-+\] +10%", shown)
    assert re.search(r"rendering +\[#+-+\] +30% +00:00:0\d", shown)
    assert re.search(r"rendering +\[#+\] +100%", shown)


@needs_posix
def test_terminal_sees_the_bar_of_a_rendering_and_its_end(scene):
    code, shown = on_terminal([*RENDER, "out.png", "--size", "300x200"], "stderr")
    assert code == 0
    assert "rendering: " not in shown
    assert re.search(r"\[#+\] +100%", shown)
    assert re.search(r"wrote out\.png \(300x200\) in [0-9.]+ s\s*$", shown)


@needs_posix
def test_quiet_terminal_sees_nothing(scene):
    assert on_terminal([*RENDER, "out.png", "--quiet"], "stderr") == (0, "")


@needs_posix
def test_picture_is_not_thrown_at_a_terminal(scene):
    assert on_terminal([*RENDER, "-"], "stdout") == (2, "")
