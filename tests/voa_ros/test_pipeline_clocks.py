"""No stamp loses a look, or its place: the whole way from a robot's bytes, with clocks that are wrong."""

import math
from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.scale import scaled
from tests.voa_ros.parking import (
    DRIVING_AT_S,
    PARKED_AT_S,
    START_S,
    STOPS,
    Clock,
    ParkingRobot,
    check_looks,
    check_places,
    mapped,
    play,
    true,
    with_amcl,
)
from voa_ros.motions import Motion
from voa_ros.pipeline import Received
from voa_ros.topics import LASER_SCAN

ORIGIN = Motion(0.3, -0.2, 0.7)
HZ = [5.0, 10.0]
WHEN = {"while parked": PARKED_AT_S, "while driving": DRIVING_AT_S}


# --- clocks


def zero(from_s: float) -> Clock:
    return lambda now_s: 0.0 if now_s >= from_s else now_s


def frozen(from_s: float) -> Clock:
    return lambda now_s: min(now_s, from_s)


def back(by_s: float) -> Callable[[float], Clock]:
    return lambda from_s: lambda now_s: now_s - by_s if now_s >= from_s else now_s


def again(from_s: float) -> Clock:
    """Simulated time that starts again."""
    return lambda now_s: now_s - from_s if now_s >= from_s else now_s - START_S


def there_and_back(from_s: float) -> Clock:
    """An hour ahead for two seconds."""
    return lambda now_s: now_s + 3_600.0 if from_s <= now_s < from_s + 2.0 else now_s


FAULTS = {
    "zero": zero,
    "frozen": frozen,
    "back 0.3 s": back(0.3),
    "back 1 s": back(1.0),
    "back 3 s": back(3.0),
    "back 100 s": back(100.0),
    "ahead 0.3 s": back(-0.3),
    "ahead 1 s": back(-1.0),
    "ahead 3 s": back(-3.0),
    "ahead 100 s": back(-100.0),
    "there and back": there_and_back,
    "again": again,
}


@pytest.mark.parametrize("hz", HZ)
@pytest.mark.parametrize("layout", ["steady", "irregular", "segments"])
def test_each_stop_is_a_look_at_its_place(hz: float, layout: str) -> None:
    came = play(mapped(), ParkingRobot(hz, layout).messages())
    check_looks(came, STOPS)
    assert set(came.refused) <= {"it is not known where the lidar was: no odometry was received yet"}


@pytest.mark.parametrize("hz", HZ)
@pytest.mark.parametrize("when", WHEN)
@pytest.mark.parametrize("whose", ["scan", "odometry", "both"])
@pytest.mark.parametrize("fault", FAULTS)
def test_no_stamp_loses_a_look_or_its_place(fault: str, whose: str, when: str, hz: float) -> None:
    clock = FAULTS[fault](WHEN[when])
    own = ParkingRobot(
        hz,
        scan_clock=true if whose == "odometry" else clock,
        odometry_clock=true if whose == "scan" else clock,
    )
    check_looks(play(mapped(), own.messages()), STOPS)


@pytest.mark.parametrize("layout", ["irregular", "segments"])
@pytest.mark.parametrize("whose", ["scan", "both"])
@pytest.mark.parametrize("fault", ["zero", "frozen", "back 3 s", "again"])
def test_no_layout_does_either(fault: str, whose: str, layout: str) -> None:
    clock = FAULTS[fault](PARKED_AT_S)
    own = ParkingRobot(10.0, layout, scan_clock=clock, odometry_clock=true if whose == "scan" else clock)
    check_looks(play(mapped(), own.messages()), STOPS)


STEPS = st.lists(st.tuples(st.floats(0.0, 32.0), st.floats(-100.0, 100.0)), max_size=4)


def stepping(steps: list[tuple[float, float]]) -> Clock:
    """A clock that is set, so long after the start, by so much; again each time."""
    return lambda now_s: now_s + sum(by_s for after_s, by_s in steps if now_s >= START_S + after_s)


@settings(max_examples=scaled(25, 500), deadline=None)
@given(STEPS, STEPS, st.sampled_from(HZ))
def test_clocks_may_be_set_at_any_time_by_any_amount(
    scan: list[tuple[float, float]], odometry: list[tuple[float, float]], hz: float
) -> None:
    own = ParkingRobot(hz, scan_clock=stepping(scan), odometry_clock=stepping(odometry))
    check_places(play(mapped(), own.messages()), STOPS)


@pytest.mark.parametrize("hz", HZ)
def test_a_simulation_that_starts_again_is_a_new_drive(hz: float) -> None:
    """Robot, odometry and stamps start again, and the stamps are to the last bit those of before."""
    once = list(
        ParkingRobot(
            hz, scan_clock=lambda now_s: now_s - START_S, odometry_clock=lambda now_s: now_s - START_S
        ).messages()
    )
    length_s = once[-1].received_s - once[0].received_s + 1.0
    cut = [message for message in once if message.received_s < PARKED_AT_S + 3.0]
    twice = [replace(message, received_s=message.received_s + length_s) for message in once]
    check_looks(play(mapped(), [*cut, *twice]), [*STOPS[:3], *STOPS])


@pytest.mark.parametrize("hz", HZ)
@pytest.mark.parametrize("late_s", [0.1, 0.3])
def test_scans_that_always_come_a_little_late_lose_no_look(hz: float, late_s: float) -> None:
    sent = [
        replace(message, received_s=message.received_s + late_s * (message.type == LASER_SCAN))
        for message in ParkingRobot(hz).messages()
    ]
    check_looks(play(mapped(), sorted(sent, key=lambda message: message.received_s)), STOPS)


@pytest.mark.parametrize("hz", HZ)
def test_a_network_that_stalls_now_and_then_loses_no_look(hz: float) -> None:
    """Every second what comes is held up for up to 0.6 s, and then comes at once, all scans before the odometry."""

    def held(message: Received) -> float:
        second, into = divmod(message.received_s, 1.0)
        return second + 0.6 if into < 0.6 else message.received_s

    sent = [replace(message, received_s=held(message)) for message in ParkingRobot(hz).messages()]
    sent.sort(key=lambda message: (message.received_s, message.type != LASER_SCAN))
    check_looks(play(mapped(), sent), STOPS)


@pytest.mark.parametrize("hz", HZ)
@pytest.mark.parametrize("when", WHEN)
@pytest.mark.parametrize("fault", ["none", *(fault for fault in FAULTS if fault not in ("zero", "frozen"))])
def test_amcl_says_the_place_in_its_map(fault: str, when: str, hz: float) -> None:
    clock = true if fault == "none" else FAULTS[fault](WHEN[when])
    own = ParkingRobot(hz, scan_clock=clock, odometry_clock=clock, odometry_frame=ORIGIN)
    check_looks(play(mapped('from = "amcl"'), with_amcl(own)), STOPS)


@pytest.mark.parametrize("fault", ["zero", "frozen"])
def test_amcl_without_a_clock_is_as_late_as_it_comes(fault: str) -> None:
    """A tenth of a second late, on the way: some centimetres off. (AMCL itself does not run without stamps.)"""
    clock = FAULTS[fault](DRIVING_AT_S)
    own = ParkingRobot(scan_clock=clock, odometry_clock=clock, odometry_frame=ORIGIN)
    poses = [look.request.sensor_pose for look in play(mapped('from = "amcl"'), with_amcl(own)).looks]
    assert len(poses) == len(STOPS)
    for pose, stop in zip(poses, STOPS, strict=True):
        assert pose is not None
        assert math.hypot(pose.x - stop.x, pose.y - stop.y) < 0.05
