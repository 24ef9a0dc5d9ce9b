"""What a character wears: a surface that hangs on a skeleton's joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.rotation import Array
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import InvalidMotionError


@dataclass(frozen=True, eq=False, slots=True)
class Mesh:
    """A skinned surface in the rest pose of its skeleton.

    vertices : (V, 3) m, world; normals : (V, 3) unit vectors, outward
    triangles : (T, 3) vertices, counter-clockwise as seen from outside
    weights : (V, J) share of each joint in a vertex; rows sum to 1
    colours : (T, 3) red, green and blue in [0, 1]

    Raises InvalidMotionError for arrays that do not fit together.
    """

    skeleton: Skeleton
    vertices: Array
    normals: Array
    triangles: NDArray[np.intp]
    weights: Array
    colours: Array

    def __post_init__(self) -> None:
        count, faces = len(self.vertices), len(self.triangles)
        shapes = {
            "vertices": (count, 3),
            "normals": (count, 3),
            "triangles": (faces, 3),
            "weights": (count, self.skeleton.joint_count),
            "colours": (faces, 3),
        }
        for name, shape in shapes.items():
            found = getattr(self, name).shape
            if found != shape:
                raise InvalidMotionError(f"Expected {name} of shape {shape}, got {found}.")
        if faces and not (self.triangles.min() >= 0 and self.triangles.max() < count):
            raise InvalidMotionError(f"Expected triangles of vertices 0 to {count - 1}, got {self.triangles.max()}.")
        if not np.allclose(self.weights.sum(axis=1), 1.0, atol=1e-6):
            raise InvalidMotionError("Expected weights that sum to 1 at every vertex.")
