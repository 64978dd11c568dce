import math
from collections.abc import Callable, Hashable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.voa_core.worlds import HERE, box, data_predictor, lidar_of, standing
from voa_core.errors import BeamGridMismatch, InvalidInput, NoMesh
from voa_core.lidars import BeamGrid, SensorConfiguration
from voa_core.poses import PoseSet
from voa_core.prediction import ObservationPredictor, Prediction, predictor_of_mesh

INF = math.inf
LIDAR = lidar_of(4, range_max=2.0)
CUBE = box(0.2, 0.2, 0.2)
AT = SensorConfiguration("a", -0.3, 0.1, 0.0)
RANGES = np.array([[0.5, INF, INF, 1.9], [0.6, INF, INF, 2.1]])


def test_a_prediction_keeps_the_beams_on_which_some_pose_returns() -> None:
    prediction = Prediction.of_dense(LIDAR.grid, RANGES)
    assert prediction.columns.tolist() == [0, 3]
    np.testing.assert_array_equal(prediction.dense(), RANGES)
    assert prediction.nbytes == 2 * 8 + 4 * 8


def test_a_prediction_may_be_empty() -> None:
    prediction = Prediction.of_dense(LIDAR.grid, np.full((2, 4), INF))
    assert prediction.columns.tolist() == []
    assert prediction.dense().tolist() == [[INF] * 4] * 2


def test_data_are_predictions_up_to_range_max() -> None:
    given = data_predictor(RANGES, LIDAR).predict(HERE, listed=True).dense()
    assert given.tolist() == [[0.5, INF, INF, 1.9], [0.6, INF, INF, INF]]


def test_data_hold_for_listed_sensors_and_the_mesh_for_others() -> None:
    mesh = predictor_of_mesh(CUBE, standing((0.0, 0.0, 0.0)), LIDAR)
    both = ObservationPredictor(mesh.poses, LIDAR, {"a": np.array([[0.7, INF, INF, INF]])}, mesh.contours_at)
    assert both.predict(AT, listed=True).dense()[0, 0] == 0.7
    assert both.predict(AT).dense()[0, 0] == pytest.approx(0.3)
    assert both.predict(SensorConfiguration("b", -0.4, 0.1, 0.0), listed=True).dense()[0, 0] == pytest.approx(0.4)


def test_a_mesh_serves_other_beams_where_data_cannot() -> None:
    mesh = predictor_of_mesh(CUBE, standing((0.0, 0.0, 0.0)), LIDAR)
    both = ObservationPredictor(mesh.poses, LIDAR, {"a": np.array([[0.7, INF, INF, INF]])}, mesh.contours_at)
    other = BeamGrid(3, 0.0, 0.01)
    prediction = both.predict(AT, other, listed=True)
    assert prediction.grid is other
    assert prediction.dense()[0, 0] == pytest.approx(0.3)


def test_data_alone_do_not_serve_other_beams() -> None:
    with pytest.raises(BeamGridMismatch, match=r"4 from 0 rad by 1\.5708 rad.*predictions of 'here' are data"):
        data_predictor(RANGES, LIDAR).predict(HERE, BeamGrid(5, 0.0, 0.1), listed=True)


def test_data_alone_do_not_serve_other_places() -> None:
    with pytest.raises(NoMesh, match=r"no predictions for sensor 'a' and no mesh.*are given for \['here'\]"):
        data_predictor(RANGES, LIDAR).predict(AT)


@pytest.mark.parametrize(
    ("ranges", "message"),
    [
        (np.ones((2, 3)), r"predictions of 'here': expected shape \(poses, beams\) = \(2, 4\), got shape \(2, 3\)"),
        (np.full((2, 4), -0.1), "predictions of 'here': expected ranges of at least 0, or none, got a negative one"),
        (np.full((2, 4), math.nan), "expected ranges of at least 0"),
    ],
)
def test_data_that_cannot_be_are_refused(
    ranges: np.ndarray[tuple[int, int], np.dtype[np.float64]], message: str
) -> None:
    with pytest.raises(InvalidInput, match=message):
        ObservationPredictor(PoseSet.named(["A", "B"]), LIDAR, {"here": ranges})


def test_the_sensors_own_height_wins_over_the_lidars() -> None:
    pyramid_poses = standing((0.0, 0.0, 0.0))
    predictor = predictor_of_mesh(CUBE, pyramid_poses, LIDAR)
    above = SensorConfiguration("a", -0.3, 0.1, 0.0, height_m=0.25)
    assert predictor.predict(AT).dense()[0, 0] == pytest.approx(0.3)
    assert predictor.predict(above).dense()[0, 0] == INF


@pytest.mark.parametrize(
    ("sensor", "grid", "listed"),
    [
        (AT, None, True),
        (replace(AT, name="b"), None, True),
        (replace(AT, x=-0.4), None, False),
        (replace(AT, y=0.3), None, False),
        (replace(AT, yaw_rad=0.3), None, False),
        (replace(AT, height_m=0.25), None, False),
        (AT, BeamGrid(3, 0.0, 0.01), False),
        (AT, BeamGrid(4, 0.2, LIDAR.grid.angle_increment), False),
    ],
)
def test_what_is_remembered_is_not_taken_for_another_prediction(
    sensor: SensorConfiguration, grid: BeamGrid | None, listed: bool
) -> None:
    mesh = predictor_of_mesh(CUBE, standing((0.0, 0.0, 0.0)), LIDAR)
    data = {"a": np.array([[0.7, INF, INF, INF]]), "b": np.array([[0.8, INF, INF, INF]])}
    kept: dict[Hashable, Prediction] = {}

    def remember(key: Hashable, make: Callable[[], Any]) -> Any:
        if key not in kept:
            kept[key] = make()
        return kept[key]

    forgetful = ObservationPredictor(mesh.poses, LIDAR, data, mesh.contours_at)
    keeping = replace(forgetful, remember=remember)
    first = keeping.predict(AT)
    assert keeping.predict(replace(AT, name="another", cost=0.5)) is first
    prediction = keeping.predict(sensor, grid, listed=listed)
    assert keeping.predict(sensor, grid, listed=listed) is prediction
    np.testing.assert_array_equal(prediction.dense(), forgetful.predict(sensor, grid, listed=listed).dense())
    assert prediction.dense().tolist() != first.dense().tolist()


def test_without_memory_nothing_is_kept() -> None:
    def refuse(key: Hashable, make: Callable[[], Any]) -> Any:
        raise AssertionError(f"{key} is kept")

    keeping = replace(predictor_of_mesh(CUBE, standing((0.0, 0.0, 0.0)), LIDAR), remember=refuse)
    forgetful = keeping.without_memory()
    assert forgetful.predict(AT).dense().tolist() == forgetful.predict(AT).dense().tolist()
    with pytest.raises(AssertionError, match="is kept"):
        keeping.predict(AT)


def test_someone_must_say_where_to_cut() -> None:
    predictor = predictor_of_mesh(CUBE, standing((0.0, 0.0, 0.0)), lidar_of(4, height=None))
    with pytest.raises(NoMesh, match="sensor 'a' has no height_m, nor has the lidar"):
        predictor.predict(AT)
    low = SensorConfiguration("a", -0.3, 0.1, 0.0, height_m=0.05)
    assert predictor.predict(low).dense()[0, 0] == pytest.approx(0.3)


def test_each_height_is_cut_once() -> None:
    predictor = predictor_of_mesh(CUBE, standing((0.0, 0.0, 0.0)), LIDAR)
    assert predictor.contours_at is not None
    assert predictor.contours_at(0.1) is predictor.contours_at(0.1)
    assert predictor.contours_at(0.1) is not predictor.contours_at(0.05)
