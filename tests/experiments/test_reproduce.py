"""The whole report, quick and on the generated samples: every section, nothing outside the file, numbers by key."""

import html
import json
import re

import pytest

from kinestitch.experiments import reproduce as r
from kinestitch.experiments.cost import slope
from kinestitch.experiments.dataset import load
from kinestitch.experiments.quality_table import METHODS
from kinestitch.experiments.stiffness import measured_law


@pytest.fixture(scope="module")
def report():
    return r.reproduce(None, quick=True)


@pytest.fixture(scope="module")
def written(report, tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    return {path.name: path for path in r.write_report(report, folder)}


def test_every_experiment_has_its_section(report):
    assert len(report.sections) == 12
    assert all(section.title and section.text for section in report.sections)
    assert report.note == r.SAMPLES_NOTE


def test_the_page_needs_nothing_beside_itself(written):
    text = written["report.html"].read_text(encoding="utf-8")
    assert html.escape(r.SAMPLES_NOTE) in text
    assert set(re.findall(r'src="([a-z:/+\-0-9]+)[;,]', text)) <= {"data:image/png", "data:video/mp4"}
    assert text.count("<h2") == 12
    assert ">nan<" not in text


def test_the_pdf_is_one(written):
    data = written["report.pdf"].read_bytes()
    assert data.startswith(b"%PDF")
    assert data.count(b"/Type /Page\n") + data.count(b"/Type /Page ") >= 4


def test_numbers_stand_under_their_keys(written):
    numbers = json.loads(written["results.json"].read_text(encoding="utf-8"))
    assert numbers["boundary_share_above_0.5"].keys() == numbers["branch_crossings_within"].keys() == {"samples"}
    assert 0 < numbers["boundary_share_above_0.5"]["samples"] <= 1
    assert numbers["flip_change_deg"]["centred"] < 1e-9 < 90 < numbers["flip_change_deg"]["principal"]
    assert numbers["quality_medians"]["samples"].keys() == METHODS.keys()
    assert set(numbers["verdicts"].values()) <= {
        "reproduced",
        "reproduced with limits",
        "not reproduced",
        "measured",
        "missing",
    }


def test_the_laplacian_adds_less_than_every_rival(report):
    medians = next(s for s in report.sections if "quality_medians" in s.numbers).numbers["quality_medians"]["samples"]
    ours = medians["laplacian"]["added acceleration"]
    assert all(row["added acceleration"] > ours for name, row in medians.items() if name != "laplacian")


@pytest.mark.parametrize("stiffness", [81.0, 1296.0, 1e4])
def test_the_law_of_reach(stiffness):
    reach, overshoot, remaining = measured_law(stiffness)
    assert reach == pytest.approx(4.2 * stiffness**0.25, abs=1.5)
    assert overshoot == pytest.approx(0.033, abs=0.001)
    assert remaining == pytest.approx(1 / (2 * 2**0.5 * stiffness**0.25), rel=0.02)


def test_slope_of_a_known_power():
    assert slope([(n, 1e-6 * n**1.5) for n in (100, 1000, 10_000, 100_000)]) == pytest.approx(1.5)


def test_samples_stand_in_where_a_folder_has_nothing(tmp_path):
    assert not load(tmp_path, "mixamo").real
    assert load(tmp_path, "bandai").name == "samples"
