"""The script door: one verb per idea, one line per error, exit code 0, 2 (wrong input) or 130 (stopped).

Verbs load when they are called, and numpy only when there is something to compute.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence

import click

from kinestitch import __version__
from kinestitch.cli.failures import Stopped, run

VERBS = {
    "stitch": "stitch",
    "cuts": "cuts",
    "info": "info",
    "convert": "convert",
    "retarget": "retarget",
    "mirror": "root",
    "in-place": "root",
    "extract-root": "root",
    "bake-root": "root",
    "loop": "looping",
    "plot": "pictures",
    "filmstrip": "pictures",
    "video": "video",
    "demo": "demo",
    "reproduce": "reproduce",
    "completion": "completion",
}
"""Verb → module of this room, in the order in which ``--help`` lists them."""


class Verbs(click.Group):
    """A group whose commands are imported when they are asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(VERBS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in VERBS:
            return None
        module = importlib.import_module(f"{__name__}.{VERBS[cmd_name]}")
        command: click.Command = getattr(module, cmd_name.replace("-", "_"))
        return command

    def invoke(self, ctx: click.Context) -> object:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise Stopped from None


@click.command(cls=Verbs, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, message="%(prog)s %(version)s")
def cli() -> None:
    """Cut motion-capture clips together; the seams solve themselves.

    \b
    Try it:      kinestitch demo
    Your clips:  kinestitch stitch walk.fbx --replace 60:110 kick.fbx@20:75 -o new.fbx

    BVH, FBX, glTF, USD and AMASS come in and go out, ASF/AMC and C3D come in; the edit itself is an OpenTimelineIO
    document (.otio).
    Every verb has its own help: kinestitch stitch --help. Tab completion: kinestitch completion --help.
    """


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code; `arguments` are those of the process unless given."""
    return run(cli, arguments)
