"""From where a motion is looked at: an orthographic camera that knows front from side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinestitch.core.mirror import mirror_pairs
from kinestitch.core.rotation import Array
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import ParameterError
from kinestitch.render.mannequin import left_joints

VIEWS = {"front": (0.0, 0.0), "side": (90.0, 0.0), "three-quarter": (52.0, 6.0), "back": (180.0, 0.0)}
"""Azimuth (0: the figure faces us, 90: it faces right) and elevation of each named view, in degrees."""


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """An orthographic camera: unit vectors (3,) of the world that point right, up, and towards the eye."""

    right: Array
    up: Array
    toward: Array

    def project(self, points: Array) -> Array:
        """Points (..., 3) m as (..., 3): right and up on the paper in m, and depth (larger is nearer)."""
        return np.stack([points @ self.right, points @ self.up, points @ self.toward], axis=-1)


def facing(skeleton: Skeleton, positions: Array) -> Array:
    """Unit horizontal vector (3,) that a body of (F, J, 3) m faces on average; travel, else +Z, if it has no sides."""
    pairs = np.array(mirror_pairs(skeleton))
    left = left_joints(skeleton)
    if left:
        across = (positions[:, left] - positions[:, pairs[left]]).sum(axis=1)
        forward = np.cross(across, [0.0, 1.0, 0.0])[:, [0, 2]]
        forward = forward / np.maximum(np.linalg.norm(forward, axis=1, keepdims=True), 1e-12)
        mean = forward.mean(axis=0)
    else:
        mean = (positions[-1, 0] - positions[0, 0])[[0, 2]]
    size = float(np.linalg.norm(mean))
    return np.array([mean[0] / size, 0.0, mean[1] / size]) if size > 1e-3 else np.array([0.0, 0.0, 1.0])


def view_of(forward: Array, view: str | float, elevation: float | None = None) -> View:
    """The camera of a named view, or of an azimuth in degrees, for a body that faces `forward` (3,).

    elevation : degrees by which the camera looks down; without it the view's own

    Raises ParameterError for an unknown name.
    """
    if isinstance(view, str):
        if view not in VIEWS:
            raise ParameterError(f"Expected a view out of {', '.join(VIEWS)} or degrees, got {view!r}.")
        azimuth, down = np.radians(VIEWS[view])
    else:
        azimuth, down = np.radians([float(view), 6.0])
    if elevation is not None:
        down = np.radians(elevation)
    left = np.cross([0.0, 1.0, 0.0], forward)
    right = np.cos(azimuth) * left + np.sin(azimuth) * forward
    level = np.cos(azimuth) * forward - np.sin(azimuth) * left
    upward = np.array([0.0, 1.0, 0.0])
    toward = np.cos(down) * level + np.sin(down) * upward
    return View(right, np.cos(down) * upward - np.sin(down) * level, toward)
