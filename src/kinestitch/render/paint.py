"""A body as coloured shapes on paper, far ones first; filmstrip and video paint with it alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.render.mannequin import Part, anchor, joint_positions, outlines, with_tips

COLOURS = {"left": "#2f6fa7", "right": "#d9822b", "torso": "#5b6168"}
PASTED = ("#8e5aa8", "#3f8f6b", "#b0446c")
"""Blue and orange part left from right for every kind of colour vision; pasted segments take these colours in turn."""
SEAM, GROUND, SHADOW = "#8c2d5b", "#b9bec4", "#e9ebee"
STANDS = "#009e73"
"""Feet that stand."""


@dataclass(frozen=True, slots=True)
class Stretch:
    """Frames [start, stop) of a result that came from elsewhere, with the words to set beside them."""

    start: int
    stop: int
    label: str = ""
    colour: str = ""


@dataclass(frozen=True, eq=False, slots=True)
class Painted:
    """The shapes of one pose, in the order in which they are painted.

    shapes : (P, K, 2) outlines; colours : (P, 3) in [0, 1]; fine : (P,) bool, fingers and the like
    """

    shapes: Array
    colours: Array
    fine: Array


def painted(parts: Sequence[Part], pose: Array, height: float = 1.0, *, standing: Sequence[int] = ()) -> Painted:
    """The parts of a pose (J, 3) as projected: the far ones first and paler.

    height : of the body, in the unit of the pose; standing : numbers of the parts that stand on the ground
    """
    from matplotlib.colors import to_rgb

    # A neck lies behind both what it carries and what carries it, whatever the view.
    back = [0.1 * height * (part.side == "torso" and len(part.joints) == 2 and part.radii[0] > 0) for part in parts]
    depth = np.array([pose[list(part.joints), 2].mean() for part in parts]) - back
    order = np.argsort(depth, kind="stable")
    middle = float(np.median(depth))
    spread = max(float(np.abs(depth - middle).max()), 0.1 * height)
    limbs = np.array([part.side != "torso" for part in parts])
    far = (0.35 * np.clip((middle - depth) / spread, 0, 1) * limbs)[:, None]
    colours = np.array([to_rgb(COLOURS[part.side]) for part in parts]) * (1 - far) + far
    colours[list(standing)] = to_rgb(STANDS)
    fine = np.array([max(map(abs, part.radii)) <= 0.01 for part in parts])
    return Painted(outlines(tuple(parts), pose, height)[order], colours[order], fine[order])


def body_positions(motion: Motion) -> Array:
    """World positions (F, J + T, 3) m as they are drawn: a dummy root above the hips has no place in the picture."""
    skeleton = with_tips(motion.skeleton)
    hung = skeleton.chain(anchor(skeleton))
    positions = joint_positions(motion)
    positions[:, hung] = positions[:, hung[-1:]]
    return positions
