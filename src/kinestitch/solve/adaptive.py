"""As much time for every seam as it needs and no more: λ chosen so that what a seam adds stays under a share of what
its sources do anyway.

The smallest λ that keeps all bounds is found on closed forms alone (:mod:`kinestitch.solve.added`), for every part of
the body by itself: an arm that hangs still at a cut need not wait for the legs (Eq. 29).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from functools import cache

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.edit.timeline import DEFAULT_SMOOTHING
from kinestitch.errors import ParameterError
from kinestitch.rig.groups import BODY, joint_groups
from kinestitch.solve.added import added_to_path, added_turning, seam_gap
from kinestitch.solve.placed import JointGroup, Placed
from kinestitch.solve.seam import VISIBLE, SeamPlace
from kinestitch.solve.sources import Strength, own_strength

LEAST, MOST = 0.03, 0.6
"""Smoothing times in s between which an automatic seam stays."""

UNSEEN = Strength(1.0, 0.1, 0.3)
"""rad/s², rad/s, m/s²: sources that move less count as if they moved so much, or two still poses could never meet."""

NEAREST = 1.1
"""A bound that no λ keeps is replaced by this many times the least that any λ comes to."""

_MARGIN = 5e-4  # of a bound, that peaks between two steps may lie above a power law
_STEP, _WIDE = 1.05, 5  # from one smoothing time that may be tried to the next, and how many at first are passed over


@dataclass(frozen=True, slots=True)
class Share:
    """How much a seam may add, over the 95th percentile of what its sources do within a second of it.

    acceleration, velocity : of any joint's turning; path : of the acceleration of the joint that carries the travel

    Raises ParameterError unless all are above 0; infinity sets no bound.
    """

    acceleration: float = 0.125
    velocity: float = 1.0
    path: float = 1.0

    def __post_init__(self) -> None:
        for name in ("acceleration", "velocity", "path"):
            if not getattr(self, name) > 0:
                raise ParameterError(f"Expected a share of {name} above 0, got {getattr(self, name)}.")

    def of(self, own: Strength) -> Array:
        """The bounds (3,) on acceleration, velocity and path, rad/s², rad/s and m/s²."""
        shares = np.array([self.acceleration, self.velocity, self.path])
        return shares * np.maximum(astuple(own), astuple(UNSEEN))


def with_automatic(
    placed: Placed,
    share: Share | None = None,
    *,
    grouped: bool = True,
    strength: Callable[[Placed, SeamPlace], Strength] = own_strength,
) -> Placed:
    """The same with a λ for every automatic seam, which :func:`place_timeline` leaves at the default's (Eq. 29).

    share : the default's when left out; strength : what the sources show around a seam
    grouped : every part of the body takes its own λ (:func:`joint_groups`); the seam itself has the largest of them
    """
    automatic = [placed.timeline.seams[seam.index].automatic for seam in placed.seams]
    if not any(automatic):
        return placed
    everything = {BODY: tuple(range(placed.skeleton.joint_count))}
    groups = joint_groups(placed.skeleton) if grouped else everything
    rows = []
    for number, seam in enumerate(placed.seams):
        if automatic[number]:
            limits = (Share() if share is None else share).of(strength(placed, seam))
            rows.append(_chosen(placed, number, limits, groups))
        else:
            rows.append([seam.stiffness] * len(groups))
    table = np.array(rows)
    seams = tuple(replace(seam, stiffness=float(row.max())) for seam, row in zip(placed.seams, table, strict=True))
    parts = tuple(
        JointGroup(name, joints, tuple(map(float, column)))
        for (name, joints), column in zip(groups.items(), table.T, strict=True)
    )
    return replace(placed, seams=seams, groups=parts if len(parts) > 1 else ())


def widest(placed: Placed, number: int) -> float:
    """The longest smoothing time in s that the seam `number` of ``placed.seams`` may take: its visible reach (Eq. 9)
    ends half way to the next seams, unless the default's is longer than that.
    """
    places = [seam.frame for seam in placed.seams]
    apart = [abs(places[number] - places[other]) for other in (number - 1, number + 1) if 0 <= other < len(places)]
    room = min(apart, default=math.inf) / 2 / VISIBLE / placed.timeline.fps
    return min(MOST, max(DEFAULT_SMOOTHING, room))


def _chosen(placed: Placed, number: int, limits: Array, groups: Mapping[str, Sequence[int]]) -> list[float]:
    """λ of each group at one seam."""
    gap = seam_gap(placed, placed.seams[number])
    shortest, longest = LEAST * gap.fps, widest(placed, number) * gap.fps
    steps = math.ceil(math.log(longest / shortest) / math.log(_STEP))
    widths = [*(shortest * _STEP**step for step in range(steps)), longest]
    order = [joint for joints in groups.values() for joint in joints]
    first = np.cumsum([0, *(len(joints) for joints in groups.values())])[:-1]
    travels = np.array([placed.carrier in joints for joints in groups.values()])

    @cache
    def peaks(step: int) -> Array:
        """(3, G): what each group's strongest joint adds, and the path."""
        stiffness = widths[step] ** 4
        turning = (np.maximum.reduceat(values, first) for values in added_turning(gap, stiffness, order))
        return np.stack([*turning, added_to_path(gap, stiffness) * travels])

    def of(group: int) -> Callable[[int], Array]:
        return lambda step: peaks(step)[:, group]

    return [_least(of(group), widths, limits) ** 4 for group in range(len(groups))]


def _least(peaks: Callable[[int], Array], widths: Sequence[float], limits: Array) -> float:
    """The least λ^¼ in frames whose peaks keep all limits (Eq. 29).

    widths : rising; peaks : those (3,) at one of them, by its number

    Wide steps find where all limits are kept for the first time, narrow ones where in between; between two of those
    the peaks follow a power law. Where no width keeps all limits, the one that breaks them least.
    """

    def excess(step: int) -> float:
        return float((peaks(step) / limits).max()) * (1.0 + _MARGIN)

    tried = [*range(0, len(widths) - 1, _WIDE), len(widths) - 1]
    keeps = next((k for k, step in enumerate(tried) if excess(step) <= 1.0), None)
    if keeps is None:
        limits = np.maximum(limits, NEAREST * np.min([peaks(step) for step in tried], axis=0))
        keeps = next((k for k, step in enumerate(tried) if excess(step) <= 1.0), None)
    if keeps is None:
        return widths[min(tried, key=excess)]
    if keeps == 0:
        return widths[0]
    low, high = tried[keeps - 1], tried[keeps]
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if excess(middle) <= 1.0 else (middle, high)
    over, under = math.log(excess(low)), math.log(max(excess(high), 1e-12))
    return widths[low] * (widths[high] / widths[low]) ** (over / (over - under))
