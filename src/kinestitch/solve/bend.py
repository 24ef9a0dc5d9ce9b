"""A path bent through waypoints: every step turned and a little lengthened, none retimed.

The displacement v_k of an interval becomes exp(ζ_k) v_k with ζ = σ + iψ, in the ground plane told as z + ix, so that ψ
is a yaw and the body turns by it. Turning costs little and should not change abruptly, above all not where the body
hardly travels; steps keep their length as far as they can:

    minimise  (T fps)² (Σ s_k (Dψ)_k² + (τ fps)² Σ (Lψ)_k²)  +  Σ σ_k² + (τ fps)⁴ Σ (Lσ)_k²                   (Eq. 32)
    with  p_0 + Σ_{k<f} exp(ζ_k) v_k = waypoint  and  ψ_f = heading                                            (Eq. 33)

ζ lives on frames, an interval takes the mean of both; solved by Gauss–Newton steps with Lagrange multipliers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.rotation import Array
from kinestitch.solve.laplacian import normal_bands, solve_bands
from kinestitch.solve.pinned import Frames, eliminated

Complex = NDArray[np.complex128]

PATIENCE = 0.5
"""T in s: how dear a turn is beside a change of the steps' length."""

_RESTING = 0.1  # of the mean speed; below it a turn gets no dearer
_STEPS, _LONGEST = 100, 0.7  # Gauss–Newton steps, and how far one may go in ζ
_MET, _SETTLED = 1e-12, 1e-9  # of the path's length; rad


@dataclass(frozen=True, slots=True)
class Aim:
    """Where frame `frame` of a path has to be (m, as z + ix), or by what its heading has to change (rad).

    weight : infinity is exact
    """

    frame: int
    value: complex
    weight: float
    is_heading: bool = False


def bend(path: Complex, aims: Sequence[Aim], fps: float, smoothing: Array, *, started: bool) -> Complex | None:
    """How a path (n + 1,) m is bent so that it passes its aims: ζ (n + 1,) of each frame (Eq. 32, 33), zero turn at its
    first one; None where the steps do not settle.

    aims : on frames 1 to n; smoothing : (n + 1,) s, τ of each frame
    started : whether frames come before the first one, whose heading the path takes over smoothly
    """
    steps = np.diff(path)
    fixed = np.array([0, len(steps)] if started else [len(steps)])
    system = _System(steps, tuple(aims), fixed, *_bands(steps, fps, smoothing, fixed))
    zeta = np.zeros(len(path), dtype=np.complex128)
    give = system.give()
    wanted = np.array([aim.value if aim.is_heading else aim.value - path[0] for aim in aims])
    scale = 1.0 + float(np.abs(steps).sum())
    for _ in range(_STEPS):
        change = system.next(zeta, wanted, give) - zeta
        longest = float(np.abs(change).max())
        zeta = zeta + change * min(1.0, _LONGEST / max(longest, 1e-300))
        if longest < _SETTLED and system.missed(zeta, wanted) < _MET * scale:
            return zeta
    return None


def bent_path(path: Complex, zeta: Complex) -> Complex:
    """The path (n + 1,) m whose steps are turned and stretched by ζ (n + 1,)."""
    return path[0] + np.concatenate([[0.0], np.cumsum(np.exp(between(zeta)) * np.diff(path))])


def between(zeta: Complex) -> Complex:
    """ζ (n,) of the intervals between frames."""
    return (zeta[1:] + zeta[:-1]) / 2


def _bands(steps: Complex, fps: float, smoothing: Array, fixed: Frames) -> tuple[Array, Array]:
    """The systems of ψ and of σ on n + 1 frames, upper bands (3, n + 1) each, given frames eliminated."""
    count = len(steps) + 1
    width = (smoothing * fps) ** 2
    inner = width.copy()
    inner[[0, -1]] = 0.0
    turns, scales = normal_bands(inner, np.zeros(count)), normal_bands(inner**2)
    slow = _slowness(steps, fps)
    slow[-1] += width[-1]  # L's row at the last frame, behind which the heading stays
    turns[2, :-1] += slow
    turns[2, 1:] += slow
    turns[1, 1:] -= slow
    scales[2, -2] += width[-1] ** 2
    if len(fixed) == 2:
        turns[2, 1] += width[0]
        scales[2, 1] += width[0] ** 2
    return eliminated(turns * (PATIENCE * fps) ** 2, np.array([0])), eliminated(scales, fixed)


def _slowness(steps: Complex, fps: float) -> Array:
    """How much dearer than at the mean speed a turn is in each interval (n,), by the speed of half a second."""
    speed = np.abs(steps)
    half = max(1, round(fps / 4))
    window = np.ones(2 * half + 1)
    near = np.convolve(speed, window)[half:-half] / np.convolve(np.ones(len(speed)), window)[half:-half]
    mean = float(speed.mean())
    return (1 + _RESTING) / (near / mean + _RESTING) if mean > 1e-12 else np.ones(len(speed))


@dataclass(frozen=True, eq=False, slots=True)
class _System:
    """The energy of a bend as bands, and its aims as rows, linear in real numbers: two a waypoint (z and x), one a
    heading.

    fixed : frames whose σ is given; ψ is given at the first
    """

    steps: Complex
    aims: tuple[Aim, ...]
    fixed: Frames
    turns: Array
    scales: Array

    def rows(self, zeta: Complex) -> tuple[Array, Array]:
        """Derivatives (n + 1, R) of all aims by σ and by ψ."""
        moved = np.exp(between(zeta)) * self.steps / 2
        by_scale, by_turn = [], []
        for aim in self.aims:
            at = np.zeros(len(zeta), dtype=np.complex128)
            if aim.is_heading:
                at[aim.frame] = 1.0
                by_scale.append(np.zeros(len(zeta)))
                by_turn.append(at.real)
            else:
                at[: aim.frame] = moved[: aim.frame]
                at[1 : aim.frame + 1] += moved[: aim.frame]
                by_scale += [at.real, at.imag]
                by_turn += [-at.imag, at.real]
        return np.stack(by_scale, axis=1), np.stack(by_turn, axis=1)

    def next(self, zeta: Complex, wanted: Complex, give: Array) -> Complex:
        """Where the constraints, taken as straight from here, are met at the least energy."""
        by_scale, by_turn = self.rows(zeta)
        scales, turns = self._responses(by_scale, by_turn)
        gap = self._real(wanted - self._values(zeta)) + by_scale.T @ zeta.real + by_turn.T @ zeta.imag
        system = by_scale.T @ scales + by_turn.T @ turns + give
        size = np.sqrt(np.maximum(np.diag(system), 1e-30))  # aims between which nothing moves are one and the same
        force = np.linalg.lstsq(system / size / size[:, None], gap / size, rcond=None)[0] / size
        return np.asarray(scales @ force + 1j * (turns @ force))

    def give(self) -> Array:
        """How far each row gives way to a unit force (R, R): nothing for exact aims, for others so much that one of
        weight w, alone, goes w / (w + 1) of the way.
        """
        by_scale, by_turn = self.rows(np.zeros(len(self.steps) + 1, dtype=np.complex128))
        scales, turns = self._responses(by_scale, by_turn)
        lone = by_scale.T @ scales + by_turn.T @ turns
        owner = np.repeat(np.arange(len(self.aims)), [1 if aim.is_heading else 2 for aim in self.aims])
        weights = np.array([aim.weight for aim in self.aims])
        return np.where(owner[:, None] == owner, lone / weights[owner], 0.0)

    def missed(self, zeta: Complex, wanted: Complex) -> float:
        """The largest distance of an exact aim in m or rad."""
        gaps = np.abs(wanted - self._values(zeta))
        return float(gaps[[aim.weight == np.inf for aim in self.aims]].max(initial=0.0))

    def _responses(self, by_scale: Array, by_turn: Array) -> tuple[Array, Array]:
        """σ and ψ (n + 1, R) that a unit force on each row brings about."""
        by_scale, by_turn = by_scale.copy(order="F"), by_turn.copy(order="F")
        by_scale[self.fixed], by_turn[0] = 0.0, 0.0
        return (
            solve_bands(self.scales.copy(order="F"), by_scale),
            solve_bands(self.turns.copy(order="F"), by_turn),
        )

    def _values(self, zeta: Complex) -> Complex:
        way = np.concatenate([[0.0], np.cumsum(np.exp(between(zeta)) * self.steps)])
        return np.array([zeta[aim.frame].imag if aim.is_heading else way[aim.frame] for aim in self.aims])

    def _real(self, values: Complex) -> Array:
        parts: list[float] = []
        for aim, value in zip(self.aims, values, strict=True):
            parts += [value.real] if aim.is_heading else [value.real, value.imag]
        return np.array(parts)
