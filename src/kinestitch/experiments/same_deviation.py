"""Rivals compared seam by seam where both change the sources as much; and how far settings have to differ for that."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.experiments.trade_off import Curve

BETTER_SMALL = ("added", "strongest", "deviation_max")
"""Measures of which less is better; of the others nearer to 1 is."""


def at_deviation(curve: Curve, measure: str, wanted: Array) -> Array:
    """One measure of every seam (S,) where its own mean deviation is `wanted` (S,), interpolated between settings; NaN
    where the seam does not come to that deviation.
    """
    x, y = curve.values["deviation"], curve.values[measure]
    found = np.full(len(wanted), np.nan)
    for seam, value in enumerate(wanted):
        order = np.argsort(x[:, seam])
        own = x[order, seam]
        if own[0] <= value <= own[-1]:
            found[seam] = np.interp(np.log(value), np.log(np.maximum(own, 1e-12)), y[order, seam])
    return found


def needed_setting(curve: Curve, measure: str, limit: float) -> Array:
    """Least setting (S,) in s at which a seam's measure has come down to `limit`; the widest where none does."""
    found = np.full(curve.values[measure].shape[1], curve.settings[-1])
    for seam, values in enumerate(curve.values[measure].T):
        below = np.flatnonzero(values <= limit)
        if below.size and below[0] == 0:
            found[seam] = curve.settings[0]
        elif below.size:
            first = int(below[0])
            pair = slice(first, first - 2 if first > 1 else None, -1)
            found[seam] = np.exp(np.interp(limit, values[pair], np.log(np.array(curve.settings))[pair]))
    return found


def spread(values: Array) -> float:
    """90th over 10th percentile."""
    low, high = np.percentile(values, (10, 90))
    return float(high / low)


@dataclass(frozen=True, slots=True)
class Versus:
    """Ours at one setting and a rival tuned to the same deviation on each seam.

    ours, theirs : medians of a measure; better : share of seams on which ours is the better one; seams : compared
    loses : whether the rival is the better one in the median
    """

    rival: str
    measure: str
    ours: float
    theirs: float
    better: float
    seams: int
    loses: bool


def versus(ours: Curve, rival: Curve, measure: str) -> Versus:
    """Compare `ours`, a curve of one setting, with a rival at the same deviation, seam by seam."""
    (mine,), (wanted,) = ours.values[measure], ours.values["deviation"]
    theirs = at_deviation(rival, measure, wanted)
    there = np.isfinite(theirs)
    if not there.any():
        return Versus(rival.name, measure, np.nan, np.nan, np.nan, 0, False)
    mine, theirs = mine[there], theirs[there]
    bad, worse = (values if measure in BETTER_SMALL else np.abs(1 - values) for values in (mine, theirs))
    return Versus(
        rival.name,
        measure,
        float(np.median(mine)),
        float(np.median(theirs)),
        float((bad < worse).mean()),
        int(there.sum()),
        bool(np.median(worse) < np.median(bad)),
    )
