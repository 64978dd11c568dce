"""Marked poses and outcomes from ROS tools, whose bytes rosbags writes."""

import json
import math
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from tests.support.audit import audited
from tests.support.ros_tools import RosLab
from tests.support.serving import Json
from tests.support.waiting import wait_for
from voa_ros.topics import BOOL, RmwAttachment, rmw_key

ROS = get_typestore(Stores.ROS2_JAZZY)
Types = ROS.types
INPUTS = "[robot.inputs]\nprior = true\noutcome = true\n"
RVIZ = (0.25, 0.25, 0.06853891909122467)
"""Variances that "2D Pose Estimate" of RViz states: half a metre and 15 degrees."""


def boolean(value: bool) -> bytes:
    return bytes(ROS.serialize_cdr(Types["std_msgs/msg/Bool"](data=value), "std_msgs/msg/Bool"))


def marked(x: float, y: float, yaw: float, frame: str = "world", variances: tuple[float, float, float] = RVIZ) -> bytes:
    covariance = np.zeros(36)
    covariance[[0, 7, 35]] = variances
    pose = Types["geometry_msgs/msg/Pose"](
        position=Types["geometry_msgs/msg/Point"](x=x, y=y, z=0.0),
        orientation=Types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2)),
    )
    message = Types["geometry_msgs/msg/PoseWithCovarianceStamped"](
        header=Types["std_msgs/msg/Header"](
            stamp=Types["builtin_interfaces/msg/Time"](sec=0, nanosec=0), frame_id=frame
        ),
        pose=Types["geometry_msgs/msg/PoseWithCovariance"](pose=pose, covariance=covariance),
    )
    return bytes(ROS.serialize_cdr(message, "geometry_msgs/msg/PoseWithCovarianceStamped"))


def put(lab: RosLab, key: str, payload: bytes, attachment: bytes | None = None) -> None:
    with lab.bus.session.declare_publisher(key) as publisher:
        wait_for(lambda: publisher.matching_status.matching, "the topic to be received")  # type: ignore[attr-defined] # the stub says bool; it has `matching`
        publisher.put(payload, attachment=attachment)


def state(lab: RosLab) -> Json:
    return dict(lab.service.get(f"/v1/sessions/{lab.session}"))


def history(lab: RosLab) -> list[Json]:
    return list(lab.service.get(f"/v1/sessions/{lab.session}/history")["items"])


def wait_for_version(lab: RosLab, version: int) -> Json:
    wait_for(lambda: state(lab)["version"] >= version, f"version {version}")
    return state(lab)


def wait_for_refusal(lab: RosLab, refusals: list[Any]) -> str:
    wait_for(lambda: refusals, "a refusal")
    return str(json.loads(refusals[0].payload)["detail"])


def test_a_marked_pose_is_a_prior_in_which_the_yaw_decides_between_poses_at_one_position(lab: RosLab) -> None:
    lab.map(INPUTS)
    put(lab, "tb3_1/voa/prior", marked(0.05, 0.0, math.pi / 2))
    belief = wait_for_version(lab, 1)["belief"]
    expected = math.exp(-((math.pi / 2) ** 2) / 2 / (RVIZ[2] + 1e-5))
    assert belief == pytest.approx([expected / (1 + expected), 1 / (1 + expected)], abs=1e-9)
    assert history(lab)[-1]["kind"] == "belief"


def test_a_pose_marked_in_the_frame_of_the_robots_odometry_is_moved_into_the_world(lab: RosLab) -> None:
    place = '{ from = "odometry", origin = { x = 1.0, y = 0.0, yaw_rad = 1.5707963267948966 } }'
    lab.map(INPUTS, place=place)
    put(lab, "tb3_1/voa/prior", marked(0.0, 1.0, 0.0, frame="odom"))
    belief = wait_for_version(lab, 1)["belief"]
    assert belief[1] > 0.99, "yaw 0 of the odometry is yaw 90 degrees of the world"


def test_the_prior_of_the_session_remains_in_force(lab: RosLab) -> None:
    lab.session = lab.service.open(lab.scenario, prior=[1.0, 0.0])
    lab.map(INPUTS)
    put(lab, "tb3_1/voa/prior", marked(0.0, 0.0, math.pi / 2))
    assert wait_for_version(lab, 1)["belief"] == [1.0, 0.0]


@pytest.mark.parametrize(
    ("payload", "said"),
    [
        (marked(0.0, 0.0, 0.0, frame="base_link"), "expected 'world', got 'base_link'"),
        (marked(0.0, 0.0, 0.0, variances=(0.0, 0.0, 0.0)), "expected variances of x, y and yaw"),
        (marked(0.0, 0.0, 0.0, variances=(-1.0, 1.0, 1.0)), "expected a positive definite matrix"),
        (boolean(True), "expected a geometry_msgs/msg/PoseWithCovarianceStamped"),
    ],
)
def test_a_marked_pose_that_cannot_be_used_is_refused_with_the_reason(lab: RosLab, payload: bytes, said: str) -> None:
    lab.map(INPUTS)
    refusals = lab.bus.subscribe(lab.bus.keys.refused(lab.session, "tb3_1"))
    with audited() as audit:
        put(lab, "tb3_1/voa/prior", payload)
        assert said in wait_for_refusal(lab, refusals)
    assert audit.of("belief.put", "caller", "robot", "session", "result") == [("mapping", "tb3_1", lab.session, 422)]
    assert state(lab)["version"] == 0


def test_an_outcome_is_of_the_best_grasp_and_counts_once(lab: RosLab) -> None:
    lab.map(INPUTS)
    best = state(lab)["best_grasp"]
    attachment = RmwAttachment(1, 2, bytes(range(16))).encode()
    key = rmw_key("tb3_1/voa/outcome", BOOL)
    put(lab, key, boolean(False), attachment)
    wait_for_version(lab, 1)
    assert history(lab)[-1]["request"] == {"grasp": best, "success": False}
    put(lab, key, boolean(False), attachment)  # delivered twice
    put(lab, key, boolean(True), RmwAttachment(2, 3, bytes(range(16))).encode())
    assert wait_for_version(lab, 2)["version"] == 2
    assert history(lab)[-1]["request"]["success"] is True


def test_an_outcome_states_how_probably_the_attempt_moved_the_object(lab: RosLab) -> None:
    lab.map("[robot.inputs]\noutcome = true\nobject_moved = 1.0\n")
    lab.prefer([0.25, 0.75])
    put(lab, "tb3_1/voa/outcome", boolean(False))
    assert wait_for_version(lab, 2)["belief"] == pytest.approx([0.5, 0.5])


def test_a_message_that_is_no_bool_is_refused(lab: RosLab) -> None:
    lab.map(INPUTS)
    refusals = lab.bus.subscribe(lab.bus.keys.refused(lab.session, "tb3_1"))
    with audited() as audit:
        put(lab, "tb3_1/voa/outcome", marked(0.0, 0.0, 0.0))
        assert "expected a std_msgs/msg/Bool" in wait_for_refusal(lab, refusals)
    assert audit.of("outcome.report") == [("mapping", 422)]


def test_nothing_is_received_unless_the_mapping_allows_it(lab: RosLab) -> None:
    lab.map("[robot.inputs]\nprior = true\n")
    with lab.bus.session.declare_publisher("tb3_1/voa/outcome") as publisher:
        put(lab, "tb3_1/voa/prior", marked(0.0, 0.0, 0.0))
        wait_for_version(lab, 1)
        assert not publisher.matching_status.matching  # type: ignore[attr-defined] # the stub says bool; it has `matching`
