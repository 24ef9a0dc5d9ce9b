"""The verb ``loop``: a clip that repeats, and whether its seam shows."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from kinestitch.cli.console import console, counted
from kinestitch.cli.options import FILE, NOT_NEGATIVE, RANGE
from kinestitch.cli.outputs import check_output
from kinestitch.cli.root import change_clip, clip_verb

if TYPE_CHECKING:
    from kinestitch.core.motion import Motion
    from kinestitch.solve.loop import Looped

_ROWS = (
    ("seam_ratio", "turn, of the typical largest"),
    ("position_step_m", "position step, m over"),
    ("rotation_step_deg", "rotation step, ° over"),
    ("velocity_step_m_s", "velocity step, m/s over"),
    ("angular_velocity_step_deg_s", "angular-velocity step, °/s over"),
    ("foot_slide_m_s", "foot slide, m/s"),
)
"""Gate, and what a person calls it."""


@clip_verb("loop", "Make a clip repeat.")
@click.option("--trim/--whole", default=True, help="Find the frames that make the best cycle, or use all.")
@click.option("--frames", type=RANGE, metavar="A:B", help="The frames of the cycle, where you know them.")
@click.option("--shortest", type=NOT_NEGATIVE, metavar="SECONDS", help="Least length.  [default: half the clip]")
@click.option("--longest", type=NOT_NEGATIVE, metavar="SECONDS", help="Greatest length, for one stride out of many.")
@click.option("--smooth", type=NOT_NEGATIVE, metavar="SECONDS", help="Smoothing time of the seam.  [default: 0.1]")
@click.option("--lambda", "stiffness", type=NOT_NEGATIVE, metavar="X", help="The same as the method's own λ.")
@click.option(
    "--foot-lock/--no-foot-lock", default=None, help="Hold standing feet at the seam.  [default: where it is needed]"
)
@click.option("--closed/--open", default=True, help="End with the first pose again, or on the frame before it.")
@click.option("--copies", type=click.IntRange(1, 1000), default=1, metavar="N", help="Write the cycle N times on end.")
@click.option("--report", type=FILE, metavar="FILE.json", help="Write the numbers as JSON.")
@click.pass_context
def loop(
    ctx: click.Context,
    *,
    trim: bool,
    frames: tuple[int | None, int | None] | None,
    shortest: float | None,
    longest: float | None,
    smooth: float | None,
    stiffness: float | None,
    foot_lock: bool | None,
    closed: bool,
    copies: int,
    report: str | None,
    **common: Any,
) -> None:
    """Make the clip IN a cycle: its end goes over into its beginning, and its travel goes on.

    The frames are chosen whose end fits their beginning best, and the seam between them is solved. The last frame of
    OUT repeats the first pose, one cycle on, so that OUT can be put behind itself; --open leaves that frame out, for
    players that go from the last frame to the first one as from any to the next.

    A table says what the seam does over the most that the clip itself does anywhere else, before and after, and whether
    that is little enough.

    \b
    Examples:
      kinestitch loop walk.fbx -o cycle.fbx
      kinestitch loop long_walk.bvh -o stride.bvh --shortest 0.8 --longest 1.5
      kinestitch loop idle.fbx -o idle_loop.fbx --whole --smooth 0.2 --report loop.json
      kinestitch loop walk.bvh -o see.bvh --copies 3
    """
    _check(ctx, (smooth, stiffness), (trim, frames, shortest, longest), report, common)
    found: list[Mapping[str, Any]] = []

    def how(motion: Motion) -> Motion:
        looped = _looped(motion, trim, frames, (shortest, longest), {"smoothing": smooth, "stiffness": stiffness})
        looped = _feet(motion, looped, foot_lock)
        found.append(_numbers(motion, looped))
        return _shown(looped, copies, closed)

    change_clip(common, how, lambda: _write(report, found[0]))
    _show(found[0], Path(common["source"]).name, closed)


def _check(
    ctx: click.Context,
    seam: tuple[float | None, float | None],
    which: tuple[bool, Any, float | None, float | None],
    report: str | None,
    common: dict[str, Any],
) -> None:
    if None not in seam:
        raise click.UsageError("Expected --smooth or --lambda, got both. Leave one out.", ctx)
    trim, frames, *limits = which
    if frames is not None and (not trim or limits != [None, None]):
        raise click.UsageError("Expected --frames alone, got --whole, --shortest or --longest as well.", ctx)
    if not trim and limits != [None, None]:
        raise click.UsageError("Expected no --shortest or --longest with --whole, which takes all frames.", ctx)
    if report is not None:
        check_output(report, [common["source"]], also=[common["output"]])


def _looped(
    motion: Motion,
    trim: bool,
    frames: tuple[int | None, int | None] | None,
    limits: tuple[float | None, float | None],
    seam: dict[str, Any],
) -> Looped:
    from kinestitch.search.cycle import best_cycle, whole_cycle
    from kinestitch.solve.loop import solve_loop

    search: dict[str, Any] = (
        {} if 0.0 in seam.values() else seam
    )  # a hard cut costs nothing anywhere; it is placed like a smooth one
    if frames is not None:
        start, stop = frames[0] or 0, frames[1]
    elif trim:
        cycle = best_cycle(motion, shortest=limits[0], longest=limits[1], **search)
        start, stop = cycle.start, cycle.stop
    else:
        cycle = whole_cycle(motion, **search)
        start, stop = cycle.start, cycle.stop
    return solve_loop(motion, start, stop, **seam)


def _feet(motion: Motion, looped: Looped, lock: bool | None) -> Looped:
    from kinestitch.analysis.cycle import with_feet_locked
    from kinestitch.solve.loop_feet import lock_loop

    if lock is None:
        return with_feet_locked(motion, looped)
    return lock_loop(motion, looped) if lock else looped


def _shown(looped: Looped, copies: int, closed: bool) -> Motion:
    from kinestitch.solve.loop import opened, repeated

    result = looped.motion if copies == 1 else repeated(looped.motion, copies)
    return result if closed else opened(result)


def _numbers(motion: Motion, looped: Looped) -> Mapping[str, Any]:
    from kinestitch.analysis.cycle import loop_report

    return {**loop_report(motion, looped), "clip_frames": motion.frames}


def _write(report: str | None, numbers: Mapping[str, Any]) -> None:
    from kinestitch.cli.seam_table import as_json
    from kinestitch.core.atomic import replacing

    if report is not None:
        with replacing(report) as stream:
            stream.write(as_json(dict(numbers)).encode())


def _show(numbers: Mapping[str, Any], source: str, closed: bool) -> None:
    from rich.table import Table

    from kinestitch.analysis.cycle import gate_text

    out = console()
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    for title in ("at the seam", "before", "after", "at most", ""):
        table.add_column(title, justify="left" if title in {"at the seam", ""} else "right", overflow="fold")
    for gate, label in _ROWS:
        values = numbers["gates"][gate]
        if values["after"] == values["after"]:  # not NaN
            cells = [gate_text(gate, values[when]) for when in ("before", "after")]
            table.add_row(label, *cells, f"{values['bound']:g}", "ok" if values["kept"] else "more")
    out.print(table)
    out.print("Over: by how much more the worst joint does at the seam than anywhere else in the cycle.")
    seconds = numbers["frames"] / numbers["fps"]
    last = "the last frame repeats the first pose" if closed else "the first pose is not repeated"
    out.print(
        f"Frames {numbers['start']}:{numbers['stop']} of {source} ({counted(numbers['clip_frames'], 'frame')}); "
        f"a cycle of {counted(numbers['frames'], 'frame')}, {seconds:.2f} s, goes {numbers['travel_m']:.2f} m "
        f"and turns by {numbers['turn_deg']:.1f}°; {last}."
    )
