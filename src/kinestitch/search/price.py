"""The price of every seam between two clips at once, and the best places to cut.

Words: a *price* is E* in rad², unweighted, of rotations; a *cost* is what a search minimises, the same with weighted
joints and with the hips' height and velocity.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from kinestitch.core.motion import Motion
from kinestitch.core.resample import resample
from kinestitch.core.rotation import Array
from kinestitch.core.skeleton import Skeleton
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline
from kinestitch.errors import ParameterError, RangeError
from kinestitch.rig.fit import fit_motion
from kinestitch.search.features import ROOT_COLUMNS, column_scales, joint_weights, place_features
from kinestitch.solve.energy import joint_price
from kinestitch.solve.placed import place_timeline
from kinestitch.solve.seam import visible_reach

Places = tuple[int, int]
"""First and last place of a window, both included."""

EVEN = "even"


@dataclass(frozen=True, eq=False, slots=True)
class PriceMap:
    """What every seam between two clips costs, each as if it were alone and far from any end; by :func:`price_map`.

    costs : (F_a + 1, F_b + 1), entry [i, j] the cost of a's frames up to i − 1 followed by b's from j on
    first, second : features of both clips' places (Eq. 18)
    a, b : the motions, b on a's skeleton and at a's rate; frames of b count at that rate
    stiffness : λ; weighted : whether costs are more than prices
    """

    costs: Array
    first: Array
    second: Array
    a: Motion
    b: Motion
    stiffness: float
    weighted: bool

    def price(self, out: int, into: int) -> float:
        """The separable price E* in rad² of one seam (Eq. 18)."""
        gap = (self.first[out] - self.second[into])[:-ROOT_COLUMNS]
        return float(gap @ gap)

    @property
    def apart(self) -> int:
        """Frames by which two of its minima differ at least: the visible reach of a seam (Eq. 9)."""
        return visible_reach(self.stiffness)


@dataclass(frozen=True, slots=True)
class Cut:
    """A cut: one clip's frames up to ``out`` − 1, the other's from ``into`` on.

    cost : what the search minimised; separable : E* in rad² as if far from any end, charted over both clips
    price : E* in rad² exactly, as it will be solved
    """

    out: int
    into: int
    cost: float
    separable: float
    price: float

    @property
    def difference(self) -> float:
        """By which share the exact price differs from the separable one."""
        return self.price / self.separable - 1.0 if self.separable > 0 else 0.0


def price_map(
    a: Motion,
    b: Motion,
    *,
    stiffness: float | None = None,
    smoothing: float | None = None,
    weights: ArrayLike | str | None = None,
) -> PriceMap:
    """The costs of all pairs (place of a, place of b) in one matrix product.

    b : fitted to a's rig and rate where it has another; stiffness, smoothing : λ or τ in s; neither is the default
    weights : (J,) ≥ 0 for a's joints; :func:`joint_weights` when left out; ``"even"`` for plain prices

    Raises SkeletonMismatchError, ParameterError.
    """
    stiff = Seam(stiffness, smoothing).lambda_at(a.fps)
    b = resample(fit_motion(b, a, b.name or "b"), a.fps)
    first, second = place_features([a, b], stiff)
    chosen = check_weights(a.skeleton, weights)
    costs = squared_distances(*(f * column_scales(a.skeleton, chosen) for f in (first, second)))
    return PriceMap(costs, first, second, a, b, stiff, chosen is not None)


def check_weights(skeleton: Skeleton, weights: ArrayLike | str | None) -> Array | None:
    """Weights (J,) of a search, None for even ones; raises ParameterError for a wrong number or negative ones."""
    if weights is None:
        return joint_weights(skeleton)
    if isinstance(weights, str):
        if weights == EVEN:
            return None
        raise ParameterError(f"Expected a weight for each joint or 'even', got {weights!r}.")
    values = np.asarray(weights, dtype=np.float64)
    if values.shape != (skeleton.joint_count,) or not (np.isfinite(values).all() and (values >= 0).all()):
        raise ParameterError(f"Expected {skeleton.joint_count} weights ≥ 0, one for each joint, got {values.size}.")
    return values


def squared_distances(p: Array, q: Array) -> Array:
    """Squared distances (N, M) of all pairs of rows of `p` (N, C) and `q` (M, C), in one matrix product."""
    middle = (p.mean(axis=0) + q.mean(axis=0)) / 2
    p, q = p - middle, q - middle
    out = p @ (-2.0 * q.T)
    out += np.einsum("ic,ic->i", p, p)[:, None]
    out += np.einsum("jc,jc->j", q, q)
    return np.maximum(out, 0.0, out=out)


def check_window(places: Places | None, first: int, last: int, name: str) -> Places:
    """A window of places within first … last, all of it when left out; raises RangeError."""
    if places is None:
        places = (first, last)
    low, high = places
    if not first <= low <= high <= last:
        raise RangeError(f"Expected places of {name} from {first} to {last}, got {low} to {high}.")
    return low, high


def best_cuts(
    prices: PriceMap,
    count: int = 1,
    *,
    outs: Places | None = None,
    intos: Places | None = None,
    apart: int | None = None,
) -> tuple[Cut, ...]:
    """The cheapest cuts, cheapest first, each a local minimum and well apart from those before it.

    outs, intos : first and last place where a may end and where b may begin; anywhere when left out
    apart : frames by which two of them differ in ``out`` or ``into`` at least; ``prices.apart`` when left out

    There may be fewer than `count`. Raises RangeError for windows outside the clips.
    """
    low, high = check_window(outs, 1, prices.a.frames, "the first clip")
    left, right = check_window(intos, 0, prices.b.frames - 1, "the second clip")
    costs = prices.costs[low : high + 1, left : right + 1]
    rows, columns = np.nonzero(_minima(costs))
    found: list[tuple[int, int]] = []
    distance = prices.apart if apart is None else apart
    for entry in np.argsort(costs[rows, columns], kind="stable"):
        place = (int(rows[entry]), int(columns[entry]))
        if all(max(abs(place[0] - i), abs(place[1] - j)) >= distance for i, j in found):
            found.append(place)
        if len(found) >= count:
            break
    return tuple(_priced(prices, low + i, left + j) for i, j in found[:count])


def best_cut(
    a: Motion,
    b: Motion,
    *,
    outs: Places | None = None,
    intos: Places | None = None,
    stiffness: float | None = None,
    smoothing: float | None = None,
    weights: ArrayLike | str | None = None,
) -> Cut:
    """The cheapest way from one clip into another; parameters as for :func:`price_map` and :func:`best_cuts`.

    >>> from kinestitch.samples import sample
    >>> walk = sample("walk", fps=30.0)
    >>> cut = best_cut(walk, walk, outs=(40, 60), intos=(10, 90))
    >>> cut.out == cut.into  # nothing is cheaper than going on
    True
    """
    prices = price_map(a, b, stiffness=stiffness, smoothing=smoothing, weights=weights)
    return best_cuts(prices, outs=outs, intos=intos)[0]


def _minima(costs: Array) -> np.ndarray:
    """Where no neighbour, diagonal ones included, costs less."""
    padded = np.pad(costs, 1, constant_values=np.inf)
    rows = np.minimum(np.minimum(padded[:-2], padded[1:-1]), padded[2:])
    return np.asarray(costs <= np.minimum(np.minimum(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:]))


def _priced(prices: PriceMap, out: int, into: int) -> Cut:
    pieces = [("a", 0, out), ("b", into, prices.b.frames)]
    exact = exact_price(prices, pieces)
    return Cut(out, into, float(prices.costs[out, into]), prices.price(out, into), exact)


def exact_price(prices: PriceMap, pieces: Sequence[tuple[str, int, int]]) -> float:
    """E* in rad² of pieces ("a" or "b", start, stop) joined one after the other: all their seams together (Eq. 17)."""
    clips = {"a": prices.a, "b": prices.b}
    infos = tuple(ClipInfo(key, motion.frames, motion.fps) for key, motion in clips.items())
    segments = tuple(Segment(key, FrameRange(start, stop)) for key, start, stop in pieces)
    seams = (Seam(prices.stiffness),) * (len(segments) - 1)
    return joint_price(place_timeline(Timeline(infos, segments, seams, prices.a.fps), clips))
