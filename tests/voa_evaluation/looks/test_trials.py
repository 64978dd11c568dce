"""Trials: drops, scans and attempts depend on the seed and on names alone."""

import math
from dataclasses import replace

import numpy as np
import pytest

from voa_evaluation.looks.sensitivity import disturbed
from voa_evaluation.looks.setting import Setting, default_imperfections
from voa_evaluation.looks.trials import TrialBench, boxes, make_trial
from voa_fleet.world.objects import FleetObject


def test_a_drop_depends_on_names_and_seed_alone(mug: FleetObject) -> None:
    imperfections = default_imperfections()
    drop = make_trial(mug, "hinted", 3, imperfections, 7)
    assert drop == make_trial(mug, "hinted", 3, imperfections, 7)
    assert drop != make_trial(mug, "hinted", 4, imperfections, 7)
    assert drop != make_trial(mug, "hinted", 3, imperfections, 8)
    assert math.fsum(drop.belief) == pytest.approx(1.0)
    assert make_trial(mug, "uniform", 3, imperfections, 7).belief == pytest.approx([1 / 6] * 6)


def test_poses_are_drawn_from_the_belief(mug: FleetObject) -> None:
    imperfections = default_imperfections()
    drops = [make_trial(mug, "hinted", index, imperfections, 0) for index in range(400)]
    held = np.array([drop.belief[mug.poses.index(drop.drop.pose)] for drop in drops])
    # A pose that is drawn from b has sum(b^2) of it on average.
    expected = np.array([sum(share**2 for share in drop.belief) for drop in drops])
    assert held.mean() == pytest.approx(expected.mean(), abs=0.04)


def test_scans_share_their_chance_between_levels(mug: FleetObject) -> None:
    imperfections = default_imperfections()
    drop, sensor = make_trial(mug, "uniform", 0, imperfections, 0), mug.scenario.sensors[0]
    subject = TrialBench(mug, 0)
    scan = subject.scan(drop, sensor, imperfections)
    assert scan == TrialBench(mug, 0).scan(drop, sensor, imperfections)
    assert scan == subject.scan(drop, sensor, disturbed("clutter", 0.0, drop, Setting()))
    assert scan != subject.scan(drop, sensor, disturbed("robot_xy", 2.0, drop, Setting()))
    noisy = subject.scan(drop, sensor, replace(imperfections, range_noise_m=0.004))
    lost = [value == 0.0 for value in scan.ranges]
    assert lost == [value == 0.0 for value in noisy.ranges]


def test_fewer_boxes_are_the_first_of_more(mug: FleetObject) -> None:
    drop = make_trial(mug, "uniform", 0, default_imperfections(), 0)
    assert boxes(drop, 4, 0)[:2] == boxes(drop, 2, 0)
    assert all(0.13 <= math.hypot(*box.centre) <= 0.25 for box in boxes(drop, 4, 0))


def test_a_grasp_is_attempted_once_per_drop(mug: FleetObject) -> None:
    subject, drop = TrialBench(mug, 0), make_trial(mug, "uniform", 0, default_imperfections(), 0)
    assert subject.attempt(drop, "TD0") == subject.attempt(drop, "TD0")
    assert subject.attempts == 1
    assert subject.attempt(drop, "TD0") == TrialBench(mug, 0).attempt(drop, "TD0")
