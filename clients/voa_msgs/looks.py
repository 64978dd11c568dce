"""Looks: the places that a session has been looked from, and looks that are under way."""

from datetime import datetime
from typing import Self

from pydantic import model_validator

from voa_msgs import examples
from voa_msgs.base import Message, Name
from voa_msgs.examples import exemplified
from voa_msgs.geometry import SensorPose, UncertainSensorPose


class Place(Message):
    """Place from which looks were taken: either `sensor` or `sensor_pose`.

    Looks from one place share the errors of the object's and the lidar's pose, so they are weighed together.
    """

    sensor: str | None
    """Name of the sensor configuration; null: `sensor_pose` states where."""
    sensor_pose: SensorPose | None
    """Pose of the lidar at the first look; later looks within 2 cm, 2 degrees and 1 cm of height share the place; null:
    `sensor` states where."""
    looks: int
    """Number of accepted looks from there."""


class AtPlace(Message):
    """Request with the place of the lidar: exactly one of `sensor` and `sensor_pose`."""

    sensor: Name | None = None
    """Name of the sensor configuration where the lidar stands; null: `sensor_pose` states where."""
    sensor_pose: UncertainSensorPose | None = None
    """Pose of the lidar; null: `sensor` states where."""

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        if (self.sensor is None) == (self.sensor_pose is None):
            raise ValueError("exactly one of 'sensor' and 'sensor_pose' is expected")
        return self


class LookAnnouncement(AtPlace):
    """Announcement of a look that is under way, with its place: exactly one of `sensor` and `sensor_pose`."""

    model_config = exemplified(examples.LOOK)

    robot: Name | None = None
    """Name of the robot that takes the look, for people and for keys that are bound to robots; null: not stated."""


class AnnouncedLook(Message):
    """Announced look that is under way: either `sensor` or `sensor_pose`."""

    id: str
    """Identifier of the announcement."""
    sensor: str | None
    """Name of the sensor configuration; null: `sensor_pose` states where."""
    sensor_pose: UncertainSensorPose | None
    """Pose of the lidar; null: `sensor` states where."""
    robot: str | None
    """Name of the robot that takes the look; null: not stated."""
    expires_at: datetime
    """Time at which the announcement ends by itself, UTC; a scan from the place, and a deletion, end it before."""
