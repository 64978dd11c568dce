"""The lidar: exact ranges by MuJoCo's ray caster, then the faults of a small spinning lidar.

Rays meet the triangles of the object's mesh, the arm, the clutter and the table; never the solids that stand in for
the object in contacts, nor the robots.
"""

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from voa_assets import lidar_presets
from voa_fleet.errors import InvalidObject, UnknownName
from voa_fleet.world.frames import Floats
from voa_fleet.world.groups import SEEN
from voa_fleet.world.imperfections import PACKET_BEAMS, Imperfections
from voa_fleet.world.scene import World
from voa_msgs.geometry import SensorPose
from voa_msgs.lidars import Lidar
from voa_msgs.sessions import Scan

REVOLUTION_S = 0.2
"""An LDS-01 turns at 5 Hz."""
_NOTHING = np.inf


@dataclass(frozen=True)
class LidarGeometry:
    """Beams and limits of a lidar.

    Attributes:
        angle_min, angle_increment: radians, counter-clockwise from the sensor's +x.
        range_min, range_max: metres.
    """

    beams: int
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    height_m: float

    @property
    def angles(self) -> Floats:
        """Of every beam, (beams,), radians."""
        return self.angle_min + self.angle_increment * np.arange(self.beams, dtype=np.float64)


def lidar_geometry(told: Lidar) -> LidarGeometry:
    """What a scenario says of its lidar, with its preset's values where it says nothing.

    Raises:
        UnknownName: there is no such preset.
        InvalidObject: something is said neither by the scenario nor by a preset.
    """
    presets = lidar_presets()
    if told.preset is not None and told.preset not in presets:
        raise UnknownName("lidar preset", told.preset, list(presets))
    values = {} if told.preset is None else presets[told.preset]
    values = values | told.model_dump(exclude_none=True)
    needed = ("beams", "angle_min", "angle_increment", "range_min", "range_max", "height_m")
    absent = [name for name in needed if name not in values]
    if absent:
        raise InvalidObject(f"lidar: expected {absent[0]}, got none")
    return LidarGeometry(**{name: values[name] for name in needed})


def true_ranges(world: World, data: mujoco.MjData, lidar: LidarGeometry, pose: SensorPose) -> Floats:
    """What a lidar without faults would measure, (beams,) metres; inf where nothing is within `range_max`.

    Args:
        world: the world.
        data: its state; positions of the bodies must be up to date (`mj_kinematics`).
        lidar: the beams.
        pose: the lidar's own; its height, if it has one, wins over the lidar's.
    """
    heading = pose.yaw_rad + lidar.angles
    directions = np.column_stack([np.cos(heading), np.sin(heading), np.zeros(lidar.beams)]).ravel()
    place = np.array([pose.x, pose.y, lidar.height_m if pose.height_m is None else pose.height_m])
    hit = np.zeros(lidar.beams, dtype=np.int32)
    ranges = np.zeros(lidar.beams)
    mujoco.mj_multiRay(
        world.model,
        data,
        place,
        directions,
        np.array(SEEN, dtype=np.uint8),
        1,
        -1,
        hit,
        ranges,
        None,
        lidar.beams,
        mujoco.mjMAXVAL,
    )
    # The ray caster's own limit leaves out whole geometries, it does not shorten rays.
    return np.where((hit >= 0) & (ranges >= 0.0) & (ranges <= lidar.range_max), ranges, _NOTHING)


def with_faults(ranges: Floats, lidar: LidarGeometry, flaws: Imperfections, rng: np.random.Generator) -> Floats:
    """What an LDS-01's driver would publish for these true ranges: 0 where nothing came back, for any reason.

    The same number of random numbers is drawn whatever the ranges are, so that two worlds that differ in one thing
    err alike in all else.
    """
    normal, lost_beam = rng.standard_normal(lidar.beams), rng.random(lidar.beams)
    lost_packet = np.repeat(rng.random(math.ceil(lidar.beams / PACKET_BEAMS)), PACKET_BEAMS)[: lidar.beams]
    there = np.isfinite(ranges)
    exact = np.where(there, ranges, 0.0)
    far = np.where(exact > flaws.near_m, flaws.range_noise_ratio * exact, 0.0)
    measured = exact + normal * np.maximum(flaws.range_noise_m, far)
    if flaws.resolution_m > 0.0:
        measured = np.round(measured / flaws.resolution_m) * flaws.resolution_m
    keep = there & (lost_beam >= flaws.beam_loss) & (lost_packet >= flaws.packet_loss)
    keep &= (measured >= lidar.range_min) & (measured <= lidar.range_max)
    return np.where(keep, measured, 0.0)


def scan_message(ranges: Floats) -> Scan:
    """Ranges as the message that goes to the service: raw, zeros and all."""
    return Scan(ranges=[float(value) for value in np.round(ranges, 6)])
