"""Automatic stiffness beside every fixed one, on random seams: what each adds at worst, and what it changes.

A fixed smoothing time has to be long enough for the worst of all seams. No rule can beat every fixed λ on the sum of
both, since each λ minimises just that; the aim is a lower mean deviation at the same 95th percentile of added
acceleration.

Run as ``python -m kinestitch.experiments.adaptive FOLDER -o docs/adaptive.md``. FOLDER holds one folder of clips per
data set.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from kinestitch.analysis.quality import deviation
from kinestitch.analysis.skating import slide_in_contact
from kinestitch.analysis.smoothness import (
    added_acceleration,
    added_velocity,
    angular_acceleration,
    angular_velocity,
    own_acceleration,
)
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.edit.timeline import DEFAULT_SMOOTHING, Seam, Timeline
from kinestitch.experiments.adaptive_page import as_markdown
from kinestitch.experiments.seams import DATA_SETS, random_cut, read_clips
from kinestitch.experiments.tables import table_options, write_page
from kinestitch.experiments.trade_off import Curve, near_seam
from kinestitch.rig.carrier import world_of
from kinestitch.search.snap import snap
from kinestitch.solve.adaptive import UNSEEN, Share, with_automatic
from kinestitch.solve.contacts import Contacts
from kinestitch.solve.footlock import placed_contacts
from kinestitch.solve.placed import Placed, place_timeline
from kinestitch.solve.seam import SeamPlace
from kinestitch.solve.sources import AROUND, PERCENTILE, Strength, own_strength, own_velocities
from kinestitch.solve.stitch import solve_placed

SNAP = 0.2
"""s by which a snapped cut may move on each side."""

FIXED = (0.03, 0.042, 0.059, 0.083, DEFAULT_SMOOTHING, 0.14, 0.2, 0.28, 0.4)
"""s: smoothing times of the fixed rule."""

SHARES = (1 / 16, 1 / 8, 1 / 4, 1 / 2)
"""Shares of the sources' own acceleration that the automatic rules may add."""

DEFAULTS = (DEFAULT_SMOOTHING, Share().acceleration)
"""Where a rule stands that nobody has set."""

Setting = Callable[[Placed, float], Placed]


def _fixed(placed: Placed, seconds: float) -> Placed:
    stiffness = Seam(smoothing=seconds).lambda_at(placed.timeline.fps)
    return replace(placed, seams=tuple(replace(seam, stiffness=stiffness) for seam in placed.seams))


def whole_clips(placed: Placed, seam: SeamPlace) -> Strength:
    """The sources' own strength like :func:`own_strength`, over all frames of both clips instead of those near by."""
    clips = sorted({segment.clip for segment in placed.timeline.segments[seam.index : seam.index + 2]})
    bends, speeds = (np.concatenate(sizes) for sizes in zip(*(_sizes(placed.sources[c]) for c in clips), strict=True))
    path = own_strength(placed, seam).path
    return Strength(float(np.percentile(bends, PERCENTILE)), float(np.percentile(speeds, PERCENTILE)), path)


@lru_cache(maxsize=8)
def _sizes(clip: Motion) -> tuple[Array, Array]:
    """The strongest joint's angular acceleration and velocity in each frame of a clip."""
    measures = (angular_acceleration, angular_velocity)
    bends, speeds = (np.linalg.norm(measure(clip.rotations, clip.fps), axis=-1).max(axis=1) for measure in measures)
    return bends, speeds


RULES: Mapping[str, tuple[tuple[float, ...], Setting]] = MappingProxyType(
    {
        "fixed": (FIXED, _fixed),
        "auto, whole body": (SHARES, lambda placed, s: with_automatic(placed, Share(s), grouped=False)),
        "auto, by parts": (SHARES, lambda placed, s: with_automatic(placed, Share(s))),
        "auto, acceleration alone": (SHARES[1:3], lambda placed, s: with_automatic(placed, Share(s, np.inf, np.inf))),
        "auto, whole clips": (SHARES[1:3], lambda placed, s: with_automatic(placed, Share(s), strength=whole_clips)),
    }
)
"""What chooses λ, with the settings it runs over: smoothing times in s, or shares."""

MEASURES: Mapping[str, str] = MappingProxyType(
    {
        "added": "added acceleration",
        "added_clip": "added acceleration, over that of both whole clips",
        "velocity": "added angular velocity",
        "path": "added acceleration of the path",
        "deviation": "mean deviation (°)",
        "kept": "dynamics kept",
        "slide": "slide in contact (m/s)",
        "smoothing": "longest smoothing time (s)",
    }
)


@dataclass(frozen=True, eq=False, slots=True)
class Study:
    """All rules on the same random seams of one data set; kind : how the cuts were made."""

    name: str
    kind: str
    fps: float
    curves: Mapping[str, Curve]


def study(clips: Mapping[str, Motion], name: str, *, seams: int = 200, seed: int = 0, snapped: float = 0.0) -> Study:
    """Every rule over its whole range on `seams` random cuts; repeatable by its seed.

    snapped : s by which both sides of each cut may move to a cheaper place
    """
    rng = np.random.default_rng(seed)
    found = {rule: np.empty((len(MEASURES), len(settings), seams)) for rule, (settings, _) in RULES.items()}
    for number in range(seams):
        cut = random_cut(dict(clips), rng, Seam())
        if snapped:
            cut = snap(cut, clips, snapped).timeline
        for rule, values in measure(near_seam(cut), clips).items():
            found[rule][:, :, number] = values
    curves = {
        rule: Curve(rule, "s" if rule == "fixed" else "share", RULES[rule][0], dict(zip(MEASURES, values, strict=True)))
        for rule, values in found.items()
    }
    kind = f"snapped by up to {snapped:g} s" if snapped else "as drawn"
    return Study(name, kind, next(iter(clips.values())).fps, curves)


def measure(cut: Timeline, clips: Mapping[str, Motion]) -> dict[str, Array]:
    """One cut, all rules: for each an array (measures, settings) in the order of ``MEASURES``."""
    placed = place_timeline(replace(cut, seams=(Seam(automatic=True),)), clips)
    (seam,) = placed.seams
    reach = max(1, round(AROUND * cut.fps))
    start, stop = max(0, seam.frame - reach), min(placed.frames, seam.frame + reach)
    found = placed_contacts(placed)
    near = _Near(
        placed,
        seam,
        reach,
        own_acceleration(placed, seam, reach),
        own_strength(placed, seam),
        whole_clips(placed, seam).acceleration,
        solve_placed(replace(placed, seams=())),
        Contacts(found.joints, found.held[start:stop]),
    )
    return {
        rule: np.transpose([near.measured(choose(placed, s), feet=s in DEFAULTS) for s in settings])
        for rule, (settings, choose) in RULES.items()
    }


@dataclass(frozen=True, eq=False, slots=True)
class _Near:
    """A seam and what its sources do around it."""

    placed: Placed
    seam: SeamPlace
    reach: int
    own: Array
    strength: Strength
    clips: float
    cut: Motion
    contacts: Contacts

    def measured(self, chosen: Placed, *, feet: bool) -> tuple[float, ...]:
        """The values of ``MEASURES`` for one choice of λ; feet : whether to measure their slide too: it takes long."""
        motion, placed, seam = solve_placed(chosen), self.placed, self.seam
        added = added_acceleration(motion, placed, seam, self.reach, own=self.own)
        start = max(0, seam.frame - self.reach)
        here = slice(start, seam.frame + self.reach)
        part = replace(motion, rotations=motion.rotations[here], translations=motion.translations[here])
        return (
            added.peak,
            float(added.added.max()) / self.clips,
            added_velocity(motion, placed, seam, self.reach).peak,
            self._path(motion),
            float(np.degrees(deviation(motion, self.cut, seam.frame, self.reach)[0])),
            added.kept,
            slide_in_contact(part, self.contacts) if feet else float("nan"),
            chosen.seams[0].stiffness ** 0.25 / motion.fps,
        )

    def _path(self, motion: Motion) -> float:
        """The acceleration that the joint which carries the travel has more than its sources, over their own."""
        start, stop = max(1, self.seam.frame - self.reach), min(motion.frames - 1, self.seam.frame + self.reach)
        before, after = own_velocities(self.placed, start, stop)[2]
        own = np.linalg.norm(after - before, axis=-1) * motion.fps
        path = world_of(motion, self.placed.carrier)[0][start - 1 : stop + 1]
        size = np.linalg.norm(np.diff(path, n=2, axis=0), axis=-1) * motion.fps**2
        return float(np.maximum(size - own, 0.0).max()) / max(self.strength.path, UNSEEN.path)


def main(arguments: Sequence[str] | None = None) -> None:
    """Study every data set of a folder, cuts as drawn and snapped, and write the document."""
    chosen = table_options(__doc__).parse_args(arguments)
    sets = {name: read_clips(chosen.folder / name) for name in DATA_SETS}
    studies = [
        [study(clips, name, seams=chosen.seams, seed=chosen.seed, snapped=seconds) for name, clips in sets.items()]
        for seconds in (0.0, SNAP)
    ]
    write_page(chosen.output, as_markdown(studies, chosen.seams, chosen.seed))


if __name__ == "__main__":
    main()
