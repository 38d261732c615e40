import numpy as np
from loop_builders import LOOSE, SURE, motion

from floornav_common.se2 import SE2
from grid_mapper.loop_candidates import loop_candidates, near_pairs
from grid_mapper.loop_config import LoopConfig

CONFIG = LoopConfig(min_way_m=5.0, reach_m=1.0)
ALIKE = np.zeros(20)
ALL = np.ones(20, bool)


def there_and_back(num=10, beside=0.4):
    """Return poses 1 m apart, out and back again beside them, and the way up to each."""
    out = [SE2(float(k), 0.0, 0.0) for k in range(num)]
    back = [SE2(float(k), beside, np.pi) for k in reversed(range(num))]
    poses = out + back
    steps = [a.between(b).distance for a, b in zip(poses, poses[1:], strict=False)]
    return poses, np.concatenate(([0.0], np.cumsum(steps)))


def chain(poses, cov=LOOSE):
    pairs = zip(poses, poses[1:], strict=False)
    return [motion(k, k + 1, a.between(b), cov=cov) for k, (a, b) in enumerate(pairs)]


def test_the_place_left_long_ago_is_a_candidate_and_the_way_just_driven_is_not():
    poses, ways = there_and_back()
    sure = np.diag([1e-3, 1e-3, 1e-4]) ** 2
    found = loop_candidates(poses, chain(poses, sure), ways, ALIKE, ALL, CONFIG)
    assert [c.reference for c in found] == [0]
    assert found[0].query == len(poses) - 1


def test_uncertainty_grows_with_the_way_and_shrinks_with_a_loop():
    poses, ways = there_and_back()
    edges = chain(poses)
    alone = loop_candidates(poses, edges, ways, ALIKE, ALL, CONFIG)[0]
    loop = motion(1, len(poses) - 2, poses[1].between(poses[-2]), is_loop=True, cov=SURE)
    tied = loop_candidates(poses, [*edges, loop], ways, ALIKE, ALL, CONFIG)[0]
    assert tied.sigma_m < 0.5 * alone.sigma_m and tied.sigma_rad < 0.5 * alone.sigma_rad


def test_a_known_chain_has_the_sum_of_its_variances():
    poses = [SE2(float(k), 0.0, 0.0) for k in range(4)]
    only_turns = np.diag([1e-9, 1e-9, 0.01]) ** 2
    ways = np.arange(4.0)
    config = LoopConfig(min_way_m=2.5, reach_m=10.0)
    found = loop_candidates(poses, chain(poses, only_turns), ways, ALIKE[:4], ALL[:4], config)[0]
    assert found.reference == 0
    assert np.isclose(found.sigma_rad, 0.01 * np.sqrt(3.0), rtol=1e-6)
    levers = np.array([0.5, 1.5, 2.5])
    assert np.isclose(found.sigma_m, 0.01 * np.hypot.reduce(levers), rtol=1e-6)


def test_what_is_far_by_more_than_its_uncertainty_is_none():
    poses, ways = there_and_back(beside=6.0)
    tight = np.diag([1e-3, 1e-3, 1e-4]) ** 2
    assert loop_candidates(poses, chain(poses, tight), ways, ALIKE, ALL, CONFIG) == []


def test_what_looks_different_is_left_out_only_where_the_graph_is_not_sure():
    poses, ways = there_and_back()
    different = np.where(np.arange(20) < 2, CONFIG.max_difference_m + 0.1, 0.0)
    sure = np.diag([1e-3, 1e-3, 1e-4]) ** 2
    vague = np.diag([0.2, 0.2, 1e-3]) ** 2
    assert loop_candidates(poses, chain(poses, sure), ways, different, ALL, CONFIG)
    found = loop_candidates(poses, chain(poses, vague), ways, different, ALL, CONFIG)
    assert [c.reference for c in found] == [2]
    assert [
        c.reference for c in loop_candidates(poses, chain(poses, vague), ways, ALIKE, ALL, CONFIG)
    ] == [0]


def test_near_pairs_come_both_ways():
    poses, ways = there_and_back()
    pairs = {(pair.query, pair.reference) for pair in near_pairs(poses, ways, ALL, CONFIG)}
    last = len(poses) - 1
    assert (0, last) in pairs and (last, 0) in pairs
    assert all(abs(ways[a] - ways[b]) > CONFIG.min_way_m for a, b in pairs)


def test_nothing_is_compared_with_a_node_without_its_scan():
    poses, ways = there_and_back()
    sure = np.diag([1e-3, 1e-3, 1e-4]) ** 2
    has_scan = np.arange(20) != 0
    found = loop_candidates(poses, chain(poses, sure), ways, ALIKE, has_scan, CONFIG)
    assert all(c.reference != 0 for c in found)
    pairs = near_pairs(poses, ways, has_scan, CONFIG)
    assert pairs and all(0 not in (pair.query, pair.reference) for pair in pairs)
