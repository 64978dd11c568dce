"""Choices of the policies in a trial."""

import math
from dataclasses import replace

import numpy as np

from voa_evaluation.looks.choices import choices
from voa_evaluation.looks.requests import EstimateBefore, RegisteredObject
from voa_evaluation.looks.setting import default_imperfections
from voa_evaluation.looks.trials import make_trial
from voa_fleet.episodes.forecasts import Forecast
from voa_fleet.episodes.policies import POLICIES
from voa_fleet.world.objects import FleetObject
from voa_msgs.rankings import Look, Ranking

RANKED = "ESE"
RANKING = Ranking(
    version=None,
    definition="posterior",
    method="exact",
    precision="float64",
    expected_score_before=0.4,
    best_grasp_before="TD0",
    ranking=[],
    recommendation=Look(action="look", sensor=RANKED, net_value=0.1),
)


def test_policies_choose_what_they_say(mug: FleetObject) -> None:
    class Stored:
        sensors = mug.scenario.sensors

    count, poses = len(mug.scenario.sensors), len(mug.poses)
    likelihoods = np.full((count, poses, poses), 1.0 / poses)
    likelihoods[4] = np.eye(poses)
    visible = np.ones((count, poses))
    visible[6] = 5.0
    forecasts = {"beam": Forecast(visible, likelihoods)}
    registered = RegisteredObject({"beam": Stored()}, forecasts)  # type: ignore[dict-item]  # only sensors are read
    trial = make_trial(mug, "uniform", 0, default_imperfections(), 0)
    trial = replace(trial, bearing_rad=math.radians(155.0), random_look=2)
    before = EstimateBefore(RANKING, "TD0", 0.4, (0.0,) * count)
    assert before.look == RANKED
    chosen = choices(list(POLICIES), registered, "beam", trial, before)
    assert chosen == {
        "voa": RANKED,
        "entropy": "WSW",
        "beams": "SSE",
        "nearest": "WNW",
        "random": "NNW",
        "none": None,
    }
