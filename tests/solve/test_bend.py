"""Bent paths: their aims are met, nothing nearby costs less, and the world may be turned."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinestitch.solve.bend import PATIENCE, Aim, bend, bent_path, between

FPS = 60.0


def walk(frames, seed=0, speed=1.3):
    """A path of (frames + 1) places with sway, uneven steps and a slow turn of its own."""
    rng = np.random.default_rng(seed)
    time = np.arange(frames) / FPS
    pace = speed / FPS * (1 + 0.3 * np.sin(11 * time + rng.uniform(0, 6)))
    facing = 0.1 * np.sin(5.5 * time) + rng.normal() * time * 0.1
    return np.concatenate([[0.0], np.cumsum(pace * np.exp(1j * facing))]) + rng.normal() + 1j * rng.normal()


APART = 20
"""Frames between waypoints, more than the τ of 0.3 s over which a path turns. Nearer ones are reachable by arithmetic
only: two places in neighbouring frames tell the direction of a single step, whose length has to be its own at the last.
"""


def gently_bent(seed, frames, stops=0):
    """A path and waypoints that some gentle bend of it passes."""
    rng = np.random.default_rng(seed)
    path = walk(frames, seed)
    knots = np.linspace(0, frames, 5)
    turn = np.interp(np.arange(frames + 1), knots, np.concatenate([[0.0], np.cumsum(rng.normal(size=4) * 0.5)]))
    goal = bent_path(path, 1j * turn + rng.normal() * 0.08)
    at = [frames]
    for frame in rng.choice(np.arange(40, frames + 1), stops).tolist():
        at += [frame] if min(abs(frame - other) for other in at) >= APART else []
    return path, [Aim(frame, goal[frame], np.inf) for frame in sorted(at)]


@st.composite
def reachable(draw):
    path, aims = gently_bent(draw(st.integers(0, 2**32 - 1)), draw(st.integers(60, 400)), draw(st.integers(0, 3)))
    return path, aims, draw(st.booleans())


def solved(path, aims, started, tau=0.3):
    zeta = bend(path, aims, FPS, np.full(len(path), tau), started=started)
    assert zeta is not None
    return zeta


def cost(path, zeta, started, tau=0.3):
    """The energy of a bend, written out (Eq. 32)."""
    speed = np.abs(np.diff(path))
    half = round(FPS / 4)
    near = np.array([speed[max(0, k - half) : k + half + 1].mean() for k in range(len(speed))])
    slow = 1.1 / (near / speed.mean() + 0.1)
    sigma, psi = zeta.real, zeta.imag
    beyond_psi, beyond_sigma = np.append(psi, psi[-1]), np.append(sigma, 0.0)
    if started:
        beyond_psi, beyond_sigma = np.append(0.0, beyond_psi), np.append(0.0, beyond_sigma)
    turns = (slow * np.diff(psi) ** 2).sum() + (tau * FPS) ** 2 * (np.diff(beyond_psi, 2) ** 2).sum()
    return (PATIENCE * FPS) ** 2 * turns + (sigma**2).sum() + (tau * FPS) ** 4 * (np.diff(beyond_sigma, 2) ** 2).sum()


@settings(deadline=None, max_examples=60)
@given(reachable())
def test_waypoints_are_met_and_what_is_given_stays(case):
    path, aims, started = case
    zeta = solved(path, aims, started)
    bent = bent_path(path, zeta)
    assert max(abs(bent[aim.frame] - aim.value) for aim in aims) < 1e-9
    assert bent[0] == path[0]
    assert abs(zeta[0].imag) < 1e-12
    assert abs(zeta[-1].real) < 1e-12
    if started:
        assert abs(zeta[0]) < 1e-12
    assert np.allclose(np.diff(bent), np.exp(between(zeta)) * np.diff(path))


def assert_stationary(path, aims, started, seed):
    """The derivative of the cost along any change that keeps all aims, to first order, is zero."""
    zeta = solved(path, aims, started)
    rng = np.random.default_rng(seed)
    smooth = np.linspace(0, 6, len(path))
    change = sum(
        rng.normal() * np.sin(k * smooth / 2) + 1j * rng.normal() * np.sin(k * smooth / 3) for k in range(1, 7)
    )
    change[-1] = 1j * change[-1].imag
    change[0] = change[0].real if not started else 0.0
    moved = np.exp(between(zeta)) * np.diff(path)
    rows = []
    for aim in aims:
        here = np.zeros(len(path), dtype=complex)
        here[: aim.frame] += moved[: aim.frame] / 2
        here[1 : aim.frame + 1] += moved[: aim.frame] / 2
        rows += [np.stack([here.real, -here.imag], 1).ravel(), np.stack([here.imag, here.real], 1).ravel()]
    free = np.ones((len(path), 2), dtype=bool)
    free[-1, 0] = free[0, 1] = False
    free[0, 0] = not started
    rows = np.array(rows) * free.ravel()
    flat = np.stack([change.real, change.imag], 1).ravel() * free.ravel()
    flat -= rows.T @ np.linalg.lstsq(rows.T, flat, rcond=None)[0]
    change = flat.reshape(-1, 2) @ [1, 1j]
    step = 1e-4
    slope = (cost(path, zeta + step * change, started) - cost(path, zeta - step * change, started)) / (2 * step)
    bend_of = cost(path, change, started) ** 0.5 * max(cost(path, zeta, started), 1e-6) ** 0.5
    assert abs(slope) < 1e-5 * bend_of + 1e-7


@settings(deadline=None, max_examples=25)
@given(reachable(), st.integers(0, 2**32 - 1))
def test_no_neighbour_that_meets_the_waypoints_costs_less(case, seed):
    assert_stationary(*case, seed)


@pytest.mark.parametrize(("seed", "frames"), [(7215, 326), (1456598803, 262)])
def test_a_path_pushed_together_until_it_nearly_buckles_settles(seed, frames):
    path, aims = gently_bent(seed, frames)
    assert abs(aims[-1].value - path[0]) < 0.87 * abs(path[-1] - path[0])
    zeta = solved(path, aims, True)
    assert abs(bent_path(path, zeta)[-1] - aims[-1].value) < 1e-9
    for change in range(10):
        assert_stationary(path, aims, True, change)


def test_a_path_that_turns_round_between_waypoints_settles():
    path = walk(300)
    aims = [
        Aim(frame, bent_path(path, 1j * np.linspace(0, 5, 301))[frame], np.inf) for frame in (60, 120, 180, 240, 300)
    ]
    zeta = solved(path, aims, False)
    assert 4 < zeta[-1].imag < 6
    assert np.abs(zeta.real).max() < 0.3


@settings(deadline=None, max_examples=30)
@given(reachable(), st.floats(-3, 3), st.complex_numbers(max_magnitude=50))
def test_a_turned_world_gives_the_same_bend(case, yaw, shift):
    path, aims, started = case
    turn = np.exp(1j * yaw)
    moved = [Aim(aim.frame, aim.value * turn + shift, aim.weight) for aim in aims]
    found = solved(path * turn + shift, moved, started)
    assert np.abs(found - solved(path, aims, started)).max() < 1e-6


def test_a_heading_alone_turns_evenly_and_keeps_all_steps():
    path = walk(200)
    zeta = solved(path, [Aim(200, np.radians(90), np.inf, is_heading=True)], False)
    assert zeta[-1].imag == pytest.approx(np.radians(90), abs=1e-12)
    assert np.abs(zeta.real).max() < 1e-12
    assert np.diff(zeta.imag).min() > -1e-12
    assert np.diff(zeta.imag).max() * FPS < np.radians(35)


def test_a_body_that_rests_turns_where_it_walks():
    path = np.concatenate([np.zeros(100), walk(100) - walk(100)[0]])
    zeta = solved(path, [Aim(200, np.radians(60), np.inf, is_heading=True)], False)
    assert zeta[80].imag < np.radians(10)


def test_a_waypoint_on_the_path_changes_nothing():
    path = walk(150)
    assert np.abs(solved(path, [Aim(90, path[90], np.inf), Aim(150, path[150], np.inf)], False)).max() < 1e-9


@pytest.mark.parametrize("is_heading", [True, False])
def test_weights_lead_from_nothing_to_all(is_heading):
    path = walk(150)
    value = 0.8 if is_heading else path[150] + 0.3j
    exact = solved(path, [Aim(150, value, np.inf, is_heading)], False)
    far, near = (solved(path, [Aim(150, value, weight, is_heading)], False) for weight in (1e-7, 1e7))
    assert np.abs(far).max() < 1e-5
    assert np.abs(near - exact).max() < 1e-5
    half = solved(path, [Aim(150, value, 1.0, is_heading)], False)
    if is_heading:
        assert half[150].imag == pytest.approx(0.4)
    else:
        assert abs(bent_path(path, half)[150] - path[150] - 0.15j) < 0.03


def test_aims_between_which_nothing_moves_are_one():
    path = np.concatenate([walk(100), np.full(20, walk(100)[-1])])
    goal = path[-1] + 0.2j
    found = solved(path, [Aim(105, goal, np.inf), Aim(115, goal, np.inf)], False)
    assert np.abs(bent_path(path, found)[[105, 115]] - goal).max() < 1e-9
    assert (
        bend(path, [Aim(105, goal, np.inf), Aim(115, goal + 1, np.inf)], FPS, np.full(121, 0.3), started=False) is None
    )
