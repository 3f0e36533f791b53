"""How `--dask` of several commands reaches its cluster."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from rtcli.cli.console import report_waiting

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
def reached_cluster(address: str, timeout: int) -> Iterator[Cluster]:
    """Connect to the cluster at an address, as `dask_cluster` does, and say so if it has no workers yet."""
    from rtcli.distributed.dask import dask_cluster  # with what few runs need

    with dask_cluster(address, timeout) as cluster:
        report_waiting(cluster.cores, address)
        yield cluster
