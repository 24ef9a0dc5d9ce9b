"""The verbs ``plot`` and ``filmstrip``: pictures of clips, and of edits as they are solved."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from kinestitch.cli.console import console, counted, progress
from kinestitch.cli.inputs import Library, is_document, read_clip
from kinestitch.cli.options import FILE
from kinestitch.cli.outputs import check_output, refuse_suffix

if TYPE_CHECKING:
    from kinestitch.core.motion import Motion
    from kinestitch.edit import Timeline
    from kinestitch.render.paint import Stretch
    from kinestitch.solve.contacts import Contacts
    from kinestitch.solve.placed import Placed

PICTURES = (".png", ".svg", ".pdf")
Step = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Shown:
    """What is drawn.

    motion : a clip, or an edit's result; before : its hard cut; seams : frames; pasted : what came from other clips
    placed : the edit as it was solved; contacts : those that its locked feet keep
    """

    motion: Motion
    before: Motion | None = None
    seams: tuple[int, ...] = ()
    pasted: tuple[Stretch, ...] = ()
    placed: Placed | None = None
    contacts: Contacts | None = None


@click.command(no_args_is_help=True, short_help="Draw a joint's curve before and after.")
@click.argument("source", metavar="IN", type=FILE)
@click.option("-o", "--output", required=True, type=FILE, metavar="OUT", help="A picture: .png, .svg or .pdf.")
@click.option("--joint", metavar="NAME", help="Which joint; left out, the one that changes most.")
@click.option("--before", type=FILE, metavar="FILE", help="A clip to draw behind, as the hard cut of the same frames.")
@click.option("--seam", "seams", type=int, multiple=True, metavar="N", help="Mark frame N; may be given often.")
def plot(source: str, output: str, joint: str | None, before: str | None, seams: tuple[int, ...]) -> None:
    """Draw a joint's curve over time, below it how sharply it bends (‖L r‖), and when the feet stand.

    IN is a clip, or an edit document (.otio), which is solved and drawn with its hard cut behind it and its seams
    marked.

    \b
    Examples:
      kinestitch plot edit.otio -o seams.png --joint RightUpLeg
      kinestitch plot result.bvh -o leg.svg --before cut.bvh --seam 60 --seam 115
    """
    from kinestitch.errors import ParameterError

    if before is not None and is_document(source):
        raise ParameterError(f"Expected no --before with an edit, which brings its own hard cut. ({source})")
    refuse_suffix(output, PICTURES)
    check_output(output, [source] if before is None else [source, before])
    with progress(4) as step:
        shown = show(source, step)
        cut = shown.before if before is None else read_clip(before)
        marks = sorted({*shown.seams, *seams})
        _check_marks(marks, shown.motion)
        index = _most_changed(shown.motion, cut) if joint is None else find_joint(shown.motion, joint)
        step("drawing")
        from kinestitch.analysis.plots import plot_joint

        plot_joint(shown.motion, index, output, before=cut, seams=marks, contacts=shown.contacts or own_contacts(shown))
    console().print(f"{output}: {shown.motion.skeleton.names[index]}, {counted(shown.motion.frames, 'frame')}")


@click.command(no_args_is_help=True, short_help="Draw posed figures over time.")
@click.argument("sources", metavar="IN...", nargs=-1, required=True, type=FILE)
@click.option("-o", "--output", required=True, type=FILE, metavar="OUT", help="A picture: .png, .svg or .pdf.")
@click.option("--poses", type=click.IntRange(1, 200), default=9, show_default=True, metavar="N", help="Poses a row.")
@click.option(
    "--view",
    default="three-quarter",
    show_default=True,
    metavar="VIEW",
    help="front, side, three-quarter, back, or degrees (0 front, 90 side).",
)
@click.option("--travel", is_flag=True, help="Let the figures stand where they walk, not side by side.")
@click.option("--title", metavar="TEXT", help="Words above the picture.")
def filmstrip(*, sources: tuple[str, ...], output: str, poses: int, view: str, travel: bool, title: str | None) -> None:
    """Draw posed figures over time, one row for each IN, as in a paper's figure.

    An edit document (.otio) is solved first; its pasted clips are tinted and its seams marked.

    \b
    Examples:
      kinestitch filmstrip walk.fbx -o walk.png
      kinestitch filmstrip walk.bvh kick.bvh edit.otio -o strip.svg --view side
    """
    refuse_suffix(output, PICTURES)
    check_output(output, sources)
    with progress(2 * len(sources) + 1) as step:
        rows = [show(source, step) for source in sources]
        step("drawing")
        from kinestitch.render.filmstrip import filmstrip as draw

        draw(
            [row.motion for row in rows],
            output,
            poses=poses,
            marks=[row.seams for row in rows],
            segments=[row.pasted for row in rows],
            view=view_option(view),
            travel=travel,
            title=title,
        )
    console().print(f"{output}: {counted(len(rows), 'row')} of up to {counted(poses, 'pose')}")


def show(path: str, step: Step) -> Shown:
    """A clip as it is, or an edit document as ``stitch`` makes it, its feet locked unless it says otherwise."""
    from dataclasses import replace
    from pathlib import Path

    from kinestitch.solve.stitch import solve_timeline

    if not is_document(path):
        step(f"reading {path}")
        return Shown(replace(read_clip(path), name=Path(path).stem))
    opened = Library(step).open(path)
    step(f"solving {path}")
    solved = solve_timeline(opened.timeline, opened.clips, foot_lock=opened.timeline.foot_lock)
    seams = tuple(seam.frame for seam in solved.seams)
    motion = replace(solved.motion, name=Path(path).stem)
    return Shown(motion, solved.cut, seams, pasted_stretches(opened.timeline), solved.placed, solved.contacts)


def own_contacts(shown: Shown) -> Contacts | None:
    """When the feet stand in the clips that are shown; None for a rig without feet."""
    from kinestitch.errors import SkeletonMismatchError
    from kinestitch.solve.contacts import find_contacts
    from kinestitch.solve.footlock import placed_contacts

    try:
        return find_contacts(shown.motion) if shown.placed is None else placed_contacts(shown.placed)
    except SkeletonMismatchError:
        return None


def pasted_stretches(timeline: Timeline) -> tuple[Stretch, ...]:
    """Where a timeline shows another clip than its original, or that one at another speed, with the clip's frames as
    label.
    """
    from kinestitch.render.paint import Stretch

    return tuple(
        Stretch(start, start + len(segment), f"{segment.clip} {segment.range.start}–{segment.range.stop - 1}")
        for start, segment in zip(timeline.starts, timeline.segments, strict=False)
        if segment.clip != timeline.original
    )


def find_joint(motion: Motion, name: str) -> int:
    """Index of a joint by its name, with or without its namespace; raises InvalidMotionError with the nearest names."""
    from kinestitch.rig.hips import bare_name

    names = motion.skeleton.names
    if name not in names:
        bare = [j for j, known in enumerate(names) if bare_name(known) == name]
        if len(bare) == 1:
            return bare[0]
    return motion.skeleton.index(name)


def _most_changed(motion: Motion, before: Motion | None) -> int:
    """The joint whose limb was swept furthest off `before`, or without it the one that sweeps most; not the root.

    A joint counts by what hangs below it, so that it is a leg rather than a finger.
    """
    import numpy as np

    from kinestitch.core.rotation import quat_distance

    skeleton = motion.skeleton
    if before is not None and before.rotations.shape == motion.rotations.shape:
        turned = quat_distance(motion.rotations, before.rotations).max(axis=0)
    else:
        turned = quat_distance(motion.rotations[1:], motion.rotations[:-1]).sum(axis=0)
    reach = np.zeros(skeleton.joint_count)
    for joint in range(skeleton.joint_count - 1, 0, -1):
        below = reach[joint] + float(np.linalg.norm(skeleton.offsets[joint]))
        reach[skeleton.parents[joint]] = max(reach[skeleton.parents[joint]], below)
    reach[0] = -1.0 if skeleton.joint_count > 1 else 0.0
    return int(np.argmax(turned * reach))


def _check_marks(marks: list[int], motion: Motion) -> None:
    from kinestitch.errors import RangeError

    for frame in marks:
        if not 0 < frame < motion.frames:
            raise RangeError(f"Expected a seam from 1 to {motion.frames - 1}, got {frame}.")


def view_option(text: str) -> str | float:
    """A view by name, or in degrees."""
    import math

    try:
        number = float(text)
    except ValueError:
        return text
    return number if math.isfinite(number) else text
