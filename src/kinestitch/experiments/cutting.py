"""Where to cut, measured on real clips: what feet in a cost do, how far separable prices hold, and what snapping gains.

Run as ``python -m kinestitch.experiments.cutting FOLDER -o docs/cutting.md``. FOLDER holds one folder of clips per data
set.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.edit.timeline import DEFAULT_SMOOTHING, Seam
from kinestitch.experiments.cut_feet import FeetAtSeam, compare_dearness
from kinestitch.experiments.seams import DATA_SETS, random_replacement, read_clips
from kinestitch.experiments.tables import table_options, write_page
from kinestitch.search.price import SHORT_LIST, best_cuts, exact_price, price_map
from kinestitch.search.snap import Snapped, snap
from kinestitch.search.standing import CONTACT
from kinestitch.solve.seam import visible_reach

APART = (5, 10, 20, 40, 80)
"""Frames between two seams, or between a seam and a clip's end."""

SNAP = 0.2
"""s"""

LISTED = 5

_INTRODUCTION = """# Where to cut, measured

Made by `python -m kinestitch.experiments.cutting`; no figure on this page is typed in. {seams} random cuts or
replacements a data set (seed {seed}), default smoothing time of {smoothing:g} s. The words are those of
[cuts.md](cuts.md).
"""

_FEET = """
## What it does to prefer stances, {where}

Random cuts; in their place the cheapest {where}; and the same with feet in the cost, c in rad
([23](method.md#where-to-cut)), the default being {default:g}. Pairs of which one clip never stands are left out. Means
over the seams, both feet together, within a visible reach of the seam. *Slide*: way over the ground of toes that stand
in their clips. *Skate*: way weighed by height. *Moved*: the farthest that locking takes a toe off its solved place.
"""

_FEET_HEAD = (
    "data set",
    "cut",
    "price (rad²)",
    "same feet stand (%)",
    "one stands on both sides (%)",
    "slide (cm)",
    "skate (cm)",
    "skate, locked (cm)",
    "moved (cm)",
)

_SEPARABLE = """
## How far separable prices hold

By how much the exact price of both seams of a replacement differs from the map's own in %, median / 95th percentile /
worst, by the frames between the seams; and that of one seam so near to the start of a clip. All else stays a visible
reach away from the clips' ends: {reach} frames.
"""

_ORDER = """
## What exact prices change in the order

The {count} best cuts ordered by the map's cost, and the {count} best of {longer} ordered by exact cost. *Free*: cuts
may lie anywhere between the clips' ends; else a visible reach of either clip stays, which is the default.
"""

_ORDER_HEAD = (
    "data set",
    "pairs of clips",
    "another cut comes first (%)",
    "free (%)",
    "first cut's price off the map's, median / worst (%)",
    "free (%)",
)

_SNAPPED = """
## What snapping gains

Both seams of random replacements moved within {seconds:g} s. Prices in rad², median over the replacements; *length*:
mean change in frames; *off*: the exact price of both against the sum of what the search saw.
"""

_SNAPPED_HEAD = ("data set", "before", "snapped", "length", "snapped, length kept", "off, median / worst (%)")


def table_head(cells: Sequence[str]) -> list[str]:
    """The first two lines of a table."""
    return ["", "| " + " | ".join(cells) + " |", "|" + "---|" * len(cells)]


def feet_rows(name: str, found: Mapping[float | None, Sequence[FeetAtSeam]]) -> list[str]:
    """Table rows: the random cuts, then the cheapest ones for each c."""
    rows = []
    for size, seams in found.items():
        means = {key: float(np.mean([getattr(seam, key) for seam in seams])) for key in FeetAtSeam.__slots__}
        cut = "random" if size is None else "cheapest" if size == 0 else f"cheapest, c = {size:g}"
        cells = [name, cut, f"{means['price']:.2f}"]
        cells += [f"{100 * means[key]:.0f}" for key in ("same", "shared")]
        cells += [f"{100 * means[key]:.1f}" for key in ("slide", "skate", "skate_locked", "moved")]
        rows.append("| " + " | ".join(cells) + " |")
    return rows


def separable_errors(clips: Mapping[str, Motion], *, seams: int, seed: int) -> tuple[Array, Array]:
    """Exact over separable price, less 1, for each of `APART`: (seams, 5) of two seams far from the original's ends,
    and of one near its start.
    """
    rng = np.random.default_rng(seed)
    prices = cache(lambda left, right: price_map(clips[left], clips[right], weights="even"))
    reach, longest = visible_reach(Seam().lambda_at(next(iter(clips.values())).fps)), max(APART)
    pairs: list[list[float]] = []
    ends: list[list[float]] = []
    while len(pairs) < seams:
        left, right = (str(key) for key in rng.choice(sorted(clips), size=2, replace=False))
        frames, others = clips[left].frames, clips[right].frames
        if frames <= longest + 2 * reach or others <= longest + reach:
            continue
        own, pair, end = prices(left, right), [], []
        start, into = int(rng.integers(reach, frames - longest - reach)), int(rng.integers(others - longest - reach))
        for apart in APART:
            pieces = [("a", 0, start), ("b", into, into + apart), ("a", start + apart, frames)]
            both = own.price(start, into) + own.price(start + apart, into + apart)
            pair.append(exact_price(own, pieces) / both - 1)
            end.append(exact_price(own, [("a", 0, apart), ("b", into, others)]) / own.price(apart, into) - 1)
        pairs.append(pair)
        ends.append(end)
    return np.array(pairs), np.array(ends)


def order_row(name: str, clips: Mapping[str, Motion], *, seams: int, seed: int) -> str:
    """How often the exact order names another cut first, with a visible reach left and with all places free."""
    rng = np.random.default_rng(seed)
    changed, off = np.zeros((seams, 2)), np.zeros((seams, 2))
    for seam in range(seams):
        left, right = (clips[str(key)] for key in rng.choice(sorted(clips), size=2, replace=False))
        prices = price_map(left, right)
        windows = ((None, None), ((1, prices.a.frames), (0, prices.b.frames - 1)))
        for column, (outs, intos) in enumerate(windows):
            by_map, exact = (best_cuts(prices, LISTED, exact=way, outs=outs, intos=intos)[0] for way in (False, True))
            changed[seam, column] = (by_map.out, by_map.into) != (exact.out, exact.into)
            off[seam, column] = 100 * abs(by_map.difference)
    cells = [name, str(seams), *(f"{100 * share:.0f}" for share in changed.mean(axis=0))]
    cells += [f"{np.median(values):.1f} / {values.max():.1f}" for values in off.T]
    return "| " + " | ".join(cells) + " |"


def snap_row(name: str, clips: Mapping[str, Motion], *, seams: int, seed: int) -> str:
    """Prices of random replacements before and after snapping, free and at constant length."""
    rng = np.random.default_rng(seed)
    free: list[Snapped] = []
    kept: list[Snapped] = []
    longer = []
    for _ in range(seams):
        line = random_replacement(dict(clips), rng, Seam())
        free.append(snap(line, clips, SNAP))
        kept.append(snap(line, clips, SNAP, keep_length=True))
        longer.append(abs(free[-1].timeline.frames - line.frames))
    before, after, same = (
        np.median([getattr(one, key) for one in found])
        for found, key in ((free, "before"), (free, "after"), (kept, "after"))
    )
    off = 100 * np.abs([one.difference for one in free])
    cells = [f"{before:.1f}", f"{after:.1f}", f"{np.mean(longer):.1f}", f"{same:.1f}"]
    return "| " + " | ".join([name, *cells, f"{np.median(off):.1f} / {off.max():.1f}"]) + " |"


def separable_rows(name: str, clips: Mapping[str, Motion], *, seams: int, seed: int) -> list[str]:
    """Table rows of :func:`separable_errors`."""
    found = separable_errors(clips, seams=seams, seed=seed)
    rows = []
    for where, errors in zip(("two seams", "a clip's start"), found, strict=True):
        cells = [f"{np.median(v):.1f} / {np.percentile(v, 95):.1f} / {v.max():.1f}" for v in 100 * np.abs(errors).T]
        rows.append("| " + " | ".join([name, where, *cells]) + " |")
    return rows


def as_markdown(sets: Mapping[str, Mapping[str, Motion]], *, seams: int, seed: int) -> str:
    """The document."""
    out = [_INTRODUCTION.format(seams=seams, seed=seed, smoothing=DEFAULT_SMOOTHING).rstrip("\n")]
    for where, seconds in (("anywhere", None), (f"within {SNAP:g} s", SNAP)):
        out += [_FEET.format(where=where, default=CONTACT).rstrip("\n"), *table_head(_FEET_HEAD)]
        for name, clips in sets.items():
            out += feet_rows(name, compare_dearness(clips, seams=seams, seconds=seconds, seed=seed))
    rates = {next(iter(clips.values())).fps for clips in sets.values()}
    reach = " or ".join(f"{visible_reach(Seam().lambda_at(fps))} ({fps:g} fps)" for fps in sorted(rates))
    out += [_SEPARABLE.format(reach=reach).rstrip("\n")]
    out += table_head(("data set", "where", *(f"{apart} frames" for apart in APART)))
    for name, clips in sets.items():
        out += separable_rows(name, clips, seams=seams, seed=seed)
    out += [_ORDER.format(count=LISTED, longer=LISTED * SHORT_LIST).rstrip("\n"), *table_head(_ORDER_HEAD)]
    out += [order_row(name, clips, seams=max(1, seams // 4), seed=seed) for name, clips in sets.items()]
    out += [_SNAPPED.format(seconds=SNAP).rstrip("\n"), *table_head(_SNAPPED_HEAD)]
    out += [snap_row(name, clips, seams=seams, seed=seed) for name, clips in sets.items()]
    return "\n".join(out) + "\n"


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure every data set of a folder and write the document."""
    chosen = table_options(__doc__).parse_args(arguments)
    sets = {name: read_clips(chosen.folder / name) for name in DATA_SETS}
    write_page(chosen.output, as_markdown(sets, seams=chosen.seams, seed=chosen.seed))


if __name__ == "__main__":
    main()
