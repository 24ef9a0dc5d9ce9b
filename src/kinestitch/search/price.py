"""The price of every seam between two clips at once, and the best places to cut.

Words: a *price* is E* in rad², unweighted, of rotations; a *cost* is what a search minimises, the same with weighted
joints, with the hips' height and velocity, and with the feet that stand.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

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
from kinestitch.search.standing import both_standing, standing_columns
from kinestitch.solve.contacts import Mask
from kinestitch.solve.energy import joint_shares, priced_joints
from kinestitch.solve.placed import place_timeline
from kinestitch.solve.seam import stiffness_at, visible_reach

Places = tuple[int, int]
"""First and last place of a window, both included."""

EVEN = "even"

SHORT_LIST = 4
"""So many times as many places as are asked for are priced exactly before the best of them are named."""


@dataclass(frozen=True, eq=False, slots=True)
class PriceMap:
    """What every seam between two clips costs, each as if it were alone and far from any end; by :func:`price_map`.

    costs : (F_a + 1, F_b + 1), entry [i, j] the cost of a's frames up to i − 1 followed by b's from j on
    first, second : features of both clips' places (Eq. 18)
    a, b : the motions, b on a's skeleton and at a's rate; frames of b count at that rate
    stiffness : λ; weights : (J,) of a's joints, None where costs are prices
    standing : (F_a, 2) and (F_b, 2), when the left and the right foot stand; None where that counts nothing
    """

    costs: Array
    first: Array
    second: Array
    a: Motion
    b: Motion
    stiffness: float
    weights: Array | None
    standing: tuple[Mask, Mask] | None

    def price(self, out: int, into: int) -> float:
        """The separable price E* in rad² of one seam (Eq. 18)."""
        return float(self._shares(out, into).sum())

    def price_in_cost(self, out: int, into: int) -> float:
        """What the separable price is in a cost: its joints weighted, in rad²."""
        return self.weighted_sum(self._shares(out, into))

    def weighted_sum(self, shares: Array) -> float:
        """Shares (P,) of a price, one for each joint from the hips down, summed up as they count in a cost."""
        joints = list(priced_joints(self.a.skeleton))
        return float(shares.sum() if self.weights is None else shares @ self.weights[joints])

    def _shares(self, out: int, into: int) -> Array:
        gap = (self.first[out] - self.second[into])[:-ROOT_COLUMNS]
        return np.asarray((gap * gap).reshape(-1, 6).sum(axis=1))

    @property
    def weighted(self) -> bool:
        """Whether costs are more than prices."""
        return self.weights is not None

    @property
    def apart(self) -> int:
        """Frames by which two of its minima differ at least: the visible reach of a seam (Eq. 9)."""
        return visible_reach(self.stiffness)

    def kept(self, frames: int) -> int:
        """How many of a clip's frames stay at least where nothing else is said: a visible reach, or half of them.

        With fewer, the solve drags all of them along and calls that cheap.
        """
        return max(1, min(self.apart, frames // 2))


@dataclass(frozen=True, slots=True)
class Cut:
    """A cut: one clip's frames up to ``out`` − 1, the other's from ``into`` on.

    cost : what the search minimised; separable : E* in rad² as if far from any end, charted over both clips
    price : E* in rad² exactly, as it will be solved; exact_cost : the cost with the exact price in the separable one's
    place
    """

    out: int
    into: int
    cost: float
    separable: float
    price: float
    exact_cost: float

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
    contacts: bool = True,
) -> PriceMap:
    """The costs of all pairs (place of a, place of b) in one matrix product.

    b : fitted to a's rig and rate where it has another; stiffness, smoothing : λ or τ in s; neither is the default
    weights : (J,) ≥ 0 for a's joints; :func:`joint_weights` when left out; ``"even"`` for plain prices
    contacts : whether cuts inside stances of the same foot cost less than others (Eq. 23); never in plain prices, nor
    where a clip's feet cannot be told or never stand

    Raises SkeletonMismatchError, ParameterError.
    """
    stiff = stiffness_at(Seam(stiffness, smoothing), a.fps)
    b = resample(fit_motion(b, a, b.name or "b"), a.fps)
    first, second = place_features([a, b], stiff)
    chosen = check_weights(a.skeleton, weights)
    scales = column_scales(a.skeleton, chosen)
    standing = both_standing(a, b) if contacts and chosen is not None else None
    rows = [first * scales, second * scales]
    if standing is not None:
        rows = [np.hstack(pair) for pair in zip(rows, standing_columns(*standing, stiff), strict=True)]
    return PriceMap(squared_distances(*rows), first, second, a, b, stiff, chosen, standing)


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


def check_window(places: Places, first: int, last: int, name: str) -> Places:
    """A window of places, which has to lie within first … last; raises RangeError."""
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
    exact: bool = False,
) -> tuple[Cut, ...]:
    """The cheapest cuts, cheapest first, each a local minimum within its windows and well apart from those before it.

    outs, intos : first and last place where a may end and where b may begin; left out, anywhere that leaves a visible
    reach of either clip, or half of it
    apart : frames by which two of them differ in ``out`` or ``into`` at least; ``prices.apart`` when left out
    exact : order by exact cost: the best of a list that is four times as long. Left out, by the map's own cost, so
    that the first one is the map's least entry

    There may be fewer than `count`. Raises RangeError for windows outside the clips.
    """
    frames, others = prices.a.frames, prices.b.frames
    low, high = check_window(outs or (prices.kept(frames), frames), 1, frames, "the first clip")
    left, right = check_window(intos or (0, others - prices.kept(others)), 0, others - 1, "the second clip")
    costs = prices.costs[low : high + 1, left : right + 1]
    distance = prices.apart if apart is None else apart
    found = minima_apart(costs, SHORT_LIST * count if exact else count, distance)
    cuts = [_priced(prices, low + i, left + j) for i, j in found]
    return tuple(by_exact_cost(cuts)[:count] if exact else cuts)


def best_cut(
    a: Motion,
    b: Motion,
    *,
    outs: Places | None = None,
    intos: Places | None = None,
    stiffness: float | None = None,
    smoothing: float | None = None,
    weights: ArrayLike | str | None = None,
    contacts: bool = True,
) -> Cut:
    """The cheapest way from one clip into another: the least entry of the map; parameters as for :func:`price_map` and
    :func:`best_cuts`.

    >>> from kinestitch.samples import sample
    >>> walk = sample("walk", fps=30.0)
    >>> cut = best_cut(walk, walk, outs=(40, 60), intos=(10, 90))
    >>> cut.out == cut.into  # nothing is cheaper than going on
    True
    """
    prices = price_map(a, b, stiffness=stiffness, smoothing=smoothing, weights=weights, contacts=contacts)
    return best_cuts(prices, outs=outs, intos=intos)[0]


class _Costed(Protocol):
    @property
    def exact_cost(self) -> float: ...


Found = TypeVar("Found", bound=_Costed)


def by_exact_cost(found: Sequence[Found]) -> list[Found]:
    """Cuts or replacements, those of least exact cost first."""
    return sorted(found, key=lambda one: one.exact_cost)


def minima_apart(costs: Array, count: int, distance: int) -> list[Places]:
    """The least local minima (row, column) of a map, least first, each `distance` rows or columns from those before."""
    rows, columns = np.nonzero(_minima(costs) & np.isfinite(costs))
    found: list[Places] = []
    for entry in np.argsort(costs[rows, columns], kind="stable"):
        if len(found) >= count:
            break
        place = (int(rows[entry]), int(columns[entry]))
        if all(max(abs(place[0] - i), abs(place[1] - j)) >= distance for i, j in found):
            found.append(place)
    return found


def _minima(costs: Array) -> np.ndarray:
    """Where no neighbour, diagonal ones included, costs less."""
    padded = np.pad(costs, 1, constant_values=np.inf)
    rows = np.minimum(np.minimum(padded[:-2], padded[1:-1]), padded[2:])
    return np.asarray(costs <= np.minimum(np.minimum(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:]))


def _priced(prices: PriceMap, out: int, into: int) -> Cut:
    cost = float(prices.costs[out, into])
    shares = exact_shares(prices, [("a", 0, out), ("b", into, prices.b.frames)])
    change = prices.weighted_sum(shares) - prices.price_in_cost(out, into)
    return Cut(out, into, cost, prices.price(out, into), float(shares.sum()), cost + change)


def exact_price(prices: PriceMap, pieces: Sequence[tuple[str, int, int]]) -> float:
    """E* in rad² of pieces ("a" or "b", start, stop) joined one after the other: all their seams together (Eq. 17)."""
    return float(exact_shares(prices, pieces).sum())


def exact_shares(prices: PriceMap, pieces: Sequence[tuple[str, int, int]]) -> Array:
    """What each joint from the hips down has of :func:`exact_price`: (P,) rad²."""
    clips = {"a": prices.a, "b": prices.b}
    infos = tuple(ClipInfo(key, motion.frames, motion.fps) for key, motion in clips.items())
    segments = tuple(Segment(key, FrameRange(start, stop)) for key, start, stop in pieces)
    seams = (Seam(prices.stiffness),) * (len(segments) - 1)
    shares = joint_shares(place_timeline(Timeline(infos, segments, seams, prices.a.fps), clips))
    return shares[list(priced_joints(prices.a.skeleton))]
