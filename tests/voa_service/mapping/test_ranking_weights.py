"""Weights of the looks in a ranking: which are kept, and which looks of a session they contain."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.support.places import spread_scenario
from tests.support.serving import Service, serving
from voa_core.checks import Floats
from voa_core.places import Viewpoint
from voa_core.simulated_weights import SimulatedWeights
from voa_core.weights import wanted
from voa_msgs.rankings import VoaRequest
from voa_service.mapping.looks import LookRecord, PlaceRecord
from voa_service.mapping.models import Model
from voa_service.mapping.ranking_tasks import RankingTask, SessionLooks, ranking_task
from voa_service.mapping.ranking_weights import Weighing, looks_of

EAST = Viewpoint("E", 0.3, 0.0, 3.141592653589793, 0.02)
KEEP, STREAM = Weighing("float64", True, wanted), Weighing("float64", False, wanted)
SUMS: Floats = np.random.default_rng(1).normal(size=(2, 64))


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with serving(tmp_path_factory.mktemp("weights")) as running:
        yield running


@pytest.fixture(scope="module")
def model(service: Service) -> Model:
    stored = service.inside.sessions.models.get(spread_scenario(service))
    assert stored is not None
    return stored


LogSums = Callable[[int, int], Floats]


def session(name: str, looks: int, log_sums: LogSums = lambda _index, _copies: SUMS) -> SessionLooks:
    """A session that has looked from E so many times."""
    return SessionLooks(name, LookRecord((PlaceRecord(EAST, looks, 64),)), log_sums=log_sums)


def task(model: Model, looks: SessionLooks | None = None, **fields: Any) -> RankingTask:
    request = VoaRequest.model_validate({"samples": 3} | fields)
    return ranking_task(model, None, request, None, looks or SessionLooks())


def weights(own: RankingTask, weighing: Weighing = KEEP, sensor: int = 0, scans: int = 1) -> SimulatedWeights:
    usual, _ = looks_of(own, weighing)
    made = usual.of(own.sensors[sensor], scans)
    assert isinstance(made, SimulatedWeights)
    return made


def test_weights_are_kept_for_rankings_of_other_beliefs(model: Model) -> None:
    assert weights(task(model)) is weights(task(model, lookahead=1))
    assert weights(task(model), STREAM) is not weights(task(model), STREAM)


def test_looks_of_a_session_are_in_the_weights_of_their_place_alone(model: Model) -> None:
    own, plain = task(model, session("S", 1)), task(model)
    assert weights(own) is not weights(plain)
    assert weights(own) is weights(task(model, session("S", 1)))
    assert weights(own, sensor=1) is weights(plain, sensor=1), "nobody looked from N"


@pytest.mark.parametrize("other", [session("T", 1), session("S", 2), replace(session("S", 1), record=replace(
    session("S", 1).record, since=4))], ids=["another session", "another look", "another belief"])  # fmt: skip
def test_weights_with_other_looks_inside_are_other_weights(model: Model, other: SessionLooks) -> None:
    assert weights(task(model, session("S", 1))) is not weights(task(model, other))


@pytest.mark.parametrize("request_", [{"samples": 4}, {"sensor_std": {"xy_m": 0.01, "yaw_rad": 0.0}}])
def test_weights_of_other_scans_are_other_weights(model: Model, request_: dict[str, Any]) -> None:
    assert weights(task(model)) is not weights(task(model, **request_))
    assert weights(task(model)) is not weights(task(model), scans=2)
    assert weights(task(model)) is not weights(task(model), Weighing("float32", True, wanted))


def test_earlier_looks_have_as_many_copies_as_the_next_look(model: Model) -> None:
    requested: list[tuple[int, int]] = []

    def log_sums(index: int, copies: int) -> Floats:
        requested.append((index, copies))
        return np.zeros((2, copies))

    weights(task(model, session("U", 1, log_sums)))
    weights(task(model, session("U", 1, log_sums), sensor_std={"xy_m": 0.03, "yaw_rad": 0.0}))
    assert requested == [(0, 64), (0, 256)]


def test_looks_that_weigh_all_copies_alike_are_not_computed(model: Model) -> None:
    def never(_index: int, _copies: int) -> Floats:
        raise AssertionError("they have no effect on later looks")

    looks = SessionLooks("V", LookRecord((PlaceRecord(EAST, 3, 1),)), log_sums=never)
    assert weights(task(model, looks)) is weights(task(model))


def test_the_best_look_is_valued_again_on_four_times_as_many_scans(model: Model) -> None:
    own = task(model)
    _, fresh = looks_of(own, KEEP)
    assert fresh is not None
    again = fresh.of(own.sensors[0], 1)
    assert isinstance(again, SimulatedWeights)
    assert (again.samples, weights(own).samples) == (12, 3)


def test_exact_scans_have_no_fresh_ones(model: Model) -> None:
    _, fresh = looks_of(task(model, scans="exact"), KEEP)
    assert fresh is None


def test_looks_from_nearly_one_place_are_together(model: Model) -> None:
    near = [{"x": 0.5, "y": 0.0, "yaw_rad": 3.0}, {"x": 0.51, "y": 0.0, "yaw_rad": 3.0}, "E"]
    own = task(model, sensors=near)
    looks, _ = looks_of(own, KEEP)
    assert looks.same_place(own.sensors[0], own.sensors[1])
    assert not looks.same_place(own.sensors[0], own.sensors[2])
