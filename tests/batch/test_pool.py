"""Tasks in executors, and workers that die. The function is `eval`, so that a task can be any expression."""

import functools
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import pytest

from rtcli.batch.pool import LocalWorkers, Result, WorkerDiedError, Workers, WorkersError, results

ROOT = Path(__file__).resolve().parent.parent.parent
DIE = "__import__('os')._exit(9)"

needs_proc = pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="a system without /proc")


def news(*arguments):
    """Yield results without the None in between: on a busy machine workers take time to start."""
    return (result for result in results(*arguments) if result is not None)


@pytest.fixture
def local():
    """Two local workers, which are closed afterwards."""
    workers = LocalWorkers(2)
    yield workers
    workers.close()


def test_any_executor_does_the_work():
    with ThreadPoolExecutor(2) as threads:
        found = {result.task: result.value for result in news(Workers(threads, 3), eval, ["1+1", "2+2", "3+3"])}
    assert found == {"1+1": 2, "2+2": 4, "3+3": 6}


def test_no_task_is_no_work():
    with ThreadPoolExecutor(1) as threads:
        assert list(results(Workers(threads, 3), eval, [])) == []


def test_result_among_the_tasks_is_yielded_as_it_is():
    known = Result("1/0", 7)
    with ThreadPoolExecutor(1) as threads:
        found = list(news(Workers(threads, 1), eval, [known, "1+1", known]))
    assert found == [known, Result("1+1", 2), known]


def test_wait_for_a_long_task_is_told(monkeypatch):
    monkeypatch.setattr("rtcli.batch.pool._HEARTBEAT", 0.01)
    with ThreadPoolExecutor(1) as threads:
        *before, last = results(Workers(threads, 3), eval, ["__import__('time').sleep(0.3)"])
    assert set(before) == {None}
    assert last.error is None


@pytest.mark.parametrize("slots", [1, 2, 5])
def test_no_more_groups_are_taken_than_there_are_slots(slots, monkeypatch):
    monkeypatch.setattr("rtcli.batch.pool._MAX_GROUP", 3)
    taken = 0

    def tasks():
        nonlocal taken
        for number in range(60):
            taken += 1
            yield str(number)

    with ThreadPoolExecutor(2) as threads:
        for count, _ in enumerate(news(Workers(threads, slots), eval, tasks()), start=1):
            assert taken <= count + 3 * slots - 1
    assert taken == 60


class Recording(Workers):
    """Workers that record how many tasks they are given at a time."""

    def __init__(self, executor):
        super().__init__(executor, 1)
        self.sizes = []

    def submit(self, function, task):
        self.sizes.append(len(task[1]))
        return super().submit(function, task)


@pytest.mark.parametrize(("seconds", "sizes"), [(1e9, [1, 16, 16, 7]), (0.0, [1] * 40)])
def test_tasks_go_to_a_worker_in_groups_that_take_it_some_time(seconds, sizes, monkeypatch):
    monkeypatch.setattr("rtcli.batch.pool._GROUP_SECONDS", seconds)
    with ThreadPoolExecutor(1) as threads:
        workers = Recording(threads)
        found = [result.value for result in news(workers, eval, [str(number) for number in range(40)])]
    assert found == list(range(40))
    assert workers.sizes == sizes


def test_large_tasks_go_to_a_worker_in_small_groups(monkeypatch):
    monkeypatch.setattr("rtcli.batch.pool._GROUP_SECONDS", 1e9)
    monkeypatch.setattr("rtcli.batch.pool._MAX_GROUP_BYTES", 10)
    with ThreadPoolExecutor(1) as threads:
        workers = Recording(threads)
        found = [result.value for result in news(workers, eval, [str(10**number) for number in range(12)], len)]
    assert found == [10**number for number in range(12)]
    assert workers.sizes == [1, 4, 2, 2, 2, 1]


def test_group_ends_with_a_task_that_takes_long(monkeypatch):
    monkeypatch.setattr("rtcli.batch.pool._GROUP_SECONDS", 1e9)
    monkeypatch.setattr("rtcli.batch.pool._MOST_SECONDS", 0)
    with ThreadPoolExecutor(1) as threads:
        workers = Recording(threads)
        found = [result.value for result in news(workers, eval, list(map(str, range(40))))]
    assert sorted(found) == list(range(40))
    # What was not begun goes to workers one by one.
    assert workers.sizes == [1, 16, *[1] * 15, 16, *[1] * 15, 7, *[1] * 6]


@pytest.mark.parametrize("first", [0, 1])
def test_task_that_fails_in_a_group_costs_no_other(first, monkeypatch):
    monkeypatch.setattr("rtcli.batch.pool._GROUP_SECONDS", 1e9)
    calls = []

    def work(task):
        calls.append(task)
        if task == 7 or (task in (first, 8, 20) and calls.count(task) == 1):
            raise MemoryError(task)
        return task

    with ThreadPoolExecutor(1) as threads:
        found = {result.task: result for result in news(Recording(threads), work, range(30))}
    assert [task for task, result in found.items() if result.error is not None] == [7]
    assert found.keys() == set(range(30))
    assert all(calls.count(task) == (2 if task in (first, 7, 8, 20) else 1) for task in found)


def test_worker_that_dies_at_work_on_a_group_costs_its_own_task_alone(local, monkeypatch):
    monkeypatch.setattr("rtcli.batch.pool._GROUP_SECONDS", 1e9)
    tasks = [*map(str, range(20)), DIE, *map(str, range(20, 40))]
    found = {result.task: result for result in news(local, eval, tasks)}
    assert isinstance(found.pop(DIE).error, WorkerDiedError)
    assert {result.value for result in found.values()} == set(range(40))
    assert all(result.error is None for result in found.values())


def test_task_that_kills_its_workers_costs_two_however_many_tasks_went_with_it(local, tmp_path, monkeypatch):
    monkeypatch.setattr("rtcli.batch.pool._GROUP_SECONDS", 1e9)
    killer = f"__import__('pathlib').Path({str(tmp_path / 'deaths')!r}).open('ab', 0).write(b'x'), {DIE}"
    errors = [result.error for result in news(local, eval, [*map(str, range(20)), killer, "20"])]
    assert sum(error is not None for error in errors) == 1
    assert (tmp_path / "deaths").read_text() == "xx"


def test_task_that_raises_is_tried_once_more_and_then_told():
    calls = []

    def work(task):
        calls.append(task)
        if task == "bad" or (task == "once" and calls.count(task) == 1):
            raise MemoryError(task)
        return task

    with ThreadPoolExecutor(1) as threads:
        found = {result.task: result for result in news(Workers(threads, 2), work, ["good", "bad", "once"])}
    assert found["good"].value == "good"
    assert isinstance(found["bad"].error, MemoryError)
    assert found["once"].value == "once"
    assert sorted(calls) == ["bad", "bad", "good", "once", "once"]


def test_worker_that_dies_costs_its_own_task_alone(local):
    tasks = [*(f"{number}+0" for number in range(10)), DIE, *(f"{number}+0" for number in range(10, 20))]
    found = {result.task: result for result in news(local, eval, tasks)}
    assert isinstance(found.pop(DIE).error, WorkerDiedError)
    assert {result.value for result in found.values()} == set(range(20))
    assert all(result.error is None for result in found.values())


def test_worker_that_dies_while_a_task_is_submitted_costs_no_task(local, monkeypatch):
    submit, calls = ProcessPoolExecutor.submit, []

    def closed(self, *arguments):
        calls.append(arguments)
        if len(calls) == 3:
            raise OSError("handle is closed")
        return submit(self, *arguments)

    monkeypatch.setattr(ProcessPoolExecutor, "submit", closed)
    found = list(news(local, eval, [f"{number}+0" for number in range(9)]))
    assert sorted(result.value for result in found) == list(range(9))


def test_every_worker_that_dies_is_told(local):
    tasks = [f"{DIE} or {number}" for number in range(3)]
    found = list(news(local, eval, tasks))
    assert sorted(result.task for result in found) == tasks
    assert all(isinstance(result.error, WorkerDiedError) for result in found)


def test_task_whose_worker_died_once_is_done(local, tmp_path):
    # It creates a file and dies; the second time the file exists.
    mark = tmp_path / "mark"
    task = f"(p := __import__('pathlib').Path({str(mark)!r})).exists() or (p.touch(), {DIE})"
    [result] = news(local, eval, [task])
    assert result.value is True


def test_workers_that_cannot_start_are_told_and_not_tried_for_ever(local, monkeypatch):
    monkeypatch.setattr("rtcli.batch.pool._start_worker", functools.partial(os._exit, 3))
    local.close()
    with pytest.raises(WorkersError, match="as soon as they start"):
        local.restart()


def test_error_that_cannot_be_sent_is_told(local):
    [result] = news(local, eval, ["(_ for _ in ()).throw(type('Odd', (BaseException,), {})('x'))"])
    assert result.error is not None
    assert not isinstance(result.error, WorkerDiedError)


def test_closing_ends_workers_at_once_whatever_they_do():
    workers = LocalWorkers(2)
    future = workers.submit(eval, "__import__('os').getpid()")
    pid = future.result()
    workers.submit(eval, "__import__('time').sleep(60)")
    start = time.monotonic()
    workers.close()
    assert time.monotonic() - start < 10
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.skipif(os.name == "nt", reason="POSIX only")
def test_worker_that_heeds_no_signal_is_killed():
    workers = LocalWorkers(1)
    signals = "__import__('signal')"
    ignore = f"{signals}.signal({signals}.SIGTERM, {signals}.SIG_IGN)"
    pid = workers.submit(eval, f"({ignore}, __import__('os').getpid())[1]").result()
    workers.submit(eval, "__import__('time').sleep(60)")
    start = time.monotonic()
    workers.close()
    assert time.monotonic() - start < 10
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


_PARENT = """
import time
from rtcli.batch.pool import LocalWorkers
if __name__ == "__main__":
    workers = LocalWorkers(2)
    task = "(__import__('time').sleep(0.5), __import__('os').getpid())[1]"
    futures = [workers.submit(eval, task) for _ in range(2)]
    print(*(future.result() for future in futures), flush=True)
    workers.submit(eval, "__import__('time').sleep(60)")
    time.sleep(60)
"""


@needs_proc
def test_workers_end_with_the_program_that_is_killed(tmp_path):
    (tmp_path / "parent.py").write_text(_PARENT)
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL, "text": True}
    parent = subprocess.Popen([sys.executable, str(tmp_path / "parent.py")], env=environment, **pipes)
    pids = parent.stdout.readline().split()
    assert len(set(pids)) == 2
    os.kill(parent.pid, signal.SIGKILL)
    parent.communicate()
    end = time.monotonic() + 20
    while (left := [pid for pid in pids if is_running(pid)]) and time.monotonic() < end:
        time.sleep(0.05)
    assert left == []


def is_running(pid):
    """Return whether a process is running, and not a zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def environment(nothing):
    return {name: value for name, value in os.environ.items() if name.startswith("MALLOC_")}


def test_workers_keep_memory_for_the_next_scene_and_the_program_is_as_before(monkeypatch):
    monkeypatch.setenv("MALLOC_TRIM_THRESHOLD_", "12345")
    monkeypatch.delenv("MALLOC_MMAP_THRESHOLD_", raising=False)
    workers = LocalWorkers(1)
    try:
        found = workers.submit(environment, None).result()
    finally:
        workers.close()
    assert found == {"MALLOC_TRIM_THRESHOLD_": "12345", "MALLOC_MMAP_THRESHOLD_": str(256 << 20)}
    assert environment(None) == {"MALLOC_TRIM_THRESHOLD_": "12345"}
