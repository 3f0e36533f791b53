"""The `--dask` of several commands: its timeout, and the connection to its cluster."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from rtcli.cli.console import report_line
from rtcli.scene.diagnostics.quoting import printable

if TYPE_CHECKING:
    from rtcli.distributed.dask import Cluster

dask_timeout_option = click.option(
    "--dask-timeout",
    type=click.IntRange(1),
    metavar="SECONDS",
    default=60,
    show_default=True,
    help="Give up after SECONDS without any workers on the Dask cluster.",
)


@contextlib.contextmanager
def connected_cluster(address: str, timeout: int) -> Iterator[Cluster]:
    """Connect to a cluster with `dask_cluster`, and report if it has no workers yet."""
    from rtcli.distributed.dask import dask_cluster  # few runs need it

    with dask_cluster(address, timeout) as cluster:
        if not cluster.cores:
            report_line(f"the cluster at {printable(address)} has no workers: waiting for some")
        yield cluster
