"""Robots: the lidar of each robot with its heading and the uncertainty of its pose."""

import math

from voa_msgs.geometry import UncertainSensorPose
from voa_scene.colours import VERMILION
from voa_scene.measures import Measures
from voa_scene.rotations import about_z
from voa_scene.shapes import AnyShape, Cylinder, Polyline, Text, Vector
from voa_scene.views import RobotPlace

_RADIUS_M = 0.035
_HEIGHT_M = 0.04
_CIRCLE = 32
_SIGMAS = 2.0
_ABOVE_M = 0.003


def robot_shapes(robot: RobotPlace, lidar_height_m: float, measures: Measures) -> list[AnyShape]:
    """Make a robot's lidar, the direction of its beam 0, its name, and two standard deviations of its pose.

    Args:
        robot: with the pose of its lidar.
        lidar_height_m: height of the scan plane if the pose does not state one, metres.
        measures: of the scenario.
    """
    place = robot.place
    height = place.height_m if place.height_m is not None else lidar_height_m
    length = 0.2 * measures.reach
    shapes: list[AnyShape] = [
        Cylinder(
            group="robot",
            name=robot.name,
            label=f"{robot.name}: x {place.x:.3f} m, y {place.y:.3f} m, yaw {math.degrees(place.yaw_rad):.0f}°",
            position=(place.x, place.y, height),
            radius=_RADIUS_M,
            height=_HEIGHT_M,
            colour=VERMILION,
        ),
        Polyline(
            group="robot",
            name=f"{robot.name} heading",
            position=(place.x, place.y, height),
            rotation=about_z(place.yaw_rad),
            points=((0.0, 0.0, 0.0), (length, 0.0, 0.0)),
            colour=VERMILION,
        ),
        Text(
            group="robot",
            name=f"{robot.name} name",
            text=robot.name,
            position=(place.x, place.y, height + _HEIGHT_M + 0.05 * measures.reach),
            size=0.06 * measures.reach,
            colour=VERMILION,
        ),
    ]
    return shapes + _uncertainty(robot.name, place, length)


def _uncertainty(name: str, place: UncertainSensorPose, length: float) -> list[AnyShape]:
    """Circle of two standard deviations of the position, and a wedge of two of the yaw, on the table."""
    if place.std is None:
        return []
    shapes: list[AnyShape] = []
    radius = _SIGMAS * place.std.xy_m
    if radius > 0.0:
        circle = (math.tau * step / _CIRCLE for step in range(_CIRCLE))
        shapes.append(
            Polyline(
                group="robot",
                name=f"{name} position",
                label=f"{name}: position within {100.0 * radius:.1f} cm (two standard deviations)",
                position=(place.x, place.y, _ABOVE_M),
                points=tuple((radius * math.cos(angle), radius * math.sin(angle), 0.0) for angle in circle),
                closed=True,
                colour=VERMILION,
            )
        )
    half = _SIGMAS * place.std.yaw_rad
    if half > 0.0:
        sides: tuple[Vector, ...] = (
            (length * math.cos(half), length * math.sin(half), 0.0),
            (0.0, 0.0, 0.0),
            (length * math.cos(half), -length * math.sin(half), 0.0),
        )
        shapes.append(
            Polyline(
                group="robot",
                name=f"{name} yaw",
                label=f"{name}: yaw within {math.degrees(half):.1f}° (two standard deviations)",
                position=(place.x, place.y, _ABOVE_M),
                rotation=about_z(place.yaw_rad),
                points=sides,
                colour=VERMILION.faded(0.7),
            )
        )
    return shapes
