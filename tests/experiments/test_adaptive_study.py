"""The study of automatic stiffness: on the samples as a whole, on made-up values where its verdict is read off."""

from __future__ import annotations

import numpy as np
import pytest

from kinestitch.edit.timeline import DEFAULT_SMOOTHING
from kinestitch.experiments import adaptive as a
from kinestitch.experiments import adaptive_page as page
from kinestitch.experiments.trade_off import Curve
from kinestitch.samples import SAMPLE_NAMES, sample


@pytest.fixture(scope="module")
def small() -> a.Study:
    clips = {name: sample(name, fps=30.0) for name in SAMPLE_NAMES}
    return a.study(clips, "samples", seams=6, seed=1)


def test_every_rule_is_measured_at_every_setting(small: a.Study):
    assert set(small.curves) == set(a.RULES)
    for rule, curve in small.curves.items():
        assert curve.settings == a.RULES[rule][0]
        assert set(curve.values) == set(a.MEASURES)
        for measure, values in curve.values.items():
            assert values.shape == (len(curve.settings), 6)
            asked = [s in a.DEFAULTS for s in curve.settings] if measure == "slide" else slice(None)
            assert np.isfinite(values[asked]).all()
        assert curve.values["smoothing"].max() <= 0.6


def test_a_smaller_share_adds_less_and_changes_more(small: a.Study):
    for rule in ("auto, whole body", "auto, by parts"):
        curve = small.curves[rule]
        assert (np.diff(curve.values["deviation"], axis=0) <= 1e-9).all()
        assert (curve.values["added"] <= np.array(curve.settings)[:, None] * 1.1 + 1e-9).mean() > 0.8


def test_parts_deviate_no_more_than_the_whole_body(small: a.Study):
    whole, parts = (small.curves[rule].values["deviation"] for rule in ("auto, whole body", "auto, by parts"))
    assert (parts.mean(axis=1) < whole.mean(axis=1)).all()


def made_up(fixed: list[float], deviation: list[float], auto: float, mean: float) -> dict[str, Curve]:
    def curve(name: str, settings: tuple[float, ...], added: list[float], moved: list[float]) -> Curve:
        values = {"added": np.outer(added, np.ones(4)), "deviation": np.outer(moved, np.ones(4))}
        return Curve(name, "s", settings, values)

    return {
        page.FIXED: curve(page.FIXED, (0.05, DEFAULT_SMOOTHING, 0.2), fixed, deviation),
        page.AUTO: curve(page.AUTO, (0.125,), [auto], [mean]),
    }


def test_the_best_fixed_one_is_read_off_between_two_settings():
    curves = made_up([1.0, 0.25, 0.04], [1.0, 2.0, 4.0], 0.5, 1.2)
    assert page.fixed_deviation(curves, "added", 0.25) == pytest.approx(2.0)
    assert page.fixed_deviation(curves, "added", 0.5) == pytest.approx(np.sqrt(2.0))
    assert page.fixed_deviation(curves, "added", 0.1) == pytest.approx(np.sqrt(8.0))
    assert np.isnan(page.fixed_deviation(curves, "added", 2.0))
    assert page.verdict(curves, page.AUTO) == [pytest.approx((0.125, 0.5, 1.2, np.sqrt(2.0)))]


@pytest.mark.parametrize(("mean", "told"), [(1.2, "**deviates less"), (1.6, "does **not** deviate less")])
def test_the_verdict_follows_the_figures(mean: float, told: str):
    assert told in page._sentence(made_up([1.0, 0.25, 0.04], [1.0, 2.0, 4.0], 0.5, mean))


def test_the_document_has_every_table(small: a.Study):
    text = page.as_markdown([[small, small], [small, small]], 6, 1)
    assert text.count("Both defaults") == 2
    for told in (
        "| both | auto, whole body |",
        "| samples | auto, by parts | 0.125 |",
        "over whole clips",
        "over all 12 seams",
    ):
        assert told in text
    assert "nan" not in text.split("Both defaults")[1].split("The fixed rule")[0]
