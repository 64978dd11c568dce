"""Points of a scan: each has the class that the service gives its beam."""

import math
from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tests.support.views import stored_scenario
from voa_core.lidars import SensorConfiguration
from voa_core.scans import Scan as CoreScan
from voa_core.scans import classify
from voa_core.workspace import Workspace as CoreWorkspace
from voa_msgs.geometry import SensorPose
from voa_msgs.lidars import Lidar, Zero
from voa_msgs.scenarios import Workspace
from voa_msgs.sessions import Scan
from voa_scene.scans import bearings, classified, scan_shapes
from voa_scene.shapes import Points, Polyline
from voa_scene.views import TakenScan
from voa_service.mapping.lidars import lidar_model

BOX = Workspace(min=[-0.2, -0.2], max=[0.2, 0.2])
BEAMS = 40
ZEROS: list[Zero] = ["missing", "no_return"]
lidars = st.sampled_from(ZEROS).map(
    lambda zero: Lidar(
        beams=BEAMS,
        angle_min=-0.5,
        angle_increment=0.15,
        range_min=0.1,
        range_max=0.9,
        height_m=0.02,
        zero=zero,
        noise_m=0.01,
        noise_ratio=0.0,
        dropout=0.0,
    )
)
ranges = st.lists(st.none() | st.just(0.0) | st.floats(0.0, 1.2), min_size=BEAMS, max_size=BEAMS)
places = st.builds(
    lambda x, y, yaw: SensorPose(x=x, y=y, yaw_rad=yaw),
    st.floats(-0.6, 0.6),
    st.floats(-0.6, 0.6),
    st.floats(-3.0, 3.0),
)


@given(lidars, ranges, places, st.sets(st.integers(0, BEAMS - 1)), st.none() | st.just(0.3))
def test_classes_are_those_of_the_service(
    lidar: Lidar, values: list[float | None], place: SensorPose, empty: set[int], near: float | None
) -> None:
    scan = Scan(ranges=values, no_return=sorted(empty), range_min=near)
    taken = TakenScan(scan, place)
    model = lidar_model(lidar)
    stand = SensorConfiguration("Q", place.x, place.y, place.yaw_rad, 0.02)
    crossing = CoreWorkspace((-0.2, -0.2), (0.2, 0.2)).crossing(stand, model.grid.angles)
    raw = np.array([math.nan if value is None else value for value in values])
    beams = classify(CoreScan(raw, model.grid, tuple(sorted(empty)), near), model, crossing)
    crosses = np.isfinite(crossing.enter)
    counts = {"return": int(np.isfinite(beams).sum()), "no-return": int((np.isposinf(beams) & crosses).sum())}
    kinds = [kind for kind, _ in classified(taken, lidar, BOX)]
    assert {kind: kinds.count(kind) for kind in counts} == counts  # type: ignore[arg-type] # keys of one literal type
    assert kinds.count("missing") <= int(np.isnan(beams).sum())


def test_points_lie_where_the_beams_ended() -> None:
    scenario = stored_scenario(workspace={"min": [-0.2, -0.2], "max": [0.2, 0.2]})
    scan = Scan(ranges=[0.25, 0.05, None, 0.4, 0.6], angle_min=0.0, angle_increment=0.1, range_min=0.0)
    taken = TakenScan(scan, SensorPose(x=0.3, y=0.0, yaw_rad=math.pi))
    points = {shape.name: shape for shape in scan_shapes(scenario, taken) if isinstance(shape, Points)}
    assert set(points) == {"return", "missing", "no-return"}
    assert np.allclose(points["return"].points[0], (0.05, 0.0, 0.02))
    assert np.allclose(points["missing"].points[0], (0.3 - 0.05 * math.cos(0.1), -0.05 * math.sin(0.1), 0.02))
    assert len(points["return"].points) == 2
    x, y, _ = points["no-return"].points[0]
    assert math.isclose(min(0.2 - abs(x), 0.2 - abs(y)), 0.0, abs_tol=1e-9)


def test_the_prediction_is_drawn_below_the_points_in_pieces() -> None:
    scenario = stored_scenario()
    beams = scenario.lidar.beams or 0
    predicted: list[float | None] = [None] * beams
    predicted[3:6] = [0.2, 0.2, 0.2]
    predicted[7:9] = [0.2, 0.3]
    predicted[20:22] = [0.25, 0.25]
    taken = TakenScan(Scan(ranges=[None] * beams), SensorPose(x=0.3, y=0.0, yaw_rad=math.pi), predicted)
    lines = [shape for shape in scan_shapes(scenario, taken) if isinstance(shape, Polyline)]
    assert [len(line.points) for line in lines] == [3, 2]
    assert lines[0].points[0][2] < 0.02
    assert bearings(taken, scenario.lidar)[0] == math.pi


def test_a_scan_without_a_workspace_has_returns_alone() -> None:
    scenario = stored_scenario()
    scan = Scan(ranges=[0.25, None, 0.0, 30.0], angle_min=0.0, angle_increment=0.1)
    shapes = scan_shapes(scenario, replace(TakenScan(scan, SensorPose(x=0.0, y=0.0, yaw_rad=0.0))))
    assert [shape.name for shape in shapes] == ["return", "lidar"]
