"""Experiment 2: the solve beside Blender's own blending of animations, on the same cuts; punches among them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.edit.timeline import DEFAULT_SMOOTHING, Seam
from kinestitch.experiments.blender_measures import (
    BLENDER,
    DEFAULT,
    Agreement,
    Struck,
    agreement,
    curves,
    struck,
    ways_with,
    widths_at,
)
from kinestitch.experiments.blender_nla import MODES, Blended, Mode, NoBlenderError, blend
from kinestitch.experiments.dataset import DataSet
from kinestitch.experiments.page import Finding, Picture, Section, Table, picture, rows_of
from kinestitch.experiments.punches import punches, strike_drawn
from kinestitch.experiments.same_deviation import Versus, needed_setting, spread, versus
from kinestitch.experiments.seams import random_cut
from kinestitch.experiments.trade_off import MEASURES, Curve, TradeOff, near_seam
from kinestitch.render.curves import Line, Panel, draw_panels
from kinestitch.solve.placed import Placed, place_timeline

TITLE = "Against Blender's interpolation"
INTERVAL = "There is no blend interval to tune."
FEATURES = "Features of the motion are kept where crossfades average them away."
LIMIT = 1.0
"""Added acceleration at which a seam adds no more than the sources' own strongest movements."""

_FEW = 10  # cuts on which Blender's other modes are looked at
_MODES = {
    "matched": "Replace, upper strip blends in, signs matched",
    "keyed": "the same, signs as keyed",
    "fade": "Replace, both strips fade",
    "combine": "Combine, both strips fade",
}


def run(data: DataSet, *, cuts: int = 40, seed: int = 0) -> Section:
    """Punches into punches and `cuts` random cuts, by Blender and by every method; a note where there is no Blender."""
    rng = np.random.default_rng(seed)
    found = punches(data)
    lines = [p.cut for p in found] + [near_seam(random_cut(dict(data.clips), rng, Seam())) for _ in range(cuts)]
    placed = [place_timeline(line, data.clips) for line in lines]
    fps = lines[0].fps
    widths = widths_at(fps)
    wanted: dict[Mode, Sequence[Placed]] = {mode: placed if mode == "matched" else placed[:_FEW] for mode in MODES}
    try:
        blended = blend(wanted, widths)
    except NoBlenderError as error:
        return missing(str(error))
    agreed = [row for mode, some in wanted.items() for row in agreement(some, blended, widths, [mode])]
    every = curves(lines, data.clips, ways_with(blended, fps, widths))
    ours = every.pop(DEFAULT)
    trade = TradeOff(data.name, len(lines), fps, tuple(every.values()))
    return section(data, trade, ours, agreed, struck(found, data, blended, widths), blended)


def missing(why: str) -> Section:
    """The section where Blender cannot be asked."""
    claims = ("Blender's blend of two strips is a crossfade.", INTERVAL, FEATURES)
    return Section(
        TITLE,
        "Missing: everything that needs Blender itself. The other methods stand in the quality table.",
        tuple(Finding(claim, "missing", why) for claim in claims),
    )


def section(
    data: DataSet,
    trade: TradeOff,
    ours: Curve,
    agreed: Sequence[Agreement],
    punched: Sequence[Struck],
    blended: Blended,
) -> Section:
    """What was measured, told; `ours` is the solve at its default, on the seams of `trade`."""
    rivals = [curve for curve in trade.curves if curve.name != "laplacian"]
    compared = [versus(ours, rival, measure) for rival in rivals for measure in MEASURES if measure != "deviation"]
    struck_cuts = len({row.punch.name for row in punched})
    text = (
        f"Two strips of Blender {blended.version} over each other, evaluated by Blender; the overlap is centred on the "
        f"seam. {trade.seams} cuts of {data.name}, {struck_cuts} of them from one punch into "
        f"another. Ours at its default is τ = {DEFAULT_SMOOTHING:g} s, untouched; a rival at the same deviation is "
        "tuned for each seam by itself to change the sources as much as ours does there."
    )
    interval, numbers = no_interval(trade, ours, compared)
    kept, more = features(compared, punched)
    return Section(
        TITLE,
        text,
        (same_thing(agreed, blended), interval, kept, where_rivals_win(compared)),
        (_curves_drawn(trade, data), *([strike_drawn(data, blended)] if punched else [])),
        (_agreement_table(agreed), _trade_table(trade, ours), _versus_table(compared), _punch_table(punched)),
        numbers=_agreement_numbers(agreed) | numbers | more,
    )


def same_thing(agreed: Sequence[Agreement], blended: Blended) -> Finding:
    """What Blender does with two strips, by measured distance."""
    matched = [row for row in agreed if row.mode == "matched"]
    most = max(matched, key=lambda row: row.largest)
    far = {mode: max(row.largest for row in agreed if row.mode == mode) for mode in _MODES}
    return Finding(
        "Blender's blend of two strips is a crossfade.",
        "measured",
        "where the upper strip alone blends in, Blender interpolates the quaternions' components: normalised, that is "
        f"its result within {max(row.lerp for row in matched):.1g}°. From our slerp crossfade it is up to "
        f"{most.largest:.2g}° away (where the way between the sources is {most.way:.0f}° and the weight "
        f"{most.share:.2f}), {max(row.mean for row in matched):.2g}° in the mean. It takes the signs as they are: "
        f"{sum(blended.turned.values())} joint-seams had opposite ones as keyed, and as keyed it is up to "
        f"{far['keyed']:.3g}° off ({_FEW} cuts). Its automatic blending gives {blended.auto[0]:.0%} of the overlap to "
        f"the lower strip's fade out and {blended.auto[1]:.0%} to the upper one's fade in; with both, the result is "
        f"drawn to the rest pose and up to {far['fade']:.0f}° off; in Combine up to {far['combine']:.0f}°",
    )


def no_interval(trade: TradeOff, ours: Curve, compared: Sequence[Versus]) -> tuple[Finding, dict[str, object]]:
    """Ours untouched against Blender tuned for each seam; and how far settings must differ to add little."""
    added = _of(compared, BLENDER, "added")
    blender, solve = trade.curve(BLENDER), trade.curve("laplacian")
    apart = {c.name: spread(needed_setting(c, "added", LIMIT)) for c in (solve, blender)}
    nearest = int(np.abs(blender.percentile("deviation") - ours.percentile("deviation")[0]).argmin())
    calm = float((ours.values["added"][0] <= LIMIT).mean()), float((blender.values["added"][nearest] <= LIMIT).mean())
    untuned = added.better >= 0.9
    limits = added.better >= 0.5
    free = apart["laplacian"] <= 1.5
    finding = Finding(
        INTERVAL,
        "reproduced" if untuned and free else "reproduced with limits" if limits else "not reproduced",
        f"untouched, ours adds less acceleration than Blender tuned for each seam to the same deviation on "
        f"{added.better:.0%} of {added.seams} seams (medians {added.ours:.2f} and {added.theirs:.2f} of the "
        f"sources' own "
        f"95th percentile). But λ takes the interval's place: to add no more than {LIMIT:g}, the smoothing time has to "
        f"vary by a factor of {apart['laplacian']:.1f} between seams (10th to 90th percentile), Blender's width by "
        f"{apart[BLENDER]:.1f} (what never comes down counts as the widest); {calm[0]:.0%} of the seams stay below at "
        f"the default, {calm[1]:.0%} with Blender's {blender.settings[nearest] * trade.fps:.0f} frames",
    )
    return finding, {
        "blender_added_ours_better_share": round(added.better, 3),
        "blender_added_over_ours": round(added.theirs / added.ours, 3),
        "setting_spread": {name: round(value, 2) for name, value in apart.items()},
    }


def features(compared: Sequence[Versus], punched: Sequence[Struck]) -> tuple[Finding, dict[str, object]]:
    """Dynamics that survive at the same deviation, and what is left of a strike."""
    survived = _of(compared, BLENDER, "survived")
    fades = [survived, *(_of(compared, name, "survived") for name in ("crossfade", "crossfade, eased"))]
    least = min(row.better for row in fades)
    finding = Finding(
        FEATURES,
        "reproduced" if least >= 0.9 else "reproduced with limits" if least >= 0.5 else "not reproduced",
        f"of the sources' angular acceleration {survived.ours:.1%} survives, {survived.theirs:.1%} with Blender tuned "
        f"to the same deviation; more with ours on {survived.better:.0%} of {survived.seams} seams, and on at least "
        f"{least:.0%} of them beside each of our own crossfades. {_strikes(punched)}",
    )
    return finding, {
        "dynamics_survived": {"ours": round(survived.ours, 4), "blender": round(survived.theirs, 4)},
        "survived_ours_better_share": round(survived.better, 3),
    }


def _strikes(punched: Sequence[Struck]) -> str:
    if not punched:
        return "No punches among these clips"
    ways = dict.fromkeys(row.way for row in punched)
    kept = {way: [row.strike for row in punched if row.way == way] for way in ways}
    return "Speed of a strike kept: " + "; ".join(f"{way}: {min(v):.0%} to {max(v):.0%}" for way, v in kept.items())


def where_rivals_win(compared: Sequence[Versus]) -> Finding:
    """Every measure on which a rival's median is the better one at the same deviation."""
    lost = [row for row in compared if row.loses]
    told = [
        f"{row.rival}: {row.measure} {row.theirs:.4g} against {row.ours:.4g} (ours better on {row.better:.0%} of the "
        "seams)"
        for row in lost
    ]
    return Finding(
        "At the same deviation no rival is better on any measure.",
        "not reproduced" if lost else "measured",
        "; ".join(told) + f" (medians, {len(lost)} of {len(compared)} comparisons)" if lost else
        f"ours is at least as good in all {len(compared)} comparisons of medians",
    )  # fmt: skip


def _of(compared: Sequence[Versus], rival: str, measure: str) -> Versus:
    return next(row for row in compared if (row.rival, row.measure) == (rival, measure))


def _curves_drawn(trade: TradeOff, data: DataSet) -> Picture:
    names = ("laplacian", BLENDER, *(c.name for c in trade.curves if c.name not in {"laplacian", BLENDER}))
    order = [trade.curve(name) for name in names]
    x: dict[str, Array] = {curve.name: curve.percentile("deviation") for curve in order}
    drawn = [
        Panel(
            tuple(Line(c.name, x[c.name], c.percentile(name), c.percentile(name, high)) for c in order),
            MEASURES["deviation"],
            label,
            y_log=name == "added",
        )
        for name, high, label in (
            ("added", 95.0, "added acceleration / sources' 95th percentile"),
            ("survived", 5.0, "share of the sources' dynamics that survives"),
        )
    ]
    caption = f"{trade.seams} cuts of {trade.name}, every method over its range: median, and the worse 5 % dotted."
    return picture(draw_panels(drawn), caption, own=not data.real)


def _agreement_table(agreed: Sequence[Agreement]) -> Table:
    rows = [(_MODES[r.mode], r.width, r.mean, r.largest, r.way, r.share, r.eased, r.lerp) for r in agreed]
    head = ("Blender", "frames", "mean °", "largest °", "way there °", "weight there", "from eased °", "from lerp °")
    caption = (
        "Blender's rotations against our linear crossfade of the same width, with the way between the sources and the "
        "weight where they differ most; the largest distance from the eased one, and from components interpolated."
    )
    return Table(caption, head, rows_of(rows))


def _trade_table(trade: TradeOff, ours: Curve) -> Table:
    rows: list[tuple[object, ...]] = []
    for curve in (ours, *(c for c in trade.curves if c.name in {"laplacian", BLENDER, "crossfade"})):
        medians = [curve.percentile(measure) for measure in MEASURES]
        for column, setting in enumerate(curve.settings):
            rows.append((curve.name, float(setting), *(float(m[column]) for m in medians)))
    caption = "Medians: " + "; ".join(f"{name}: {meaning}" for name, meaning in MEASURES.items()) + "."
    return Table(caption, ("method", "setting s", *MEASURES), rows_of(rows))


def _versus_table(compared: Sequence[Versus]) -> Table:
    rows = [(r.rival, r.measure, r.ours, r.theirs, f"{r.better:.0%}", r.seams) for r in compared]
    head = ("rival", "measure", "ours", "rival's", "ours better on", "seams")
    return Table("Ours at its default, rivals tuned to the same deviation on each seam; medians.", head, rows_of(rows))


def _punch_table(punched: Sequence[Struck]) -> Table:
    rows = [
        (s.punch.name, "{:.1f} → {:.1f}".format(*s.punch.speeds), s.way, s.strike, s.added, s.deviation, s.survived)
        for s in punched
    ]
    head = ("punches", "peak speeds m/s", "way", "strike kept", "added", "deviation °", "survived")
    return Table("From one punch into another, a quarter of a second before it strikes.", head, rows_of(rows))


def _agreement_numbers(agreed: Sequence[Agreement]) -> dict[str, object]:
    largest = {
        mode: round(max(row.largest for row in agreed if row.mode == mode), 3)
        for mode in dict.fromkeys(row.mode for row in agreed)
    }
    lerp = max(row.lerp for row in agreed if row.mode == "matched")
    return {"blender_from_crossfade_deg": largest, "blender_from_component_lerp_deg": float(f"{lerp:.2g}")}
