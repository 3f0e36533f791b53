"""`rtcli new`: write a scene to start from."""

from __future__ import annotations

import shlex
from importlib import resources
from pathlib import Path

import click
from click.shell_completion import CompletionItem

from rtcli.cli.console import STDIO, report_line, write_bytes
from rtcli.cli.help import Command
from rtcli.scene.diagnostics.problems import did_you_mean, nearest, printable, quoted
from rtcli.scene.files import YAML_SUFFIXES
from rtcli.scene.gallery import caption, gallery, text_to_start_from


class _GalleryScene(click.ParamType[str]):
    """The name of a scene of the gallery."""

    name = "name"

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        known = gallery()
        if value not in known:
            hint = did_you_mean(nearest(value, known))
            message = f"{quoted(value)} is not in the gallery{hint}\nrtcli new --list lists its scenes"
            self.fail(message, param, ctx)
        return value

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        return [
            CompletionItem(name, help=caption(scene))
            for name, scene in gallery().items()
            if name.startswith(incomplete)
        ]


@click.command(
    "new",
    cls=Command,
    examples=["rtcli new my.yaml", "rtcli new --from cornell room.yaml", "rtcli new --list"],
)
@click.argument("file", required=False, help="The file to write, or - for standard output.")
@click.option("--from", "source", type=_GalleryScene(), metavar="NAME", help="Write this scene of the gallery.")
@click.option("--list", "lists", is_flag=True, help="List the scenes of the gallery.")
@click.option("--force", is_flag=True, help="Replace an existing FILE.")
def command(file: str | None, source: str | None, lists: bool, force: bool) -> None:
    """Write a small commented scene to start from."""
    if lists:
        if file is not None or source is not None or force:
            raise click.UsageError("--list writes no file; leave out FILE, --from and --force")
        _list_gallery()
    elif file is None:
        raise click.UsageError("Missing argument 'FILE'. For example: rtcli new my.yaml")
    else:
        _write(file, source, force)


def _list_gallery() -> None:
    scenes = gallery()
    width = max(map(len, scenes))
    for name, scene in scenes.items():
        click.echo(f"{name:{width}}  {caption(scene)}")


def _write(file: str, source: str | None, force: bool) -> None:
    if file != STDIO and not file.lower().endswith(YAML_SUFFIXES):
        raise click.UsageError(f"{file!r}: the name of a YAML file must end in .yaml or .yml")
    if source is None:
        text = (resources.files("rtcli.scene") / "starter.yaml").read_text(encoding="utf-8")
    else:
        text = text_to_start_from(gallery()[source])
    if file != STDIO and not force and Path(file).exists():
        raise FileExistsError(f"{printable(file)} already exists; use --force to replace it")
    write_bytes(text.encode(), file)
    if file != STDIO:
        scene = f"./{file}" if file.startswith("-") else file
        render = shlex.join(["rtcli", "render", scene, "-o", str(Path(file).with_suffix(".png"))])
        report_line(f"wrote {printable(file)}; render it with: {printable(render)}")
