"""Models of scenarios: the precision of rankings, and the parts of a scenario that are cached."""

import math
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

from tests.support.serving import LIDAR, Json, box_obj, changed, data_scenario, mesh_scenario, serving
from voa_connections.settings import MEBIBYTE
from voa_core.assistance import value_of_assistance
from voa_core.lidars import SensorConfiguration
from voa_core.weights import wanted
from voa_service.bootstrap import services
from voa_service.mapping.models import Models, Precision
from voa_service.runtime.cache import Cache
from voa_service.settings import PrecisionSetting, Settings

POSES, SENSORS, BEAMS = 200, 4, 12


def large() -> Json:
    rng = np.random.default_rng(5)
    names = [f"P{i}" for i in range(POSES)]
    ranges = rng.uniform(0.2, 1.9, (SENSORS, POSES, BEAMS)).round(4).tolist()
    return data_scenario(
        poses=[{"name": name} for name in names],
        scores={"probabilities": rng.uniform(0.0, 1.0, (2, POSES)).tolist()},
        sensors=[{"name": f"S{a}", "x": 0.0, "y": 0.0, "yaw_rad": 0.0} for a in range(SENSORS)],
        predictions={f"S{a}": dict(zip(names, ranges[a], strict=True)) for a in range(SENSORS)},
        lidar=LIDAR | {"beams": BEAMS},
        update={"rule": "exponential"},
    )


def ranked(folder: Path, precision: Precision) -> Any:
    with serving(folder, precision=precision) as service:
        session = service.open(service.create(large()))
        first = service.get(f"/v1/sessions/{session}/voa?outcomes=true")
        assert service.get(f"/v1/sessions/{session}/voa?outcomes=true") == first
        return first


def test_float64_and_float32_agree(tmp_path_factory: pytest.TempPathFactory) -> None:
    exact, rough = (ranked(tmp_path_factory.mktemp(kind), kind) for kind in get_args(Precision))
    assert (exact["precision"], rough["precision"]) == ("float64", "float32")
    values = {look["sensor"]: look["voa"] for look in exact["ranking"]}
    assert {look["sensor"]: look["voa"] for look in rough["ranking"]} == pytest.approx(values, abs=1e-5)
    assert rough["expected_score_before"] == pytest.approx(exact["expected_score_before"], abs=1e-12)


def test_weights_that_are_streamed_agree_with_weights_that_are_kept(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        model = service.inside.sessions.models.get(service.create(large()))
        assert model is not None
        sensor = model.scenario.sensors[0]
        scenario = model.scenario
        kinds: list[tuple[Precision, bool]] = [(p, keep) for p in get_args(Precision) for keep in (False, True)]
        values = [
            value_of_assistance(
                model.weigher(sensor, precision, keep, wanted), scenario.prior, scenario.table, scenario.policy
            )
            for precision, keep in kinds
        ]
    for other in values[1:2]:
        assert other.voa == pytest.approx(values[0].voa, abs=1e-12)
    for other in values[2:]:
        assert other.voa == pytest.approx(values[0].voa, abs=1e-5)


@pytest.mark.parametrize(
    ("setting", "sensors", "poses", "expected", "is_kept_in_one_mebibyte"),
    [
        ("auto", 9, 100, "float64", True),
        ("auto", 10, 100, "float64", False),
        ("float32", 18, 100, "float32", True),
        ("float32", 19, 100, "float32", False),
        ("auto", 24, 3_162, "float64", False),
        ("auto", 24, 3_163, "float32", False),
        ("auto", 1, 20_000, "float32", False),
        ("float64", 1, 20_000, "float64", False),
        ("float64", 0, 100, "float64", True),
    ],
)
def test_the_setting_decides_on_the_precision_and_memory_on_what_is_kept(
    tmp_path: Path, setting: PrecisionSetting, sensors: int, poses: int, expected: str, is_kept_in_one_mebibyte: bool
) -> None:
    with services(Settings(database_url=f"sqlite:///{tmp_path}/voa.db")) as inside:
        small, large = (Models(inside.health.store, Cache(size * MEBIBYTE), setting) for size in (1, 2**20))
        precision = small.precision(sensors * poses**2)
        assert precision == large.precision(sensors * poses**2) == expected
        assert small.keeps_weights(sensors, poses, poses, precision) == is_kept_in_one_mebibyte
        assert large.keeps_weights(sensors, poses, poses, precision)


@pytest.mark.parametrize("precision", get_args(Precision))
def test_weights_that_are_said_to_fit_into_the_cache_do(tmp_path: Path, precision: Precision) -> None:
    with serving(tmp_path) as service:
        model = service.inside.sessions.models.get(service.create(large()))
        assert model is not None
        weigher = model.weigher(model.scenario.sensors[0], precision, True, wanted)
        assert weigher.panels is not None
        poses, held = len(model.scenario.poses), weigher.panels.nbytes
        for budget, fits in ((10 * held, True), (9 * held, False)):
            assert Models(service.inside.health.store, Cache(budget)).keeps_weights(9, poses, poses, precision) == fits


def test_a_model_is_rebuilt_from_the_store_when_the_cache_has_no_room(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        scenario = service.create(data_scenario())
        small = Models(service.inside.health.store, Cache(1))
        first, second = small.get(scenario), small.get(scenario)
        assert first is not None
        assert second is not None
        assert first is not second
        assert first.scenario.poses.names == second.scenario.poses.names
        assert small.get("nothing") is None


def test_nothing_that_is_kept_of_one_scenario_height_or_precision_serves_another(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        models = service.inside.sessions.models
        far = changed(data_scenario(name="far"), "predictions.Q1.P1", [0.7, 0.7, None, 1.0])
        above = SensorConfiguration("above", 0.3, 0.0, math.pi, height_m=0.06)
        bodies = [data_scenario(), far, *(mesh_scenario(service.upload(box_obj(x))) for x in (0.04, 0.05))]
        for _ in range(2):  # the second time everything is kept
            for body in bodies:
                model = models.get(service.create(body))
                assert model is not None
                fresh = Models(service.inside.sessions.store, Cache(0)).get(service.create(body))
                assert fresh is not None
                for sensor in [*model.scenario.sensors, *([above] if body["name"] == "mesh" else [])]:
                    for precision in get_args(Precision):
                        kept, rebuilt = (each.weigher(sensor, precision, True, wanted) for each in (model, fresh))
                        assert kept.panels is not None
                        assert rebuilt.panels is not None
                        assert kept.dtype == precision
                        np.testing.assert_array_equal(kept.panels.numbers, rebuilt.panels.numbers)
                        np.testing.assert_array_equal(kept.ranges, rebuilt.ranges)
