"""The options of several commands that use a Dask cluster, and the connection to it."""

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
    from rtcli.distributed.dask import Cluster

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
