"""Random seams between real clips: how often a limb spins in each chart, and the numbers before and after.

Run as ``python -m kinestitch.experiments.seams FOLDER -o docs/seams.md``. FOLDER holds one folder of clips per data
set.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kinestitch import files
from kinestitch.analysis.quality import SeamQuality, seam_quality
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_distance
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline
from kinestitch.experiments.tables import table_options, write_page
from kinestitch.solve.chart import CHARTS, Chart
from kinestitch.solve.placed import Placed
from kinestitch.solve.rivals import geodesic_blend
from kinestitch.solve.seam import SeamPlace, visible_reach
from kinestitch.solve.stitch import solve_timeline

DATA_SETS = ("mixamo_xbot_60fps", "bandai")
SPIN_FACTOR = 2.0
SPIN_MARGIN = np.radians(90.0)  # rad/s
_LONGEST = 120  # frames that a random replacement may have
_SIDE = 8  # frames that must stand on each side of a random cut


@dataclass(frozen=True, slots=True)
class Spin:
    """A joint whose peak speed near a seam has no cause in the clips: rad/s, beside the larger of blend's and
    sources'.
    """

    seam: int
    joint: str
    speed: float
    allowed: float


@dataclass(frozen=True, slots=True)
class Survey:
    """What a number of random seams of one data set showed: per seam the numbers (centred chart), per chart the
    spins.
    """

    name: str
    clips: int
    joints: int
    fps: float
    qualities: tuple[SeamQuality, ...]
    spins: dict[Chart, tuple[Spin, ...]]


def read_clips(folder: Path) -> dict[str, Motion]:
    """All clips of a folder that share the skeleton and rate of its first one, by file name."""
    clips: dict[str, Motion] = {}
    for path in sorted(p for p in folder.iterdir() if p.suffix.lower() in (".bvh", ".fbx")):
        motion = files.read(path)
        first = next(iter(clips.values()), motion)
        if motion.skeleton.names == first.skeleton.names and motion.frames > 2 * _SIDE:
            clips[path.name] = motion
    return clips


def random_cut(clips: dict[str, Motion], rng: np.random.Generator, seam: Seam) -> Timeline:
    """One clip until a random frame, then another from a random frame on."""
    left, right = rng.choice(sorted(clips), size=2, replace=False)
    fps = clips[left].fps
    infos = tuple(ClipInfo(str(key), clips[key].frames, clips[key].fps) for key in (left, right))
    out = int(rng.integers(_SIDE, infos[0].frames_at(fps) + 1))
    into = int(rng.integers(0, infos[1].frames_at(fps) - _SIDE))
    segments = (
        Segment(infos[0].key, FrameRange(0, out)),
        Segment(infos[1].key, FrameRange(into, infos[1].frames_at(fps))),
    )
    return Timeline(infos, segments, (seam,), fps)


def random_replacement(clips: dict[str, Motion], rng: np.random.Generator, seam: Seam) -> Timeline:
    """One clip with some of its frames replaced by as many of another: two seams, near enough to share a window."""
    base, other = (str(key) for key in rng.choice(sorted(clips), size=2, replace=False))
    fps = clips[base].fps
    infos = tuple(ClipInfo(key, clips[key].frames, clips[key].fps) for key in (base, other))
    first, second = (info.frames_at(fps) for info in infos)
    length = int(rng.integers(_SIDE, max(_SIDE + 1, min(_LONGEST, first - 2 * _SIDE, second))))
    start = int(rng.integers(_SIDE, max(_SIDE + 1, first - length - _SIDE)))
    into = int(rng.integers(0, second - length + 1))
    segments = (
        Segment(base, FrameRange(0, start)),
        Segment(other, FrameRange(into, into + length)),
        Segment(base, FrameRange(min(start + length, first - 1), first)),
    )
    return Timeline(infos, segments, (seam, seam), fps)


def joint_speeds(rotations: Array, fps: float) -> Array:
    """Geodesic speed (F − 1, J) in rad/s of rotations (F, J, 4)."""
    return quat_distance(rotations[1:], rotations[:-1]) * fps


def find_spins(result: Motion, placed: Placed, seam: SeamPlace, number: int) -> list[Spin]:
    """Joints whose peak speed near a seam exceeds 2 × the larger of the geodesic blend's and the sources', plus
    90°/s.
    """
    reach = visible_reach(seam.stiffness)
    near = slice(max(0, seam.frame - reach), seam.frame + reach)
    speed = joint_speeds(result.rotations[near], result.fps).max(axis=0)
    start, blended = geodesic_blend(placed, seam)
    blend = joint_speeds(blended[near.start - start : near.stop - start], result.fps).max(axis=0)
    allowed = np.maximum(blend, _source_speed(placed, seam, reach)) * SPIN_FACTOR + SPIN_MARGIN
    names = result.skeleton.names
    return [Spin(number, names[j], float(speed[j]), float(allowed[j])) for j in np.flatnonzero(speed > allowed)]


def _source_speed(placed: Placed, seam: SeamPlace, reach: int) -> Array:
    left, right = placed.timeline.segments[seam.index], placed.timeline.segments[seam.index + 1]
    a, b = placed.sources[left.clip], placed.sources[right.clip]
    before = a.rotations[max(0, left.range.stop - reach) : left.range.stop + 1]
    after = b.rotations[max(0, right.range.start - 1) : right.range.start + reach]
    return np.maximum(joint_speeds(before, a.fps).max(axis=0), joint_speeds(after, b.fps).max(axis=0))


def survey(
    folder: Path,
    *,
    seams: int = 200,
    seed: int = 0,
    draw: Callable[[dict[str, Motion], np.random.Generator, Seam], Timeline] = random_cut,
) -> Survey:
    """Stitch random pairs of a folder's clips in both charts and measure `seams` seams; repeatable by its seed."""
    clips = read_clips(folder)
    rng = np.random.default_rng(seed)
    qualities: list[SeamQuality] = []
    spins: dict[Chart, list[Spin]] = {chart: [] for chart in CHARTS}
    while len(qualities) < seams:
        cut = draw(clips, rng, Seam())
        number = len(qualities)
        for chart in CHARTS:
            solved = solve_timeline(cut, clips, chart=chart)
            for offset, seam in enumerate(solved.seams):
                spins[chart] += find_spins(solved.motion, solved.placed, seam, number + offset)
                if chart == "centred":
                    qualities.append(seam_quality(solved, seam))
    first = next(iter(clips.values()))
    return Survey(
        folder.name,
        len(clips),
        first.skeleton.joint_count,
        first.fps,
        tuple(qualities),
        {chart: tuple(found) for chart, found in spins.items()},
    )


_ROWS = (
    ("rotation step, worst joint (°)", "rotation_step_deg_before", "rotation_step_deg_after"),
    (
        "angular-velocity step, worst joint (°/s)",
        "angular_velocity_step_deg_s_before",
        "angular_velocity_step_deg_s_after",
    ),
    ("root step (mm)", "root_step_m_before", "root_step_m_after"),
    ("deviation, mean (°)", None, "deviation_mean_deg"),
    ("deviation, worst joint and frame (°)", None, "deviation_max_deg"),
    ("dynamics kept", None, "dynamics_kept"),
    ("price E* (rad²)", None, "price"),
)


_INTRODUCTION = """# Random seams between real clips

Made by `python -m kinestitch.experiments.seams`; no figure on this page is typed in. {seams} random seams a row (seed
{seed}), default smoothing time, root placed. *Cuts*: one clip until a random frame, another from a random frame on.
*Replacements*: {shortest} to {longest} frames of one clip in the place of as many of another, so that two seams share a
window.

## How often a limb spins

A joint spins where its peak speed near the seam exceeds twice the larger of the geodesic blend's and the sources' own,
plus 90°/s ([why so](decisions/0003-what-counts-as-a-spin.md)).

| data set | seams | clips | joints | fps | joint-seams | spins, centred | spins, principal | seams with one |
|---|---|---|---|---|---|---|---|---|
"""


def as_markdown(cuts: Sequence[Survey], replacements: Sequence[Survey], seams: int, seed: int) -> str:
    """The document: spins by chart, then every number before and after as median and 95th percentile."""
    out = [_INTRODUCTION.format(seams=seams, seed=seed, shortest=_SIDE, longest=_LONGEST).rstrip("\n")]
    out += [_spin_row(s, "cuts") for s in cuts] + [_spin_row(s, "replacements") for s in replacements]
    out += ["", "## Numbers before and after, centred chart, cuts", "", "Median / 95th percentile over the seams.", ""]
    out += ["| measure | " + " | ".join(f"{s.name} before | {s.name} after" for s in cuts) + " |"]
    out += ["|---|" + "---|---|" * len(cuts)]
    for label, before, after in _ROWS:
        scale = 1000.0 if "(mm)" in label else 1.0
        cells = [_cell(s.qualities, name, scale) for s in cuts for name in (before, after)]
        out.append(f"| {label} | " + " | ".join(cells) + " |")
    return "\n".join(out) + "\n"


def _spin_row(s: Survey, kind: str) -> str:
    centred, principal = s.spins["centred"], s.spins["principal"]
    hit = len({spin.seam for spin in principal})
    total = len(s.qualities) * s.joints
    cells = (s.name, kind, s.clips, s.joints, f"{s.fps:g}", f"{total:,}", len(centred), len(principal), hit)
    return "| " + " | ".join(map(str, cells)) + " |"


def _cell(qualities: Sequence[SeamQuality], name: str | None, scale: float) -> str:
    if name is None:
        return ""
    values = np.array([getattr(quality, name) for quality in qualities]) * scale
    return f"{np.median(values):.3g} / {np.percentile(values, 95):.3g}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Survey every data set of a folder and write the document."""
    chosen = table_options(__doc__).parse_args(arguments)
    folders = [chosen.folder / name for name in DATA_SETS]
    cuts, pairs = (
        [survey(folder, seams=chosen.seams, seed=chosen.seed, draw=draw) for folder in folders]
        for draw in (random_cut, random_replacement)
    )
    write_page(chosen.output, as_markdown(cuts, pairs, chosen.seams, chosen.seed))


if __name__ == "__main__":
    main()
