"""Functions as bytes, in which a scenario is named."""

import threading
from collections.abc import Callable

import pytest

from tests.voa_service.local.documents import data_document, local
from voa_service.cluster.sending import dumped, loaded, named_parts
from voa_service.local.document import read_document
from voa_service.local.ranking import stored
from voa_service.mapping.models import Model


@pytest.fixture(scope="module")
def model() -> Model:
    with local() as built:
        id_, _ = stored(built, read_document(data_document({})))
        built_model = built.rankings.models.get(id_)
        assert built_model is not None
        return built_model


def adder(lock: object, model: Model, more: float) -> Callable[[int], float]:
    """A nested function that holds what cannot be sent, and a number that is sent with it."""

    def add(item: int) -> float:
        assert lock
        return item + more + len(model.scenario.poses)

    return add


def test_a_nested_function_arrives_with_what_it_holds(model: Model) -> None:
    here, there = threading.Lock(), threading.Lock()
    content = dumped(adder(here, model, 0.5), {"lock": here, "model": model})
    assert loaded(content, {"lock": there, "model": model})(1) == 4.5


def test_what_has_no_name_and_cannot_be_sent_is_an_error(model: Model) -> None:
    with pytest.raises(TypeError, match="lock"):
        dumped(adder(threading.Lock(), model, 0.5), {"model": model})


def test_a_scenario_its_parts_and_the_check_are_named(model: Model) -> None:
    def check() -> None:
        raise AssertionError

    named = named_parts(model, check)
    scenario = model.scenario
    held = (model, scenario, scenario.predictor, scenario.poses, scenario.table, scenario.prior, check)
    content = dumped(lambda: held, named)
    assert len(content) < 2_000, "the names alone are sent"
    read = loaded(content, named)()
    assert all(one is other for one, other in zip(read, held, strict=True))
