"""Other ways over a seam, on the same placed timeline, for comparison.

All of them get the sources where :func:`kinestitch.solve.placed.place_timeline` has put them, so that what differs is
the seam alone.
"""

from kinestitch.solve.rivals.blends import crossfade, geodesic_blend
from kinestitch.solve.rivals.extrapolation import dead_blend
from kinestitch.solve.rivals.offsets import hermite, inertialize

__all__ = ["crossfade", "dead_blend", "geodesic_blend", "hermite", "inertialize"]
