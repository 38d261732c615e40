"""Lines fitted to echoes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from view_builders import drive_along, views

from grid_mapper.bayes_config import BayesConfig
from grid_mapper.pane_lines import find_lines, fit_line, lies_on

TOL_M, TOL_RAD = 1e-3, 1e-3
UP = np.pi / 2.0


def test_parallel_echoes_are_a_line_at_their_range():
    (line,) = find_lines(views(*drive_along(np.arange(0.0, 1.0, 0.1), 0.0, 1.5)), BayesConfig())
    assert line.theta == pytest.approx(UP, abs=TOL_RAD)
    assert line.rho == pytest.approx(1.5, abs=TOL_M)
    assert (line.low, line.high) == (pytest.approx(-0.9, abs=0.01), pytest.approx(0.0, abs=0.01))


def test_a_pane_heard_from_both_sides_is_one_line():
    xs = np.arange(0.0, 1.0, 0.1)
    both = views(*drive_along(xs, 0.0, 1.5), *drive_along(xs, 2.6, 1.1, -UP))
    (line,) = find_lines(both, BayesConfig())
    assert line.rho == pytest.approx(1.5, abs=TOL_M)
    assert len(line.echoes) == len(both)


def test_two_panes_at_a_corner_are_two_lines():
    at_left = drive_along(np.arange(0.0, 1.0, 0.1), 0.0, 1.5)
    ahead = [(float(x), 0.0, 0.0, 3.0 - float(x)) for x in np.arange(0.0, 1.0, 0.1)]
    lines = find_lines(views(*at_left, *ahead), BayesConfig())
    found = sorted((line.theta, line.rho) for line in lines)
    assert np.allclose(found, [(0.0, 3.0), (UP, 1.5)], atol=2e-3)


def test_echoes_that_no_line_joins_are_no_pane():
    rng = np.random.default_rng(0)
    rows = [(x, 0.0, UP, float(rng.uniform(0.5, 4.0))) for x in np.arange(0.0, 2.0, 0.1)]
    assert find_lines(views(*rows), BayesConfig()) == []


def test_echoes_from_one_place_are_no_pane():
    rows = [(0.0, 0.0, UP + 0.01 * k, 1.5) for k in range(10)]
    assert find_lines(views(*rows), BayesConfig()) == []


def test_far_echoes_count_for_less_as_in_equation_1():
    near, far = (drive_along(np.arange(0.0, 0.8, 0.1), 0.0, r) for r in (1.9, 4.0))
    assert len(find_lines(views(*near), BayesConfig(trusted_m=2.0))) == 1
    assert find_lines(views(*far), BayesConfig(trusted_m=2.0)) == []


def test_an_explained_echo_begins_no_line():
    rows = views(*drive_along(np.arange(0.0, 1.0, 0.1), 0.0, 1.5))
    rows["open"] = 0
    assert find_lines(rows, BayesConfig()) == []


@pytest.mark.parametrize(("r", "fit"), [(1.5, 2), (1.7, 0), (None, 0)])
def test_only_an_echo_at_the_right_range_lies_on_a_line(r, fit):
    (view,) = views((0.0, 0.0, UP, r))
    assert lies_on(view, UP, 0.0, 1.0, 1.5, 0.02, 0.01) == fit


def test_an_echo_whose_cone_lacks_the_normal_lies_on_no_line():
    (view,) = views((0.0, 0.0, UP + 0.25, 1.5))
    assert lies_on(view, UP, 0.0, 1.0, 1.5, 0.02, 0.01) == 0


@given(
    theta=st.floats(-3.1, 3.1), rho=st.floats(-5.0, 5.0),
    off=st.floats(-0.05, 0.05), shift=st.floats(-0.05, 0.05),
)  # fmt: skip
def test_a_fit_finds_the_line_that_exact_echoes_came_from(theta, rho, off, shift):
    n, way = np.array([np.cos(theta), np.sin(theta)]), np.array([-np.sin(theta), np.cos(theta)])
    rows = []
    for k in range(8):
        d = 1.0 + 0.1 * k * (-1) ** k
        x, y = (rho - d) * n + 0.2 * k * way
        rows.append((x, y, theta, abs(d)))
    guess, place = theta + off, rho + shift
    for _ in range(4):
        guess, place = fit_line(views(*rows), np.arange(8), guess, place, 0.7)
    assert guess == pytest.approx(theta, abs=TOL_RAD)
    assert place == pytest.approx(rho, abs=5 * TOL_M)
