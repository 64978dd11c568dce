"""A driver as a function from revolutions to messages, and the sensor that all of them share."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tests.support.lidar_drivers.scene import Floats, Scene
from voa_assets import lidar_presets
from voa_ros.messages import LaserScan, Stamp

PoseAt = Callable[[float], tuple[float, float, float]]
"""Time in seconds to x, y (metres) and yaw (radians) of the lidar in the world."""


def float32(value: float) -> float:
    """Round to the number that a float32 field of a message holds."""
    return float(np.float32(value))


def floats32(values: ArrayLike) -> tuple[float, ...]:
    """Round every value to float32."""
    return tuple(np.asarray(values, dtype=np.float32).astype(np.float64).tolist())


def quantised(ranges: Floats, step_m: float) -> Floats:
    """Round ranges to whole steps of the sensor's protocol; NaN and inf stay."""
    return np.asarray(np.round(ranges / step_m) * step_m)


@dataclass(frozen=True)
class Turn:
    """Revolution of a lidar at one place.

    Attributes:
        scene: the world.
        x, y, yaw: the lidar's pose in it, metres and radians.
        start_s, hz: when the revolution began and how fast it is; the motor's own wandering included.
        number: counts from 0.
        rng: noise, lost beams and phases.
        noise_m, noise_ratio, dropout, range_min, range_max: the preset's.
    """

    scene: Scene
    x: float
    y: float
    yaw: float
    start_s: float
    hz: float
    number: int
    rng: np.random.Generator
    noise_m: float
    noise_ratio: float
    dropout: float
    range_min: float
    range_max: float

    @property
    def period_s(self) -> float:
        """Seconds of this revolution."""
        return 1.0 / self.hz

    def phases(self, rate_hz: float) -> Floats:
        """Angles that the head has turned through at each sample of this revolution.

        Args:
            rate_hz: samples a second; the sensor's clock knows nothing of its motor.

        Returns:
            (n,) radians in [0, 2 pi), ascending; how many there are, and where the first one is, varies.
        """
        step = math.tau * self.hz / rate_hz
        return np.arange(self.rng.uniform(0.0, step), math.tau, step)

    def measure(self, angles: ArrayLike, forward_m: ArrayLike = 0.0, left_m: ArrayLike = 0.0) -> Floats:
        """Measure ranges with the preset's noise.

        Args:
            angles: (r,) radians, counter-clockwise from the lidar's +x.
            forward_m, left_m: where the rays begin in the lidar's frame; one place, or one for each ray.

        Returns:
            (r,) metres along the rays; inf where nothing is in range, NaN where a beam was lost or is too short.
        """
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        forward, left = np.asarray(forward_m), np.asarray(left_m)
        x, y = self.x + c * forward - s * left, self.y + s * forward + c * left
        true = self.scene.distances(x, y, self.yaw, angles)
        sigma = np.maximum(self.noise_m, self.noise_ratio * np.where(np.isfinite(true), true, 0.0))
        measured = true + sigma * self.rng.standard_normal(len(true))
        lost = self.rng.random(len(true)) < self.dropout
        ranges = np.where(true > self.range_max, np.inf, measured)
        return np.asarray(np.where(lost | (measured < self.range_min), np.nan, ranges))


@dataclass(frozen=True)
class Driver:
    """A lidar with its ROS 2 driver.

    Attributes:
        name: of the lidar, as in `DRIVERS`.
        preset: its name among the presets.
        rates_hz: speeds at which it is used.
        publish: the messages of one revolution.
        reach_increments: how far the direction that a beam's message gives may lie from where it was measured, in
            increments of that message.
        messages_per_turn: 1, or the segments of a revolution.
        wandering: standard deviation of the speed between revolutions, as a share of it; an assumption.
    """

    name: str
    preset: str
    rates_hz: tuple[float, ...]
    publish: Callable[[Turn], list[LaserScan]]
    reach_increments: float = 0.0
    messages_per_turn: int = 1
    wandering: float = 0.0

    def play(
        self,
        scene: Scene,
        pose_at: PoseAt,
        count: int,
        hz: float,
        rng: np.random.Generator,
        start_s: float = 1000.0,
    ) -> list[LaserScan]:
        """Publish revolutions.

        Args:
            scene: the scene around the lidar.
            pose_at: pose of the lidar, evaluated at the beginning of each revolution.
            count: revolutions; there are `messages_per_turn` messages for each.
            hz: nominal revolutions a second.
            rng: the same generator state gives the same messages.
            start_s: when the first revolution begins.
        """
        preset = lidar_presets()[self.preset]
        fields = ("noise_m", "noise_ratio", "dropout", "range_min", "range_max")
        figures = {field: preset[field] for field in fields}
        scans: list[LaserScan] = []
        at_s = start_s
        for number in range(count):
            x, y, yaw = pose_at(at_s)
            speed = hz * (1.0 + self.wandering * float(np.clip(rng.standard_normal(), -3.0, 3.0)))
            turn = Turn(scene, x, y, yaw, at_s, speed, number, rng, **figures)
            scans += self.publish(turn)
            at_s += turn.period_s
        return scans


@dataclass(frozen=True)
class Header:
    """All fields of a LaserScan but its ranges and intensities; `message` rounds them to float32."""

    stamp_s: float
    frame_id: str
    angle_min: float
    angle_max: float
    angle_increment: float
    time_increment: float
    scan_time: float
    range_min: float
    range_max: float

    def message(self, ranges: ArrayLike, intensities: ArrayLike = ()) -> LaserScan:
        """Make the message of these ranges and intensities."""
        return LaserScan(
            Stamp.of(self.stamp_s),
            self.frame_id,
            float32(self.angle_min),
            float32(self.angle_max),
            float32(self.angle_increment),
            float32(self.time_increment),
            float32(self.scan_time),
            float32(self.range_min),
            float32(self.range_max),
            floats32(ranges),
            floats32(intensities),
        )
