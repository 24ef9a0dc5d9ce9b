"""Root travel at a constant speed."""

from __future__ import annotations

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.samples.curves import Curve


def forwards(speed: float) -> Curve:
    """Position (F, 3) m along +Z at `speed` m/s, zero at time 0."""

    def at(t: Array) -> Array:
        return np.stack([np.zeros_like(t), np.zeros_like(t), speed * t], axis=-1)

    return at
