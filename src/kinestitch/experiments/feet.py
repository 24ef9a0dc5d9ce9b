"""What locking the feet does on real seams: how far feet slide, and how hard legs move, before and after.

Run as ``python -m kinestitch.experiments.feet FOLDER -o docs/feet_table.md``. FOLDER holds one folder of clips per
data set.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kinestitch import files
from kinestitch.analysis.feet import foot_joints, standing_heights
from kinestitch.analysis.skating import skating_report
from kinestitch.analysis.smoothness import PERCENTILE, acceleration_near, angular_velocity, own_acceleration
from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.edit.operations import replace as paste
from kinestitch.edit.timeline import DEFAULT_SEAM, Timeline, timeline
from kinestitch.experiments.seams import DATA_SETS, random_cut, random_replacement, read_clips
from kinestitch.experiments.tables import table_options, write_page
from kinestitch.rig.hips import hips_joint
from kinestitch.search.snap import snap
from kinestitch.solve.contacts import legs_of
from kinestitch.solve.footlock import Locked, locked, placed_contacts
from kinestitch.solve.legs import stretched
from kinestitch.solve.seam import SeamPlace, visible_reach
from kinestitch.solve.solved import Solved
from kinestitch.solve.stitch import solve_timeline

Clips = Mapping[str, Motion]
Lock = Callable[[Solved], Locked]

SNAP = 0.2
"""s by which a snapped cut may move on each side."""

_WALK, _RUN = "mixamo_xbot_60fps/Walking (1).fbx", "mixamo_xbot_60fps/Running.fbx"
CASES: Mapping[str, tuple[str, str, tuple[int, int], tuple[int, int]]] = {
    "walk → kick → walk, Mixamo": (_WALK, "mixamo_xbot_60fps/Kicking.fbx", (50, 90), (15, 115)),
    "walk → kick → walk, Bandai": (
        "bandai/dataset-1_walk_normal_001.bvh",
        "bandai/dataset-1_kick_normal_001.bvh",
        (80, 110),
        (100, 200),
    ),
    "run → jump → run, Mixamo": (_RUN, "mixamo_xbot_60fps/Running Jump.fbx", (20, 25), (0, 100)),
}
"""Clip, clip pasted into it, the frames it takes the place of, and the frames of it."""

MEASURES = {
    "slide": "standing feet slide (cm/s)",
    "skate": "feet skate near the seams (cm/s)",
    "share": "frames in which a foot skates (%)",
    "body": "added acceleration, worst joint",
    "knees": "peak acceleration of the knees (rad/s²)",
    "ankles": "peak acceleration of the ankles (rad/s²)",
    "thighs": "peak acceleration of the hip joints (rad/s²)",
    "turn": "peak speed of the knees (°/s)",
    "sink": "deepest under the ground (cm)",
    "straight": "frames with a straight leg",
}
"""What is measured of a timeline before its feet are locked, after it, and of its clips."""

WHEN = ("before", "after", "sources")


@dataclass(frozen=True, eq=False, slots=True)
class Feet:
    """What was measured on one timeline.

    values : (M, 3) of ``MEASURES``, before, after and in the sources; NaN where there is nothing to measure
    kept : share of the contacts that the result keeps; down : cm by which the hips come down
    """

    values: Array
    kept: float
    down: float


def measure(solved: Solved, lock: Lock = locked) -> Feet:
    """The feet of a solve before and after they are locked."""
    after = lock(solved)
    told = skating_report(solved, after.motion, after.contacts)
    names = ("slide_in_contact_m_s", "skate_near_seams_m_s", "skating_share")
    rows = [[100 * told[f"{name}_{when}"] for when in WHEN] for name in names]
    motions = (solved.motion, after.motion)
    legs = legs_of(solved.motion.skeleton)
    rows.append([*(_added(solved, motion) for motion in motions), float("nan")])
    for joints in zip(*((leg.shin, leg.foot, leg.thigh) for leg in legs), strict=True):
        rows.append([*(_peak(solved, motion, joints) for motion in motions), _peak(solved, None, joints)])
    seams = [seam.frame for seam in solved.seams]
    rows.append([_turn(motion, ()) for motion in motions] + [_turn(solved.cut, seams)])
    rows.append([_sink(solved, motion) for motion in (*motions, solved.cut)])
    rows.append([_straight(motion) for motion in (*motions, solved.cut)])
    hips = hips_joint(solved.motion.skeleton)
    heights = [world_pose(motion, [hips]).positions[:, hips, 1] for motion in motions]
    everything = placed_contacts(solved.placed).held.sum()
    kept = float(after.contacts.held.sum() / everything) if everything else 1.0
    return Feet(np.array(rows), kept, 100 * float((heights[0] - heights[1]).max()))


def _added(solved: Solved, motion: Motion) -> float:
    """The worst joint's added acceleration over what the sources' strongest joint does, at the worst seam."""
    found = [0.0]
    for seam in solved.seams:
        own, size = _sizes(solved, None, seam), _sizes(solved, motion, seam)
        strength = float(np.percentile(own.max(axis=1), PERCENTILE))
        found.append(float(np.maximum(size - own, 0.0).max()) / max(strength, 1e-9))
    return max(found)


def _peak(solved: Solved, motion: Motion | None, joints: Sequence[int]) -> float:
    """The strongest acceleration of these joints within the visible reach of a seam; None for the sources' own."""
    return max([0.0, *(float(_sizes(solved, motion, seam)[:, list(joints)].max()) for seam in solved.seams)])


def _sizes(solved: Solved, motion: Motion | None, seam: SeamPlace) -> Array:
    reach = visible_reach(seam.stiffness)
    if motion is None:
        return own_acceleration(solved.placed, seam, reach)
    return acceleration_near(motion, solved.placed, seam, reach)


def _turn(motion: Motion, leave_out: Sequence[int]) -> float:
    shins = [leg.shin for leg in legs_of(motion.skeleton)]
    sizes = np.linalg.norm(angular_velocity(motion.rotations[:, shins], motion.fps), axis=-1)
    return float(np.degrees(np.delete(sizes, [frame - 1 for frame in leave_out], axis=0).max()))


def _sink(solved: Solved, motion: Motion) -> float:
    joints = list(foot_joints(motion.skeleton))
    ground = np.min([standing_heights(source, joints) for source in solved.placed.sources.values()], axis=0)
    return 100 * float(np.maximum(ground - world_pose(motion, joints).positions[:, joints, 1], 0.0).max())


def _straight(motion: Motion) -> float:
    legs, count = legs_of(motion.skeleton), 0
    pose = world_pose(motion, [leg.foot for leg in legs])
    for leg in legs:
        hip, knee, ankle = (pose.positions[:, joint] for joint in (leg.thigh, leg.shin, leg.foot))
        length = np.linalg.norm(knee - hip, axis=-1) + np.linalg.norm(ankle - knee, axis=-1)
        count += int((stretched(pose, leg) > 0.998 * length).sum())
    return float(count)


def draw(clips: dict[str, Motion], seams: int, seed: int) -> list[Timeline]:
    """Random timelines with `seams` seams: half of them cuts from one clip to another, half of them replacements."""
    rng = np.random.default_rng(seed)
    cuts = [random_cut(clips, rng, DEFAULT_SEAM) for _ in range(seams // 2)]
    return cuts + [random_replacement(clips, rng, DEFAULT_SEAM) for _ in range(seams // 4)]


def survey(folder: Path, seams: int, seed: int, lock: Lock = locked) -> dict[str, list[Feet]]:
    """Random cuts of a folder's clips as drawn, and the same snapped."""
    clips = read_clips(folder)
    lines = draw(clips, seams, seed)
    snapped = [snap(line, clips, SNAP).timeline for line in lines]
    return {
        name: [measure(solve_timeline(line, clips), lock) for line in some]
        for name, some in (("random", lines), ("snapped", snapped))
    }


def named(folder: Path) -> dict[str, Feet]:
    """The named cases, and each with its cuts snapped; those whose clips the folder has."""
    found = {}
    for name, (first, second, cut, pasted) in CASES.items():
        if all((folder / place).exists() for place in (first, second)):
            clips = {"first": files.read(folder / first), "second": files.read(folder / second)}
            line = paste(timeline(clips, "first"), *cut, "second", *pasted)
            found[name] = measure(solve_timeline(line, clips))
            found[f"{name}, snapped"] = measure(solve_timeline(snap(line, clips, SNAP).timeline, clips))
    return found


_INTRODUCTION = """# Locked feet on real seams

Made by `python -m kinestitch.experiments.feet`; no figure on this page is typed in. {seams} random seams a data set
(seed {seed}), automatic as `stitch` makes them: half of them cuts from one clip into another, half of them the two
ends of a replacement. *Snapped*: each side of a cut moved by up to {snap:g} s to where the seam is cheapest.
*Before*: solved. *After*: the same with its feet locked, as [feet.md](feet.md) says. *Clips*: the hard cut without its
seams.

- **Slide**: mean speed over the ground of joints that stand, in the contacts that the result keeps.
- **Skate near the seams**: way over the ground of both feet, weighed by how low they are, within the visible reach of
  the seams; swings that are low in the clips are in it.
- **Added acceleration**: what the worst of all joints has above its own source, over what the sources' strongest joint
  does in 95 % of the frames; **peak acceleration**: the largest within the visible reach.

## Named cases

| | slide (cm/s): before | after | clips | skate (cm/s): before | after | clips | contacts kept | hips down (cm) |
|---|---|---|---|---|---|---|---|---|
"""


def as_markdown(cases: Mapping[str, Feet], surveys: Mapping[str, Mapping[str, Sequence[Feet]]], how: str) -> str:
    """The document: the named cases, then one table for each data set and kind of cut."""
    out = [how.rstrip("\n")]
    for name, feet in cases.items():
        cells = [f"{value:.2f}" for value in feet.values[:2].ravel()]
        out.append(f"| {name} | {' | '.join(cells)} | {feet.kept:.0%} | {feet.down:.1f} |")
    for data_set, kinds in surveys.items():
        for kind, found in kinds.items():
            out += ["", f"## {data_set}, {kind} cuts", "", "Median / mean / 95th percentile over the timelines.", ""]
            out += ["| | before | after | clips |", "|---|---|---|---|"]
            values = np.stack([feet.values for feet in found])
            out += [_row(label, values[:, k]) for k, label in enumerate(MEASURES.values())]
            kept, down = np.mean([feet.kept for feet in found]), [feet.down for feet in found]
            out += ["", f"{kept:.1%} of the contacts are kept. The hips come down by {_cell(np.array(down))} cm."]
    return "\n".join(out) + "\n"


def _row(label: str, values: Array) -> str:
    return f"| {label} | " + " | ".join(_cell(values[:, k]) for k in range(len(WHEN))) + " |"


def _cell(values: Array) -> str:
    if np.isnan(values).all():
        return "–"
    return f"{np.median(values):.3g} / {values.mean():.3g} / {np.percentile(values, 95):.3g}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure the named cases and every data set of a folder, and write the document."""
    chosen = table_options(__doc__).parse_args(arguments)
    surveys = {name: survey(chosen.folder / name, chosen.seams, chosen.seed) for name in DATA_SETS}
    how = _INTRODUCTION.format(seams=chosen.seams, seed=chosen.seed, snap=SNAP)
    write_page(chosen.output, as_markdown(named(chosen.folder), surveys, how))


if __name__ == "__main__":
    main()
