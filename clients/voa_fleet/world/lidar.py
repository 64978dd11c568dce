"""The simulated lidar: exact ranges by MuJoCo's ray caster, then the errors of a small spinning lidar.

Rays end on the triangles of the object's mesh, the arm, the clutter and the table; never on the solids that replace
the object in contacts, nor on the robots.
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
"""Duration of one revolution: an LDS-01 turns at 5 Hz."""
_NOTHING = np.inf


@dataclass(frozen=True)
class LidarGeometry:
    """Beams and limits of a lidar.

    Attributes:
        beams: number of beams in a revolution.
        angle_min, angle_increment: radians, counter-clockwise from the sensor's +x.
        range_min, range_max: limits of a measured range, metres.
        height_m: of the scan plane over the table.
    """

    beams: int
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    height_m: float

    @property
    def angles(self) -> Floats:
        """Angles of all beams in the lidar's frame, (beams,), radians."""
        return self.angle_min + self.angle_increment * np.arange(self.beams, dtype=np.float64)


def lidar_geometry(lidar: Lidar) -> LidarGeometry:
    """Complete a scenario's lidar with the values of its preset.

    Raises:
        UnknownName: there is no such preset.
        InvalidObject: neither the scenario nor a preset states one of the values.
    """
    presets = lidar_presets()
    if lidar.preset is not None and lidar.preset not in presets:
        raise UnknownName("lidar preset", lidar.preset, list(presets))
    values = {} if lidar.preset is None else presets[lidar.preset]
    values = values | lidar.model_dump(exclude_none=True)
    needed = ("beams", "angle_min", "angle_increment", "range_min", "range_max", "height_m")
    absent = [name for name in needed if name not in values]
    if absent:
        raise InvalidObject(f"lidar: expected {absent[0]} in the scenario or its preset, got none")
    return LidarGeometry(**{name: values[name] for name in needed})


def true_ranges(world: World, data: mujoco.MjData, lidar: LidarGeometry, pose: SensorPose) -> Floats:
    """Cast the rays of a lidar without errors: ranges (beams,), metres; inf where nothing is within `range_max`.

    Args:
        world: the world.
        data: the world's state; positions of the bodies must be up to date (`mj_kinematics`).
        lidar: the beams.
        pose: of the lidar; a height that it states replaces the lidar's.
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
    # The ray caster's own limit leaves out whole geometries instead of shortening rays.
    return np.where((hit >= 0) & (ranges >= 0.0) & (ranges <= lidar.range_max), ranges, _NOTHING)


def with_errors(ranges: Floats, lidar: LidarGeometry, imperfections: Imperfections, rng: np.random.Generator) -> Floats:
    """Add an LDS-01's errors to true ranges (beams,), metres: 0 where its driver would report no return.

    The number of random numbers drawn does not depend on the ranges, so that two worlds that differ in one respect
    have the same errors in all others.
    """
    normal, lost_beam = rng.standard_normal(lidar.beams), rng.random(lidar.beams)
    lost_packet = np.repeat(rng.random(math.ceil(lidar.beams / PACKET_BEAMS)), PACKET_BEAMS)[: lidar.beams]
    hit = np.isfinite(ranges)
    exact = np.where(hit, ranges, 0.0)
    far = np.where(exact > imperfections.near_m, imperfections.range_noise_ratio * exact, 0.0)
    measured = exact + normal * np.maximum(imperfections.range_noise_m, far)
    if imperfections.resolution_m > 0.0:
        measured = np.round(measured / imperfections.resolution_m) * imperfections.resolution_m
    keep = hit & (lost_beam >= imperfections.beam_loss) & (lost_packet >= imperfections.packet_loss)
    keep &= (measured >= lidar.range_min) & (measured <= lidar.range_max)
    return np.where(keep, measured, 0.0)


def displaced(sensor: SensorPose, imperfections: Imperfections, rng: np.random.Generator) -> SensorPose:
    """Draw the pose at which a robot really stands that was sent to `sensor`, with its position and heading errors."""
    dx, dy, turn = (float(number) for number in rng.standard_normal(3))
    return SensorPose(
        x=sensor.x + dx * imperfections.robot_xy_m,
        y=sensor.y + dy * imperfections.robot_xy_m,
        yaw_rad=sensor.yaw_rad + turn * imperfections.robot_yaw_rad,
        height_m=sensor.height_m,
    )


def scan_message(ranges: Floats) -> Scan:
    """Make the message for the service from ranges (beams,), metres; zeros stay zeros."""
    return Scan(ranges=[float(value) for value in np.round(ranges, 6)])
