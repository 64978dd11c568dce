"""The whole way from a robot's bytes to its looks: one look of each stop, at the right place."""

import math
from collections.abc import Iterator
from dataclasses import replace

import pytest

from tests.voa_ros import parking
from tests.voa_ros.parking import (
    GRID,
    PARKED_AT_S,
    START_S,
    STOPS,
    ParkingRobot,
    check_looks,
    mapped,
    play,
    true,
    with_amcl,
)
from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.keys import Attachment
from voa_ros.cdr import decode_laser_scan, encode_laser_scan, encode_odometry
from voa_ros.look_taker import PARKED
from voa_ros.looks import GatheredLook
from voa_ros.messages import LaserScan, Odometry, Pose, Stamp
from voa_ros.motions import Motion, composed
from voa_ros.pipeline import Received, UnusableMessage
from voa_ros.topics import LASER_SCAN, ODOMETRY

# --- places


LIDAR = Motion(0.1, -0.05, 0.4)
ORIGIN = Motion(0.3, -0.2, 0.7)
MOUNTED = "lidar = { x = 0.1, y = -0.05, yaw_rad = 0.4 }"


def test_origin_and_mount_are_where_the_mapping_says() -> None:
    own = ParkingRobot(odometry_frame=ORIGIN, lidar=LIDAR)
    came = play(mapped('from = "odometry"\norigin = { x = 0.3, y = -0.2, yaw_rad = 0.7 }', MOUNTED), own.messages())
    check_looks(came, [composed(stop, LIDAR) for stop in STOPS])


@pytest.mark.parametrize("layout", ["steady", "irregular", "segments"])
def test_a_lidar_that_hangs_upside_down_sees_the_same_room(layout: str) -> None:
    own = ParkingRobot(layout=layout, lidar=LIDAR, hangs=True)
    came = play(mapped(more=MOUNTED.replace("}", ", upside_down = true }")), own.messages())
    check_looks(came, [composed(stop, LIDAR) for stop in STOPS])


def test_a_lidar_that_hangs_upside_down_unsaid_sees_another_room() -> None:
    came = play(mapped(), ParkingRobot(hangs=True).messages())
    assert len(came.looks) == len(STOPS)
    with pytest.raises(AssertionError):
        check_looks(came, STOPS)


@pytest.mark.parametrize("first", ["the pose", "odometry"])
def test_a_latched_pose_serves_a_robot_that_has_been_parked_for_long(first: str) -> None:
    own = ParkingRobot(odometry_frame=ORIGIN, stops=STOPS[:1])
    long_ago = replace(own, scan_clock=lambda now_s: now_s - 700.0)
    (said,) = long_ago.amcl()
    at_s = START_S if first == "the pose" else START_S + 0.5
    came = play(mapped('from = "amcl"'), with_amcl(own, lambda message: replace(said, received_s=at_s)))
    check_looks(came, STOPS[:1])


def test_without_an_amcl_pose_it_is_said_which_is_waited_for() -> None:
    came = play(mapped('from = "amcl"'), ParkingRobot(stops=STOPS[:1]).messages())
    assert came.looks == []
    assert came.refused[-1] == "it is not known where the lidar was: no AMCL pose was received yet on amcl_pose"
    assert came.waiting[-1] == "the lidar's pose: no AMCL pose was received yet on amcl_pose"


def beside(message: Received, **attached: object) -> Received:
    return replace(message, attached=Attachment.model_validate(attached)) if message.type == LASER_SCAN else message


def test_attachments_say_the_place() -> None:
    own = ParkingRobot()
    sent = []
    for message in own.messages():
        place = own.base(message.received_s)
        pose = UncertainSensorPose(x=place.x, y=place.y, yaw_rad=place.yaw_rad)
        sent.append(beside(message, sensor_pose=pose.model_dump()))
    check_looks(play(mapped('from = "attachment"'), sent), STOPS)
    named = [beside(message, sensor="E") for message in ParkingRobot(stops=STOPS[:1]).messages()]
    (look,) = play(mapped('from = "attachment"'), named).looks
    assert look.request.sensor == "E"


def test_an_attachment_that_says_nothing_is_refused() -> None:
    came = play(mapped('from = "attachment"'), ParkingRobot(stops=STOPS[:1]).messages())
    assert came.looks == []
    assert set(came.refused) == {"it is not known where the lidar was: the attachment of the scan does not state it"}


def test_an_attachment_stays_with_its_scan_where_the_lidar_sees_a_quarter_turn() -> None:
    quarter = (GRID.beams + 3) // 4
    looks, taken = mapped('from = "attachment"', look='mode = "every"'), []
    for number, name in enumerate("ABCD"):
        measured = LaserScan(
            Stamp(number + 1), "f", 0.0, 1.5, GRID.angle_increment, 0.0, 0.1, 0.1, 8.0, (1.0 + number,) * quarter
        )
        answer = looks.receive(
            Received(LASER_SCAN, encode_laser_scan(measured), float(number), Attachment(sensor=name))
        )
        if isinstance(answer, GatheredLook):
            taken.append((answer.request.sensor, answer.request.scan.ranges[0]))
    assert taken == [("A", 1.0), ("B", 2.0), ("C", 3.0), ("D", 4.0)]


@pytest.mark.parametrize("layout", ["steady", "irregular", "segments"])
@pytest.mark.parametrize("hz", [5.0, 10.0])
def test_a_lidar_at_a_named_place_looks_once_a_stop_by_the_scene(hz: float, layout: str) -> None:
    came = play(mapped('from = "sensor"\nsensor = "E"'), ParkingRobot(hz, layout).messages())
    assert [look.request.sensor for look in came.looks] == ["E"] * len(STOPS)


# --- scans that arrive twice, of other frames, and that cannot be used


@pytest.mark.parametrize("delay_s", [0.0, 0.004, 0.3])
@pytest.mark.parametrize("whose", ["none", "both"])
def test_two_bridges_make_no_second_look(delay_s: float, whose: str) -> None:
    clock = true if whose == "none" else lambda now_s: now_s - 3.0 * (now_s >= PARKED_AT_S)
    once = list(ParkingRobot(scan_clock=clock, odometry_clock=clock).messages())
    twice = [*once, *(replace(message, received_s=message.received_s + delay_s) for message in once)]
    came = play(mapped(), sorted(twice, key=lambda message: message.received_s))
    check_looks(came, STOPS)
    assert not any("received before" in reason for reason in came.waiting)
    alone = play(mapped(), once)
    if whose == "none" and delay_s == 0.0:
        assert [look.digest for look in came.looks] == [look.digest for look in alone.looks]


def test_a_driver_that_hangs_is_noticed() -> None:
    sent = list(ParkingRobot(stops=STOPS[:1]).messages())
    scans = [message for message in sent if message.type == LASER_SCAN]
    looks = mapped()
    came = play(looks, [*sent[:20], *[scans[5]] * 20])
    assert came.looks == []
    assert looks.waiting_for == "a scan that was not received before: this one equals an earlier one, stamp included"


def echoes() -> Iterator[Received]:
    """Three echoes on one topic; only the first sees the room."""
    for message in ParkingRobot().messages():
        if message.type != LASER_SCAN:
            yield message
            continue
        for echo in range(3):
            measured = decode_laser_scan(message.payload)
            ranges = tuple(value + echo for value in measured.ranges)
            yield replace(message, payload=encode_laser_scan(replace(measured, frame_id=f"echo_{echo}", ranges=ranges)))


def test_one_of_several_echoes_is_used_where_the_mapping_says_which() -> None:
    came = play(mapped(more='frame_id = "echo_0"'), echoes())
    check_looks(came, STOPS)
    assert not any("echo_" in reason for reason in came.waiting[2:])


def test_several_echoes_are_refused_where_it_does_not() -> None:
    looks = mapped()
    came = play(looks, echoes())
    assert came.looks == []
    assert "3 frames on one topic ('echo_0', 'echo_1', 'echo_2')" in came.refused[-1]
    assert looks.waiting_for == "scans of one frame"


def test_a_frame_that_never_comes_is_waited_for() -> None:
    looks = mapped(more='frame_id = "front"')
    assert play(looks, ParkingRobot(stops=STOPS[:1]).messages()).looks == []
    assert looks.waiting_for == "a scan of frame 'front': found 'base_scan'"


def test_a_header_that_contradicts_itself_is_refused_and_what_is_waited_for_says_so() -> None:
    looks = mapped()
    scans = [message for message in ParkingRobot().messages() if message.type == LASER_SCAN]
    measured = decode_laser_scan(scans[0].payload)
    for wrong, words in [
        (replace(measured, angle_increment=-measured.angle_increment), "one of them is wrong"),
        (replace(measured, angle_increment=1.0, angle_max=119.0), "19.1 turns"),
    ]:
        with pytest.raises(UnusableMessage, match=words):
            looks.receive(replace(scans[0], payload=encode_laser_scan(wrong)))
        assert looks.waiting_for == "a scan that can be used"


def test_bytes_that_are_no_scan_are_refused() -> None:
    looks = mapped()
    odometry = encode_odometry(Odometry(Stamp(), "odom", "base", Pose.planar(0.0, 0.0, 0.0)))
    with pytest.raises(UnusableMessage, match=r"expected a sensor_msgs/msg/LaserScan, found a nav_msgs/msg/Odometry"):
        looks.receive(Received(LASER_SCAN, odometry, 0.0))
    with pytest.raises(UnusableMessage, match=r"expected a nav_msgs/msg/Odometry"):
        looks.receive(Received(ODOMETRY, b"", 0.0))
    assert looks.waiting_for == "a scan that can be used"


def test_more_beams_than_the_limit_are_refused_by_the_name_of_the_setting() -> None:
    looks = mapped(most_beams=GRID.beams - 1)
    scan = next(message for message in ParkingRobot().messages() if message.type == LASER_SCAN)
    with pytest.raises(UnusableMessage, match=f"VOA_LIMITS__BEAMS={GRID.beams}"):
        looks.receive(scan)


# --- what is waited for, and warned of


def test_what_is_waited_for_changes_with_the_drive() -> None:
    came = play(mapped(), ParkingRobot(stops=STOPS[:2]).messages())
    standing = [f"standing still: {number} of 10 revolutions" for number in range(2, 10)]
    seen = list(dict.fromkeys(came.waiting))
    assert seen[0] == "a scan"
    assert [reason for reason in seen if reason in standing] == standing
    assert seen[-1] == "the robot to move on: this stop's look is taken"
    assert "the robot to stop" in seen


def test_segments_say_how_many_there_are() -> None:
    looks = mapped('from = "sensor"\nsensor = "E"')
    sent = [message for message in ParkingRobot(layout="segments").messages() if message.type == LASER_SCAN]
    play(looks, sent[:5])
    assert looks.waiting_for == "a whole revolution of the lidar: 4 segments received so far"


def test_every_scan_of_a_parked_robot_is_warned_of() -> None:
    looks = mapped(look='mode = "every"')
    sent = list(ParkingRobot(stops=STOPS[:2]).messages())
    parked = [message for message in sent if message.received_s < START_S + parking.PARKED_S]
    came = play(looks, parked[: 3 * (PARKED - 2)])
    assert len(came.looks) > 2
    assert looks.warnings == []
    play(looks, parked[3 * (PARKED - 2) :])
    (warning,) = looks.warnings
    assert warning.kind == "every-while-parked"
    assert looks.waiting_for is None
    driving = [message for message in sent if 0.5 < message.received_s - START_S - parking.PARKED_S < 2.5]
    play(looks, driving)
    assert looks.warnings == []


def test_a_request_is_kept_for_another_session() -> None:
    looks = mapped(look='mode = "on_request"')
    states = [(looks.requested, looks.waiting_for)]
    looks.request()
    looks.restart()
    states.append((looks.requested, looks.waiting_for))
    check_looks(play(looks, ParkingRobot(stops=STOPS[:1]).messages()), STOPS[:1])
    states.append((looks.requested, looks.waiting_for))
    assert states == [(False, "a request"), (True, "the robot to stop"), (False, "a request")]


def test_another_session_gets_a_look_of_the_same_stop() -> None:
    looks, sent = mapped(), list(ParkingRobot(stops=STOPS[:1]).messages())
    half = len(sent) // 2
    assert len(play(looks, sent[:half]).looks) == 1
    assert looks.waiting_for == "the robot to move on: this stop's look is taken"
    looks.restart()
    assert looks.waiting_for == "a scan"
    assert len(play(looks, sent[half:]).looks) == 1


def test_looks_that_are_not_accepted_are_taken_again_and_counted_once() -> None:
    looks, accepted, tries = mapped(), [], 0
    for message in ParkingRobot().messages():
        try:
            result = looks.receive(message)
        except UnusableMessage:
            continue
        if isinstance(result, GatheredLook):
            tries += 1
            if tries % 2:
                looks.rejected("no_beams", result.request)
            else:
                accepted.append(result)
    assert tries == 2 * len(STOPS)
    check_looks(parking.Outcome(accepted), STOPS)


def test_two_processes_take_the_same_looks() -> None:
    one, other = mapped(), mapped()
    sent = list(ParkingRobot().messages())
    first = play(one, sent)
    resumed = play(other, [message for message in sent if message.received_s >= START_S + parking.PARKED_S + 1.0])
    assert [look.digest for look in resumed.looks] == [look.digest for look in first.looks[1:]]


def test_a_process_that_starts_while_the_robot_is_parked_takes_no_second_look() -> None:
    sent = list(ParkingRobot(stops=STOPS[:2]).messages())
    first = play(mapped(), sent)
    after = mapped()
    after.resume(first.looks[0].request)
    rest = [message for message in sent if message.received_s >= START_S + 3.0]
    check_looks(play(after, rest), STOPS[1:2])
    assert math.isclose(rest[0].received_s, START_S + 3.0, abs_tol=0.1)
