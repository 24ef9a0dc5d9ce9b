"""Frame rates as people mean them: files write 0.008333 s and mean 120 frames a second."""

from __future__ import annotations

COMMON_RATES = (
    *(8.0, 10.0, 12.0, 12.5, 15.0, 16.0, 20.0, 24.0, 25.0, 30.0, 40.0, 48.0, 50.0, 60.0, 72.0, 75.0, 80.0, 90.0, 100.0),
    *(120.0, 125.0, 144.0, 150.0, 180.0, 200.0, 240.0, 250.0, 300.0, 480.0, 500.0, 1000.0),
    *(24000 / 1001, 30000 / 1001, 48000 / 1001, 60000 / 1001, 120000 / 1001),
)
"""Frames a second that cameras, games and motion capture use."""

SNAP = 5e-4


def snap_rate(fps: float) -> float:
    """The common frame rate within 0.05 % of `fps`, else `fps` itself.

    >>> snap_rate(1 / 0.008333), snap_rate(1 / 0.0333333), snap_rate(37.0)
    (120.0, 30.0, 37.0)
    """
    nearest = min(COMMON_RATES, key=lambda rate: abs(rate - fps))
    return nearest if abs(nearest - fps) <= SNAP * nearest else fps
