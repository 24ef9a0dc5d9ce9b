"""Random seams between real clips: the centred chart never spins a limb."""

import os
from pathlib import Path

import numpy as np
import pytest

from kinestitch.core.rotation import quat_about_axis, quat_multiply
from kinestitch.experiments import seams
from kinestitch.solve.solved import Solved
from kinestitch.solve.stitch import solve_timeline
from kinestitch.testing import random_motion


def folder(name: str) -> Path:
    root = os.environ.get("KINESTITCH_DATA")
    if not root:
        pytest.skip("KINESTITCH_DATA, the folder of real clips, is not set")
    return Path(root) / name


@pytest.mark.parametrize("draw", [seams.random_cut, seams.random_replacement])
@pytest.mark.parametrize("name", seams.DATA_SETS)
def test_no_limb_spins_in_the_centred_chart(name, draw):
    found = seams.survey(folder(name), seams=200, draw=draw)
    assert len(found.qualities) == 200
    assert found.spins["centred"] == ()


def test_the_principal_chart_spins_limbs_that_rest_half_a_turn_away():
    assert len(seams.survey(folder("bandai"), seams=40).spins["principal"]) > 10


def one_cut() -> Solved:
    clips = {str(seed): random_motion(seed, frames=120) for seed in range(2)}
    return solve_timeline(seams.random_cut(clips, np.random.default_rng(0), seams.Seam()), clips)


def test_a_joint_made_to_spin_is_found():
    from dataclasses import replace

    solved = one_cut()
    (seam,) = solved.seams
    assert seams.find_spins(solved.motion, solved.placed, seam, 0) == []
    turn = quat_about_axis(0, np.clip(np.arange(solved.motion.frames) - seam.frame + 2, 0, 4) * np.pi / 2)
    rotations = solved.motion.rotations.copy()
    rotations[:, 2] = quat_multiply(rotations[:, 2], turn)
    (spin,) = seams.find_spins(replace(solved.motion, rotations=rotations), solved.placed, seam, 7)
    assert (spin.seam, spin.joint) == (7, solved.motion.skeleton.names[2])
    assert spin.speed > spin.allowed


def test_the_document_has_a_row_for_every_measure():
    solved = one_cut()
    quality = seams.seam_quality(solved, solved.seams[0])
    one = seams.Survey("mine", 2, 4, 30.0, (quality,), {"centred": (), "principal": (seams.Spin(0, "Arm", 9.0, 1.0),)})
    text = seams.as_markdown([one], [one], 1, 0)
    assert "| mine | cuts | 2 | 4 | 30 | 4 | 0 | 1 | 1 |" in text
    assert all(label in text for label, _, _ in seams._ROWS)
    assert f"{quality.price:.3g} / {quality.price:.3g}" in text
