"""Scenes: equal views give equal scenes, whose shapes mean what their labels say."""

import math

import pytest

from tests.support.views import OBJECT, ranking, stored_scenario, view
from voa_msgs.geometry import PoseUncertainty, UncertainSensorPose
from voa_scene import colours
from voa_scene.ghosts import MOST_GHOSTS, percent
from voa_scene.scene import scene_of
from voa_scene.shapes import Box, Colour, Cylinder, MeshShape, Polyline, Text
from voa_scene.views import RobotPlace

GRASP = {"tool_centre_point": [0.1, 0.0, 0.05], "approach": [0, 0, -2], "closing": [0, 1, 0], "width_m": 0.03}


def test_equal_views_give_equal_scenes_with_unique_names() -> None:
    facts = {"ranking": ranking(), "robots": [RobotPlace("tb3", UncertainSensorPose(x=1.0, y=0.0, yaw_rad=0.0))]}
    scene = scene_of(view(**facts))
    assert scene == scene_of(view(**facts))
    names = [(shape.group, shape.name) for shape in scene.shapes]
    assert len(names) == len(set(names))


def test_ghosts_are_the_more_opaque_the_likelier_and_the_likeliest_is_orange() -> None:
    first, second = (shape for shape in scene_of(view()).of("belief") if isinstance(shape, MeshShape))
    assert (first.name, first.label, first.object) == ("A", "A: 75 %", OBJECT)
    assert first.colour.hex == colours.ORANGE.hex
    assert second.colour.hex == colours.GREY.hex
    assert first.colour.opacity > second.colour.opacity > 0.05


def test_impossible_poses_have_no_ghost_and_no_more_than_60_are_drawn() -> None:
    poses = [{"name": f"P{i}", "position": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]} for i in range(80)]
    many = stored_scenario(poses=poses, scores={"probabilities": [[0.5] * 80] * 2})
    assert len(scene_of(view(scenario=many, belief=[1 / 80] * 80)).of("belief")) == MOST_GHOSTS
    assert [shape.name for shape in scene_of(view(belief=[0.0, 1.0])).of("belief")] == ["B"]


def test_towers_are_as_high_as_their_voa_and_say_how_they_compare() -> None:
    shapes = scene_of(view(ranking=ranking())).of("looks")
    east, north = (shape for shape in shapes if isinstance(shape, Cylinder))
    assert east.height / north.height == pytest.approx(0.3 / 0.29)
    assert east.label == "E: VOA +0.300 ± 0.010, recommended"
    assert north.label == "N: VOA +0.290, about equal to the best"
    assert (east.colour.hex, north.colour.hex) == (colours.BLUE.hex, colours.SKY_BLUE.hex)
    bar = next(shape for shape in shapes if shape.name == "E error")
    assert isinstance(bar, Polyline)
    assert bar.points[1][2] - bar.points[0][2] == pytest.approx(east.height * 4 * 0.01 / 0.3)
    assert not [shape for shape in shapes if shape.name == "N error"]
    assert [shape.text for shape in shapes if isinstance(shape, Text)] == ["E", "N"]


def test_both_places_of_a_recommended_pair_are_marked() -> None:
    pair = ranking(action="look", sensor="N", net_value=0.4, then="E")
    towers = [shape for shape in scene_of(view(ranking=pair)).of("looks") if isinstance(shape, Cylinder)]
    assert {tower.colour.hex for tower in towers} == {colours.BLUE.hex}


def test_places_without_a_ranking_are_flat_discs() -> None:
    towers = [shape for shape in scene_of(view()).of("looks") if isinstance(shape, Cylinder)]
    assert [tower.label for tower in towers] == ["E", "N"]
    assert max(tower.height for tower in towers) < 0.01


def test_the_gripper_closes_about_the_tool_centre_point() -> None:
    scenario = stored_scenario(grasps=[{"name": "G1", "data": GRASP}, {"name": "G2", "data": {"angle": 3}}])
    shapes = scene_of(view(scenario=scenario, best_grasp="G1")).of("grasp")
    fingers = [shape for shape in shapes if isinstance(shape, Box) and shape.name.startswith("finger")]
    assert [finger.position[1] for finger in fingers] == pytest.approx([-0.021, 0.021])
    assert all(finger.position[2] == pytest.approx(0.075) for finger in fingers)  # it comes from above
    line = next(shape for shape in shapes if isinstance(shape, Polyline))
    assert line.points[1] == (0.1, 0.0, 0.05)
    assert not scene_of(view(scenario=scenario, best_grasp="G2")).of("grasp")
    assert not scene_of(view(scenario=scenario)).of("grasp")


def test_data_that_break_the_convention_draw_no_gripper() -> None:
    scenario = stored_scenario(grasps=[{"name": "G1", "data": GRASP | {"closing": [0, 0, 1]}}, {"name": "G2"}])
    assert not scene_of(view(scenario=scenario, best_grasp="G1")).of("grasp")


def test_a_robot_has_two_standard_deviations_of_its_pose() -> None:
    place = UncertainSensorPose(x=0.4, y=0.1, yaw_rad=math.pi / 2, std=PoseUncertainty(xy_m=0.01, yaw_rad=0.02))
    shapes = {shape.name: shape for shape in scene_of(view(robots=[RobotPlace("tb3", place)])).of("robot")}
    assert set(shapes) == {"tb3", "tb3 heading", "tb3 name", "tb3 position", "tb3 yaw"}
    circle = shapes["tb3 position"]
    assert isinstance(circle, Polyline)
    assert math.hypot(*circle.points[0][:2]) == pytest.approx(0.02)
    assert shapes["tb3"].label == "tb3: x 0.400 m, y 0.100 m, yaw 90°"
    certain = UncertainSensorPose(x=0.4, y=0.1, yaw_rad=0.0)
    assert len(scene_of(view(robots=[RobotPlace("tb3", certain)])).of("robot")) == 3


def test_the_workspace_is_outlined_where_there_is_one() -> None:
    assert [shape.name for shape in scene_of(view()).of("table")] == ["table"]
    scenario = stored_scenario(workspace={"min": [-0.2, -0.1], "max": [0.2, 0.1]})
    _, outline = scene_of(view(scenario=scenario)).of("table")
    assert isinstance(outline, Polyline)
    assert outline.closed
    assert outline.points[2][:2] == (0.2, 0.1)


def test_a_scenario_of_recorded_scans_has_no_ghosts() -> None:
    scenario = stored_scenario().model_copy(update={"object": None})
    assert not scene_of(view(scenario=scenario)).of("belief")


@pytest.mark.parametrize(
    ("probability", "words"),
    [(0.0, "0 %"), (0.004, "below 1 %"), (0.5, "50 %"), (0.995, "above 99 %"), (1.0, "100 %")],
)
def test_shares_claim_no_certainty_that_rounding_made(probability: float, words: str) -> None:
    assert percent(probability) == words


def test_colours_are_written_for_browsers() -> None:
    assert Colour(1.0, 0.5, 0.0).hex == "#ff8000"
    assert colours.VERMILION.hex == "#d55e00"
