"""Each sample once, with its world pose and the place of every joint by its bare name."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.samples import SAMPLE_NAMES, sample, sample_contacts
from kinestitch.samples.body import PREFIX, joint


class Seen(NamedTuple):
    motion: Motion
    positions: np.ndarray
    contacts: dict[str, np.ndarray]

    def at(self, name: str) -> np.ndarray:
        """World positions (F, 3) of a joint by its name without the prefix."""
        return self.positions[:, joint(name)]

    def held(self, name: str) -> np.ndarray:
        return self.contacts[PREFIX + name]

    def speed(self, name: str) -> np.ndarray:
        """Metres a second (F − 1,) of a joint."""
        return np.linalg.norm(np.diff(self.at(name), axis=0), axis=1) * self.motion.fps

    def bend(self, name: str) -> np.ndarray:
        """Signed turn (F,) in degrees of a knee about its hinge, positive where the heel comes to the seat."""
        q = self.motion.rotations[:, joint(name)]
        return np.degrees(2 * np.arctan2(q[:, 0], q[:, 3]))


@cache
def see(name: str, fps: float = 60.0) -> Seen:
    motion = sample(name, fps=fps)
    return Seen(motion, world_pose(motion).positions, sample_contacts(name, fps=fps))


@pytest.fixture(params=SAMPLE_NAMES)
def seen(request: pytest.FixtureRequest) -> Seen:
    return see(request.param)


@pytest.fixture
def look():
    return see
