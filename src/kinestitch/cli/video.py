"""The verb ``video``: clips side by side, and edits beside their hard cut and a crossfade."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import click

from kinestitch.cli.console import console, progress
from kinestitch.cli.inputs import is_document, read_clip
from kinestitch.cli.options import FILE, SIZE
from kinestitch.cli.outputs import check_output, refuse_suffix
from kinestitch.cli.pictures import Shown, own_contacts, show, view_option
from kinestitch.errors import ParameterError

if TYPE_CHECKING:
    from kinestitch.core.motion import Motion
    from kinestitch.core.skeleton import Skeleton
    from kinestitch.render.paint import Stretch
    from kinestitch.solve.contacts import Contacts

CROSSFADE = 0.4
"""Seconds that the crossfade beside an edit takes in all, a common choice by hand."""
_STEPS = 100
Step = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Panel:
    """One figure of the video, with its words, its seams, what came from other clips, and when its feet stand."""

    motion: Motion
    label: str
    seams: tuple[int, ...] = ()
    pasted: tuple[Stretch, ...] = ()
    contacts: Contacts | None = None


@click.command(no_args_is_help=True, short_help="Show clips moving, side by side.")
@click.argument("sources", metavar="IN...", nargs=-1, required=True, type=FILE)
@click.option("-o", "--output", required=True, type=FILE, metavar="OUT.mp4", help="The video, H.264.")
@click.option(
    "--view",
    default="three-quarter",
    show_default=True,
    metavar="VIEW",
    help="front, side, three-quarter, back, or degrees (0 front, 90 side).",
)
@click.option("--size", type=SIZE, metavar="WxH", help="Pixels.  [default: 480x540 for each figure]")
@click.option("--fps", type=float, metavar="N", help="Pictures a second.  [default: the clips', 60 at most]")
@click.option("--speed", type=float, default=1.0, show_default=True, metavar="X", help="0.25: four times as slow.")
@click.option("--before", type=FILE, metavar="FILE", help="A clip to show on the left, as it was before.")
@click.option(
    "--style",
    type=click.Choice(["mannequin", "skeleton"]),
    default="mannequin",
    show_default=True,
    help="A body, or bare bones and joints.",
)
@click.option("--character", type=FILE, metavar="FILE.glb", help="Show this file's character for the mannequin.")
def video(
    *,
    sources: tuple[str, ...],
    output: str,
    view: str,
    size: tuple[int, int] | None,
    fps: float | None,
    speed: float,
    before: str | None,
    style: str,
    character: str | None,
) -> None:
    """Show clips moving side by side on the ground, with trails of the feet; needs the extra kinestitch[video].

    An edit document (.otio) is solved first and shown three times: its hard cut, a crossfade, and the result. Its
    pasted clips are tinted, and the ground glows at its seams. Feet are green while they stand in their clip.

    \b
    Examples:
      kinestitch video walk.fbx -o walk.mp4
      kinestitch video edit.otio -o edit.mp4 --view side --speed 0.5
      kinestitch video result.bvh -o compare.mp4 --before original.bvh
    """
    from kinestitch.render.encoder import encoder_library

    if before is not None and any(map(is_document, sources)):
        raise ParameterError(f"Expected no --before with an edit, which brings its own hard cut. ({before})")
    refuse_suffix(output, (".mp4",))
    check_output(output, [path for path in (*sources, before, character) if path is not None])
    encoder_library()
    with progress(2 * len(sources) + _STEPS + 2) as step:
        panels = [] if before is None else _panels(Shown(replace(read_clip(before), name="before")))
        panels += [panel for source in sources for panel in _panels(show(source, step))]
        how = {"view": view_option(view), "size": size, "fps": fps, "speed": speed, "style": style}
        count = _write(panels, output, step, figure=character, **how)
    console().print(f"{output}: {count} pictures of {len(panels)} figure{'s' * (len(panels) != 1)}")


def _panels(shown: Shown) -> list[Panel]:
    """A clip alone, or an edit three times."""
    motion, stands = shown.motion, own_contacts(shown)
    result = Panel(motion, motion.name, shown.seams, shown.pasted, shown.contacts or stands)
    if shown.placed is None or shown.before is None or not shown.seams:
        return [result]
    from kinestitch.solve.rivals import crossfade

    blended = crossfade(shown.placed, max(1, round(CROSSFADE / 2 * motion.fps)))
    cut = Panel(shown.before, "hard cut", shown.seams, shown.pasted, stands)
    return [cut, Panel(blended, f"crossfade {CROSSFADE:g} s", shown.seams, shown.pasted, stands), result]


def _write(panels: list[Panel], output: str, step: Step, *, figure: str | None, **how: Any) -> int:
    """The number of pictures written; figure : a file with a character; how : options of the film."""
    from kinestitch.render.video import video as write_video

    motions = [panel.motion for panel in panels]
    bodies, contacts = None, [panel.contacts for panel in panels]
    if figure is not None:
        from kinestitch.files.gltf_mesh import read_mesh
        from kinestitch.render.skinned import Character

        step(f"reading {figure}")
        mesh = read_mesh(figure)
        motions = [_on_rig(motion, mesh.skeleton) for motion in motions]
        bodies, contacts = [Character(mesh)] * len(motions), [None] * len(motions)
    told = [0, 0]

    def follow(done: int, count: int) -> None:
        while told[0] * count < done * _STEPS:
            told[:] = told[0] + 1, count
            step(f"drawing {told[0]} %")
        told[1] = count

    write_video(
        motions,
        output,
        labels=[panel.label for panel in panels],
        seams=[panel.seams for panel in panels],
        segments=[panel.pasted for panel in panels],
        bodies=bodies,
        contacts=contacts,
        progress=follow,
        **how,
    )
    return told[1]


def _on_rig(motion: Motion, skeleton: Skeleton) -> Motion:
    """The motion as the character does it: as it is where the rigs match, else retargeted."""
    from kinestitch.errors import SkeletonMismatchError
    from kinestitch.rig.match import match_motion
    from kinestitch.rig.retarget import retarget

    try:
        return match_motion(motion, skeleton)
    except SkeletonMismatchError:
        return retarget(motion, skeleton)
