"""Jumping jacks: three, arms overhead while the feet are apart, a small hop each way."""

from __future__ import annotations

from kinestitch.samples.airborne import beside, hops
from kinestitch.samples.build import Choreography, Swing
from kinestitch.samples.curves import Curve, keyed
from kinestitch.samples.feet import Footwork, Stance

SECONDS = 3.5
COUNT = 3
HALF = 0.45
"""Seconds from one hop to the next."""
FIRST = 0.42
AIR = 0.20
NARROW, WIDE = 0.085, 0.360
DIP = 0.100
PLACE = 0.125


def _hops() -> list[tuple[float, float, bool]]:
    """Take-off, landing, and whether the feet land apart, of each hop."""
    starts = [FIRST + HALF * k for k in range(2 * COUNT)]
    return [(start, start + AIR, k % 2 == 0) for k, start in enumerate(starts)]


def choreography() -> Choreography:
    """Six hops of 0.2 s; hands and feet are out at the same moment, and the knees give at every landing."""
    return Choreography(
        seconds=SECONDS,
        hips=beside(keyed([(0.0, 0, 0.01), (0.3, 0, 0.02), (3.2, 0, 0.02), (3.5, 0, 0.01)], smooth=0.08), _height()),
        pelvis=keyed(_dips(still=2.0, low=7.0, high=2.0)),
        spine=keyed(_dips(still=1.0, low=3.0, high=-3.0)),
        head=keyed(_dips(still=2.0, low=4.0, high=-3.0), smooth=0.08),
        left_arm=Swing(_arm()),
        right_arm=Swing(_arm()),
        left_foot=_foot(1.0),
        right_foot=_foot(-1.0),
        fists=6.0,
    )


def _height() -> Curve:
    """Feet apart, the legs slant, so the hips stand 6 cm lower there."""
    narrow, wide = 1.008, 0.956
    flights, grounded = [], [[(0.0, 0.950), (0.16, 0.925), (FIRST - 0.14, 0.868)]]
    for off, on, out in _hops():
        flights.append((off, on, narrow if out else wide, wide if out else narrow))
        grounded.append([(on + 0.5 * (HALF - AIR), (wide if out else narrow) - DIP)])
    last = _hops()[-1][1]
    grounded[-1] = [(last + 0.125, narrow - DIP - 0.002), (last + 0.26, 0.922), (last + 0.42, 0.942), (SECONDS, 0.950)]
    return hops(flights, grounded)


def _dips(*, still: float, low: float, high: float) -> list[tuple[float, float, float, float]]:
    """Keys of a lean in degrees that is `low` in every crouch and `high` in every flight."""
    rows = [(0.0, 0.0, still, 0.0), (FIRST - 0.12, 0.0, low, 0.0)]
    for off, on, _ in _hops():
        rows += [(0.5 * (off + on), 0.0, high, 0.0), (on + 0.5 * (HALF - AIR), 0.0, low, 0.0)]
    return [*rows, (SECONDS - 0.3, 0.0, still, 0.0), (SECONDS, 0.0, still, 0.0)]


def _arm() -> Curve:
    """Hands swing from the thighs to over the head and back, through the sides."""
    rows = [(0.0, 2.0, 9.0, 8.0, 14.0), (FIRST - 0.10, 4.0, 11.0, 8.0, 20.0)]
    for off, on, out in _hops():
        middle = 0.5 * (off + on)
        rows.append((middle, 6.0, 92.0 if out else 88.0, -10.0, 22.0))
        end = (12.0, 168.0, -20.0, 26.0) if out else (3.0, 11.0, 6.0, 20.0)
        rows.append((on + 0.07, *end))
        rows.append((on + 0.17, *end))
    rows[-1] = (SECONDS - 0.2, 2.0, 9.0, 8.0, 14.0)
    return keyed([*rows, (SECONDS, 2.0, 9.0, 8.0, 14.0)], smooth=0.035)


def _foot(side: float) -> Footwork:
    """Lands on the ball, lowers the heel a little late, and leaves over the ball again."""
    stances: list[Stance] = []
    swings: list[tuple[tuple[float, ...], ...]] = []
    yaw, down = side * 6.0, -0.5
    x = side * NARROW
    for off, on, out in _hops():
        start = (down, 0.0, yaw) if not stances else (down, -26.0, yaw)
        flat = () if not stances else ((down + 0.10, 0.0, yaw),)
        stances.append(Stance(x, PLACE, (start, *flat, (off - 0.12, 0.0, yaw), (off, -40.0, yaw))))
        before, x, down = x, side * (WIDE if out else NARROW), on
        yaw = side * (20.0 if out else 6.0)
        # The ball of the foot leaves and lands at the same height, so the swing needs one point: halfway, toes hanging.
        swings.append(((0.5 * (off + on), 0.5 * (before + x), 0.216, -0.005, -36.0, side * 13.0),))
    last = ((down, -26.0, yaw), (down + 0.10, 0.0, yaw), (SECONDS + 1.0, 0.0, yaw))
    return Footwork((*stances, Stance(x, PLACE, last)), tuple(swings))
