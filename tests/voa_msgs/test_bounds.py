"""Every list and mapping of a request has a limit, and reading stops at its first mistakes."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Annotated, Any

import pytest
from annotated_types import Len
from pydantic import BaseModel, TypeAdapter, ValidationError

from voa_msgs.bounds import MOST_ERRORS, LimitedBy, OneMistake
from voa_msgs.keys import Attachment
from voa_msgs.rankings import RankingRequest, VoaRequest
from voa_msgs.robots import ClaimRequest
from voa_msgs.scenarios import PredictionsRequest, ScenarioRequest
from voa_msgs.sessions import BeliefRequest, OutcomeRequest, ScanRequest, SessionRequest, UpdateRequest

REQUESTS = [
    Attachment,
    BeliefRequest,
    ClaimRequest,
    OutcomeRequest,
    PredictionsRequest,
    RankingRequest,
    ScanRequest,
    ScenarioRequest,
    SessionRequest,
    UpdateRequest,
    VoaRequest,
]
Few = Annotated[list[Annotated[list[int], LimitedBy("inner")]], LimitedBy("outer")]
Named = Annotated[dict[str, Annotated[list[int], LimitedBy("inner")]], LimitedBy("outer")]
LIMITS = SimpleNamespace(outer=100, inner=50, count=3)


def lists(node: Any, wrapped: bool = False) -> Iterator[tuple[str, bool]]:
    """Lists and mappings in a schema, and whether each is bounded."""
    if isinstance(node, dict) and "JsonValue" not in str(node.get("ref")):  # measured by `voa_msgs.base.Free` itself
        kind = node.get("type")
        if kind == "dict":
            yield str(node.get("metadata", node)), wrapped
        if kind == "list":
            yield str(node)[:200], bool(node.get("fail_fast")) and (wrapped or "max_length" in node)
        for name, child in node.items():
            if name not in ("metadata", "serialization"):
                yield from lists(child, kind == "function-wrap" and name == "schema")
    elif isinstance(node, list | tuple):
        for child in node:
            yield from lists(child)


@pytest.mark.parametrize("kind", REQUESTS)
def test_every_list_and_mapping_of_a_request_is_bounded(kind: type[BaseModel]) -> None:
    unbounded = [where for where, bounded in lists(kind.__pydantic_core_schema__) if not bounded]
    assert unbounded == []


def test_there_are_lists_to_look_at() -> None:
    assert len(list(lists(ScenarioRequest.__pydantic_core_schema__))) > 10


def mistakes(kind: Any, value: Any, context: Any = LIMITS) -> list[Any]:
    with pytest.raises(ValidationError) as error:
        TypeAdapter(kind).validate_python(value, context=context, strict=True)
    return list(error.value.errors())


@pytest.mark.parametrize(
    ("kind", "value", "loc"),
    [(Few, [[0]] * 101, ()), (Few, [[0], ["a"] * 51], (1,)), (Named, {str(i): 0 for i in range(101)}, ())],
)
def test_what_is_too_long_is_said_once_whatever_is_in_it(kind: Any, value: Any, loc: tuple[Any, ...]) -> None:
    [mistake] = mistakes(kind, value)
    assert (mistake["type"], mistake["loc"]) == ("too_many", loc)


def test_without_limits_there_are_none() -> None:
    assert TypeAdapter(Few).validate_python([[0]] * 1_000) == [[0]] * 1_000


def test_a_count_is_limited_too_however_large() -> None:
    count = TypeAdapter(Annotated[int, LimitedBy("count")])
    assert count.validate_python(3, context=LIMITS) == 3
    for most in (4, 10**400):
        with pytest.raises(ValidationError, match="at most 3"):
            count.validate_python(most, context=LIMITS)


def test_mistakes_stand_at_their_own_index() -> None:
    wrong = mistakes(Few, [[0], ["a", 1, "b"], 5, [2], [3, "c"]])
    assert [each["loc"] for each in wrong] == [(1, 0), (1, 2), (2,), (4, 1)]


@pytest.mark.parametrize("value", [[["a"] * 50] * 100, [0] * 100, [[0, "a"]] * 100])
def test_there_are_never_more_than_the_most(value: Any) -> None:
    assert len(mistakes(Few, value)) == MOST_ERRORS
    assert len(mistakes(Named, dict(zip(map(str, range(100)), value, strict=True)))) == MOST_ERRORS


@pytest.mark.parametrize("value", [{}, {"a": 1}, "a", None, 5])
def test_what_is_no_list_is_refused(value: Any) -> None:
    assert mistakes(Few, value)[0]["type"] == "list_type"


def test_a_short_list_is_read_to_its_first_mistake() -> None:
    assert len(mistakes(Annotated[list[int], OneMistake(), Len(2, 2)], ["a"] * 100)) == 1
