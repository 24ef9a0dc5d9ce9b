"""The document of :mod:`kinestitch.experiments.features`: a table for each data set and kind of cut, and the aims."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.edit.timeline import DEFAULT_SMOOTHING
from kinestitch.experiments.features import ALIGN, CUTS, FADE, REACH, SNAP, SOURCES, Survey

HEADS: Mapping[str, str] = MappingProxyType(
    {
        "price": "price E* (rad²)",
        "acceleration": "added acceleration",
        "velocity": "added angular velocity",
        "deviation": "deviation, mean (°)",
        "deviation_max": "deviation, worst (°)",
        "kept": "dynamics kept",
        "survived": "dynamics that survive",
        "root_step": "root step (mm)",
        "skate": "skate in contact (cm/s)",
        "skate_own": "the same in the clips (cm/s)",
        "stances": "contacts kept (%)",
        "hovering": "without support (s)",
    }
)

ACCELERATION, VELOCITY, KEPT, SHARE = 0.25, 1.0, 0.98, 0.95
"""The aims, and the share of the seams that should meet them."""

SLIDE = 0.1
"""cm/s that count as no more than the sources' own."""

AIMS = (
    f"acceleration ≤ {ACCELERATION:g}",
    f"angular velocity ≤ {VELOCITY:g}",
    f"dynamics kept ≥ {KEPT:g}",
    "skate ≤ the clips' own",
)

_NOTHING = 1e-9  # what rounding leaves
_LEAST = ("kept", "survived", "stances")  # measures of which less is worse

_INTRODUCTION = """# What each feature does to a seam

Made by `python -m kinestitch.experiments.features`; no figure on this page is typed in. {seams} random {draw} for each
data set (seed {seed}), the same in every row.

- *Snapped*: each side of the cut moved by up to {snap:g} s to where the seam is cheapest.
- *Crossfade*: {fade:g} s on each side. *Solved*: at {smoothing:g} s. *Automatic*: as [auto.md](auto.md) says.
  Feet are locked as [feet.md](feet.md) says.
- *Steps aligned*: where both clips walk or run, the cut has moved by up to {align:g} s to where their steps meet
  ([time.md](time.md)); then as solved.
- *Everything on*: steps aligned, automatic, feet locked.

Everything is measured within {reach:g} s of the seam on each side, but for the dynamics kept, which are measured within
the visible reach of {smoothing:g} s. A cell has the median and the 95th percentile over the seams; where less is worse,
the 5th.

- **Price**: what the seam costs at a smoothing time of {smoothing:g} s. It belongs to the cut, not to what is made of
  it.
- **Added acceleration, added angular velocity**: what the worst joint has above its own source in the same frame, over
  what the sources' strongest joint does in 95 % of the frames ([why so](decisions/0005-what-counts-as-added.md)).
- **Deviation**: from the hard cut, all joints; the mean, and the worst joint and frame.
- **Dynamics kept**: ‖L R‖ over ‖δ_tar‖; pops and blur cancel out in it. **Dynamics that survive** count only what is
  weaker than its source.
- **Root step**: how far the hips move over the seam's interval. The clips' own is the larger of both.
- **Skate in contact**: speed over the ground of feet that stand. All rows of a cut count the contacts that locked feet
  keep; what is too far apart, or would take too sudden a movement, is given up for a step.
- **Contacts kept, without support**: how many contacts of the clips the locked feet keep, and how long no foot is on
  the ground although one is in the clips.
"""


_ABOUT_AIMS = (
    f"Shares of the seams. Feet may slide by {SLIDE:g} cm/s more than in the clips, and are counted where one stands."
)


def as_markdown(surveys: Sequence[Survey], *, seed: int, draw: str = "cuts") -> str:
    """The whole document."""
    seams = len(next(iter(surveys[0].values[next(iter(CUTS))].values())))
    told = {
        "seams": seams,
        "draw": draw,
        "seed": seed,
        "snap": SNAP,
        "align": ALIGN,
        "smoothing": DEFAULT_SMOOTHING,
        "fade": FADE,
        "reach": REACH,
    }
    out = [_INTRODUCTION.format(**told).rstrip("\n"), ""]
    for survey in surveys:
        out += [f"## {survey.name}", "", f"{survey.clips} clips, {survey.joints} joints, {survey.fps:g} fps.", ""]
        for cuts in CUTS:
            out += [f"### {cuts.capitalize()} cuts", "", *_table(survey, cuts), ""]
    out += ["## How many seams meet the aims", "", _ABOUT_AIMS, "", *_aims_table(surveys), "", *_verdict(surveys)]
    return "\n".join(out) + "\n"


def _table(survey: Survey, cuts: str) -> list[str]:
    lines = ["| | " + " | ".join(HEADS.values()) + " |", "|---" * (len(HEADS) + 1) + "|"]
    for row in survey.values[cuts]:
        cells = [_cell(survey.of(cuts, row, measure), measure) for measure in HEADS]
        lines.append(f"| {row} | " + " | ".join(cells) + " |")
    return lines


def _cell(values: Array, measure: str) -> str:
    values = values[~np.isnan(values)]
    if not values.size:
        return "–"
    worse = 5 if measure in _LEAST else 95
    typical, bad = (0.0 if abs(value) < _NOTHING else value for value in np.percentile(values, (50, worse)))
    return f"{typical:.3g} / {bad:.3g}"


def met(survey: Survey, cuts: str, row: str) -> Array:
    """Which seams meet each of the `AIMS`: (S, 4) of 1 and 0; NaN for the skate where no foot stands."""
    skate = survey.of(cuts, row, "skate")
    slides = skate <= survey.of(cuts, row, "skate_own") + SLIDE
    return np.stack(
        [
            survey.of(cuts, row, "acceleration") <= ACCELERATION,
            survey.of(cuts, row, "velocity") <= VELOCITY,
            survey.of(cuts, row, "kept") >= KEPT,
            np.where(np.isnan(skate), np.nan, slides),
        ],
        axis=1,
    )


def _aims_table(surveys: Sequence[Survey]) -> list[str]:
    head = ("data set", "cuts", "", *AIMS, "all of them")
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    for survey in surveys:
        for cuts in CUTS:
            for row in survey.values[cuts]:
                if row != SOURCES:
                    one = met(survey, cuts, row)
                    shares = [*np.nanmean(one, axis=0), np.nanmin(one, axis=1).mean()]
                    cells = (survey.name, cuts, row, *(f"{share:.1%}" for share in shares))
                    lines.append("| " + " | ".join(cells) + " |")
    return lines


def _verdict(surveys: Sequence[Survey]) -> list[str]:
    """The last row on the last kind of cut, aim by aim."""
    cuts = tuple(CUTS)[-1]
    lines = [f"The aim is {SHARE:.0%} of the seams, with everything on and cuts {cuts}:", ""]
    for survey in surveys:
        row = tuple(survey.values[cuts])[-1]
        shares = np.nanmean(met(survey, cuts, row), axis=0)
        told = [
            f"{aim} {'is met' if share >= SHARE else 'is missed'} ({share:.1%})"
            for aim, share in zip(AIMS, shares, strict=True)
        ]
        lines.append(f"- {survey.name}, {row}: " + "; ".join(told) + ".")
    return lines
