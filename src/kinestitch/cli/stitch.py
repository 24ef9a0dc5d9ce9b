"""The verb ``stitch``: edits on a command line, or a document, to a motion."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import click

from kinestitch.cli.console import progress
from kinestitch.cli.failures import tell
from kinestitch.cli.inputs import Library, Opened, is_document
from kinestitch.cli.keeping import preset_option, write_clip
from kinestitch.cli.options import (
    BEFORE,
    CLIP,
    FILE,
    NOT_NEGATIVE,
    OVER,
    RANGE,
    OrderedCommand,
    clip_before_range,
    in_order,
)
from kinestitch.cli.outputs import check_output, check_suffix
from kinestitch.cli.pinning import pin_options, tell_unsolved, with_pins
from kinestitch.cli.retiming import in_time, time_options

if TYPE_CHECKING:
    from kinestitch.edit import Edit, Pin, Seam
    from kinestitch.solve.solved import Solved

EDITS = ("replace", "insert", "append", "delete")
Step = Callable[[str], None]


SECTIONS = {
    "Edits": (*EDITS, "take"),
    "Where to cut, and when": ("snap", "keep_length", "align_steps", "warp", "speed"),
    "How seams are solved": ("auto", "smooth", "stiffness", "chart", "method", "foot_lock"),
    "Where the body has to be": ("pin", "waypoint", "come_back"),
    "What is written": ("output", "report", "skeleton_only", "preset"),
}


@click.command(cls=OrderedCommand, sections=SECTIONS, no_args_is_help=True)
@click.argument("original", type=FILE)
@click.option("--replace", type=OVER, multiple=True, metavar="A:B REF@a:b", help="Paste REF over the frames A:B.")
@click.option("--insert", type=BEFORE, multiple=True, metavar="N REF@a:b", help="Put REF in front of frame N.")
@click.option("--append", type=CLIP, multiple=True, metavar="REF@a:b", help="Put REF at the end.")
@click.option("--delete", type=RANGE, multiple=True, metavar="A:B", help="Take the frames A:B out.")
@click.option("--take", metavar="NAME", help="Which take of an FBX, glTF or USD file ORIGINAL; info lists them.")
@click.option("--smooth", type=NOT_NEGATIVE, metavar="SECONDS", help="Smoothing time of all seams, instead of --auto.")
@click.option(
    "--lambda",
    "stiffness",
    type=NOT_NEGATIVE,
    metavar="X",
    help="Instead of --smooth, the method's own λ = (seconds · fps)⁴: larger is smoother and wider, 0 a hard cut.",
)
@click.option("--auto", is_flag=True, help="For each seam as little time as its clips' own movement allows.  [default]")
@click.option(
    "--snap",
    type=NOT_NEGATIVE,
    metavar="SECONDS",
    help="Move both sides of each seam to the cheapest frames this near.",
)
@time_options
@pin_options
@click.option(
    "--chart",
    type=click.Choice(["centred", "principal"]),
    default="centred",
    show_default=True,
    help="Where rotation vectors are taken: around each seam, or as published.",
)
@click.option(
    "--method",
    type=click.Choice(["laplacian", "cut"]),
    default="laplacian",
    show_default=True,
    help="Solve the seams, or leave the hard cut, placed on the ground.",
)
@click.option(
    "--foot-lock/--no-foot-lock",
    default=None,
    help="Keep planted feet where they stand near seams.  [default: foot-lock]",
)
@click.option(
    "--skeleton-only", is_flag=True, help="Leave out the mesh and all else that OUT keeps of ORIGINAL in its format."
)
@preset_option
@click.option("--report", type=FILE, metavar="FILE.json", help="Write every seam's numbers as JSON.")
@click.option("-o", "--output", type=FILE, required=True, metavar="OUT", help="A clip, or .otio for the edit itself.")
@click.pass_context
def stitch(
    ctx: click.Context,
    *,
    original: str,
    take: str | None,
    smooth: float | None,
    stiffness: float | None,
    auto: bool,
    chart: str,
    method: str,
    foot_lock: bool | None,
    pin: tuple[Pin, ...],
    waypoint: tuple[Pin, ...],
    come_back: float | None,
    skeleton_only: bool,
    preset: str | None,
    report: str | None,
    output: str,
    **_: Any,
) -> None:
    """Cut, paste and join clips; the seams solve themselves.

    ORIGINAL is the clip that is edited (BVH, FBX, GLB), or an edit document (.otio). REF is a clip and maybe a range
    of its frames, PATH@START:STOP; either end may be left out.

    Frames count from 0; a range A:B holds the frames A to B-1. A:B and N are frames of ORIGINAL as it was before any
    of the edits; edits at one place happen in the order they are written in. What follows an edit moves in time, and
    its path on the ground rides along, unless pins or --return take it elsewhere. A REF of another frame rate is
    resampled to ORIGINAL's. An OUT in ORIGINAL's format keeps its character.

    \b
    Examples:
      kinestitch stitch walk.fbx --replace 60:110 kick.fbx@20:75 -o new.fbx
      kinestitch stitch walk.bvh --append walk.bvh --append run.bvh@:90 -o go.bvh
      kinestitch stitch walk.bvh --delete 30:50 --insert 80 jump.bvh \\
                 --smooth 0.2 --report seams.json -o out.glb
      kinestitch stitch walk.bvh --replace 60:110 kick.bvh --snap 0.2 --auto -o out.bvh
      kinestitch stitch walk.bvh --append run.bvh --align-steps 0.3 -o out.bvh
      kinestitch stitch walk.bvh --insert 60 kick.bvh --speed 2=0.5 -o out.bvh
      kinestitch stitch walk.bvh --waypoint 120=1,2.5 --pin LeftHand@80=0.3,1.4,1.6 \\
                 -o out.bvh
      kinestitch stitch walk.bvh --replace 60:110 kick.bvh -o edit.otio
      kinestitch stitch edit.otio -o out.bvh
    """
    edits = in_order(ctx, EDITS)
    _check_paths(ctx, original, edits, output, report)
    seam = _seam(ctx, smooth, stiffness, auto)
    with progress(len(edits) + 8) as step:
        opened, notes = _edited(Library(step), original, take, edits, (seam, foot_lock))
        opened, changed = in_time(opened, ctx.params, step)
        notes += changed
        opened = with_pins(opened, (*pin, *waypoint), come_back)
        _keep_inputs(opened.sources.values(), output, report)
        for note in notes:
            tell("note", note)
        if is_document(output):
            _save(opened, output, unsolved=report is None)
        if is_document(output) and report is None:
            solved, numbers = None, None
        else:
            solved, numbers = _solved(opened, (chart, method), step)
            step("writing")
            how = {"skeleton_only": skeleton_only, "preset": preset, "take": take}
            _write(solved, numbers, None if is_document(output) else output, report, opened, how)
    from kinestitch.cli.seam_table import show_edit, show_seams

    if solved is None or numbers is None:
        show_edit(opened.timeline, output)
    else:
        show_seams(solved, numbers, output)


def _check_paths(
    ctx: click.Context, original: str, edits: list[tuple[str, Any]], output: str, report: str | None
) -> None:
    check_suffix(output, documents=True)
    if clip_before_range(original):
        raise click.UsageError(f"Expected ORIGINAL without a range, got {original!r}. Use --delete on it.", ctx)
    references = [reference[0] for reference in map(_reference, edits) if reference is not None]
    _keep_inputs([original, *references], output, report)
    if ctx.params["take"] is not None and (is_document(original) or is_document(output)):
        raise click.UsageError("Expected no --take with a document, which names files alone. Convert it first.", ctx)
    if is_document(output):
        for name in ("chart", "method", "preset") if report is None else ("preset",):
            if ctx.get_parameter_source(name) == click.core.ParameterSource.COMMANDLINE:
                raise click.UsageError(
                    f"Expected no --{name.replace('_', '-')} for a document, which holds the edit alone.", ctx
                )


def _keep_inputs(inputs: Iterable[str], output: str, report: str | None) -> None:
    """Refuse outputs that would replace one of these files, or each other."""
    inputs = list(inputs)
    check_output(output, inputs)
    if report is not None:
        check_output(report, inputs, also=[output])


def _reference(edit: tuple[str, Any]) -> tuple[str, int | None, int | None] | None:
    """The clip that an edit pastes, or None for a deletion."""
    kind, value = edit
    if kind == "delete":
        return None
    reference: tuple[str, int | None, int | None] = value if kind == "append" else value[1]
    return reference


def _seam(ctx: click.Context, smooth: float | None, stiffness: float | None, auto: bool) -> Seam | None:
    from kinestitch.edit import Seam

    if smooth is not None and stiffness is not None:
        raise click.UsageError("Expected --smooth or --lambda, got both. Leave one out.", ctx)
    if auto and (smooth is not None or stiffness is not None):
        other = "--lambda" if smooth is None else "--smooth"
        raise click.UsageError(f"Expected --auto or {other}, got both. Leave one out.", ctx)
    return Seam(stiffness, smooth, auto) if auto or smooth is not None or stiffness is not None else None


def _edited(
    library: Library,
    original: str,
    take: str | None,
    edits: list[tuple[str, Any]],
    wishes: tuple[Seam | None, bool | None],
) -> tuple[Opened, list[str]]:
    """The edit and notes on it; wishes : for all seams, and for the feet, None where the edit itself may say."""
    from dataclasses import replace

    from kinestitch.cli.fitting import changes
    from kinestitch.cli.joining import drop_repeated_poses
    from kinestitch.edit import ClipInfo, add_clip, apply_edits

    seam, foot_lock = wishes
    line = library.open(original, take).timeline
    line = line if foot_lock is None else replace(line, foot_lock=foot_lock)
    frames = line.frames
    script = []
    for kind, value in edits:
        reference = _reference((kind, value))
        key = None if reference is None else library.add(reference[0])
        if key is not None:
            line = add_clip(line, ClipInfo(key, library.clips[key].frames, library.clips[key].fps))
        script.append(_edit(kind, value, key, frames))
    line = apply_edits(line, script, seam=seam)
    if seam is not None:
        line = replace(line, seams=(seam,) * len(line.seams))
    line, notes = drop_repeated_poses(line, library.clips, sum(kind == "append" for kind, _ in edits))
    opened = Opened(line, library.clips, library.sources)
    return opened, [*notes, *changes(opened)]


def _edit(kind: Any, value: Any, key: str | None, frames: int) -> Edit:
    """frames : of ORIGINAL, where a range ends whose end is left out."""
    from kinestitch.edit import Edit

    reference = _reference((kind, value))
    place = (None, None) if kind == "append" else value if kind == "delete" else value[0]
    start, stop = place if isinstance(place, tuple) else (place, None)
    if kind in {"replace", "delete"}:
        start, stop = 0 if start is None else start, frames if stop is None else stop
    return Edit(kind, start, stop, key, *(reference[1:] if reference else ()))


def _save(opened: Opened, output: str, *, unsolved: bool) -> None:
    """unsolved : whether nobody else will tell of pins and seams"""
    from kinestitch.edit import save_document

    if unsolved:
        tell_unsolved(opened.timeline)
    known = {info.key for info in opened.timeline.clips}
    save_document(opened.timeline, output, sources={k: v for k, v in opened.sources.items() if k in known})


def _solved(opened: Opened, how: tuple[Any, Any], step: Step) -> tuple[Solved, dict[str, Any]]:
    """The result, its feet locked where the rig has feet, and its numbers; how : chart and method."""
    from kinestitch.analysis.quality import report
    from kinestitch.analysis.skating import feet_report
    from kinestitch.solve.stitch import solve_timeline

    step("solving the seams")
    solved = solve_timeline(
        opened.timeline, opened.clips, chart=how[0], method=how[1], foot_lock=opened.timeline.foot_lock
    )
    step("measuring the seams")
    return solved, {**report(solved), "feet": feet_report(solved)}


def _write(
    solved: Solved, numbers: dict[str, Any], output: str | None, report: str | None, opened: Opened, how: dict[str, Any]
) -> None:
    """The report takes its place only after the motion has taken its own."""
    from contextlib import ExitStack

    from kinestitch.cli.seam_table import as_json
    from kinestitch.core.atomic import replacing

    with ExitStack() as stack:
        if report is not None:
            stack.enter_context(replacing(report)).write(as_json(numbers).encode())
        if output is not None:
            key = _whose_skeleton(solved, opened)
            name = opened.clips[key].name
            if key != next(iter(opened.clips)):
                how = how | {"take": None}  # it is ORIGINAL's
            write_clip(solved.motion, output, opened.sources[key], name=name, **how)


def _whose_skeleton(solved: Solved, opened: Opened) -> str:
    """The clip whose joints the result has: ORIGINAL, unless nothing of it is left."""
    skeleton = solved.motion.skeleton
    return next((key for key, clip in opened.clips.items() if clip.skeleton is skeleton), opened.timeline.original)
