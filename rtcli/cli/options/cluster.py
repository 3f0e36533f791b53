"""The options of several commands that use a Dask cluster, the connection to it, and the workers of a command."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from rtcli.cli.console import report_line
from rtcli.cli.help import Option
from rtcli.cli.options.types import WholeNumber, option_group
from rtcli.scene.diagnostics.quoting import printable

if TYPE_CHECKING:
    from rtcli.batch.pool import Workers
    from rtcli.distributed.dask import Cluster

# The least number of tasks that a cluster has at a time.
_MIN_SLOTS = 64

cluster_option = functools.partial(click.option, cls=Option, heading="Cluster")

cluster_options = option_group(
    cluster_option(
        "--dask",
        metavar="ADDRESS",
        help="Use the Dask cluster at ADDRESS; local starts one.",
    ),
    cluster_option(
        "--dask-timeout",
        type=WholeNumber(1),
        metavar="SEC",
        default=60,
        show_default=True,
        help="Wait SEC seconds for workers.",
    ),
)


@contextlib.contextmanager
def connected_cluster(address: str, timeout: int) -> Iterator[Cluster]:
    """Connect to a cluster with `dask_cluster`, and report if it has no workers yet."""
    from rtcli.distributed.dask import dask_cluster  # few runs need it

    with dask_cluster(address, timeout) as cluster:
        if not cluster.cores:
            report_line(f"the cluster at {printable(address)} has no workers yet; waiting")
        yield cluster


# For commands whose workers write files to the folder DIR.
shared_option = cluster_option("--shared", is_flag=True, help="Let workers write to DIR, the same folder for all.")


def check_workers(dask: str | None, jobs: int | None, shared: bool) -> None:
    """Raise click.UsageError for options of workers that exclude each other."""
    if dask is not None and jobs is not None:
        raise click.UsageError("--jobs cannot be used with --dask, which uses all workers of the cluster")
    if shared and dask is None:
        raise click.UsageError(
            "--shared cannot be used without --dask; the workers of one machine share DIR anyway"
        )


@contextlib.contextmanager
def workers_of(dask: str | None, timeout: int, jobs: int) -> Iterator[Workers]:
    """Yield the workers of a cluster, or a number of processes of this machine without one."""
    from rtcli.batch.pool import LocalWorkers, Workers  # `render` does without

    if dask is None:
        yield LocalWorkers(jobs)
        return
    with connected_cluster(dask, timeout) as cluster:
        # An adaptive cluster adds workers only once tasks are waiting.
        yield Workers(cluster.executor, max(_MIN_SLOTS, 2 * cluster.cores))
