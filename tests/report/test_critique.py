"""Pictures of a diagnosis: what they show is what was hidden, and the same input gives the same bytes."""

import numpy as np
import pytest
from arms import SCARA, TORQUE_NOISE, make_log, make_model, multisine, planar_torque, white

from chebid.critique import candidate_kinds, refine
from chebid.estimators import Problem
from chebid.report.critique import diagnosis_figure, ladder_figure, strip_figure
from chebid.report.residuals import Errors

SIZE, WAVES = 0.2, 5.0  # of the torque ripple that is hidden on the second joint: N.m, 1/rev


@pytest.fixture(scope="module")
def refinement():
    rng = np.random.default_rng(7)
    motion = multisine(7, 20.0)
    tau = planar_torque(motion) + white(rng, motion.q.shape, TORQUE_NOISE)
    tau[:, 1] += SIZE * np.cos(WAVES * motion.q[:, 1])
    log = make_log(motion.t, motion.q + white(rng, motion.q.shape, 5e-5), tau)
    return refine(Problem(make_model(SCARA), (log,)), candidate_kinds()[0])


@pytest.fixture(scope="module")
def errors(refinement) -> Errors:
    return Errors(refinement.steps[0].diagnosis)


def test_the_map_shows_the_hidden_torque(errors):
    """Cells follow the ripple, which no parameter of the model takes up; those of the other joint are noise."""
    found = errors.map(1)
    q = (found.q[1:] + found.q[:-1]) / 2
    column = np.nanmean(found.mean, axis=0)
    assert np.corrcoef(column, np.cos(WAVES * q))[0, 1] > 0.9
    assert 0.5 * SIZE < found.scale < 2 * SIZE
    other = errors.map(0)
    assert np.nanmean(np.abs(other.mean)) < 0.25 * other.scale, "noise stays pale"


def test_levels_of_colour_keep_the_sign_and_the_range(errors):
    found = errors.map(1)
    assert np.abs(found.levels).max() == 8
    strong = np.abs(np.nan_to_num(found.mean)) > found.scale / 8
    np.testing.assert_array_equal(np.sign(found.levels)[strong], np.sign(found.mean)[strong])


def test_the_profile_over_q_is_the_ripple(errors):
    found = errors.profile(1, "q")
    expected = SIZE * np.cos(WAVES * found.x)
    # the model's own columns take up a part of it, and a bin is a tenth of the range wide
    assert np.corrcoef(found.mean, expected)[0, 1] > 0.9
    assert np.all(np.diff(found.x) > 0) and np.all(found.spread > 0)
    assert errors.profile(1, "no such variable") is None


def titles(figure) -> list[str]:
    return [axis.get_title(loc="left") for axis in figure.axes if axis.get_title(loc="left")]


def test_the_strip_is_four_pictures(refinement):
    figure = strip_figure(refinement.steps[0].diagnosis, refinement)
    assert titles(figure) == ["1  compare", "2  where q2 fails", "3  candidates", "4  the error falls"]
    labels = [label.get_text() for axis in figure.axes for label in axis.get_yticklabels()]
    assert "torque_ripple:q2" in labels


def test_the_diagnosis_shows_every_joint_and_three_answers(refinement):
    figure = diagnosis_figure(refinement.steps[0].diagnosis)
    wanted = ["where q1 fails", "where q2 fails", "worst regions", "on what the error depends", "candidates"]
    assert titles(figure) == wanted
    for axis in figure.axes:
        assert all(np.isfinite(axis.get_xlim())) and all(np.isfinite(axis.get_ylim()))


def test_where_nothing_is_missing_pictures_say_so(refinement):
    assert refinement.last.diagnosis.verdict.status == "nothing_missing"
    figure = diagnosis_figure(refinement.last.diagnosis)
    assert sum(text.get_text() == "nothing stands out" for axis in figure.axes for text in axis.texts) >= 1


def test_the_ladder_falls_to_the_floor(refinement):
    (axis,) = ladder_figure(refinement).axes
    lines = {line.get_label(): line.get_ydata() for line in axis.get_lines()}
    ratio = [step.estimate.residual["q2"].ratio for step in refinement.steps]
    np.testing.assert_array_equal(lines["q2"], ratio)
    assert len(axis.get_xticklabels()) == len(refinement.steps)


def test_the_same_bytes_twice(refinement, tmp_path):
    for name in ("one.png", "two.png"):
        strip_figure(refinement.steps[0].diagnosis, refinement).savefig(tmp_path / name)
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()
