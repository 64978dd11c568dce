"""A robot like a TurtleBot3 with a lidar on top; it is moved by setting its pose and touches nothing."""

from typing import Any

import mujoco

from voa_fleet.world.groups import ROBOT

RADIUS_M = 0.09
"""Radius of the robot's base."""
LIDAR_RADIUS_M = 0.035
HEIGHT_M = 0.16
"""Height of the scan plane over the floor; the scenario's lidar height is counted from the table's top instead."""


def add_robot(spec: mujoco.MjSpec, name: str, lidar_height_m: float) -> None:
    """Add a robot as a mocap body whose frame is its lidar's: origin in the scan plane, x along beam 0."""
    robot = spec.worldbody.add_body(name=name, mocap=True, pos=[1.0, 0.0, lidar_height_m])
    parts: list[tuple[Any, list[float], list[float], list[float]]] = [
        (mujoco.mjtGeom.mjGEOM_CYLINDER, [RADIUS_M, 0.035, 0.0], [0.0, 0.0, -0.115], [0.20, 0.22, 0.25, 1.0]),
        (mujoco.mjtGeom.mjGEOM_CYLINDER, [0.07, 0.03, 0.0], [0.0, 0.0, -0.05], [0.30, 0.32, 0.35, 1.0]),
        (mujoco.mjtGeom.mjGEOM_CYLINDER, [LIDAR_RADIUS_M, 0.018, 0.0], [0.0, 0.0, 0.0], [0.05, 0.05, 0.06, 1.0]),
        (mujoco.mjtGeom.mjGEOM_BOX, [0.012, 0.006, 0.004], [LIDAR_RADIUS_M, 0.0, 0.0], [0.90, 0.62, 0.0, 1.0]),
    ]
    for shape, size, position, colour in parts:
        robot.add_geom(type=shape, size=size, pos=position, rgba=colour, contype=0, conaffinity=0, group=ROBOT)
