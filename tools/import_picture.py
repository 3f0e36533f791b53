"""Draw the imports among the parts of rtcli as an SVG, with a box for each module of the import linter's layers.

The rows are the layers of the first layers contract in `pyproject.toml`, so the picture follows when folders
change. `tools/refresh.py` writes it to `docs/architecture.svg`.
"""

from __future__ import annotations

import itertools
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import escape

import grimp
from importlinter.api import read_configuration

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = "rtcli"

# Not worth naming: a backport of the standard library, and a part of pydantic.
_OMITTED = frozenset({"typing_extensions", "pydantic_core"})
_DISTRIBUTIONS = {"PIL": "Pillow", "numpy": "NumPy", "yaml": "PyYAML"}

# Pixels.
_MARGIN, _ROW, _BOX, _GAP, _LANE = 24, 86, 44, 22, 14
_NAME_CHARACTER, _NOTE_CHARACTER, _PADDING = 8.5, 6.3, 24
# The number of sweeps that sort the rows; a few suffice.
_SWEEPS = 12

_STYLE = """
  .page { fill: #ffffff; }
  .box { fill: #eef3fa; stroke: #5b7aa6; }
  .name { font: 600 14px ui-monospace, SFMono-Regular, Menlo, Consolas, monospace; fill: #16233a; }
  .note { font: 11px system-ui, "Segoe UI", Helvetica, Arial, sans-serif; fill: #4d5f7a; }
  .import { fill: none; stroke: #7f93b2; stroke-width: 1.4; }
  .head { fill: #7f93b2; }
  @media (prefers-color-scheme: dark) {
    .page { fill: #0d1117; }
    .box { fill: #1b2638; stroke: #6f8fbd; }
    .name { fill: #e6edf7; }
    .note { fill: #a5b4ca; }
    .import { stroke: #6d7f9b; }
    .head { fill: #6d7f9b; }
  }
"""


@dataclass(frozen=True)
class Imports:
    """The imports among the modules of the layers.

    Parameters
    ----------
    layers
        The modules of each layer, the topmost first.
    packages
        The modules that are folders.
    edges
        Pairs of modules, (importer, imported), without those that a longer path implies.
    externals
        The third-party distributions that each module imports, sorted.
    """

    layers: tuple[tuple[str, ...], ...]
    packages: frozenset[str]
    edges: tuple[tuple[str, str], ...]
    externals: Mapping[str, tuple[str, ...]]


# --- The imports -----------------------------------------------------------------------------------------


def read_layers(config: Path = ROOT / "pyproject.toml") -> tuple[tuple[str, ...], ...]:
    """Return the modules of each layer of the first layers contract, the topmost first."""
    contracts = read_configuration(str(config))["contracts_options"]
    contract = next(options for options in contracts if options["type"] == "layers")
    (prefix,) = (f"{name}." for name in contract["containers"]) if contract.get("containers") else ("",)
    return tuple(tuple(f"{prefix}{name}" for name in re.findall(r"[\w.]+", row)) for row in contract["layers"])


def read_imports() -> Imports:
    """Return the imports among the layers of the package, read from its source files.

    Raises
    ------
    ValueError
        If a module is in no layer, or a layer imports from itself.
    """
    layers = read_layers()
    graph = grimp.build_graph(
        PACKAGE, include_external_packages=True, exclude_type_checking_imports=True, cache_dir=None
    )
    parts = {name for layer in layers for name in layer}
    owners = {module: _owner(module, parts) for module in graph.modules}
    ownerless = sorted(
        module for module, owner in owners.items() if owner is None and module.startswith(f"{PACKAGE}.")
    )
    if ownerless:
        raise ValueError(f"add {', '.join(ownerless)} to the layers of the import linter in pyproject.toml")
    edges: set[tuple[str, str]] = set()
    externals: dict[str, set[str]] = {name: set() for name in parts}
    for module, owner in owners.items():
        if owner is None:
            continue
        for imported in graph.find_modules_directly_imported_by(module):
            target = owners[imported]
            if target is not None:
                edges.add((owner, target))
            elif imported != PACKAGE and imported not in (sys.stdlib_module_names | _OMITTED):
                externals[owner].add(_DISTRIBUTIONS.get(imported, imported))
    edges = {(source, target) for source, target in edges if source != target}
    return Imports(
        layers=layers,
        packages=frozenset(name for name in parts if graph.find_children(name)),
        edges=tuple(sorted(_reduced(edges, layers))),
        externals={name: tuple(sorted(found, key=str.lower)) for name, found in externals.items()},
    )


def _owner(module: str, parts: Iterable[str]) -> str | None:
    """Return the part that contains a module."""
    return next((part for part in parts if module == part or module.startswith(f"{part}.")), None)


def _reduced(edges: set[tuple[str, str]], layers: Sequence[Sequence[str]]) -> set[tuple[str, str]]:
    """Return the edges without those that a longer path from importer to imported implies."""
    row = {name: index for index, layer in enumerate(layers) for name in layer}
    level = sorted(f"{source} -> {target}" for source, target in edges if row[source] >= row[target])
    if level:
        raise ValueError(f"the picture shows imports downwards only, and there is {', '.join(level)}")
    reached: dict[str, set[str]] = {}
    reduced = set()
    for source in sorted(row, key=lambda name: (-row[name], name)):
        below = sorted((target for origin, target in edges if origin == source), key=lambda name: row[name])
        seen: set[str] = set()
        for target in below:
            if target not in seen:
                reduced.add((source, target))
                seen |= {target} | reached[target]
        reached[source] = seen
    return reduced


# --- The layout ------------------------------------------------------------------------------------------

# A box is named after its module; a lane, where an import crosses a row, after the import and the row.
_Node = str | tuple[str, str, int]


class _Layout:
    """The positions of boxes and lanes: in rows, sorted so that few imports cross."""

    def __init__(self, imports: Imports) -> None:
        self._imports = imports
        self.rows: list[list[_Node]] = [sorted(layer) for layer in imports.layers]
        self.paths = [self._path(*edge) for edge in imports.edges]
        self._links = [link for path in self.paths for link in itertools.pairwise(path)]
        self._sort()
        self.x = self._positions()

    def _path(self, source: str, target: str) -> list[_Node]:
        """Return the nodes that an import passes through, with a new lane in each row that it crosses."""
        row = {name: index for index, layer in enumerate(self._imports.layers) for name in layer}
        lanes: list[_Node] = [(source, target, index) for index in range(row[source] + 1, row[target])]
        for index, lane in enumerate(lanes, start=row[source] + 1):
            self.rows[index].append(lane)
        return [source, *lanes, target]

    def width(self, node: _Node) -> float:
        if not isinstance(node, str):
            return _LANE
        note = ", ".join(self._imports.externals[node])
        text = max(_NAME_CHARACTER * len(label(node, self._imports)), _NOTE_CHARACTER * len(note))
        return max(_PADDING + text, 90)

    def _neighbours(self, node: _Node, *, above: bool) -> list[_Node]:
        if above:
            return [start for start, end in self._links if end == node]
        return [end for start, end in self._links if start == node]

    def _sort(self) -> None:
        """Sort each row repeatedly by the mean position of its neighbours, and keep the best order."""
        best, fewest = [list(row) for row in self.rows], self._crossings()
        for sweep in range(_SWEEPS):
            down = sweep % 2 == 0
            for row in self.rows if down else reversed(self.rows):
                rank = self._ranks()
                means = {
                    node: sum(rank[other] for other in others) / len(others)
                    for node in row
                    if (others := self._neighbours(node, above=down))
                }
                row.sort(key=lambda node: (means.get(node, rank[node]), rank[node]))
            if self._crossings() < fewest:
                best, fewest = [list(row) for row in self.rows], self._crossings()
        self.rows = best

    def _ranks(self) -> dict[_Node, float]:
        """Return the position of each node along its row, 0 to 1, so that rows of any length compare."""
        return {node: (i + 0.5) / len(row) for row in self.rows for i, node in enumerate(row)}

    def _crossings(self) -> int:
        rank = self._ranks()
        row = {node: index for index, nodes in enumerate(self.rows) for node in nodes}
        return sum(
            (rank[a] - rank[c]) * (rank[b] - rank[d]) < 0
            for (a, b), (c, d) in itertools.combinations(self._links, 2)
            if row[a] == row[c]
        )

    def _positions(self) -> dict[_Node, float]:
        """Return the centre of each node, as close to its neighbours above and below as the row allows."""
        x: dict[_Node, float] = {}
        for row in self.rows:
            x |= dict(zip(row, _spread([0.0] * len(row), [self.width(node) for node in row]), strict=True))
        for sweep in range(4 * _SWEEPS):
            down = sweep % 2 == 0
            for row in self.rows if down else reversed(self.rows):
                wanted = []
                for node in row:
                    others = self._neighbours(node, above=down) or [node]
                    wanted.append(sum(x[other] for other in others) / len(others))
                x |= dict(zip(row, _spread(wanted, [self.width(node) for node in row]), strict=True))
        left = min(x[node] - self.width(node) / 2 for node in x)
        return {node: centre - left + _MARGIN for node, centre in x.items()}


def _spread(wanted: Sequence[float], widths: Sequence[float]) -> list[float]:
    """Return the centres in the same order, without overlap, that are closest to the wanted ones by least squares.

    With the widths subtracted, no centre may be less than the one before: an isotonic regression.
    """
    offsets = list(itertools.accumulate(((a + b) / 2 + _GAP for a, b in itertools.pairwise(widths)), initial=0.0))
    groups: list[list[float]] = []  # values that share their mean
    for value in (centre - offset for centre, offset in zip(wanted, offsets, strict=True)):
        groups.append([value])
        while len(groups) > 1 and _mean(groups[-2]) > _mean(groups[-1]):
            groups[-2:] = [groups[-2] + groups[-1]]
    means = itertools.chain.from_iterable([_mean(group)] * len(group) for group in groups)
    return [mean + offset for mean, offset in zip(means, offsets, strict=True)]


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)


# --- The drawing -----------------------------------------------------------------------------------------


def label(name: str, imports: Imports) -> str:
    """Return the label of a box: the name of its module, with a slash for a folder."""
    return name.removeprefix(f"{PACKAGE}.") + ("/" if name in imports.packages else "")


def import_picture() -> str:
    """Return the picture as the text of an SVG file."""
    imports = read_imports()
    layout = _Layout(imports)
    top = {node: _MARGIN + _ROW * index for index, row in enumerate(layout.rows) for node in row}
    width = max(layout.x[node] + layout.width(node) / 2 for node in layout.x) + _MARGIN
    height = _ROW * (len(layout.rows) - 1) + _BOX + 2 * _MARGIN
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height}" '
        f'width="{width:.0f}" height="{height}" role="img" aria-labelledby="title">',
        f'<title id="title">The imports of {PACKAGE}: each part imports from those below it</title>',
        f"<style>{_STYLE}</style>",
        '<marker id="head" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" markerHeight="8" '
        'markerUnits="userSpaceOnUse" orient="auto"><path class="head" d="M0 0 8 4 0 8z"/></marker>',
        f'<rect class="page" width="{width:.0f}" height="{height}" rx="8"/>',
    ]
    starts, ends = _ports(layout, end=0), _ports(layout, end=-1)
    for path, start, end in zip(layout.paths, starts, ends, strict=True):
        lines.append(
            f'<path class="import" marker-end="url(#head)" d="{_curve(path, (start, end), layout, top)}"/>'
        )
    for name in sorted(name for layer in imports.layers for name in layer):
        lines += _box(name, imports, (layout.x[name], top[name], layout.width(name)))
    return "\n".join([*lines, "</svg>", ""])


def _ports(layout: _Layout, *, end: int) -> list[float]:
    """Return where each import leaves its box (end 0) or enters it (end -1), in the order of the other ends."""
    ports = [0.0] * len(layout.paths)
    next_node = 1 if end == 0 else -2
    for node in {path[end] for path in layout.paths}:
        numbers = [i for i, path in enumerate(layout.paths) if path[end] == node]
        numbers.sort(key=lambda i: (layout.x[layout.paths[i][next_node]], i))
        step = min(18.0, (layout.width(node) - 20) / len(numbers))
        for rank, number in enumerate(numbers):
            ports[number] = layout.x[node] + step * (rank - (len(numbers) - 1) / 2)
    return ports


def _curve(path: Sequence[_Node], ports: tuple[float, float], layout: _Layout, top: Mapping[_Node, int]) -> str:
    """Return the SVG path of an import: from the bottom of one box, down the lanes, to the top of another."""
    stops = [(ports[0], top[path[0]] + _BOX)]
    for lane in path[1:-1]:
        stops += [(layout.x[lane], top[lane]), (layout.x[lane], top[lane] + _BOX)]
    stops.append((ports[1], top[path[-1]]))
    curve = f"M{stops[0][0]:.0f} {stops[0][1]}"
    for (x, y), (next_x, next_y) in itertools.pairwise(stops):
        middle = (y + next_y) // 2
        curve += f" C{x:.0f} {middle} {next_x:.0f} {middle} {next_x:.0f} {next_y}"
    return curve


def _box(name: str, imports: Imports, position: tuple[float, int, float]) -> list[str]:
    x, y, width = position
    note = ", ".join(imports.externals[name])
    text = f'text-anchor="middle" x="{x:.0f}"'
    lines = [
        f'<rect class="box" x="{x - width / 2:.0f}" y="{y}" width="{width:.0f}" height="{_BOX}" rx="6"/>',
        f'<text class="name" {text} y="{y + (20 if note else 27)}">{escape(label(name, imports))}</text>',
    ]
    return [*lines, f'<text class="note" {text} y="{y + 36}">{escape(note)}</text>'] if note else lines


if __name__ == "__main__":
    sys.stdout.write(import_picture())
