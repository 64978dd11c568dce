"""Sessions of several looks."""

import pytest

from voa_core.estimates import Estimate
from voa_core.filtering import Belief
from voa_core.updating import update_estimate
from voa_evaluation.values.bench import Bench
from voa_evaluation.values.policies import NEAREST, RANDOM, VOA, VOA_EXACT
from voa_evaluation.values.several_looks import LOOKS, SESSION_WAYS, NextLook, SessionBench, _next, run_sessions


@pytest.fixture(scope="module")
def scene(bench: Bench) -> SessionBench:
    return SessionBench(bench, 8, 2)


def test_every_session_takes_all_looks_and_looks_help(scene: SessionBench) -> None:
    sessions = run_sessions(scene)
    assert set(sessions) == set(SESSION_WAYS)
    for way, own in sessions.items():
        assert len(own) == 8
        assert all([step.looks for step in steps] == list(range(LOOKS + 1)) for steps in own)
        assert all(step.taken == step.looks or way in (VOA, VOA_EXACT) for steps in own for step in steps)
        if way in (NEAREST, RANDOM):
            assert not any(step.repeated for steps in own for step in steps)
    voa = sessions[VOA]
    assert sum(steps[-1].achieved for steps in voa) > sum(steps[0].achieved for steps in voa) + 1.0


def test_true_poses_take_turns(scene: SessionBench) -> None:
    rows = [scene.row(session) for session in range(8)]
    assert [pose for pose, _ in rows] == [0, 1, 2, 3, 4, 5, 0, 1]
    assert len({row for _, row in rows}) == 8


def test_a_session_sees_one_scan_however_often_it_is_requested(scene: SessionBench) -> None:
    sensor = scene.bench.sensors[0]
    assert scene.evidence(1, sensor, 0) is scene.evidence(1, sensor, 0)
    assert (scene.evidence(1, sensor, 0).log_copies != scene.evidence(1, sensor, 1).log_copies).any()


def test_a_place_that_was_looked_from_is_worth_less(scene: SessionBench) -> None:
    bench = scene.bench
    estimate = Estimate.of(Belief.uniform(6))
    first = _next(bench, VOA, estimate, [], (1.0, 0.0), range(8))
    assert first is not None
    assert first.then is None
    assert first.gain is not None
    evidence = scene.evidence(0, bench.sensors[first.place], 0)
    after = update_estimate(estimate, evidence, bench.scenario.policy, 0).estimate
    second = _next(bench, VOA, after, [first.place], (1.0, 0.0), range(8))
    assert second is None or second.place != first.place
    assert _next(bench, RANDOM, after, [3], (1.0, 0.0), [3, 5, 1, 0, 2, 4, 6, 7]) == NextLook(5)


def test_a_known_pose_ends_the_session(bench: Bench) -> None:
    certain = Estimate.of(Belief.of([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]))
    for way in (VOA, VOA_EXACT):
        assert _next(bench, way, certain, [], (1.0, 0.0), range(8)) is None
