"""A path bent through waypoints: every step turned and a little lengthened, none retimed.

The displacement v_k of an interval becomes exp(ζ_k) v_k with ζ = σ + iψ, in the ground plane told as z + ix, so that ψ
is a yaw and the body turns by it. Turning costs little and should not change abruptly, above all not where the body
hardly travels; steps keep their length as far as they can:

    minimise  (T fps)² (Σ s_k (Dψ)_k² + (τ fps)² Σ (Lψ)_k²)  +  Σ σ_k² + (τ fps)⁴ Σ (Lσ)_k²                   (Eq. 32)
    with  p_0 + Σ_{k<f} exp(ζ_k) v_k = waypoint  and  ψ_f = heading                                            (Eq. 33)

ζ lives on frames, an interval takes the mean of both. The steps set out from chords that are turned as wanted; they are
Gauss–Newton's with Lagrange multipliers, and Newton's near the end, where a path that is pushed together yields slowly.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.rotation import Array
from kinestitch.solve.laplacian import normal_bands, solve_bands, solve_indefinite_bands
from kinestitch.solve.pinned import Frames, banded_product, eliminated

Complex = NDArray[np.complex128]

T = TypeVar("T")
Pair = tuple[T, T]

PATIENCE = 0.5
"""T in s: how dear a turn is beside a change of the steps' length."""

_RESTING = 0.1  # of the mean speed; below it a turn gets no dearer
_STEPS, _LONGEST = 100, 0.7  # how many steps, and how far one may go in ζ
_NEAR, _FARTHER = 0.2, 10.0  # rad below which steps tell how the path yields, and how much longer they may get for it
_STRAIGHT = 0.5  # of a way; a shorter chord does not tell where the way leads
_MET, _SETTLED, _NEARLY = 1e-12, 1e-9, 1e-3  # of the path's length; rad; rad where a path is about to buckle


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

    aims : on frames 1 to n, waypoints in time; smoothing : (n + 1,) s, τ of each frame
    started : whether frames come before the first one, whose heading the path takes over smoothly
    """
    steps = np.diff(path)
    fixed = np.array([0, len(steps)] if started else [len(steps)]), np.array([0])
    spans, wanted = _between_waypoints(path[0], aims)
    system = _System(steps, tuple(aims), spans, fixed, _bands(steps, fps, smoothing, fixed))
    give = system.give()
    zeta = (1j * _turned_chords(path, aims, smoothing * fps)).astype(np.complex128)
    force = np.zeros(len(give))
    scale = 1.0 + float(np.abs(steps).sum())
    for _ in range(_STEPS):
        change, force = system.step(zeta, force, wanted, give)
        longest = float(np.abs(change).max())
        zeta = zeta + change * min(1.0, _LONGEST / max(longest, 1e-300))
        if longest < _SETTLED and system.missed(zeta, wanted) < _MET * scale:
            return zeta
    return zeta if longest < _NEARLY and system.missed(zeta, wanted) < _MET * scale else None


def bent_path(path: Complex, zeta: Complex) -> Complex:
    """The path (n + 1,) m whose steps are turned and stretched by ζ (n + 1,)."""
    return path[0] + np.concatenate([[0.0], np.cumsum(np.exp(between(zeta)) * np.diff(path))])


def between(zeta: Complex) -> Complex:
    """ζ (n,) of the intervals between frames."""
    return (zeta[1:] + zeta[:-1]) / 2


def _between_waypoints(start: complex, aims: Sequence[Aim]) -> tuple[tuple[slice, ...], Complex]:
    """The intervals from each waypoint to the next, and the way over them; of a heading, nothing and its turn."""
    spans, wanted, frame = [], [], 0
    for aim in aims:
        spans.append(slice(0) if aim.is_heading else slice(frame, aim.frame))
        wanted.append(aim.value if aim.is_heading else aim.value - start)
        if not aim.is_heading:
            frame, start = aim.frame, aim.value
    return tuple(spans), np.array(wanted, dtype=np.complex128)


def _turned_chords(path: Complex, aims: Sequence[Aim], width: Array) -> Array:
    """ψ (n + 1,) to begin with: in the middle between exact waypoints as much as the way between them, taken as
    straight, has to turn, in the branch nearest to the turn before.

    width : (n + 1,) frames, within which a path hardly turns; waypoints as near as that say nothing
    """
    travel = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(path)))])
    at, turns, frame, place = [0.0], [0.0], 0, path[0]
    for aim in aims:
        if aim.is_heading or aim.weight != np.inf:
            continue
        own, wanted = path[aim.frame] - path[frame], aim.value - place
        straight = min(abs(own), abs(wanted)) > _STRAIGHT * (travel[aim.frame] - travel[frame])
        if straight and aim.frame - frame > width[aim.frame]:
            at.append((frame + aim.frame) / 2)
            turns.append(turns[-1] + math.remainder(float(np.angle(wanted / own)) - turns[-1], 2 * math.pi))
        frame, place = aim.frame, aim.value
    return np.interp(np.arange(len(path)), at, turns)


def _bands(steps: Complex, fps: float, smoothing: Array, fixed: Pair[Frames]) -> Pair[Array]:
    """The systems of σ and ψ on n + 1 frames, upper bands (3, n + 1) each, given frames eliminated."""
    count = len(steps) + 1
    width = (smoothing * fps) ** 2
    inner = width.copy()
    inner[[0, -1]] = 0.0
    scales, turns = normal_bands(inner**2), normal_bands(inner, np.zeros(count))
    slow = _slowness(steps, fps)
    slow[-1] += width[-1]  # L's row at the last frame, behind which the heading stays
    turns[2, :-1] += slow
    turns[2, 1:] += slow
    turns[1, 1:] -= slow
    scales[2, -2] += width[-1] ** 2
    if len(fixed[0]) == 2:
        scales[2, 1] += width[0] ** 2
        turns[2, 1] += width[0]
    return eliminated(scales, fixed[0]), eliminated(turns * (PATIENCE * fps) ** 2, fixed[1])


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
    """The energy of a bend as bands of σ and of ψ, and its aims as rows, linear in real numbers: two a waypoint (z and
    x), one a heading. Waypoints count from the one before, so that near ones stay apart in numbers too.

    fixed : frames whose σ or ψ is given, and zero
    """

    steps: Complex
    aims: tuple[Aim, ...]
    spans: tuple[slice, ...]
    fixed: Pair[Frames]
    bands: Pair[Array]

    def step(self, zeta: Complex, force: Array, wanted: Complex, give: Array) -> tuple[Complex, Array]:
        """A step to where the constraints, taken as straight from here, are met at the least energy, and the forces
        (R,) that hold it there; force : of the step before.

        What a constraint's own bend adds to the energy's is taken in where it stiffens: a path under tension, like a
        string, is harder to turn, one that is pushed together harder to shorten. Short steps take in where it softens
        as well, unless the path gives way along the step: then it buckles, and the step goes farther.
        """
        change, held = self._held(zeta, force, wanted, give, self._stiffened(self._pull(zeta, force)))
        longest = float(np.abs(change).max())
        if not _SETTLED <= longest < _NEAR:
            return change, held
        if self._resistance(zeta, held, change, give, held - force) < 0:
            return change * min(_FARTHER, _NEAR / longest), held
        try:
            whole, kept = self._held(zeta, held, wanted, give, self._curved(self._pull(zeta, held)))
        except np.linalg.LinAlgError:  # just about to buckle
            return change, held
        resists = self._resistance(zeta, held, whole, give, kept - held) > 0
        return (whole, kept) if resists and float(np.abs(whole).max()) < 2 * _NEAR else (change, held)

    def _held(
        self, zeta: Complex, force: Array, wanted: Complex, give: Array, solve: Callable[[Pair[Array]], Pair[Array]]
    ) -> tuple[Complex, Array]:
        """The change of ζ (n + 1,) and the forces (R,) after it, for a system of σ and ψ that `solve` inverts. Both
        come from what is left to do, which keeps digits that a long path would lose.
        """
        rows = self.rows(zeta)
        left = [
            row @ force - banded_product(own, part[:, None])[:, 0]
            for row, own, part in zip(rows, self.bands, _parts(zeta), strict=True)
        ]
        found = solve((_beside(rows[0], left[0]), _beside(rows[1], left[1])))
        met = _product(rows, found)
        gap = self._real(wanted - self._values(zeta)) - give @ force - met[:, -1]
        system = give + met[:, :-1]
        # aims between which nothing moves are one and the same
        size = np.sqrt(np.maximum(np.abs(np.diag(system)), 1e-30))
        more = np.linalg.lstsq(system / size / size[:, None], gap / size, rcond=None)[0] / size
        real, imaginary = (part @ np.append(more, 1.0) for part in found)
        return real + 1j * imaginary, force + more

    def _stiffened(self, pull: Complex) -> Callable[[Pair[Array]], Pair[Array]]:
        """Inverts the energy's systems of σ and of ψ, stiffened where the pull (n,) along each step does so."""
        pulls = (-pull.real, pull.real)
        bands = [_on_means(own, np.maximum(part, 0.0)) for own, part in zip(self.bands, pulls, strict=True)]
        scales, turns = (eliminated(own, fixed) for own, fixed in zip(bands, self.fixed, strict=True))
        return lambda values: self._responses((scales, turns), values)

    def _curved(self, pull: Complex) -> Callable[[Pair[Array]], Pair[Array]]:
        """Inverts the whole system of σ and ψ, frame by frame in turns, with all that the constraints' bend adds."""
        bands = np.zeros((5, 2 * len(pull) + 2), order="F")
        bands[::2, ::2], bands[::2, 1::2] = _on_means(self.bands[0], -pull.real), _on_means(self.bands[1], pull.real)
        across = pull.imag / 4
        bands[3, 1:-2:2] += across
        bands[3, 2::2] += across
        bands[3, 3::2] += across
        bands[1, 3::2] += across
        fixed = np.concatenate([2 * self.fixed[0], 2 * self.fixed[1] + 1])
        bands = eliminated(bands, fixed)

        def solve(values: Pair[Array]) -> Pair[Array]:
            rhs = np.empty((bands.shape[1], values[0].shape[1]), order="F")
            rhs[::2], rhs[1::2] = values
            rhs[fixed] = 0.0
            found = solve_indefinite_bands(bands, rhs)
            return np.asfortranarray(found[::2]), np.asfortranarray(found[1::2])

        return solve

    def _resistance(self, zeta: Complex, force: Array, change: Complex, give: Array, more: Array) -> float:
        """Twice the energy that a change of ζ, and of the forces with it, costs beyond first order while `force` acts;
        below zero the path gives way.
        """
        spent = sum(
            float(part @ banded_product(own, part[:, None])[:, 0])
            for own, part in zip(self.bands, _parts(change), strict=True)
        )
        gained = float((self._pull(zeta, force) * between(change) ** 2).real.sum())
        return spent - gained + float(more @ give @ more)

    def rows(self, zeta: Complex) -> Pair[Array]:
        """Derivatives (n + 1, R) of all aims by σ and by ψ."""
        moved = np.exp(between(zeta)) * self.steps / 2
        count = sum(1 if aim.is_heading else 2 for aim in self.aims)
        by_scale, by_turn = (np.zeros((len(zeta), count), order="F") for _ in range(2))
        row = 0
        for aim, span in zip(self.aims, self.spans, strict=True):
            if aim.is_heading:
                by_turn[aim.frame, row] = 1.0
                row += 1
                continue
            for here in (span, slice(span.start + 1, span.stop + 1)):
                by_scale[here, row] += moved[span].real
                by_scale[here, row + 1] += moved[span].imag
                by_turn[here, row] -= moved[span].imag
                by_turn[here, row + 1] += moved[span].real
            row += 2
        return by_scale, by_turn

    def give(self) -> Array:
        """How far each row gives way to a unit force (R, R): nothing for exact aims, for others so much that one of
        weight w, alone, goes w / (w + 1) of the way.
        """
        rows = self.rows(np.zeros(len(self.steps) + 1, dtype=np.complex128))
        owner, part, weight = np.array(
            [
                (index, -index if aim.is_heading else axis, aim.weight)
                for index, aim in enumerate(self.aims, start=3)
                for axis in ((0,) if aim.is_heading else (1, 2))
            ]
        ).T
        sums = np.tril(part[:, None] == part).astype(np.float64)  # from ways between waypoints to ways from the start
        lone = sums @ _product(rows, self._responses(self.bands, rows)) @ sums.T
        apart = np.linalg.inv(sums)
        return np.asarray(apart @ np.where(owner[:, None] == owner, lone / weight, 0.0) @ apart.T)

    def missed(self, zeta: Complex, wanted: Complex) -> float:
        """By how much the way to an exact aim from the one before it is missed at most, m or rad."""
        gaps = np.abs(wanted - self._values(zeta))
        return float(gaps[[aim.weight == np.inf for aim in self.aims]].max(initial=0.0))

    def _pull(self, zeta: Complex, force: Array) -> Complex:
        """What the forces on the waypoints behind each step of the path (n,) do along it and, as i, across it."""
        pull, row = np.zeros(len(self.steps), dtype=np.complex128), 0
        for aim, span in zip(self.aims, self.spans, strict=True):
            if not aim.is_heading:
                pull[span] = force[row] + 1j * force[row + 1]
            row += 1 if aim.is_heading else 2
        return np.asarray(pull.conj() * np.exp(between(zeta)) * self.steps)

    def _responses(self, bands: Sequence[Array], values: Sequence[Array]) -> Pair[Array]:
        """σ and ψ (n + 1, R) that belong to right-hand sides of these systems."""
        found = []
        for own, value, fixed in zip(bands, values, self.fixed, strict=True):
            rhs = np.array(value, order="F")
            rhs[fixed] = 0.0
            found.append(solve_bands(own.copy(order="F"), rhs))
        return found[0], found[1]

    def _values(self, zeta: Complex) -> Complex:
        moved = np.exp(between(zeta)) * self.steps
        return np.array(
            [
                zeta[aim.frame].imag if aim.is_heading else moved[span].sum()
                for aim, span in zip(self.aims, self.spans, strict=True)
            ]
        )

    def _real(self, values: Complex) -> Array:
        parts: list[float] = []
        for aim, value in zip(self.aims, values, strict=True):
            parts += [value.real] if aim.is_heading else [value.real, value.imag]
        return np.array(parts)


def _parts(zeta: Complex) -> Pair[Array]:
    return zeta.real, zeta.imag


def _beside(rows: Array, column: Array) -> Array:
    """Rows (n, R) and one column (n,) more: (n, R + 1), in the order that the banded solves want."""
    out = np.empty((len(rows), rows.shape[1] + 1), order="F")
    out[:, :-1], out[:, -1] = rows, column
    return out


def _product(rows: Pair[Array], columns: Pair[Array]) -> Array:
    """What rows (n + 1, R) say of σ and ψ (n + 1, K): (R, K)."""
    return np.asarray(rows[0].T @ columns[0] + rows[1].T @ columns[1])


def _on_means(bands: Array, more: Array) -> Array:
    """A system on frames with `more` (n,) for the intervals' means."""
    out, share = bands.copy(order="F"), more / 4
    out[2, :-1] += share
    out[2, 1:] += share
    out[1, 1:] += share
    return out
