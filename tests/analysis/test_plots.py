"""What the curves under a joint's curves show."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from kinestitch.analysis import plots
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis
from kinestitch.core.skeleton import Skeleton


@pytest.fixture
def drawn(monkeypatch) -> list[Figure]:
    figures: list[Figure] = []
    monkeypatch.setattr(plots, "save_figure", lambda figure, path: figures.append(figure))
    return figures


def joint(degrees: np.ndarray) -> Motion:
    rotations = quat_about_axis(1, np.radians(degrees))[:, None]
    return Motion(Skeleton(("Hips",), (-1,), [[0, 0, 0]]), np.zeros((len(degrees), 1, 3)), rotations, 30.0)


def test_the_lower_panel_shows_the_size_of_the_second_difference(drawn):
    time = np.arange(30.0)
    plots.plot_joint(joint(0.05 * time**2), 0, "x.png")
    (line,) = drawn[0].axes[1].lines
    np.testing.assert_allclose(line.get_ydata(), [0.0, *[0.1] * 28, 0.0], atol=1e-9)


def test_a_constant_turn_has_none(drawn):
    plots.plot_joint(joint(2.0 * np.arange(30.0)), 0, "x.png")
    (line,) = drawn[0].axes[1].lines
    np.testing.assert_allclose(line.get_ydata(), 0.0, atol=1e-9)


@pytest.mark.parametrize("frames", [1, 30])
def test_a_joint_that_holds_still_has_axes_that_can_be_read(drawn, frames):
    plots.plot_joint(joint(np.full(frames, 10.0)), 0, "x.png")
    for panel, least in zip(drawn[0].axes, (0.9, 0.01), strict=True):
        low, high = panel.get_ylim()
        assert least <= high - low < 10
        assert all(line.get_marker() == ("o" if frames == 1 else "None") for line in panel.lines)
    low, high = drawn[0].axes[0].get_xlim()
    assert high - low >= 1
