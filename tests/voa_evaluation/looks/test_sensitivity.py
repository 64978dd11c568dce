"""Disturbances: their sizes, and the uncertainty that a robot states."""

from voa_evaluation.looks.sensitivity import disturbed, stated_at
from voa_evaluation.looks.setting import Setting, default_imperfections
from voa_evaluation.looks.trials import make_trial
from voa_fleet.world.objects import FleetObject


def test_what_is_stated_is_what_goes_wrong(mug: FleetObject) -> None:
    drop = make_trial(mug, "uniform", 0, default_imperfections(), 0)
    assert disturbed("robot_xy", 3.0, drop, Setting()).robot_xy_m == stated_at("robot_xy", 3.0).xy_m == 0.03
    assert disturbed("robot_yaw", 3.0, drop, Setting()).robot_yaw_rad == stated_at("robot_yaw", 3.0).yaw_rad
    assert disturbed("range_noise", 10.0, drop, Setting()).range_noise_m == 0.01
