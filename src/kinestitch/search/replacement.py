"""The best replacement: which frames of a clip to take out, and which of another to put there, both seams at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.errors import RangeError
from kinestitch.search.price import (
    SHORT_LIST,
    Places,
    PriceMap,
    by_exact_cost,
    check_window,
    exact_shares,
    minima_apart,
    price_map,
)


@dataclass(frozen=True, slots=True)
class Replacement:
    """The frames start:stop of one clip replaced by clip_start:clip_stop of another (at the first one's rate).

    cost : what the search minimised; separable : both seams' E* in rad² as if each were alone
    price : E* in rad² of both together, as they will be solved; exact_cost : the cost with this price in the separable
    one's place
    """

    start: int
    stop: int
    clip_start: int
    clip_stop: int
    cost: float
    separable: float
    price: float
    exact_cost: float

    @property
    def difference(self) -> float:
        """By which share the exact price differs from the separable one."""
        return self.price / self.separable - 1.0 if self.separable > 0 else 0.0


@dataclass(frozen=True, slots=True)
class Limits:
    """Where a replacement may lie; each is a first and a last value, both included, and None leaves it open.

    start, stop : places of the original; open, a visible reach stays on either side, or half of the clip
    clip_start, clip_stop : places of the clip that is pasted
    removed, pasted : how many frames go and how many come; open, one at least goes (0 would be an insert) and two
    visible reaches at least come
    """

    start: Places | None = None
    stop: Places | None = None
    clip_start: Places | None = None
    clip_stop: Places | None = None
    removed: Places | None = None
    pasted: Places | None = None


def best_replacement(
    original: Motion,
    reference: Motion,
    limits: Limits = Limits(),
    *,
    stiffness: float | None = None,
    smoothing: float | None = None,
    weights: ArrayLike | str | None = None,
    contacts: bool = True,
) -> Replacement:
    """The replacement of least cost within its limits, both seams counted; exact, not greedy.

    Parameters as for :func:`price_map`. Raises RangeError where no replacement keeps the limits.
    """
    prices = price_map(
        original, reference, stiffness=stiffness, smoothing=smoothing, weights=weights, contacts=contacts
    )
    return replacement_from(prices, limits)


def replacement_from(prices: PriceMap, limits: Limits = Limits()) -> Replacement:
    """The same from a map that is already there."""
    return best_replacements(prices, limits)[0]


def best_replacements(
    prices: PriceMap, limits: Limits = Limits(), count: int = 1, *, exact: bool = False
) -> tuple[Replacement, ...]:
    """The replacements of least cost, least first; each way in is well apart from those before it, and has its
    cheapest way out.

    exact : order by exact cost, the best of a list that is four times as long; left out, by the map's own, so that
    the first one is the best of all

    For every way in, the cheapest way out lies in a rectangle of the map that moves along with it; the minima of all
    rectangles are one sliding minimum along each axis (Eq. 19). There may be fewer than `count`.

    Raises RangeError where no replacement keeps the limits.
    """
    frames, clip = prices.a.frames, prices.b.frames
    last, kept = frames - 1, min(prices.kept(frames), frames - 1)
    start = check_window(limits.start or (kept, last), 1, last, "the original's start")
    stop = check_window(limits.stop or (1, frames - kept), 1, last, "the original's stop")
    into = check_window(limits.clip_start or (0, clip - 1), 0, clip - 1, "the clip's start")
    out = check_window(limits.clip_stop or (1, clip), 1, clip, "the clip's stop")
    removed = check_window(limits.removed or (1, frames), 0, frames, "the number of frames removed")
    shortest = min(2 * prices.apart, clip)
    pasted = check_window(limits.pasted or (shortest, clip), 1, clip, "the number of frames pasted")
    leaving = _outside(prices.costs, stop, out)
    least = sliding_minimum(sliding_minimum(leaving, *removed).T, *pasted).T
    total = _outside(prices.costs, start, into) + least
    if not np.isfinite(total).any():
        raise RangeError("Expected limits that some replacement keeps, got none that does. Widen one of them.")
    found = []
    for i, j in minima_apart(total, SHORT_LIST * count if exact else count, prices.apart):
        corner = (i + removed[0], j + pasted[0])
        block = leaving[corner[0] : i + removed[1] + 1, corner[1] : j + pasted[1] + 1]
        di, dj = (int(k) for k in np.unravel_index(np.argmin(block), block.shape))
        found.append(_priced(prices, (i, corner[0] + di, j, corner[1] + dj), float(total[i, j])))
    return tuple(by_exact_cost(found)[:count] if exact else found)


def _priced(prices: PriceMap, places: tuple[int, int, int, int], cost: float) -> Replacement:
    start, stop, into, out = places
    shares = exact_shares(prices, [("a", 0, start), ("b", into, out), ("a", stop, prices.a.frames)])
    separable, in_cost = (price(start, into) + price(stop, out) for price in (prices.price, prices.price_in_cost))
    exact_cost = cost + prices.weighted_sum(shares) - in_cost
    return Replacement(start, stop, into, out, cost, separable, float(shares.sum()), exact_cost)


def _outside(costs: Array, rows: Places, columns: Places) -> Array:
    """The costs, infinite outside these rows and columns."""
    out = np.full(costs.shape, np.inf)
    here = (slice(rows[0], rows[1] + 1), slice(columns[0], columns[1] + 1))
    out[here] = costs[here]
    return out


def sliding_minimum(values: Array, first: int, last: int) -> Array:
    """Entry i is the least of ``values[i + first : i + last + 1]`` along axis 0, infinite where that is empty.

    Windows of doubled width, so that the time grows with the logarithm of the width.
    """
    rows, width = len(values), last - first + 1
    padded = np.full((rows + width, *values.shape[1:]), np.inf)
    padded[: max(rows - first, 0)] = values[first:]
    done = 1
    while 2 * done <= width:
        padded[:-done] = np.minimum(padded[:-done], padded[done:])
        done *= 2
    return np.minimum(padded[:rows], padded[width - done : width - done + rows])
