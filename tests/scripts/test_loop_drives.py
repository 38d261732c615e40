import numpy as np

from experiments.corridor_loop import ring_laps
from experiments.loop_drives import NEAR_M, _errors, _revisits
from floornav_common.se2 import SE2

NUM = 40


def test_revisits_are_of_another_lap_and_near():
    truth = ring_laps(8, np.pi, 3, NUM).truth
    lap = len(truth) // 2
    pairs = _revisits(truth)
    assert len(pairs) > 5
    for i, j in pairs:
        assert abs(i - j) >= lap // 3
        assert truth[i].between(truth[j]).distance < NEAR_M


def test_the_truth_has_no_error_wherever_it_lies():
    truth = ring_laps(8, np.pi, 3, NUM).truth
    moved = [SE2(3.0, 1.0, 0.7) @ pose for pose in truth]
    errors = _errors(truth, moved)
    assert max(errors.values()) < 1e-9


def test_a_second_lap_that_lies_off_shows_as_revisit_error():
    truth = ring_laps(8, np.pi, 3, NUM).truth
    lap = len(truth) // 2
    off = [*truth[:lap], *(SE2(0.5, 0.0, 0.0) @ pose for pose in truth[lap:])]
    assert 0.3 < _errors(truth, off)["revisit_m"] <= 0.5 + 1e-9
