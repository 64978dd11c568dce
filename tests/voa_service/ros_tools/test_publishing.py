"""Outputs for ROS tools on a real router, decoded by a stock decoder."""

import math

import pytest

from tests.support.ros_tools import RosLab, Tool
from tests.support.waiting import wait_for
from voa_ros.outputs.types import DETECTION, FLOAT, GRASP, MARKER_ARRAY, POSE_ARRAY, POSE_STAMPED


@pytest.fixture
def tool(lab: RosLab) -> Tool:
    return Tool(lab.bus)


def test_the_belief_is_a_detection_with_a_hypothesis_for_each_pose(lab: RosLab, tool: Tool) -> None:
    lab.map()
    first = tool.read(DETECTION, "belief")
    assert first.header.frame_id == "world"
    assert [(each.hypothesis.class_id, each.hypothesis.score) for each in first.results] == [("A", 0.5), ("B", 0.5)]
    assert first.id == lab.session
    lab.prefer([0.25, 0.75])
    second = tool.read(DETECTION, "belief", 2)
    assert [(each.hypothesis.class_id, each.hypothesis.score) for each in second.results] == [("B", 0.75), ("A", 0.25)]
    likeliest = second.results[0].pose
    assert likeliest.pose.orientation.z == pytest.approx(math.sqrt(0.5))
    assert [likeliest.covariance[0], likeliest.covariance[7], likeliest.covariance[35]] == pytest.approx(
        [1e-4, 1e-4, 1e-2]
    )
    assert second.bbox.center.position.z == pytest.approx(0.025, abs=1e-6)
    size = second.bbox.size
    assert (size.x, size.y, size.z) == pytest.approx((0.04, 0.06, 0.05), abs=1e-6)


def test_poses_hold_95_per_cent_of_the_belief(lab: RosLab, tool: Tool) -> None:
    lab.map()
    assert len(tool.read(POSE_ARRAY, "poses").poses) == 2
    lab.prefer([0.04, 0.96])
    (pose,) = tool.read(POSE_ARRAY, "poses", 2).poses
    assert pose.orientation.w == pytest.approx(math.sqrt(0.5))


def test_grasps_with_a_geometry_are_published_best_first(lab: RosLab, tool: Tool) -> None:
    lab.map()
    grasp = tool.read(GRASP, "grasps")
    assert (grasp.id, grasp.grasp_quality) == ("G1", pytest.approx(0.5))
    pose = grasp.grasp_pose.pose
    assert (pose.position.x, pose.position.y, pose.position.z) == (0.0, 0.0, 0.05)
    assert grasp.pre_grasp_approach.direction.vector.z == pytest.approx(-1.0)
    best = tool.read(POSE_STAMPED, "best_grasp")
    assert best.pose.orientation.x == pytest.approx(pose.orientation.x)
    w, x, y, z = (getattr(pose.orientation, each) for each in "wxyz")
    assert 1 - 2 * (x * x + y * y) == pytest.approx(-1.0), "z of the tool points down, along the approach"
    assert (1 - 2 * (y * y + z * z), 2 * (x * y + w * z)) == pytest.approx((0.0, 1.0)), "x of the tool: the closing"


def test_numbers_are_published_for_plots(lab: RosLab, tool: Tool) -> None:
    lab.map()
    assert tool.read(FLOAT, "numbers/entropy_nats").data == pytest.approx(math.log(2))
    assert tool.read(FLOAT, "numbers/expected_score").data == pytest.approx(0.5)
    assert tool.on("numbers/fit_rmsd_mm") == []
    lab.service.post(f"/v1/sessions/{lab.session}/scans", scan_of_pose(lab, "A"))
    fit = lab.service.get(f"/v1/sessions/{lab.session}")["last_fit_rmsd_mm"]
    assert tool.read(FLOAT, "numbers/fit_rmsd_mm").data == pytest.approx(fit)


def scan_of_pose(lab: RosLab, pose: str, sensor: str = "E") -> dict[str, object]:
    predicted = lab.service.post(f"/v1/scenarios/{lab.scenario}/predictions", {"sensors": [sensor]})
    ranges = predicted["ranges"][0][predicted["poses"].index(pose)]
    empty = [index for index, value in enumerate(ranges) if value is None]
    return {"sensor": sensor, "scan": {"ranges": ranges, "no_return": empty}}


def test_markers_show_the_scene_and_delete_the_older_ones(lab: RosLab, tool: Tool) -> None:
    lab.map()
    wait_for(lambda: len(tool.on("markers")) >= 2, "markers with towers")
    markers = tool.read(MARKER_ARRAY, "markers", 2).markers
    assert (markers[0].action, markers[0].ns) == (3, "")
    assert {marker.ns for marker in markers[1:]} >= {"table", "belief", "looks"}
    assert len({(marker.ns, marker.id) for marker in markers[1:]}) == len(markers) - 1
    ghosts = [marker for marker in markers if marker.ns == "belief"]
    assert [(ghost.type, len(ghost.points)) for ghost in ghosts] == [(11, 36), (11, 36)]
    assert {marker.type for marker in markers if marker.ns == "looks"} >= {3}, "towers are cylinders"
    lab.service.post(f"/v1/sessions/{lab.session}/scans", scan_of_pose(lab, "A"))
    wait_for(lambda: len(tool.on("markers")) >= 3, "markers of the scan")
    assert "scan" in {marker.ns for marker in tool.read(MARKER_ARRAY, "markers", 3).markers}


def test_tools_read_the_mesh_from_the_service_where_its_address_is_stated(lab: RosLab, tool: Tool) -> None:
    lab.map('[robot.outputs]\nmarkers = true\nmeshes = "http://lab:8000/"\n')
    (first, _) = [each for each in tool.read(MARKER_ARRAY, "markers").markers if each.ns == "belief"]
    object_ = lab.service.get(f"/v1/scenarios/{lab.scenario}")["object"]
    assert first.mesh_resource == f"http://lab:8000/v1/objects/{object_}/mesh.stl?most_faces=2000"
    stl = lab.service.http.get(first.mesh_resource.removeprefix("http://lab:8000"))
    assert (stl.status_code, len(stl.content)) == (200, 84 + 12 * 50)
    assert not first.mesh_use_embedded_materials


def test_the_recommended_place_is_the_base_pose_of_the_robot_in_its_odometry(lab: RosLab, tool: Tool) -> None:
    place = '{ from = "odometry", origin = { x = 1.0, y = 2.0, yaw_rad = 1.5707963267948966 } }'
    lab.map(place=place, more="lidar = { x = -0.032 }")
    goal = tool.read(POSE_STAMPED, "place")
    ranking = lab.service.get(f"/v1/sessions/{lab.session}/voa")
    assert ranking["recommendation"]["sensor"] == "E", "the lidar at x = 0.3 looks towards the west"
    assert goal.header.frame_id == "odom"
    # The base is 0.032 m in front of the lidar, at (0.268, 0) in the world, and the odometry's x is the world's y.
    assert (goal.pose.position.x, goal.pose.position.y) == pytest.approx((-2.0, 0.732))
    assert 2 * math.atan2(goal.pose.orientation.z, goal.pose.orientation.w) == pytest.approx(math.pi / 2)


def test_no_place_is_published_when_the_recommendation_is_to_grasp(lab: RosLab, tool: Tool) -> None:
    lab.prefer([1.0, 0.0])
    lab.map()
    tool.wait("markers", 2)  # the second array has the towers of the ranking
    assert tool.on("place") == []


def test_only_the_outputs_that_are_switched_on_are_published(lab: RosLab, tool: Tool) -> None:
    lab.map('[robot.outputs]\nbelief = "/lab/belief"\nnumbers = false\n')
    other = Tool(lab.bus, "lab/**")
    lab.prefer([0.25, 0.75])
    wait_for(lambda: other.samples, "the belief on another topic")
    lab.prefer([0.5, 0.5])
    wait_for(lambda: len(other.samples) >= 2, "a second belief")
    assert tool.samples == []


def test_newest_messages_are_repeated_for_tools_that_start_late_but_goals_are_not(lab: RosLab, tool: Tool) -> None:
    lab.map("[robot.outputs]\nbelief = true\nplace = true\nrepeat_s = 0.2\n")
    tool.wait("place")
    late = Tool(lab.bus)
    belief = late.wait("belief", 3)
    assert len({sample.payload for sample in belief}) == 1
    assert late.on("place") == []
    assert len(tool.on("place")) == 1


def test_rmw_zenoh_gets_keys_with_the_hash_of_the_type_and_its_attachment(lab: RosLab) -> None:
    every = Tool(lab.bus, "7/**")
    lab.map('[robot.outputs]\nbelief = true\nmiddleware = "rmw_zenoh"\n', more="domain = 7")
    wait_for(lambda: every.samples, "the belief")
    (sample, *_) = every.samples
    hashed = "RIHS01_ddd703be132ab0b69d33121f1bb034132bfbb3b0ac5f9fb1516005ba1c8a265b"
    assert sample.key == f"7/tb3_1/voa/belief/vision_msgs::msg::dds_::Detection3D_/{hashed}"
    assert sample.attachment is not None
    assert len(sample.attachment) == 33


def test_topics_are_announced_while_they_are_published(lab: RosLab) -> None:
    lab.map()
    alive = lab.bus.session.liveliness()

    def topics() -> set[str]:
        replies = list(alive.get("@/*/@ros2_lv/MP/*/*/*"))
        return {str(reply.ok.key_expr).split("/")[4].replace("§", "/") for reply in replies if reply.ok is not None}

    names = ("belief", "poses", "markers", "grasps", "best_grasp", "place")
    numbers = ("entropy_nats", "expected_score", "fit_rmsd_mm")
    expected = {f"tb3_1/voa/{name}" for name in names} | {f"tb3_1/voa/numbers/{name}" for name in numbers}
    wait_for(lambda: topics() == expected, "the announcements")
    lab.map("")
    wait_for(lambda: topics() == set(), "their end")


def test_the_scene_is_cleared_when_the_session_ends(lab: RosLab, tool: Tool) -> None:
    lab.map("[robot.outputs]\nmarkers = true\nrepeat_s = 60.0\n")
    tool.wait("markers", 2)
    assert lab.service.http.delete(f"/v1/sessions/{lab.session}").status_code == 204
    (marker,) = tool.read(MARKER_ARRAY, "markers", 3).markers
    assert marker.action == 3


def test_a_robot_mapped_to_a_scenario_shows_the_session_that_claims_it(lab: RosLab, tool: Tool) -> None:
    robot = f'[[robot]]\nname = "tb3_1"\nscenario = "{lab.scenario}"\nplace = {{ from = "attachment" }}\n'
    lab.mapping.write_text(robot + "outputs = { belief = true, repeat_s = 60.0 }\n")
    assert tool.read(DETECTION, "belief").id == lab.session, "the newest on the scenario"
    other = lab.service.open(lab.scenario, robots=["tb3_1"])
    assert tool.read(DETECTION, "belief", 2).id == other


def test_a_grasp_that_is_no_longer_the_best_is_not_repeated(lab: RosLab, tool: Tool) -> None:
    lab.map("[robot.outputs]\nbelief = true\nbest_grasp = true\nrepeat_s = 0.2\n")
    tool.wait("best_grasp", 2)  # G1, whose geometry is known
    lab.prefer([0.0, 1.0])  # G2 is the best grasp, and states no geometry
    wait_for(lambda: len(tool.read(DETECTION, "belief", len(tool.on("belief"))).results) == 1, "the new belief")
    before, seen = len(tool.on("best_grasp")), len(tool.on("belief"))
    tool.wait("belief", seen + 3)
    assert len(tool.on("best_grasp")) == before
