"""Covariance and intervals of a straight line by hand; what is not determined is named."""

import numpy as np
import pytest

from floor_perception.fit_statistics import fit_statistics, numeric_jacobian

X = np.array([0.0, 1.0, 2.0, 3.0])
LINE = np.stack((np.ones(4), X), axis=1)


def test_a_line_through_four_points_has_the_textbooks_intervals() -> None:
    residuals = np.array([1.0, -2.0, 1.0, 0.0])
    found = fit_statistics(("offset", "slope"), np.array([3.0, 0.5]), residuals, LINE)
    # By hand: s^2 = 6 / 2; var(slope) = s^2 / 5; var(offset) = s^2 (1/4 + 1.5^2 / 5).
    assert found.dof == 2 and found.residual_sd == pytest.approx(3.0**0.5)
    assert np.diag(found.cov) == pytest.approx([3.0 * 0.7, 3.0 / 5.0])
    assert found.quantile == pytest.approx(4.3027, abs=1e-4)  # Student's t, 2 degrees of freedom
    assert found.interval("slope")[1] == pytest.approx(0.5 + 4.3027 * 0.6**0.5, abs=1e-3)


def test_a_function_of_the_parameters_carries_their_covariance() -> None:
    residuals = np.array([1.0, -2.0, 1.0, 0.0])
    found = fit_statistics(("offset", "slope"), np.array([3.0, 0.5]), residuals, LINE)
    at_middle = found.of(("y",), np.array([3.75]), np.array([[1.0, 1.5]]))
    assert at_middle.cov[0, 0] == pytest.approx(3.0 / 4.0)  # s^2 / N at the mean of x


def test_units_change_no_condition() -> None:
    a = fit_statistics(("a", "b"), np.zeros(2), np.ones(4), LINE)
    b = fit_statistics(("a", "b"), np.zeros(2), np.ones(4), LINE * (1.0, 1e6))
    assert a.condition == pytest.approx(b.condition)


def test_what_the_data_do_not_determine_is_named() -> None:
    twice = np.stack((np.ones(4), X, 2.0 * X), axis=1)
    with pytest.raises(ValueError, match="do not determine b, c"):
        fit_statistics(("a", "b", "c"), np.zeros(3), np.ones(4), twice)
    none = np.stack((np.ones(4), np.zeros(4)), axis=1)
    with pytest.raises(ValueError, match="do not determine b$"):
        fit_statistics(("a", "b"), np.zeros(2), np.ones(4), none)
    with pytest.raises(ValueError, match="2 measured values cannot determine 2"):
        fit_statistics(("a", "b"), np.zeros(2), np.ones(2), LINE[:2])


def test_numeric_jacobian_of_a_product() -> None:
    J = numeric_jacobian(lambda p: np.array([p[0] * p[1], p[0] ** 2]), np.array([2.0, 3.0]))
    assert np.allclose(J, [[3.0, 2.0], [4.0, 0.0]], atol=1e-6)
