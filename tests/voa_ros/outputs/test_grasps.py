import pytest

from tests.support.views import stored_scenario
from voa_msgs.rankings import RankedGrasp, RankedGrasps
from voa_msgs.scenarios import Scenario
from voa_ros.outputs.fields import Fields, turned
from voa_ros.outputs.grasps import best_grasp, geometries, grasp_messages

GEOMETRY = {"tool_centre_point": [0.1, 0.2, 0.3], "approach": [0.0, -2.0, 0.0], "closing": [3.0, 0.0, 0.0]}


def scenario(*data: object) -> Scenario:
    grasps = [{"name": f"G{number}", "data": each} for number, each in enumerate(data)]
    scores = {"attempts": 10, "successes": [[1, 1]] * len(grasps)}
    return stored_scenario(grasps=grasps, scores=scores)


def ranked(**scores: float) -> RankedGrasps:
    return RankedGrasps(version=0, grasps=[RankedGrasp(name=n, expected_score=s) for n, s in scores.items()])


def axes(pose: Fields) -> list[tuple[float, ...]]:
    q = pose["orientation"]
    rotation = (q["w"], q["x"], q["y"], q["z"])
    return [turned(rotation, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]


def test_the_tool_points_along_the_approach_with_x_along_the_closing() -> None:
    best = best_grasp(scenario(GEOMETRY), "G0", "world")
    assert best is not None
    x, y, z = axes(best["pose"])
    assert z == pytest.approx((0.0, -1.0, 0.0), abs=1e-12)
    assert x == pytest.approx((1.0, 0.0, 0.0), abs=1e-12)
    assert y == pytest.approx((0.0, 0.0, 1.0), abs=1e-12)
    assert best["pose"]["position"] == {"x": 0.1, "y": 0.2, "z": 0.3}


def test_grasps_come_best_first_and_without_those_that_never_succeed() -> None:
    own = scenario(GEOMETRY, GEOMETRY, GEOMETRY)
    made = grasp_messages(own, ranked(G2=0.9, G0=0.4, G1=0.0), "world")
    assert [(each["id"], each["grasp_quality"]) for each in made] == [("G2", 0.9), ("G0", 0.4)]


def test_a_grasp_without_geometry_is_left_out() -> None:
    own = scenario({"width_m": 0.1}, GEOMETRY, {"tool_centre_point": "here"}, None)
    assert list(geometries(own)) == ["G1"]
    assert [each["id"] for each in grasp_messages(own, ranked(G0=0.9, G1=0.8, G2=0.7), "world")] == ["G1"]
    assert best_grasp(own, "G0", "world") is None
    assert best_grasp(own, None, "world") is None


def test_at_most_ten_grasps_fill_the_queue_of_a_subscriber() -> None:
    own = scenario(*[GEOMETRY] * 12)
    assert len(grasp_messages(own, ranked(**{f"G{number}": 0.5 for number in range(12)}), "world")) == 10
