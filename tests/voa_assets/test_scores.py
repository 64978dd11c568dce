"""Grasp scores of goblet and coupling: those in their scenarios come out of the simulation again."""

import math

import pytest

from voa_evaluation.grasp_scores import score_grasps
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.objects import named_object
from voa_msgs.scenarios import MeasuredScores

NOISE = Imperfections(object_xy_m=0.005, object_yaw_rad=math.radians(3.0))


@pytest.mark.parametrize("name", ["goblet", "coupling"])
def test_the_scores_are_the_measured_ones(name: str) -> None:
    target = named_object(name)
    scores = target.scenario.scores
    assert isinstance(scores, MeasuredScores)
    measured = score_grasps(target, scores.attempts, NOISE, seed=0)
    assert measured.successes == scores.successes
