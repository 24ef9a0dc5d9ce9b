"""The document of the study of automatic stiffness: the verdict, the trade-off, and both defaults side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.edit.timeline import DEFAULT_SMOOTHING
from kinestitch.experiments.trade_off import Curve
from kinestitch.solve.adaptive import Share

FIXED, AUTO, CLIPS = "fixed", "auto, by parts", "auto, whole clips"
BOTH = "both"
WORST = 95.0
AIMS = (("added", 0.25), ("velocity", 1.0))


class Study(Protocol):
    """What is shown of a study."""

    @property
    def name(self) -> str: ...
    @property
    def kind(self) -> str: ...
    @property
    def curves(self) -> Mapping[str, Curve]: ...


def pooled(studies: Sequence[Study]) -> dict[str, Curve]:
    """The curves of several data sets as if they were one."""
    first = studies[0].curves
    return {
        rule: Curve(
            rule,
            curve.setting,
            curve.settings,
            {m: np.concatenate([s.curves[rule].values[m] for s in studies], axis=1) for m in curve.values},
        )
        for rule, curve in first.items()
    }


def fixed_deviation(curves: Mapping[str, Curve], measure: str, worst: float) -> float:
    """Mean deviation in degrees of the best fixed smoothing time whose 95th percentile of a measure is `worst`.

    Between two of the settings the curve is followed on logarithms. NaN where no setting adds so little, or so much.
    """
    added = curves[FIXED].percentile(measure, WORST)
    deviation = curves[FIXED].values["deviation"].mean(axis=1)
    crossed = np.flatnonzero((added[:-1] >= worst) & (worst >= added[1:]))
    if len(crossed) == 0:
        return float("nan")
    k = crossed[0]
    at = [np.log(worst), *np.log(added[k : k + 2])]
    share = (at[1] - at[0]) / (at[1] - at[2]) if at[1] > at[2] else 0.0
    return float(np.exp((1 - share) * np.log(deviation[k]) + share * np.log(deviation[k + 1])))


def verdict(curves: Mapping[str, Curve], rule: str, measure: str = "added") -> list[tuple[float, float, float, float]]:
    """For each setting of a rule: the setting, the 95th percentile of a measure, the mean deviation, and that of the
    best fixed smoothing time at the same 95th percentile.
    """
    curve = curves[rule]
    return [
        (setting, worst, mean, fixed_deviation(curves, measure, worst))
        for setting, worst, mean in zip(
            curve.settings, curve.percentile(measure, WORST), curve.values["deviation"].mean(axis=1), strict=True
        )
    ]


_INTRODUCTION = """# Automatic stiffness on real seams

Made by `python -m kinestitch.experiments.adaptive`; no figure on this page is typed in. {seams} random seams of each
data set (seed {seed}), once where they were drawn and once snapped. What is added is measured on the group, over the
95th percentile of what the sources' strongest joint does within a second of the seam
([why so](decisions/0005-what-counts-as-added.md)); the deviation is the mean over all joints and frames within that
second.

- **fixed**: one smoothing time for all seams.
- **auto, whole body**: per seam the smallest λ that keeps three bounds: a share of the sources' acceleration, all of
  their velocity, and all of the acceleration of their path.
- **auto, by parts**: the same for trunk, arms and legs, each by itself. This is what `--auto` does, with a share of
  {share:g}.
- **auto, acceleration alone**: by parts, without the bounds on velocity and path.
- **auto, whole clips**: by parts, with the sources' strength taken over the whole clips.
"""


def as_markdown(kinds: Sequence[Sequence[Study]], seams: int, seed: int) -> str:
    """The document. kinds : for each way of cutting the studies of all data sets"""
    out = [_INTRODUCTION.format(seams=seams, seed=seed, share=Share().acceleration)]
    for studies in kinds:
        together = pooled(studies)
        out += [f"## Cuts {studies[0].kind}", "", _sentence(together), ""]
        sets = {**{s.name: s.curves for s in studies}, BOTH: together}
        out += [*_verdicts(sets), "", *_defaults(sets), "", *_fixed_rows(sets), ""]
    out += ["## Near the seam or over the whole clips", "", _norms([pooled(studies) for studies in kinds])]
    return "\n".join(out).rstrip("\n") + "\n"


def _sentence(curves: Mapping[str, Curve]) -> str:
    ratios = [mean / fixed for _, _, mean, fixed in verdict(curves, AUTO) if np.isfinite(fixed)]
    count = curves[FIXED].values["added"].shape[1]
    if ratios and max(ratios) < 1:
        told = "**deviates less than the best fixed λ** at every share"
    else:
        told = "does **not** deviate less than the best fixed λ at every share"
    return (
        f"At the same 95th percentile of added acceleration `--auto` {told}: {min(ratios, default=np.nan):.0%} to "
        f"{max(ratios, default=np.nan):.0%} of its mean deviation, over all {count} seams."
    )


def _verdicts(sets: Mapping[str, Mapping[str, Curve]]) -> list[str]:
    out = [
        "| seams | rule | share | added, 95th percentile | mean deviation (°) | best fixed λ there (°) | of it |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, curves in sets.items():
        for rule in [rule for rule in curves if rule not in (FIXED, CLIPS)] if name == BOTH else [AUTO]:
            for share, worst, mean, fixed in verdict(curves, rule):
                cells = (f"{share:.3g}", f"{worst:.3f}", f"{mean:.2f}", f"{fixed:.2f}", f"{mean / fixed:.0%}")
                out.append(f"| {name} | {rule} | {' | '.join(cells)} |")
    return out


def _defaults(sets: Mapping[str, Mapping[str, Curve]]) -> list[str]:
    """The default smoothing time beside the default share, all measures."""
    measures = [m for m in next(iter(sets.values()))[FIXED].values if m != "added_clip"]
    titles = [_TITLES[m] for m in measures]
    out = [
        f"Both defaults, τ = {DEFAULT_SMOOTHING:g} s and a share of {Share().acceleration:g}; median / 95th "
        "percentile, mean in brackets. *Within* is the share of seams that add at most "
        f"{AIMS[0][1]:g} of their sources' acceleration and {AIMS[1][1]:g} of their angular velocity.",
        "",
        f"| seams | rule | {' | '.join(titles)} | within |",
        "|---" * (len(measures) + 3) + "|",
    ]
    for name, curves in sets.items():
        for rule, setting in ((FIXED, DEFAULT_SMOOTHING), ("auto, whole body", None), (AUTO, None)):
            curve = curves[rule]
            row = curve.settings.index(Share().acceleration if setting is None else setting)
            values = [curve.values[m][row] for m in measures]
            within = [f"{(curve.values[m][row] <= aim).mean():.0%}" for m, aim in AIMS]
            out.append(f"| {name} | {rule} | {' | '.join(map(_cell, values))} | {', '.join(within)} |")
    return out


_TITLES = {
    "added": "added acceleration",
    "velocity": "added velocity",
    "path": "added acceleration of the path",
    "deviation": "deviation (°)",
    "kept": "dynamics kept",
    "slide": "slide in contact (m/s)",
    "smoothing": "longest smoothing time (s)",
}


def _cell(values: Array) -> str:
    return f"{np.median(values):.3g} / {np.percentile(values, WORST):.3g} ({values.mean():.3g})"


def _fixed_rows(sets: Mapping[str, Mapping[str, Curve]]) -> list[str]:
    names = list(sets)
    out = [
        "The fixed rule: 95th percentile of added acceleration, and mean deviation in degrees.",
        "",
        f"| τ (s) | {' | '.join(names)} |",
        "|---" * (len(names) + 1) + "|",
    ]
    for row, setting in enumerate(next(iter(sets.values()))[FIXED].settings):
        cells = []
        for curves in sets.values():
            curve = curves[FIXED]
            worst, mean = curve.percentile("added", WORST)[row], curve.values["deviation"][row].mean()
            cells.append(f"{worst:.3f}, {mean:.2f}")
        out.append(f"| {setting:g} | {' | '.join(cells)} |")
    return out


def _norms(kinds: Sequence[Mapping[str, Curve]]) -> str:
    """Both ways to take the sources' strength, each judged by both."""
    out = [
        "What counts as the sources' own strength, and by which of the two it is judged: mean deviation over that of "
        "the best fixed λ at the same 95th percentile, all seams.",
        "",
        "| cuts | strength taken | share | judged near the seam | judged over whole clips |",
        "|---|---|---|---|---|",
    ]
    for kind, curves in zip(("as drawn", "snapped"), kinds, strict=False):
        for rule, what in ((AUTO, "near the seam"), (CLIPS, "over whole clips")):
            near, clips = (verdict(curves, rule, measure) for measure in ("added", "added_clip"))
            for a, b in zip(near, clips, strict=True):
                if a[0] not in curves[CLIPS].settings:
                    continue
                out.append(f"| {kind} | {what} | {a[0]:.3g} | {a[2] / a[3]:.0%} | {b[2] / b[3]:.0%} |")
    return "\n".join(out)
