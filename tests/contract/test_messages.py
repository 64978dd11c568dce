"""The messages are what they were: one snapshot of their schemas, and what holds for all of them."""

from typing import Any

import pytest
from pydantic import ValidationError

from tests.contract.snapshot import FILE, messages, schemas, text
from voa_msgs.base import MOST_NESTED, Message
from voa_msgs.geometry import SensorPose
from voa_msgs.scenarios import Grasp
from voa_msgs.sessions import HistoryEntry, Scan

MESSAGES = messages()


def test_the_schemas_are_those_of_the_snapshot() -> None:
    assert text() == FILE.read_text(encoding="utf-8"), (
        "the messages have changed; if that is meant: python -m tests.contract.snapshot"
    )


@pytest.mark.parametrize("message", MESSAGES.values(), ids=MESSAGES)
def test_a_message_is_strict_closed_finite_and_immutable(message: type[Message]) -> None:
    config = message.model_config
    assert config["strict"] is True
    assert config["extra"] == "forbid"
    assert config["frozen"] is True
    assert config["allow_inf_nan"] is False
    assert schemas()[message.__name__]["additionalProperties"] is False


def test_a_message_cannot_be_changed() -> None:
    pose = SensorPose(x=0.0, y=0.0, yaw_rad=0.0)
    with pytest.raises(ValidationError):
        setattr(pose, "x", 1.0)  # noqa: B010 - mypy would not let us


def nested(levels: int, leaf: Any = 0) -> Any:
    value = leaf
    for level in range(levels):
        value = [value] if level % 2 else {"deeper": value}
    return value


def test_free_data_is_kept_as_deep_as_is_said() -> None:
    deepest = Grasp(name="G", data=nested(MOST_NESTED))
    assert Grasp.model_validate_json(deepest.model_dump_json()) == deepest
    for levels in (MOST_NESTED + 1, 190, 254, 500):
        with pytest.raises(ValidationError, match=f"at most {MOST_NESTED} levels"):
            Grasp(name="G", data=nested(levels))


@pytest.mark.parametrize("data", ["\ud800", ["\udfff"], {"a": ["x\udabc"]}, {"\ud800": 1}])
def test_free_data_is_text_that_can_be_written_down(data: Any) -> None:
    with pytest.raises(ValidationError, match="surrogate"):
        Scan(ranges=[1.0], stamp=data)


@pytest.mark.parametrize("data", [None, True, 5, 10**300, 0.5, "ключ 🤖", [], {}, {"a": [1, {"b": None}]}])
def test_free_data_of_every_kind_survives_the_wire(data: Any) -> None:
    there = Grasp.model_validate_json(Grasp(name="G", data=data).model_dump_json())
    assert there.data == data


def test_history_gives_back_requests_around_the_deepest_free_data() -> None:
    at = "2026-01-01T00:00:00Z"
    entry = {"version": 1, "kind": "scan", "at": at, "request": nested(MOST_NESTED + 2), "update": None}
    assert HistoryEntry.model_validate(entry, strict=False).request == entry["request"]
