import numpy as np
import pytest

from floornav_common.se2 import SE2
from grid_mapper.trajectory_metrics import (
    align,
    format_tum,
    load_tum,
    path_length,
    trajectory_errors,
)

NS = 1_000_000_000
TOL_M = 1e-9


def wandering(num: int = 50, seed: int = 0) -> list[tuple[int, SE2]]:
    rng = np.random.default_rng(seed)
    pose, track = SE2.identity(), []
    for i in range(num):
        track.append((976_052_890_244_111_000 + i * NS // 7, pose))
        pose = pose @ SE2(0.3, 0.0, float(rng.normal(0.0, 0.2)))
    return track


def noisy(track, seed=1):
    rng = np.random.default_rng(seed)
    return [(t, pose @ SE2(*rng.normal(0.0, 0.05, 3))) for t, pose in track]


def test_tum_reads_back_equal(tmp_path):
    (tmp_path / "t.tum").write_text(format_tum(wandering()))
    back = load_tum(tmp_path / "t.tum")
    assert [t for t, _ in back] == [t for t, _ in wandering()]
    for (_, a), (_, b) in zip(back, wandering(), strict=True):
        np.testing.assert_allclose(a.as_array(), b.as_array(), atol=1e-15, rtol=1e-15)


def test_tum_of_a_bad_file_is_one_clear_line(tmp_path):
    for text, expected in (("1 2 3\n", "line 1"), ("", "no pose")):
        (tmp_path / "t.tum").write_text(text)
        with pytest.raises(ValueError, match=expected):
            load_tum(tmp_path / "t.tum")


def test_where_the_frame_lies_does_not_matter():
    moved = [(t, SE2(4.0, -2.0, 2.5) @ pose) for t, pose in wandering()]
    errors = trajectory_errors(moved, wandering())
    assert errors.ate == pytest.approx(0.0, abs=TOL_M)
    assert errors.rpe == pytest.approx(0.0, abs=TOL_M)
    assert errors.num_compared == 50


def test_alignment_finds_a_known_motion():
    rng = np.random.default_rng(0)
    points = rng.normal(size=(20, 2))
    T = SE2(1.0, 2.0, -3.0)
    np.testing.assert_allclose(align(points, T @ points).as_array(), T.as_array(), atol=TOL_M)


def test_known_error_by_hand():
    truth = [(i * NS, SE2(float(i), 0.0, 0.0)) for i in range(4)]
    estimate = [(i * NS, SE2(1.1 * i, 0.0, 0.0)) for i in range(4)]
    errors = trajectory_errors(estimate, truth)
    assert errors.rpe == pytest.approx(0.1)
    assert errors.ate == pytest.approx(np.sqrt(np.mean([0.15**2, 0.05**2] * 2)))


def test_too_little_in_common_is_refused():
    late = [(t + 900 * NS, pose) for t, pose in wandering()]
    with pytest.raises(ValueError, match="only 0 poses"):
        trajectory_errors(late, wandering())


def test_way_is_the_sum_of_steps():
    assert path_length(wandering()) == pytest.approx(49 * 0.3)


def test_evo_reads_the_file_and_agrees(tmp_path):
    pytest.importorskip("evo", reason="evo is not installed")
    from evo.core import metrics, sync
    from evo.tools import file_interface

    (tmp_path / "a.tum").write_text(format_tum(noisy(wandering())))
    (tmp_path / "b.tum").write_text(format_tum(wandering()))
    estimate = file_interface.read_tum_trajectory_file(tmp_path / "a.tum")
    truth = file_interface.read_tum_trajectory_file(tmp_path / "b.tum")
    truth, estimate = sync.associate_trajectories(truth, estimate)
    rpe = metrics.RPE(metrics.PoseRelation.translation_part, 1, metrics.Unit.frames)
    rpe.process_data((truth, estimate))
    estimate.align(truth)
    ape = metrics.APE(metrics.PoseRelation.translation_part)
    ape.process_data((truth, estimate))
    ours = trajectory_errors(noisy(wandering()), wandering())
    assert ours.ate == pytest.approx(ape.get_statistic(metrics.StatisticsType.rmse), abs=1e-4)
    assert ours.rpe == pytest.approx(rpe.get_statistic(metrics.StatisticsType.rmse), abs=1e-6)
