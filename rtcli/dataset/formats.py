"""The forms of a data set: which files hold its samples.

To add one, write its class in `rtcli.dataset.forms`, and add it to `FORMATS`. A worker calls `add` for each sample
of a piece and `close` after the last; then `finish_shard` and, once all shards are done, `finish_set` run in the
main process.
"""

from __future__ import annotations

from collections.abc import Mapping

from rtcli.dataset.forms.clevr import Clevr
from rtcli.dataset.forms.coco import Coco
from rtcli.dataset.forms.files import Files
from rtcli.dataset.forms.form import Form
from rtcli.dataset.forms.hdf5 import Hdf5
from rtcli.dataset.forms.parquet import Parquet
from rtcli.dataset.forms.webdataset import WebDataset

# By the name that `--to` takes.
FORMATS: Mapping[str, type[Form]] = {
    "files": Files,
    "webdataset": WebDataset,
    "coco": Coco,
    "hdf5": Hdf5,
    "parquet": Parquet,
    "clevr": Clevr,
}
