"""Steps across real seams, as cut and after each option that looks at them; and slow motion beside straight lines.

Run as ``python -m kinestitch.experiments.phase FOLDER -o docs/time.md``; the tables take the place of those between two
marks of that page. FOLDER holds one folder of clips per data set.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from kinestitch.analysis.skating import slide_in_contact
from kinestitch.core.motion import Motion
from kinestitch.core.retime import poses_at
from kinestitch.core.rotation import Array, quat_conjugate, quat_multiply, quat_slerp, quat_to_rotvec
from kinestitch.edit.timeline import Seam, Timeline
from kinestitch.errors import KinestitchError
from kinestitch.experiments.seams import DATA_SETS, random_cut, read_clips
from kinestitch.experiments.tables import table_options, write_page
from kinestitch.search.align import align_phase, phase_gaps
from kinestitch.search.phase import find_steps, step_phase, strikes
from kinestitch.search.snap import snap
from kinestitch.search.warp import warp_steps
from kinestitch.solve.contacts import Contacts
from kinestitch.solve.energy import joint_price
from kinestitch.solve.footlock import locked, placed_contacts
from kinestitch.solve.stitch import solve_timeline

Clips = dict[str, Motion]

REACH, BOUND = 0.3, 0.2
"""s that a seam may move, and by how much speeds may change."""

AROUND = 1.0
"""s on each side of a seam within which feet are watched."""

GAITS = ("walk", "run", "dash")
MARKS = ("<!-- measured by kinestitch.experiments.phase -->", "<!-- end of what is measured -->")

WAYS: Mapping[str, Callable[[Timeline, Clips], Timeline]] = MappingProxyType(
    {
        "as cut": lambda line, _: line,
        f"`--snap {REACH:g}`": lambda line, clips: snap(line, clips, REACH).timeline,
        f"`--align-steps {REACH:g}`": lambda line, clips: align_phase(line, clips, REACH).timeline,
        f"`--warp {BOUND:g}`": lambda line, clips: warp_steps(line, clips, BOUND).timeline,
        f"`--align-steps {REACH:g} --warp {BOUND:g}`": lambda line, clips: (
            warp_steps(align_phase(line, clips, REACH).timeline, clips, BOUND).timeline
        ),
    }
)


@dataclass(frozen=True, slots=True)
class Crossing:
    """How one seam between two gaits came out.

    gap : rad between the phases; price : rad²; slide : m/s of feet in contact, before any locking
    alternate : whether the last strike before the seam and the first one after it are those of different feet, in the
        result with its feet locked; interval : the time between both over the mean of both clips' own steps; both are
        None where there is no strike on one of the sides
    """

    gap: float
    price: float
    slide: float
    alternate: bool | None
    interval: float | None


@dataclass(frozen=True, slots=True)
class Slowed:
    """A clip at half its speed: the largest angular acceleration of any joint, and the mean change of accelerations,
    each with straight lines between frames and here. Accelerations are shares of the clip's own largest at half speed;
    changes here are shares of those of straight lines.
    """

    lines: float
    ours: float
    jerk: float


def stepping(clips: Mapping[str, Motion]) -> Clips:
    """The clips that walk or run: told by their names, and by steps in more than half of their frames."""
    found = {}
    for name, motion in clips.items():
        if any(gait in name.lower() for gait in GAITS):
            try:
                known = np.isfinite(step_phase(motion)).mean()
            except KinestitchError:
                continue
            if known > 0.5:
                found[name] = motion
    return found


def crossing(line: Timeline, clips: Clips) -> Crossing:
    """Solve and measure the one seam of a timeline."""
    solved = solve_timeline(line, clips)
    contacts = placed_contacts(solved.placed)
    seam, around = solved.seams[0].frame, round(AROUND * line.fps)
    near = slice(max(0, seam - around), seam + around)
    window = replace(
        solved.motion, rotations=solved.motion.rotations[near], translations=solved.motion.translations[near]
    )
    slide = slide_in_contact(window, Contacts(contacts.joints, contacts.held[near]))
    before, after = _strikes_around(locked(solved, contacts).motion, seam)
    own = np.mean([_step_time(clips[line.clip(segment.clip).source]) for segment in line.segments])
    return Crossing(
        phase_gaps(line, find_steps(line, clips))[0],
        joint_price(solved.placed),
        slide,
        None if before is None or after is None else before[1] != after[1],
        None if before is None or after is None else (after[0] - before[0]) / line.fps / float(own),
    )


def _strikes_around(motion: Motion, seam: int) -> tuple[tuple[int, int] | None, tuple[int, int] | None]:
    try:
        found = strikes(motion)
    except KinestitchError:
        found = []
    before, after = [s for s in found if s[0] < seam], [s for s in found if s[0] >= seam]
    return (before[-1] if before else None), (after[0] if after else None)


def _step_time(motion: Motion) -> float:
    """Mean time of a clip's steps in s."""
    phase = step_phase(motion)
    rates = np.diff(phase)
    return float(np.pi / (rates[np.isfinite(rates)].mean() * motion.fps))


def survey(clips: Clips, seams: int, seed: int) -> dict[str, list[Crossing]]:
    """Random seams between steps of two clips, each in all ways; repeatable by its seed."""
    rng = np.random.default_rng(seed)
    found: dict[str, list[Crossing]] = {way: [] for way in WAYS}
    while len(found["as cut"]) < seams:
        line = random_cut(clips, rng, Seam())
        if not np.isfinite(phase_gaps(line, find_steps(line, clips))[0]):
            continue
        for way, made in WAYS.items():
            found[way].append(crossing(made(line, clips), clips))
    return found


def slowed(motion: Motion) -> Slowed:
    """A clip at half its speed beside the same with straight lines between its frames."""
    places = np.arange(2 * motion.frames - 1) / 2
    left = np.minimum(places.astype(np.intp), motion.frames - 2)
    lines = quat_slerp(motion.rotations[left], motion.rotations[left + 1], (places - left)[:, None])
    ours = poses_at(motion, places).rotations
    own = np.abs(_accelerations(motion.rotations)).max() / 4
    bends = [_accelerations(rotations) for rotations in (lines, ours)]
    jerks = [np.abs(np.diff(bend, axis=0)).mean() for bend in bends]
    return Slowed(
        float(np.abs(bends[0]).max() / own), float(np.abs(bends[1]).max() / own), float(jerks[1] / max(jerks[0], 1e-12))
    )


def _accelerations(rotations: Array) -> Array:
    turns = quat_to_rotvec(quat_multiply(quat_conjugate(rotations[:-1]), rotations[1:]))
    return np.asarray(np.linalg.norm(np.diff(turns, axis=0), axis=-1))


_CAPTION = """{seams} random seams between the steps of two clips of *{name}* ({clips} clips that walk or run, \
{fps:g} fps; seed {seed}). Median / 95th percentile.

| | phases differ by ° | price rad² | slide in contact cm/s | foot follows foot | step over the seam off by |
|---|---|---|---|---|---|"""

_SLOW = """Every clip at half its speed. The largest angular acceleration of a joint, as a multiple of the largest \
that the clip has at that speed, and the mean change of angular accelerations; medians over the clips.

| data set | clips | largest, straight lines | largest, here | change, here, as a share of straight lines' |
|---|---|---|---|---|"""


def as_markdown(
    found: Mapping[str, tuple[Clips, Mapping[str, Sequence[Crossing]]]], slow: Mapping[str, Sequence[Slowed]], seed: int
) -> str:
    """Both tables, with what they say above them."""
    out = []
    for name, (clips, ways) in found.items():
        fps = next(iter(clips.values())).fps
        out.append(_CAPTION.format(seams=len(ways["as cut"]), name=name, clips=len(clips), fps=fps, seed=seed))
        out += [_row(way, crossings) for way, crossings in ways.items()]
        out.append("")
    out.append(_SLOW)
    for name, values in slow.items():
        cells = [f"{np.median([getattr(value, field) for value in values]):.2f}" for field in ("lines", "ours", "jerk")]
        out.append(f"| {name} | {len(values)} | {' | '.join(cells)} |")
    return "\n".join(out)


def _row(way: str, crossings: Sequence[Crossing]) -> str:
    told = [one for one in crossings if one.alternate is not None]
    off = [100 * abs(one.interval - 1) for one in told if one.interval is not None]
    cells = [
        way,
        _cell([np.degrees(abs(one.gap)) for one in crossings]),
        _cell([one.price for one in crossings]),
        _cell([100 * one.slide for one in crossings]),
        f"{100 * np.mean([bool(one.alternate) for one in told]):.0f} % of {len(told)}" if told else "",
        _cell(off, " %") if off else "",
    ]
    return "| " + " | ".join(cells) + " |"


def _cell(values: Sequence[float], unit: str = "") -> str:
    """Of the values that are there: a snapped seam may have moved to where nobody steps."""
    return " / ".join(f"{round(float(value), 3):.3g}" for value in np.nanpercentile(values, (50, 95))) + unit


def filled(page: str, text: str) -> str:
    """The page with this text between the marks; raises ValueError where they are not."""
    before, first, rest = page.partition(MARKS[0])
    _, last, after = rest.partition(MARKS[1])
    if not (first and last):
        raise ValueError(f"Expected a page with the marks {MARKS[0]} and {MARKS[1]}.")
    return f"{before}{first}\n\n{text}\n\n{last}{after}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Survey every data set of a folder and fill the tables into the page."""
    chosen = table_options(__doc__, seams=100).parse_args(arguments)
    page = chosen.output.read_text(encoding="utf-8")
    found, slow = {}, {}
    for name in DATA_SETS:
        clips = read_clips(chosen.folder / name)
        walks = stepping(clips)
        found[name] = (walks, survey(walks, chosen.seams, chosen.seed))
        slow[name] = [slowed(motion) for motion in clips.values()]
    write_page(chosen.output, filled(page, as_markdown(found, slow, chosen.seed)))


if __name__ == "__main__":
    main()
