"""Mistakes in the numbers of a scenario: units, grasps that never succeed, a missing workspace."""

import math

import numpy as np

from voa_core.mistakes.mistake import Mistake, listed
from voa_core.scenario import Scenario

FARTHEST_M = 10.0
"""Largest coordinate of a table-top scene, metres; a larger one is probably in millimetres."""


def mistakes_of_values(scenario: Scenario) -> list[Mistake]:
    """Find angles in degrees, lengths in millimetres, grasps that never succeed, and a missing workspace."""
    return _degrees(scenario) + _millimetres(scenario) + _useless_grasps(scenario) + _no_workspace(scenario)


def _degrees(scenario: Scenario) -> list[Mistake]:
    wrong = [sensor for sensor in scenario.sensors if abs(sensor.yaw_rad) > 2.0 * math.pi]
    mistakes = []
    if wrong:
        first = wrong[0]
        mistakes.append(
            Mistake(
                "angle-in-degrees",
                f"the yaw_rad of {listed('sensor', [sensor.name for sensor in wrong])} is more than a turn "
                f"({first.yaw_rad:g} rad at {first.name!r}): is it in degrees? {first.yaw_rad:g} degrees are "
                f"{math.radians(first.yaw_rad):.4g} rad",
                sensors=tuple(sensor.name for sensor in wrong),
            )
        )
    grid = scenario.lidar.grid
    turns = grid.beams * abs(grid.angle_increment) / (2.0 * math.pi)
    if turns > 1.0 + 1.5 / grid.beams * turns:
        mistakes.append(
            Mistake(
                "angle-in-degrees",
                f"the lidar's {grid.beams} beams, {grid.angle_increment:g} rad apart, go round {turns:.3g} times: "
                "is angle_increment in degrees?",
            )
        )
    return mistakes


def _millimetres(scenario: Scenario) -> list[Mistake]:
    poses = scenario.poses
    far_poses: tuple[str, ...] = ()
    if poses.positions is not None:
        far_poses = tuple(poses.names[p] for p in np.flatnonzero(np.abs(poses.positions).max(axis=1) > FARTHEST_M))
    far_sensors = tuple(
        sensor.name
        for sensor in scenario.sensors
        if max(abs(sensor.x), abs(sensor.y), abs(sensor.height_m or 0.0)) > FARTHEST_M
    )
    what = [listed("pose", far_poses)] * bool(far_poses) + [listed("sensor", far_sensors)] * bool(far_sensors)
    if abs(scenario.lidar.height_m or 0.0) > FARTHEST_M:
        what.append("the lidar (height_m)")
    if scenario.workspace is not None and max(map(abs, scenario.workspace.min + scenario.workspace.max)) > FARTHEST_M:
        what.append("the workspace")
    if not what:
        return []
    detail = (
        f"coordinates of {', '.join(what)} are more than {FARTHEST_M:g} m from the origin: are they in millimetres? "
        "Lengths are metres, in a frame whose origin is near the table"
    )
    return [Mistake("length-in-millimetres", detail, far_poses, far_sensors)]


def _useless_grasps(scenario: Scenario) -> list[Mistake]:
    useless = [scenario.table.names[x] for x in np.flatnonzero(scenario.table.scores.max(axis=1) == 0.0)]
    if not useless:
        return []
    detail = f"at no pose {listed('grasp', useless)} can succeed: leave it out, or check its row of scores"
    return [Mistake("grasp-never-succeeds", detail)]


def _no_workspace(scenario: Scenario) -> list[Mistake]:
    if scenario.workspace is not None:
        return []
    detail = (
        "there is no workspace: walls and people that the lidar sees count as the object. Give the box of the table "
        "in which the object can be"
    )
    return [Mistake("no-workspace", detail)]
