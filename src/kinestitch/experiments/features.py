"""What each feature does to real seams: the same cuts measured before and after it, as drawn and snapped.

Run as ``python -m kinestitch.experiments.features FOLDER -o docs/features.md``. FOLDER holds one folder of clips per
data set.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from kinestitch.analysis.quality import deviation, dynamics_kept, root_step
from kinestitch.analysis.skating import slide_in_contact
from kinestitch.analysis.smoothness import added_acceleration, added_velocity
from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.edit.timeline import DEFAULT_SMOOTHING, Seam, Segment, Timeline
from kinestitch.experiments.seams import DATA_SETS, random_cut, random_replacement, read_clips
from kinestitch.experiments.tables import table_options, write_page
from kinestitch.experiments.trade_off import near_seam
from kinestitch.rig.hips import hips_joint
from kinestitch.search.align import align_phase
from kinestitch.search.snap import snap
from kinestitch.solve.contacts import Contacts
from kinestitch.solve.energy import seam_price
from kinestitch.solve.footlock import locked, placed_contacts
from kinestitch.solve.placed import straddling
from kinestitch.solve.rivals import crossfade
from kinestitch.solve.seam import SeamPlace
from kinestitch.solve.solved import Solved, as_motion
from kinestitch.solve.stitch import solve_timeline

Clips = Mapping[str, Motion]
Feature = Callable[[Timeline, Clips], Solved]
"""A way over the seams: from a timeline and its clips to a result whose `motion` is measured against its `placed`."""

SNAP = 0.2
"""s by which a snapped cut may move on each side."""

ALIGN = 0.5
"""s by which a cut between steps may move to where they meet."""

FADE = 0.2
"""s on each side that the crossfade takes."""

REACH = 1.0
"""s on each side of a seam within which everything is measured, whatever the feature's width."""

SOURCES = "the clips themselves"
"""The row of what both sources do without a seam."""


def _faded(line: Timeline, clips: Clips) -> Solved:
    cut = solve_timeline(line, clips, method="cut")
    return replace(cut, motion=crossfade(cut.placed, max(1, round(FADE * line.fps))))


def _automatic(line: Timeline) -> Timeline:
    return replace(line, seams=(Seam(automatic=True),) * len(line.seams))


def _aligned(line: Timeline, clips: Clips) -> Timeline:
    return align_phase(line, clips, ALIGN).timeline


FEATURES: Mapping[str, Feature] = MappingProxyType(
    {
        "hard cut": lambda line, clips: solve_timeline(line, clips, method="cut"),
        "crossfade": _faded,
        "solved": lambda line, clips: solve_timeline(line, clips, foot_lock=False),
        "solved, feet locked": lambda line, clips: solve_timeline(line, clips, foot_lock=True),
        "automatic": lambda line, clips: solve_timeline(_automatic(line), clips, foot_lock=False),
        "steps aligned": lambda line, clips: solve_timeline(_aligned(line, clips), clips, foot_lock=False),
        "everything on": lambda line, clips: solve_timeline(_automatic(_aligned(line, clips)), clips, foot_lock=True),
    }
)
"""One row each; the last one has everything on."""

CUTS: Mapping[str, Callable[[Timeline, Clips], Timeline]] = MappingProxyType(
    {
        "random": lambda line, _: line,
        "snapped": lambda line, clips: snap(line, clips, SNAP).timeline,
    }
)
"""Where the cuts lie: one table each."""

DRAWS: Mapping[str, Callable[[dict[str, Motion], np.random.Generator, Seam], Timeline]] = MappingProxyType(
    {
        "cuts": lambda clips, rng, seam: near_seam(random_cut(clips, rng, seam)),
        "replacements": random_replacement,
    }
)

MEASURES = (
    "price",
    "acceleration",
    "velocity",
    "deviation",
    "deviation_max",
    "kept",
    "survived",
    "root_step",
    "skate",
    "skate_own",
    "stances",
    "hovering",
)


@dataclass(frozen=True, eq=False, slots=True)
class Survey:
    """One data set, measured.

    values : per kind of cut and row (:data:`SOURCES` and :data:`FEATURES`) an array (S, M) over seams and `MEASURES`
    """

    name: str
    clips: int
    joints: int
    fps: float
    values: Mapping[str, Mapping[str, Array]]

    def of(self, cuts: str, row: str, measure: str) -> Array:
        """One measure of one row over all seams (S,); NaN where it does not apply."""
        return np.asarray(self.values[cuts][row][:, MEASURES.index(measure)])


def measure(line: Timeline, clips: Clips, features: Mapping[str, Feature] = FEATURES) -> dict[str, list[list[float]]]:
    """The values of ``MEASURES`` at every seam of one timeline, row by row."""
    made = {name: make(line, clips) for name, make in features.items()}
    kept: dict[tuple[Segment, ...], Contacts] = {}
    for one in made.values():
        if one.contacts is not None:
            kept.setdefault(one.placed.timeline.segments, one.contacts)

    def stands(one: Solved) -> Contacts:
        """The contacts that count: a locked row's own, else those that a lock keeps on the same cut."""
        cut = one.placed.timeline.segments
        if one.contacts is None and cut not in kept:
            kept[cut] = locked(solve_timeline(one.placed.timeline, clips, foot_lock=False)).contacts
        return one.contacts or kept[cut]

    first = next(iter(made.values()))
    found = {SOURCES: [_own(first, seam, stands(first)) for seam in first.placed.seams]}
    for name, one in made.items():
        found[name] = [_numbers(one, seam, stands(one)) for seam in one.placed.seams]
    return found


def _numbers(made: Solved, seam: SeamPlace, contacts: Contacts) -> list[float]:
    """A result's values of ``MEASURES`` at one seam."""
    motion, placed = made.motion, made.placed
    usual = SeamPlace(seam.index, seam.frame, Seam(smoothing=DEFAULT_SMOOTHING).lambda_at(motion.fps))
    reach = round(REACH * motion.fps)
    bend, turn = added_acceleration(motion, placed, seam, reach), added_velocity(motion, placed, seam, reach)
    mean, largest = np.degrees(deviation(motion, made.cut, seam.frame, reach))
    return [
        seam_price(replace(placed, groups=()), usual),
        bend.peak,
        turn.peak,
        float(mean),
        float(largest),
        dynamics_kept(motion, placed, usual),
        bend.survived,
        1000 * root_step(motion, seam.frame),
        _skate(motion, contacts, seam.frame, ()),
        _own_skate(made, contacts, seam.frame),
        *_support(made, seam),
    ]


def _own(made: Solved, seam: SeamPlace, contacts: Contacts) -> list[float]:
    """What the sources do: the larger of their own steps over the seam's interval, and how far their feet slide."""
    around = straddling(made.placed, seam)
    poses = as_motion(made.placed, around.rotations.copy(), around.translations.copy())
    joint = hips_joint(poses.skeleton)
    hips = world_pose(poses, [joint]).positions[:, joint]
    step = max(float(np.linalg.norm(hips[k + 1] - hips[k])) for k in (0, 2))
    skate = _own_skate(made, contacts, seam.frame)
    none = dict.fromkeys(MEASURES, float("nan"))
    return list((none | {"root_step": 1000 * step, "skate": skate}).values())


def _own_skate(made: Solved, contacts: Contacts, frame: int) -> float:
    """What :func:`_skate` is in the clips."""
    return _skate(made.cut, contacts, frame, [place.frame for place in made.placed.seams])


def _skate(motion: Motion, contacts: Contacts, frame: int, leave_out: Sequence[int]) -> float:
    """cm/s at which standing feet slide within ``REACH`` of a frame; NaN where none stands."""
    reach = round(REACH * motion.fps)
    near = slice(max(0, frame - reach), frame + reach)
    window = replace(motion, rotations=motion.rotations[near], translations=motion.translations[near])
    held = Contacts(contacts.joints, contacts.held[near])
    inside = [place - near.start for place in leave_out if near.start < place < near.start + window.frames]
    together = held.held[1:] & held.held[:-1]
    if not np.delete(together, [place - 1 for place in inside], axis=0).any():
        return float("nan")
    return 100 * slide_in_contact(window, held, leave_out=inside)


def _support(made: Solved, seam: SeamPlace) -> tuple[float, float]:
    """Where feet were locked: the share in % of the sources' contacts near a seam that the result keeps, and for how
    many s it has no foot on the ground although a source has; NaN where nothing stands, or nothing was locked.
    """
    if made.contacts is None:
        return float("nan"), float("nan")
    reach = round(REACH * made.motion.fps)
    near = slice(max(0, seam.frame - reach), seam.frame + reach)
    own, kept = placed_contacts(made.placed).held[near], made.contacts.held[near]
    if not own.any():
        return float("nan"), float("nan")
    hovers = own.any(axis=1) & ~kept.any(axis=1)
    return 100 * float((own & kept).sum() / own.sum()), float(hovers.sum() / made.motion.fps)


def survey(
    clips: dict[str, Motion],
    name: str,
    *,
    seams: int = 200,
    seed: int = 0,
    draw: str = "cuts",
    features: Mapping[str, Feature] = FEATURES,
    progress: Callable[[int, int], None] | None = None,
) -> Survey:
    """Measure every feature on the same `seams` seams between clips of one rig; repeatable by its seed.

    draw : a key of :data:`DRAWS`; progress : called with the number of seams done and of all
    """
    rng = np.random.default_rng(seed)
    found: dict[str, dict[str, list[list[float]]]] = {cuts: {} for cuts in CUTS}
    done = 0
    while done < seams:
        line = DRAWS[draw](clips, rng, Seam())
        for cuts, moved in CUTS.items():
            for row, lists in measure(moved(line, clips), clips, features).items():
                found[cuts].setdefault(row, []).extend(lists)
        done += len(line.seams)
        if progress is not None:
            progress(done, seams)
    first = next(iter(clips.values()))
    values = {cuts: {row: np.array(lists) for row, lists in rows.items()} for cuts, rows in found.items()}
    return Survey(name, len(clips), first.skeleton.joint_count, first.fps, values)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure every data set of a folder and write the document."""
    from kinestitch.experiments.features_page import as_markdown

    parser = table_options(__doc__)
    parser.add_argument("--sets", nargs="+", default=DATA_SETS, metavar="NAME", help="folders within FOLDER")
    parser.add_argument("--draw", choices=tuple(DRAWS), default="cuts")
    chosen = parser.parse_args(arguments)

    def tell(done: int, of: int) -> None:
        if done % 20 == 0 or done >= of:
            print(f"{name}: {done} of {of} seams", file=sys.stderr)

    surveys = []
    for name in chosen.sets:
        clips = read_clips(chosen.folder / name)
        how = {"seams": chosen.seams, "seed": chosen.seed, "draw": chosen.draw}
        surveys.append(survey(clips, name, **how, progress=tell))
    write_page(chosen.output, as_markdown(surveys, seed=chosen.seed, draw=chosen.draw))


if __name__ == "__main__":
    main()
