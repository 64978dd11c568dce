"""Example messages, and hypothesis strategies for all types of them."""

import math
from itertools import cycle, islice

from hypothesis import strategies as st

from voa_ros.messages import LaserScan, Odometry, Pose, PoseWithCovariance, Stamp, Twist

TURN = 360
STEP = 0.01745329238474369  # 2 pi / 360, as the float32 that it is on the wire


def scan(*ranges: float, at: float = 0.0, increment: float = STEP) -> LaserScan:
    """A scan of an LDS-01."""
    return LaserScan(Stamp.of(at), "base_scan", 0.0, 6.25, increment, 0.0, 0.25, 0.125, 3.5, ranges)


def odometry(x: float, y: float, yaw_rad: float, at: float = 0.0) -> Odometry:
    return Odometry(Stamp.of(at), "odom", "base_footprint", Pose.planar(x, y, yaw_rad))


FLOATS = st.floats(width=32)
STAMPS = st.builds(Stamp, st.integers(-(2**31), 2**31 - 1), st.integers(0, 999_999_999))
TEXTS = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=20)
COVARIANCES = st.lists(st.floats(), min_size=1, max_size=5).map(lambda some: tuple(islice(cycle(some), 36)))
COORDINATES = st.floats(-1e5, 1e5)
POSES = st.builds(Pose.planar, COORDINATES, COORDINATES, st.floats(-math.pi, math.pi))
VELOCITIES = st.tuples(st.floats(), st.floats(), st.floats())
LIMITS = st.lists(st.floats(0.0, width=32), min_size=2, max_size=2).map(sorted).filter(lambda two: two[0] < math.inf)
INCREMENTS = st.floats(2.0**-19, 6.25, width=32)


@st.composite
def scans(draw: st.DrawFn, most: int = 30) -> LaserScan:
    low, high = draw(LIMITS)
    return LaserScan(
        draw(STAMPS),
        draw(TEXTS),
        draw(st.floats(-100.0, 100.0, width=32)),
        draw(FLOATS),
        draw(INCREMENTS) * draw(st.sampled_from([1.0, -1.0])),
        draw(FLOATS),
        draw(FLOATS),
        low,
        high,
        tuple(draw(st.lists(FLOATS, min_size=1, max_size=most))),
        tuple(draw(st.lists(FLOATS, max_size=most))),
    )


POSES_WITH_COVARIANCE = st.builds(PoseWithCovariance, STAMPS, TEXTS, POSES, COVARIANCES)
ODOMETRY = st.builds(
    Odometry,
    STAMPS,
    TEXTS,
    TEXTS,
    POSES,
    COVARIANCES,
    st.builds(Twist, VELOCITIES, VELOCITIES),
    COVARIANCES,
)
