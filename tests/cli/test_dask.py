"""`--dask`: a real scheduler and two worker processes on the loopback, some of which die."""

import contextlib
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from batches import entries, lasting, private_files, results_in, write_scene, write_scenes
from clusters import no_workers, two_workers, worker_of
from template_texts import TEXT

from rtcli.cli.options.cluster import connected_cluster
from rtcli.distributed.dask import Cluster

pytestmark = [pytest.mark.integration, pytest.mark.skipif(os.name == "nt", reason="POSIX only")]

OUT = Path("out")
PASSES = ("--passes", "depth,normal")

# A worker takes a tenth of a second for such a scene.
OPTIONS = ("--size", "320x240", "--samples", "64", *PASSES)


@pytest.fixture
def cluster():
    pytest.importorskip("distributed", exc_type=ImportError)
    with two_workers() as started:
        yield started


@pytest.fixture
def scenes(folder):
    """Forty small scenes."""
    return write_scenes(folder / "scenes", 40)


def wait_until(happened, seconds=60):
    end = time.monotonic() + seconds
    while not happened():
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.01)


def pictures():
    return list(OUT.glob("???.png"))


def processes_of(session):
    """Return the running processes of a session."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
        except (FileNotFoundError, ProcessLookupError):
            continue
        if fields[3] == str(session) and fields[0] != "Z":
            found.append(folder.name)
    return found


# --- Many scenes -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("shared", [(), ("--shared",)], ids=["brought back", "shared"])
def test_batch_of_a_cluster_that_loses_a_worker_is_that_of_one_machine(run, spawn, scenes, cluster, shared):
    write_scene(scenes[7], -1)
    assert run("batch", "scenes", "-o", "whole", *OPTIONS).exit_code == 1
    process = spawn("batch", "scenes", "-o", "out", *OPTIONS, "--dask", cluster.address, *shared)
    wait_until(lambda: len(pictures()) >= 6)
    cluster.workers[0].kill()
    assert len(pictures()) < 39
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 1
    assert b"39 rendered, 0 current, 1 failed" in errors
    assert b"Traceback" not in errors
    assert len(results_in(OUT)) == 39 * 4
    assert results_in(OUT) == results_in(Path("whole"))
    assert lasting(OUT) == lasting(Path("whole"))
    assert private_files(OUT) == [".rtcli/lock"]
    assert cluster.workers[1].poll() is None
    told = run("batch", "scenes", "-o", "out", *OPTIONS).stderr
    assert "0 rendered, 39 current, 1 failed" in told


def test_scheduler_that_dies_ends_the_batch_and_the_next_goes_on_from_there(run, spawn, scenes, cluster):
    assert run("batch", "scenes", "-o", "whole", *OPTIONS).exit_code == 0
    process = spawn("batch", "scenes", "-o", "out", *OPTIONS, "--dask", cluster.address)
    wait_until(lambda: len(pictures()) >= 6)
    cluster.scheduler.kill()
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 3
    assert errors.splitlines()[-1].startswith(
        b"Error: the connection to the workers was lost: finished results are kept"
    )
    assert b"Traceback" not in errors
    assert private_files(OUT) == [".rtcli/lock"]
    done = [key for key, entry in entries(OUT).items() if entry["status"] == "done"]
    assert len(done) == len(entries(OUT)) == len(pictures()) >= 6
    assert results_in(OUT).items() < results_in(Path("whole")).items()
    assert (
        f"{40 - len(done)} rendered, {len(done)} current" in run("batch", "scenes", "-o", "out", *OPTIONS).stderr
    )
    assert results_in(OUT) == results_in(Path("whole"))
    assert lasting(OUT) == lasting(Path("whole"))


def test_scheduler_that_is_not_there_costs_nothing(run, scenes):
    pytest.importorskip("distributed", exc_type=ImportError)
    run("batch", "scenes", "-o", "out")
    scenes[0].unlink()
    write_scene(scenes[1], 0.1)
    before = results_in(OUT)
    result = run("batch", "scenes", "-o", "out", "--prune", "--dask", "tcp://127.0.0.1:9")
    assert result.exit_code == 3
    assert "no Dask scheduler answers at 'tcp://127.0.0.1:9'" in result.stderr
    assert results_in(OUT) == before


@pytest.mark.parametrize("to_all", [False, True], ids=["to the program", "to all of its processes"])
def test_interrupt_ends_a_cluster_of_this_machine(spawn, folder, to_all):
    pytest.importorskip("distributed", exc_type=ImportError)
    write_scene(folder / "scenes" / "000.yaml")
    for path in write_scenes(folder / "scenes" / "long", 3):
        path.write_text(path.read_text().replace("[40, 30]", "[20000, 20000]") + "render: {samples: 1024}\n")
    process = spawn("batch", "scenes", "-o", "out", "--dask", "local")
    wait_until(lambda: (OUT / "manifest.json").exists())
    (os.killpg if to_all else os.kill)(process.pid, signal.SIGINT)
    start = time.perf_counter()
    _, errors = process.communicate(timeout=30)
    assert time.perf_counter() - start < 5
    assert process.returncode == -signal.SIGINT
    assert b"Traceback" not in errors
    assert private_files(OUT) == [".rtcli/lock"]
    assert list(entries(OUT)) == ["000"]
    if Path("/proc/self/stat").exists():
        wait_until(lambda: not processes_of(process.pid), 5)


# --- A data set ------------------------------------------------------------------------------------------


@pytest.fixture
def template(folder):
    """A template of 500 samples, which take some seconds."""
    (folder / "t.yaml").write_text(TEXT.replace("count: 2500", "count: 500"))
    return "t.yaml"


def pieces():
    """Return the lists of labels of the pieces that are done or begun."""
    return list(OUT.glob(".rtcli/run-*/*.jsonl"))


@pytest.mark.parametrize("shared", [(), ("--shared",)], ids=["brought back", "shared"])
def test_data_set_of_a_cluster_that_loses_a_worker_is_that_of_one_machine(run, spawn, template, cluster, shared):
    options = ("--to", "webdataset,coco", "--passes", "depth")
    assert run("dataset", template, "-o", "whole/set", *options).exit_code == 0
    process = spawn("dataset", template, "-o", "out", *options, "--dask", cluster.address, *shared)
    wait_until(lambda: len(pieces()) >= 2)
    cluster.workers[0].kill()
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    assert b"train 400, test 100; 0 left out" in errors
    assert cluster.workers[1].poll() is None
    assert files_of(OUT) == files_of(Path("whole/set"))


def files_of(folder):
    """Return the bytes of the files of a data set; its card has the name of the folder."""
    files = (path for path in folder.rglob("*") if path.is_file() and path.name != "README.md")
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def test_scheduler_that_dies_ends_a_data_set_and_the_next_run_goes_on(run, spawn, template, cluster):
    process = spawn("dataset", template, "-o", "out", "--dask", cluster.address)
    wait_until(lambda: len(pieces()) >= 2)
    cluster.scheduler.kill()
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 3
    assert errors.splitlines()[-1].startswith(b"Error: the connection to the workers was lost")
    assert b"Traceback" not in errors
    assert run("dataset", template, "-o", "out", "-q").exit_code == 0
    assert run("dataset", template, "-o", "whole", "-q").exit_code == 0
    assert files_of(OUT) == files_of(Path("whole"))


# --- One picture -----------------------------------------------------------------------------------------


def test_picture_of_a_cluster_is_that_of_one_machine(run, scene, cluster):
    for name, options in {
        "plain.png": [],
        "deep.png": ["--bits", "16", "--exposure", "auto"],
        "small.png": ["--compress", "small"],
        "passes.png": PASSES,
        "all.npz": ["--passes", "all"],
        "crop.webp": ["--crop", "50,37,200,150"],
        "other.npy": ["--engine", "reference", "--size", "40x30"],
    }.items():
        arguments = ["render", scene, "--size", "400x300", "--samples", "4", *options]
        for folder, dask in (("local", []), ("cluster", ["--dask", cluster.address])):
            Path(folder).mkdir(exist_ok=True)
            assert run(*arguments, "-o", f"{folder}/{name}", *dask).exit_code == 0
    assert len(results_in(Path("local"))) == 10
    assert results_in(Path("cluster")) == results_in(Path("local"))


def test_scheduler_that_dies_leaves_no_picture(spawn, scene, cluster):
    process = spawn(
        "render", scene, "-o", "a.png", "--size", "8000x8000", "--samples", "256", "--dask", cluster.address
    )
    wait_until(lambda: list(Path().glob(".rtcli-*.tmp")))
    time.sleep(2)
    cluster.scheduler.kill()
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 3
    told = f"Error: the connection to the Dask scheduler was lost at '{cluster.address}'".encode()
    assert errors.splitlines()[-1] == told
    assert [path.name for path in Path().iterdir()] == [scene]


# --- What is refused -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "answer", [b"HTTP/1.1 400 Bad Request\r\n\r\n", bytes(8), b""], ids=["HTTP", "zeros", "none"]
)
def test_server_of_another_kind_is_not_taken_for_a_lack_of_memory(run, scene, answer):
    pytest.importorskip("distributed", exc_type=ImportError)
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]

        def serve():
            with contextlib.suppress(OSError):  # closed at the end
                while True:
                    connection, _ = server.accept()
                    connections.append(connection)
                    connection.sendall(answer)

        connections = []
        threading.Thread(target=serve, daemon=True).start()
        result = run("render", scene, "-o", "a.png", "--dask", f"tcp://127.0.0.1:{port}", "--dask-timeout", "2")
    assert result.exit_code == 3
    assert f"no Dask scheduler answers at 'tcp://127.0.0.1:{port}': " in result.stderr
    assert "memory" not in result.stderr


def test_threads_are_of_this_machine(run, scene):
    result = run("render", scene, "-o", "a.png", "--dask", "local", "--threads", "2")
    assert result.exit_code == 2
    assert "--threads cannot be used with --dask" in " ".join(result.stderr.split())


@pytest.mark.parametrize(
    "arguments", [["batch", "scene.yaml", "-o", "out"], ["render", "scene.yaml", "-o", "a.png"]]
)
def test_missing_extra_is_told_with_how_to_install_it(scene, arguments):
    program = "import sys; sys.modules['distributed'] = None; from rtcli.cli import main; main(prog_name='rtcli')"
    command = [sys.executable, "-c", program, *arguments, "--dask", "local"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 3
    told = "Error: rendering on a Dask cluster needs the package distributed: pip install distributed\n"
    assert result.stderr == told
    assert not Path("a.png").exists()
    assert not Path("out").exists()


@pytest.mark.parametrize("command", [["batch", "scenes", "-o", "out"], ["render", "scene.yaml", "-o", "a.png"]])
@pytest.mark.parametrize("way", ["option", "variable"])
def test_cluster_without_workers_is_given_up_after_a_while(run, scene, scenes, command, way):
    pytest.importorskip("distributed", exc_type=ImportError)
    with no_workers() as cluster:
        option = ["--dask-timeout", "1"] if way == "option" else []
        env = {} if option else {f"RTCLI_{command[0].upper()}_DASK_TIMEOUT": "1"}
        start = time.monotonic()
        result = run(*command, "--dask", cluster.address, *option, env=env)
    assert time.monotonic() - start < 20
    assert result.exit_code == 3
    waiting, *_, error = result.stderr.splitlines()
    assert waiting == f"the cluster at {cluster.address} has no workers yet; waiting"
    told = f"the cluster at '{cluster.address}' had no workers for 1 s: start workers, or raise --dask-timeout"
    assert error == f"Error: {told}"
    assert not Path("a.png").exists()
    assert not list(Path().glob("**/*.tmp"))
    assert not pictures()


def test_late_worker_of_another_version_ends_a_batch_and_the_next_goes_on(run, spawn, scenes):
    pytest.importorskip("distributed", exc_type=ImportError)
    assert run("batch", "scenes", "-o", "whole", *OPTIONS).exit_code == 0
    with no_workers() as cluster, worker_of(cluster) as worker:
        process = spawn("batch", "scenes", "-o", "out", *OPTIONS, "--dask", cluster.address)
        wait_until(lambda: len(pictures()) >= 2)
        worker.send_signal(signal.SIGSTOP)  # else it might be done before the other one has started
        with worker_of(cluster, "9.9.9"):
            worker.send_signal(signal.SIGCONT)
            _, errors = process.communicate(timeout=60)
    assert process.returncode == 3
    assert re.fullmatch(
        r"Error: the worker at tcp://\S+ has rtcli 9\.9\.9, not \S+: install the same version on both",
        errors.decode().splitlines()[-1],
    )
    assert b"Traceback" not in errors
    assert all(entry["status"] == "done" for entry in entries(OUT).values())
    assert run("batch", "scenes", "-o", "out", *OPTIONS).exit_code == 0
    assert results_in(OUT) == results_in(Path("whole"))


@pytest.mark.parametrize("seconds", ["0", "-1", "soon", "nan"])
def test_timeout_is_a_number_of_seconds(run, scene, seconds):
    for command in (["batch", scene, "-o", "out"], ["render", scene, "-o", "a.png"]):
        assert run(*command, "--dask", "tcp://127.0.0.1:9", "--dask-timeout", seconds).exit_code == 2


@pytest.mark.parametrize(("cores", "told"), [(0, "the cluster at tcp://a:1 has no workers yet; waiting"), (1, "")])
def test_cluster_without_workers_is_told(cores, told, capsys, monkeypatch):
    empty = contextlib.nullcontext(Cluster(None, cores))
    monkeypatch.setattr("rtcli.distributed.dask.dask_cluster", lambda address, timeout: empty)
    with connected_cluster("tcp://a:1", 60):
        pass
    assert capsys.readouterr().err.startswith(told)
    assert bool(told) == (cores == 0)


def test_cluster_of_this_machine_is_quiet_though_another_has_dasks_port(run, scenes):
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):  # already in use
            stack.enter_context(socket.create_server(("127.0.0.1", 8787)))
        result = run("batch", "scenes", "-o", "quiet", "--dask", "local", "-q")
    assert (result.exit_code, result.stderr) == (0, "")
