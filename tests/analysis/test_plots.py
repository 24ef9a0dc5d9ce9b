"""What the curves under a joint's curves show."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from kinestitch.analysis import plots
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis
from kinestitch.core.skeleton import Skeleton
from kinestitch.samples import sample
from kinestitch.solve.contacts import find_contacts, runs


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


def test_a_map_has_its_cuts_where_they_are_and_bars_where_feet_stand(drawn):
    costs = np.arange(7.0)[:, None] + np.arange(5.0)
    up, along = np.zeros((6, 2), dtype=bool), np.ones((4, 2), dtype=bool)
    up[1:3, 0] = up[5:, 0] = True
    plots.plot_costs(costs, "x.png", cuts=[(2, 3)], standing=(up, along))
    over, corner, shown, beside = drawn[0].axes[:4]
    assert not corner.patches
    (mark,) = shown.lines
    assert (mark.get_xdata()[0], mark.get_ydata()[0]) == (3, 1)  # the last frame shown is 1
    (picture,) = shown.images
    np.testing.assert_array_equal(picture.get_array(), costs[1:, :-1])
    assert picture.get_extent() == [-0.5, 3.5, -0.5, 5.5]
    bars = [(bar.get_y(), bar.get_height()) for bar in beside.patches if bar.get_height() > 0]
    assert bars == [(0.5, 2.0), (4.5, 1.0)]
    assert [bar.get_width() for bar in over.patches if bar.get_width() > 0] == [4.0, 4.0]
    plots.plot_costs(costs, "x.png")
    assert sum(len(axes.patches) for axes in drawn[1].axes[:4]) == 0


def test_a_map_without_differences_can_be_drawn(tmp_path):
    plots.plot_costs(np.ones((3, 4)), tmp_path / "x.png")
    assert (tmp_path / "x.png").stat().st_size > 1000


def test_contacts_are_bars_below_the_curves(drawn):
    walk = sample("walk")
    found = find_contacts(walk)
    plots.plot_joint(walk, 0, "x.png", contacts=found)
    curves, laplacian, feet = drawn[0].axes
    assert [label.get_text() for label in feet.get_yticklabels()] == [
        "left ankle", "left toe", "right ankle", "right toe",
    ]  # fmt: skip
    assert len(feet.collections) == 4
    for row, (bars, held) in enumerate(zip(feet.collections, found.held.T, strict=True)):
        corners = [path.vertices[:4] for path in bars.get_paths()]
        assert [(box[:, 0].min() + 0.5, box[:, 0].max() + 0.5) for box in corners] == runs(held)
        assert all(abs(box[:, 1].mean() - row) < 1e-9 for box in corners)
    assert feet.get_xlabel()
    assert not laplacian.get_xlabel()
    assert curves.get_xlim() == feet.get_xlim()
