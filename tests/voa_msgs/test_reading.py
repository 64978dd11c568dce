"""Descriptions of the mistakes in a message: the field, what was expected, and the known names."""

import copy
import json
import math
from collections.abc import Iterator
from typing import Any

import pytest
from pydantic import BaseModel

from tests.support.serving import box_obj, data_scenario, mesh_scenario, scan_of
from voa_msgs import examples
from voa_msgs.rankings import RankingRequest, VoaRequest
from voa_msgs.reading import InvalidMessage, read_json, read_message
from voa_msgs.scenarios import PredictionsRequest, ScenarioRequest
from voa_msgs.sessions import BeliefRequest, OutcomeRequest, ScanRequest, SessionRequest, UpdateRequest

Json = dict[str, Any]
HERE = {"x": 0.0, "y": 0.0, "yaw_rad": 0.0}
MODEL = {"form": "pose_model", "categories": [{"pose": "P1", "probability": 1.0}]}
BODIES: list[tuple[type[BaseModel], Json]] = [
    (ScenarioRequest, examples.SCENARIO),
    (ScenarioRequest, data_scenario(prior=MODEL)),
    (ScenarioRequest, mesh_scenario(box_obj()[:64], workspace={"min": [0, 0], "max": [1, 1]})),
    (ScenarioRequest, data_scenario(update={"rule": "margin", "margin_m": 0.008})),
    (ScenarioRequest, data_scenario(update={"rule": "gaussian", "sigma_m": 1.0})),
    (ScenarioRequest, data_scenario(update={"rule": "inverse_rmsd", "floor_m": 0.001})),
    (ScenarioRequest, data_scenario(update={"rule": "beam", "temper": 0.5})),
    (SessionRequest, {"scenario": "s", "prior": MODEL}),
    (ScanRequest, scan_of([0.5])),
    (ScanRequest, {"sensor_pose": HERE | {"std": {"xy_m": 0.1}}, "scan": {"ranges": [0.5]}}),
    (BeliefRequest, examples.BELIEF),
    (OutcomeRequest, examples.OUTCOME),
    (PredictionsRequest, {"sensors": [HERE]}),
    (VoaRequest, examples.VOA | {"sensors": ["Q1", HERE]}),
    (UpdateRequest, examples.UPDATE),
    (RankingRequest, examples.RANKING),
]
OF_THE_USER = {"data", "predictions", "stamp"}
"""Fields whose value has keys of the user's own."""


def objects(body: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Locations in a body that hold objects with fields."""
    if isinstance(body, dict):
        yield path
    for key, value in body.items() if isinstance(body, dict) else enumerate(body) if isinstance(body, list) else ():
        if key not in OF_THE_USER:
            yield from objects(value, (*path, key))


def inside(body: Any, path: tuple[Any, ...]) -> Any:
    for step in path:
        body = body[step]
    return body


def refused(kind: type[BaseModel], body: Any) -> str:
    with pytest.raises(InvalidMessage) as error:
        read_message(kind, body if isinstance(body, bytes) else json.dumps(body).encode())
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize(("kind", "body"), BODIES, ids=lambda value: getattr(value, "__name__", ""))
def test_a_misspelt_field_anywhere_is_named_with_the_fields_of_its_place(kind: type[BaseModel], body: Json) -> None:
    read_message(kind, json.dumps(body).encode())
    places = list(objects(body))
    assert places
    for path in places:
        wrong = copy.deepcopy(body)
        inside(wrong, path)["colour"] = "red"
        said = refused(kind, wrong)
        where, _, listed = said.partition(": no such field: expected one of ")
        assert where.split(".")[-1] == "colour"
        assert set(inside(body, path)) <= set(listed.split(", ")), said


def test_a_misspelt_field_is_reported_before_a_missing_one() -> None:
    said = refused(SessionRequest, {"scenairo": "s"})
    assert said == "scenairo: no such field: expected one of scenario, prior, robots (and 1 more)"


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(
    ("kind", "body", "path"),
    [
        (ScanRequest, scan_of([0.5, 0.5]), ("scan", "ranges", 1)),
        (ScanRequest, scan_of([0.5], stamp={"at": [1.0]}), ("scan", "stamp", "at", 0)),
        (ScenarioRequest, data_scenario(), ("predictions", "Q1", "P1", 0)),
        (ScenarioRequest, data_scenario(), ("sensors", 0, "x")),
        (BeliefRequest, {"belief": [0.5, 0.5]}, ("belief", 0)),
    ],
)
def test_nan_and_infinity_are_refused_with_advice(
    kind: type[BaseModel], body: Json, path: tuple[Any, ...], value: float
) -> None:
    wrong = copy.deepcopy(body)
    inside(wrong, path[:-1])[path[-1]] = value
    said = refused(kind, wrong)
    assert "expected a finite number" in said
    assert "null" in said
    assert "`no_return`" in said


@pytest.mark.parametrize("word", ["nan", "inf", "-inf", "+Infinity"])
def test_so_is_what_json_does_not_even_know(word: str) -> None:
    said = refused(ScanRequest, f'{{"sensor": "Q1",\n "scan": {{"ranges": [0.5, {word}]}}}}'.encode())
    assert said.startswith("not JSON: ")
    assert "line 2, column 27" in said
    assert "`no_return`" in said


def test_a_byte_order_mark_is_skipped() -> None:
    marked = b"\xef\xbb\xbf" + json.dumps(examples.BELIEF).encode()
    assert read_json(marked) == examples.BELIEF
    assert read_message(BeliefRequest, marked).belief == examples.BELIEF["belief"]


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "not JSON: Expecting value in line 1, column 1"),
        (b"{", "not JSON: Expecting property name"),
        (b'{"belief": [0.5,}', "not JSON: "),
        (b"\xff\xfe{\x00", "not UTF-8: byte 0xff at position 0"),
        (b"\xef\xbb\xbf{\xff}", "not UTF-8: byte 0xff at position 4"),
        (b"[" * 100_000, "nested too deep"),
        (b'{"belief": ' + b"1" * 5_000 + b"}", ""),
        (b"[]", "expected an object with fields, got a list"),
        (b"null", "expected an object with fields, got null"),
        (b'{"belief": "half"}', "belief: "),
        (b"{}", "belief: this field is required"),
    ],
)
def test_what_is_no_such_message_is_said_in_one_line(content: bytes, says: str) -> None:
    assert says in refused(BeliefRequest, content)
