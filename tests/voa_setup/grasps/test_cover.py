import numpy as np

from voa_setup.grasps.cover import Ranked, choose, thin


def ranked(scores: list[list[float]], features: list[list[float]] | None = None) -> Ranked:
    table = np.array(scores, dtype=np.float64)
    return Ranked(
        table, np.zeros(len(table)), np.array(features) if features else np.arange(float(len(table)))[:, None]
    )


def test_poses_are_covered_by_what_adds_most_first() -> None:
    scores = [[0.9, 0.0, 0.0], [0.8, 0.8, 0.0], [0.0, 0.0, 0.9], [0.7, 0.7, 0.0]]
    assert choose(ranked(scores), np.array([0.3, 0.3, 0.4]), 2) == [1, 2]


def test_a_pose_that_is_likelier_comes_first() -> None:
    scores = [[0.9, 0.0], [0.0, 0.9]]
    assert choose(ranked(scores), np.array([0.2, 0.8]), 2) == [1, 0]


def test_grasps_that_add_nothing_are_chosen_by_how_much_they_differ() -> None:
    scores = [[0.9], [0.89], [0.85], [0.6]]
    features = [[0.0], [0.05], [0.9], [0.2]]
    assert choose(ranked(scores, features), np.array([1.0]), 3) == [0, 2, 3]


def test_grasps_that_work_nowhere_are_not_listed() -> None:
    assert choose(ranked([[0.9], [0.1], [0.0]]), np.array([1.0]), 3) == [0]
    assert choose(ranked([[0.0]]), np.array([1.0]), 3) == []


def test_merits_decide_between_equal_scores() -> None:
    table = Ranked(np.array([[0.9], [0.9]]), np.array([0.0, 0.1]), np.zeros((2, 1)))
    assert choose(table, np.array([1.0]), 1) == [1]


def test_thinning_keeps_the_best_and_those_that_differ() -> None:
    features = np.array([[0.0], [0.01], [1.0], [0.5]])
    assert thin(np.array([0.9, 1.0, 0.8, 0.8]), features, 3) == [1, 2, 3]
    assert thin(np.ones(2), np.zeros((2, 1)), 5) == [0, 1]
