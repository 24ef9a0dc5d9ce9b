"""Every way over a seam at every width, on the same cuts: what it adds against what it changes.

A method is better where it adds less acceleration for the same deviation and keeps the sources' dynamics. One setting
of each says little, since every method can be made smooth by making it wide; so each runs over its whole range.

What is added is counted against the source whose frame it is. A blend that lets the other source's movements in early
adds them, even where they are no stronger than what that source does by itself; ``strongest`` looks at the result
alone, and falls below the sources' own where a blend averages them away.

Run as ``python -m kinestitch.experiments.trade_off FOLDER -o PICTURE``, FOLDER being one data set.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from kinestitch.analysis.quality import deviation
from kinestitch.analysis.smoothness import added_acceleration, own_acceleration
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.edit.timeline import FrameRange, Seam, Timeline
from kinestitch.experiments.seams import random_cut, read_clips
from kinestitch.experiments.tables import table_options
from kinestitch.render.curves import Line, Panel, plot_panels
from kinestitch.solve.placed import Placed, place_timeline
from kinestitch.solve.rivals import crossfade, dead_blend, hermite, inertialize
from kinestitch.solve.stitch import stitch

REACH = 1.0
"""s on each side of a seam within which everything is measured, whatever the method's width."""

CONTEXT = 4.0
"""s on each side of a seam that are stitched at all; at the largest λ less than 1e-3 of a correction is left there."""

SECONDS = (0.03, 0.06, 0.1, 0.16, 0.25, 0.4, 0.6, 1.0)
"""Widths of the rivals; the solver's smoothing times are a third of them, since it reaches about four times as far."""

MEASURES: Mapping[str, str] = MappingProxyType(
    {
        "added": "added acceleration over the sources' own 95th percentile",
        "strongest": "largest acceleration over the sources' own 95th percentile",
        "deviation": "mean deviation within a second of the seam (°)",
        "deviation_max": "largest deviation (°)",
        "kept": "dynamics kept (size of the angular acceleration over the sources')",
        "survived": "dynamics that survive (only what is weaker than its source counts)",
    }
)


@dataclass(frozen=True, slots=True)
class Way:
    """One method: what it is called, what its setting means, and the settings (P,) it runs over, in s."""

    name: str
    setting: str
    settings: tuple[float, ...]
    join: Callable[[Placed, float], Motion]


@dataclass(frozen=True, eq=False, slots=True)
class Curve:
    """One method over its range: settings (P,) in s, and for each of ``MEASURES`` the values (P, S) of all seams."""

    name: str
    setting: str
    settings: tuple[float, ...]
    values: Mapping[str, Array]

    def percentile(self, measure: str, percent: float = 50.0) -> Array:
        """A percentile over the seams of one measure at each setting: (P,)."""
        return np.asarray(np.percentile(self.values[measure], percent, axis=1))

    def at(self, measure: str, given: str, value: float, percent: float = 50.0) -> float:
        """The median of one measure where the median of another has a value; NaN outside the curve's range.

        For instance the added acceleration at 3° of deviation, interpolated between settings on logarithms. For
        `percent` other than 50 that percentile of `measure` at the median of `given`.
        """
        x, y = self.percentile(given), self.percentile(measure, percent)
        order = np.argsort(x)
        x, y = x[order], np.maximum(y[order], 1e-12)
        if not x[0] <= value <= x[-1]:
            return float("nan")
        return float(np.exp(np.interp(np.log(value), np.log(x), np.log(y))))


@dataclass(frozen=True, eq=False, slots=True)
class TradeOff:
    """All methods on the same random seams of one data set."""

    name: str
    seams: int
    fps: float
    curves: tuple[Curve, ...]

    def curve(self, name: str) -> Curve:
        """The curve of a method by its name."""
        return next(curve for curve in self.curves if curve.name == name)


def _frames(placed: Placed, seconds: float) -> int:
    return max(1, round(seconds * placed.timeline.fps))


def _laplacian(placed: Placed, seconds: float) -> Motion:
    softer = replace(placed.timeline, seams=(Seam(smoothing=seconds),) * len(placed.timeline.seams))
    return stitch(softer, placed.sources)


WAYS: tuple[Way, ...] = (
    Way("laplacian", "smoothing time τ", tuple(seconds / 3 for seconds in SECONDS), _laplacian),
    Way("crossfade", "width on each side", SECONDS, lambda placed, s: crossfade(placed, _frames(placed, s))),
    Way(
        "crossfade, eased",
        "width on each side",
        SECONDS,
        lambda placed, s: crossfade(placed, _frames(placed, s), eased=True),
    ),
    Way("inertialize", "half-life", SECONDS, inertialize),
    Way("dead blend", "width", SECONDS, lambda placed, s: dead_blend(placed, _frames(placed, s))),
    Way("hermite", "width", SECONDS, lambda placed, s: hermite(placed, _frames(placed, s))),
    Way(
        "hermite, both sides",
        "width on each side",
        SECONDS,
        lambda placed, s: hermite(placed, _frames(placed, s), sides="both"),
    ),
)


def trade_off(
    clips: Mapping[str, Motion],
    name: str,
    *,
    seams: int = 200,
    seed: int = 0,
    ways: Sequence[Way] = WAYS,
    progress: Callable[[int, int], None] | None = None,
) -> TradeOff:
    """Run every method over its whole range on `seams` random cuts between clips of one rig; repeatable by its seed.

    progress : called with the number of seams done and of all seams
    """
    rng = np.random.default_rng(seed)
    found = {way.name: np.empty((len(MEASURES), len(way.settings), seams)) for way in ways}
    for number in range(seams):
        cut = near_seam(random_cut(dict(clips), rng, Seam()))
        for way, values in measure(cut, clips, ways).items():
            found[way][:, :, number] = values
        if progress is not None:
            progress(number + 1, seams)
    curves = tuple(
        Curve(way.name, way.setting, way.settings, dict(zip(MEASURES, found[way.name], strict=True))) for way in ways
    )
    return TradeOff(name, seams, next(iter(clips.values())).fps, curves)


def near_seam(cut: Timeline) -> Timeline:
    """The same cut with no more of either clip than ``CONTEXT`` on each side of the seam."""
    left, right = cut.segments
    frames = round(CONTEXT * cut.fps)
    short = (
        replace(left, range=FrameRange(max(left.range.start, left.range.stop - frames), left.range.stop)),
        replace(right, range=FrameRange(right.range.start, min(right.range.stop, right.range.start + frames))),
    )
    return replace(cut, segments=short)


def measure(cut: Timeline, clips: Mapping[str, Motion], ways: Sequence[Way] = WAYS) -> dict[str, Array]:
    """One cut, all methods: for each an array (measures, settings) in the order of ``MEASURES``."""
    placed = place_timeline(cut, clips)
    (seam,) = placed.seams
    reach = _frames(placed, REACH)
    own = own_acceleration(placed, seam, reach)
    hard = stitch(cut, clips, method="cut")
    found = {}
    for way in ways:
        values = np.empty((len(MEASURES), len(way.settings)))
        for column, setting in enumerate(way.settings):
            motion = way.join(placed, setting)
            added = added_acceleration(motion, placed, seam, reach, own=own)
            mean, largest = np.degrees(deviation(motion, hard, seam.frame, reach))
            values[:, column] = added.peak, added.total, mean, largest, added.kept, added.survived
        found[way.name] = values
    return found


def advantage(
    trade: TradeOff, rival: str, *, of: str = "laplacian", measure: str = "added", percent: float = 50.0
) -> Array:
    """How many times as much a rival has of a measure as `of` at the same median mean deviation: (P,), one for each
    setting of the rival; NaN where `of` does not come to that deviation.

    Above 1 where less is better (``added``, ``deviation_max``) `of` wins, below 1 the rival does.
    """
    ours, theirs = trade.curve(of), trade.curve(rival)
    value = theirs.percentile(measure, percent)
    same = [ours.at(measure, "deviation", x, percent) for x in theirs.percentile("deviation")]
    return value / np.array(same)


def plot_trade_off(trade: TradeOff, path: str | os.PathLike[str]) -> None:
    """Draw acceleration added, and dynamics that survive, against mean deviation; medians, 95th percentile dotted."""
    deviations = {curve.name: curve.percentile("deviation") for curve in trade.curves}
    added, survived = (
        tuple(
            Line(c.name, deviations[c.name], c.percentile(name), None if high is None else c.percentile(name, high))
            for c in trade.curves
        )
        for name, high in (("added", 95.0), ("survived", 5.0))
    )
    x = MEASURES["deviation"]
    panels = [
        Panel(added, x, "added acceleration / sources' 95th percentile", y_log=True),
        Panel(survived, x, "share of the sources' dynamics that survives"),
    ]
    title = f"{trade.seams} random seams, {trade.name}: median, and the worse 5 % dotted"
    plot_panels(panels, path, title=title)


def as_markdown(trade: TradeOff) -> str:
    """Every method's medians (95th percentiles) at every setting, and how much it adds at the deviation of ours."""
    names = list(MEASURES)
    out = [
        f"| method | setting (s) | {' | '.join(names)} | added over ours at this deviation |",
        "|---" * (len(names) + 3) + "|",
    ]
    for curve in trade.curves:
        versus = advantage(trade, curve.name)
        for column, setting in enumerate(curve.settings):
            cells = [f"{curve.percentile(n)[column]:.3g} ({curve.percentile(n, 95)[column]:.3g})" for n in names]
            times = "" if np.isnan(versus[column]) else f"{versus[column]:.2f}"
            out.append(f"| {curve.name} | {curve.setting} {setting:.3g} | {' | '.join(cells)} | {times} |")
    return "\n".join(out) + "\n"


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure one folder of clips, draw the curves and print the table."""
    chosen = table_options(__doc__).parse_args(arguments)
    trade = trade_off(read_clips(chosen.folder), chosen.folder.name, seams=chosen.seams, seed=chosen.seed)
    plot_trade_off(trade, chosen.output)
    print(as_markdown(trade), end="")


if __name__ == "__main__":
    main()
