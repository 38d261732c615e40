import numpy as np
import pytest
from recording_builders import data_file

from floornav_common.se2 import SE2
from grid_mapper.published_relations import published_errors
from grid_mapper.recordings.carmen_lines import parse_flaser, parse_robotlaser
from grid_mapper.recordings.log_entries import read_words
from grid_mapper.relations import Relation, load_relations, relation_errors

NS = 1_000_000_000
TRAJECTORY = [(NS, SE2(0, 0, 0)), (2 * NS, SE2(1, 0, np.pi / 2)), (3 * NS, SE2(1, 1, np.pi / 2))]


def test_a_perfect_trajectory_has_no_error_wherever_its_frame_lies():
    relations = [Relation(NS, 3 * NS, SE2(1, 1, np.pi / 2)), Relation(2 * NS, 3 * NS, SE2(1, 0, 0))]
    moved = [(t, SE2(5, -3, 1.0) @ pose) for t, pose in TRAJECTORY]
    errors = relation_errors(moved, relations, 0)
    np.testing.assert_allclose(errors.translations, 0.0, atol=1e-12)
    np.testing.assert_allclose(errors.rotations, 0.0, atol=1e-12)


def test_error_is_the_motion_left_over():
    errors = relation_errors(TRAJECTORY, [Relation(NS, 2 * NS, SE2(1.3, 0.4, np.pi / 2 - 0.1))], 0)
    assert errors.translations[0] == pytest.approx(0.5)
    assert errors.rotations[0] == pytest.approx(0.1)


def test_only_relations_near_a_pose_at_both_ends_are_used():
    relations = [
        Relation(NS + 2_000_000, 2 * NS, SE2(1, 0, 0)),
        Relation(NS + 2_000_001, 2 * NS, SE2(1, 0, 0)),
        Relation(NS, 9 * NS, SE2(1, 0, 0)),
    ]
    errors = relation_errors(TRAJECTORY, relations, 2_000_000)
    assert errors.relations == (relations[0],)
    assert errors.num_total == 3


def test_offset_is_added_to_the_trajectory():
    relation = Relation(11 * NS, 12 * NS, SE2(1, 0, np.pi / 2))
    assert len(relation_errors(TRAJECTORY, [relation], 0).relations) == 0
    errors = relation_errors(TRAJECTORY, [relation], 0, offset_ns=10 * NS)
    assert errors.translations[0] == pytest.approx(0.0, abs=1e-12)


def test_stamps_in_any_order_and_the_worst_first():
    relations = [Relation(NS, 2 * NS, SE2(1 + d, 0, np.pi / 2)) for d in (0.1, 0.3, 0.2)]
    errors = relation_errors(TRAJECTORY[::-1], relations, 0)
    assert [round(t, 6) for _, t, _ in errors.worst(2)] == [0.3, 0.2]


def test_a_bad_file_is_one_clear_line(tmp_path):
    path = tmp_path / "relations"
    for text, expected in (("1 2 3\n", "line 1"), ("# nothing\n", "no relation")):
        path.write_text(text)
        with pytest.raises(ValueError, match=expected):
            load_relations(path)


def test_intel_figures_of_the_published_poses_and_of_raw_odometry():
    relations = load_relations(data_file("intel-lab/intel.relations.gz"))
    log = data_file("intel-lab/intel_keyframes_rawodom_corrected.log.gz")
    lines = [parse_flaser(words, 80.0) for words in read_words(log).lines]
    raw = relation_errors([(ln.stamp_ns, ln.T_odom_base) for ln in lines], relations, 2_000_000)
    best = relation_errors([(ln.stamp_ns, ln.T_log_laser) for ln in lines], relations, 2_000_000)
    assert len(raw.relations) == len(best.relations) == 108
    assert np.mean(raw.translations) == pytest.approx(4.09, abs=0.01)
    assert np.degrees(np.mean(raw.rotations)) == pytest.approx(18.7, abs=0.1)
    assert np.mean(best.translations) == pytest.approx(0.041, abs=0.001)
    assert np.degrees(np.mean(best.rotations)) == pytest.approx(0.81, abs=0.01)


@pytest.mark.parametrize(
    ("log", "relations", "num_used", "trans_m", "rot_deg"),
    [("intel-lab/intel_posegraph.log.gz", "intel-lab/intel.relations.gz", 473, 0.037, 0.91),
     ("fr079/fr079_posegraph.log.gz", "fr079/fr079.relations.gz", 136, 0.043, 0.52)],
)  # fmt: skip
def test_figures_of_the_pose_graphs(log, relations, num_used, trans_m, rot_deg):
    words = [w for w in read_words(data_file(log)).lines if w[0] == "ROBOTLASER1"]
    poses = [(ln.stamp_ns, ln.T_odom_base) for ln in map(parse_robotlaser, words)]
    errors = relation_errors(poses, load_relations(data_file(relations)), 2_000_000)
    assert len(errors.relations) == num_used
    assert np.mean(errors.translations) == pytest.approx(trans_m, abs=0.001)
    assert np.degrees(np.mean(errors.rotations)) == pytest.approx(rot_deg, abs=0.01)


def test_fr079_figures_with_its_offset():
    relations = load_relations(data_file("fr079/fr079.relations.gz"))
    words = read_words(data_file("fr079/fr079_corrected.log.gz")).lines
    lines = [parse_flaser(w, 80.0) for w in words if w[0] == "FLASER"]
    poses = [(ln.stamp_ns, ln.T_log_laser) for ln in lines]
    errors = relation_errors(poses, relations, 100_000_000, 1_211_450_000_000)
    assert len(errors.relations) == pytest.approx(1638, abs=5)
    assert np.mean(errors.translations) == pytest.approx(0.059, abs=0.001)
    assert np.degrees(np.mean(errors.rotations)) == pytest.approx(0.70, abs=0.01)


def test_published_rows_are_of_the_files_that_they_are_of():
    of = {
        path: published_errors(load_relations(data_file(path)))
        for path in ("intel-lab/intel.relations.gz", "fr079/fr079.relations.gz")
    }
    graph = {path: rows[2] for path, rows in of.items()}
    assert [(r.method, r.mean, r.std) for r in graph.values()] == [
        ("graph mapping", 0.031, 0.026), ("graph mapping", 0.056, 0.042),
    ]  # fmt: skip


def test_of_other_relations_nothing_is_published():
    intel = [Relation(976_052_896_784_509_000 + k, NS, SE2(0, 0, 0)) for k in range(2984)]
    assert [row.mean for row in published_errors(intel)] == [0.220, 0.070, 0.031]
    assert published_errors(intel[:-1]) == published_errors(intel[1:]) == published_errors([]) == []
