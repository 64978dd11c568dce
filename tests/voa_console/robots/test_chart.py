"""Chart of a scan from above: points in the world, whatever the reading, and the part that is shown."""

import math
from typing import Any

import pytest

from tests.support.serving import Service
from voa_client import Scan, Scenario
from voa_console.robots.chart import drawing_of, legend, options
from voa_console.robots.readings import AS_MEASURED, MIRRORED
from voa_msgs.geometry import UncertainSensorPose

PLACE = UncertainSensorPose(x=1.0, y=0.0, yaw_rad=math.pi)
SCAN = Scan(ranges=[0.5, 0.5, None, 0.0], angle_min=0.0, angle_increment=math.pi / 2)


@pytest.fixture
def scenario(service: Service, mesh_id: str) -> Scenario:
    return Scenario.model_validate_json(service.http.get(f"/v1/scenarios/{mesh_id}").content)


def rounded(points: Any) -> list[tuple[float, float]]:
    return [(round(x, 6) + 0.0, round(y, 6) + 0.0) for x, y in points]


def test_points_are_in_the_world() -> None:
    assert rounded(drawing_of(SCAN, PLACE, None).inside) == [(0.5, 0.0), (1.0, -0.5)]
    assert rounded(drawing_of(SCAN, PLACE, None, MIRRORED).inside) == [(0.5, 0.0), (1.0, 0.5)]
    assert rounded(drawing_of(SCAN, None, None).inside) == [(0.5, 0.0), (0.0, 0.5)]


def test_a_prediction_is_drawn_in_pieces(scenario: Scenario) -> None:
    predicted: list[float | None] = [None, 1.0, 1.0, None, None, 1.0, 1.2]
    drawing = drawing_of(SCAN, PLACE, scenario, AS_MEASURED, predicted, "A")
    pieces = "".join("." if point is None else "x" for point in drawing.outline)
    assert pieces == "xx.x.x"
    assert ("prediction of pose 'A'", "#e69f00") in legend(drawing)


def test_each_part_is_square_and_contains_what_it_names(scenario: Scenario) -> None:
    far = Scan(ranges=[3.0, 0.5], angle_min=0.0, angle_increment=math.pi / 2)
    drawing = drawing_of(far, PLACE, scenario, AS_MEASURED, [0.98, 0.98], "A")
    edges = []
    for window in ("Object", "Table", "Room"):
        shown = options(drawing, window)
        (left, right), (low, high) = ((shown[axis]["min"], shown[axis]["max"]) for axis in ("xAxis", "yAxis"))
        assert right - left == pytest.approx(high - low, abs=1e-3)
        edges.append(right - left)
    assert edges[0] < edges[1] < edges[2]
    assert edges[0] == pytest.approx(0.1)
    assert edges[2] > 2 * 2.0
