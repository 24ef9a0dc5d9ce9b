"""Experiments 6 and 7: axis flips, injected and found, and what each chart makes of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinestitch.analysis.continuity import flip, principal_vectors, steps_between
from kinestitch.core.rotation import Array, quat_distance
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline
from kinestitch.experiments.dataset import DataSet
from kinestitch.experiments.page import Finding, Section, Table, panels, picture, rows_of
from kinestitch.experiments.seams import find_spins, joint_speeds
from kinestitch.solve.chart import CHARTS, Chart
from kinestitch.solve.rotvecs import stitch_rotvecs
from kinestitch.solve.stitch import solve_timeline


def injected(data: DataSet, *, stiffness: float = 1296.0) -> dict[str, Array]:
    """A segment pasted plainly and with its axes flipped, in both charts: rotations (F, J, 4) by name."""
    left, right = data.find("Walking", "Kicking") if data.real else data.find("walk", "kick")
    a, b = (principal_vectors(data.clips[key]) for key in (left, right))
    pieces = [a[: len(a) // 2], b[len(b) // 4 : len(b) // 2], a[len(a) // 2 :]]
    flipped = [pieces[0], flip(pieces[1]), pieces[2]]
    return {
        f"{chart}, {name}": stitch_rotvecs(parts, stiffness, chart=chart)
        for chart in CHARTS
        for name, parts in (("as it is", pieces), ("flipped", flipped))
    }


def run_injected(data: DataSet) -> Section:
    """The synthetic flip: picture and numbers."""
    found = injected(data)
    fps = next(iter(data.clips.values())).fps
    drawing, axes = panels(2, 1, size=(8.0, 4.4))
    rows, worst = [], {}
    for axis, chart in zip(axes, CHARTS, strict=True):
        plain, turned = found[f"{chart}, as it is"], found[f"{chart}, flipped"]
        gap = np.degrees(quat_distance(plain, turned))
        worst[chart] = float(gap.max())
        for name, rotations, colour in (("as it is", plain, "#0072B2"), ("flipped", turned, "#D55E00")):
            speed = np.degrees(joint_speeds(rotations, fps))
            axis.plot(speed.max(axis=1), color=colour, label=name, linewidth=1.2)
            rows.append((chart, name, float(speed.max()), worst[chart]))
        axis.set_title(f"{chart} chart", loc="left")
        axis.set_ylabel("fastest joint (°/s)")
    axes[0].legend(frameon=False)
    axes[-1].set_xlabel("frame")
    finding = Finding(
        "Axis flips do no harm.",
        "reproduced with limits",
        f"a flipped segment changes the result by {worst['principal']:.0f}° in the principal chart and by "
        f"{worst['centred']:.1e}° in the centred one",
    )
    return Section(
        "A synthetic axis flip",
        "The pasted segment's vectors θu are replaced by (2π − θ)(−u), which are the same rotations. The principal "
        "chart, "
        "taking vectors as they are, makes the joints turn the long way round; the centred chart looks at the "
        "rotations.",
        (finding,),
        (picture(drawing, "Speed of the fastest joint.", own=not data.real),),
        (Table("Peak speed and largest change.", ("chart", "segment", "peak °/s", "change °"), rows_of(rows)),),
        numbers={"flip_change_deg": {chart: float(f"{value:.3g}") for chart, value in worst.items()}},
    )


def flipped_pairs(data: DataSet, limit: int) -> list[tuple[str, str, tuple[int, ...], Array]]:
    """Boundaries end → start where some joint's axis turns round: clips, joints, and their angles θ (rad)."""
    vectors = {key: principal_vectors(motion) for key, motion in data.clips.items()}
    found = []
    for left, before in vectors.items():
        for right, after in vectors.items():
            if left != right:
                steps = steps_between(before[-1], after[0])
                joints = np.flatnonzero(steps.flips)
                if len(joints):
                    found.append((left, right, tuple(int(j) for j in joints), steps.theta[joints]))
    if len(found) > limit:  # an even sample, so that every clip is heard
        found = [found[i] for i in np.linspace(0, len(found) - 1, limit).astype(int)]
    return found


def spun(data: DataSet, left: str, right: str, chart: Chart) -> set[str]:
    """Joints that spin where one whole clip follows another."""
    infos = tuple(ClipInfo(key, data.clips[key].frames, data.clips[key].fps) for key in (left, right))
    segments = tuple(Segment(info.key, FrameRange(0, info.frames)) for info in infos)
    solved = solve_timeline(Timeline(infos, segments, (Seam(),), infos[0].fps), data.clips, chart=chart)
    return {spin.joint for spin in find_spins(solved.motion, solved.placed, solved.seams[0], 0)}


@dataclass(frozen=True, slots=True)
class Detected:
    """What a data set's flips came to: boundaries, flips, their angles in degrees, spins by chart, flips by joint."""

    name: str
    boundaries: int
    flips: int
    theta: tuple[float, float]
    spun: Mapping[Chart, int]
    joints: tuple[tuple[str, int], ...]

    @property
    def row(self) -> tuple[object, ...]:
        """A row of the report's table."""
        fine = (self.flips - self.spun["principal"], self.flips - self.spun["centred"])
        return (self.name, self.boundaries, self.flips, *self.theta, *fine)


def detect(data: DataSet, limit: int) -> Detected:
    """Find a data set's flips at boundaries and stitch each of them in both charts."""
    pairs = flipped_pairs(data, limit)
    names = next(iter(data.clips.values())).skeleton.names
    theta = np.degrees(np.concatenate([t for *_, t in pairs])) if pairs else np.zeros(1)
    spins: dict[Chart, int] = {
        chart: sum(len(spun(data, left, right, chart) & {names[j] for j in joints}) for left, right, joints, _ in pairs)
        for chart in CHARTS
    }
    counts = np.bincount([j for _, _, joints, _ in pairs for j in joints], minlength=len(names))
    most = tuple((names[j], int(counts[j])) for j in np.argsort(counts)[::-1][:4] if counts[j])
    around = (float(np.median(theta)), float(theta.max()))
    return Detected(data.name, len(pairs), int(counts.sum()), around, spins, most)


def run_detected(sets: Sequence[DataSet], *, limit: int = 150) -> Section:
    """All real flips at boundaries: which joints, at which θ, and how many stitch without a spin in each chart."""
    found = [detect(data, limit) for data in sets]
    told = {chart: ", ".join(f"{d.spun[chart]} on {d.name}" for d in found) for chart in CHARTS}
    finding = Finding(
        "Flips at boundaries are stitched without harm, since θ stays in [0, π].",
        "reproduced with limits" if any(d.spun["principal"] for d in found) else "reproduced",
        f"joints that spin in the principal chart: {told['principal']}; in the centred chart: {told['centred']}",
    )
    head = ("data", "boundaries", "flips", "median θ °", "largest θ °", "without spin, principal", "without, centred")
    caption = f"Flips, the larger θ of both sides, and how many stitch without a spin; at most {limit} boundaries."
    joints = [(d.name, *joint) for d in found for joint in d.joints]
    return Section(
        "Flips found at real boundaries",
        "Every boundary from the end of one clip to the start of another at which u · u′ < −0.9 for some joint. The "
        "claim holds where rotations stay well inside π; where a joint rests near half a turn, the principal chart "
        "spins it and the centred chart does not.",
        (finding,),
        (),
        (
            Table(caption, head, rows_of([d.row for d in found])),
            Table("The joints that flip most.", ("data", "joint", "flips"), rows_of(joints)),
        ),
        numbers={
            "detected_flips": {
                d.name: {"flips": d.flips, **{f"spun_{chart}": d.spun[chart] for chart in CHARTS}} for d in found
            }
        },
    )
