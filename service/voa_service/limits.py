"""Enforces the list lengths and counts that `voa_msgs.base.LimitedBy` marks and the OpenAPI document states."""

from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from voa_msgs.base import LimitedBy
from voa_service.failures import INVALID, Failure
from voa_service.settings import Limits


def check(message: BaseModel, limits: Limits) -> None:
    """Refuse a request with a list that is too long, or a count that is too high.

    Raises:
        Failure: the request is invalid; names the first of them and its limit.
    """
    for field, count, name in _limited(message, "body"):
        most = getattr(limits, name)
        if count > most:
            raise Failure(
                INVALID,
                f"{field}: expected at most {most} ({name}), got {count}",
                errors=[{"field": field, "problem": f"expected at most {most}, got {count}"}],
            )


def _limited(message: BaseModel, path: str) -> Iterator[tuple[str, int, str]]:
    """Everything in a message that a setting limits: where it stands, how many it is, the setting."""
    for name, field in type(message).model_fields.items():
        value = getattr(message, name)
        here = f"{path}.{name}"
        limit = _limit(field)
        if isinstance(value, BaseModel):
            yield from _limited(value, here)
        elif limit is not None and isinstance(value, list | int):
            yield here, value if isinstance(value, int) else len(value), limit
        elif name == "predictions" and isinstance(value, dict):
            yield from _of_predictions(value, here)


def _limit(field: FieldInfo) -> str | None:
    marks = [mark for mark in _metadata(field.annotation, list(field.metadata)) if isinstance(mark, LimitedBy)]
    return marks[0].limit if marks else None


def _metadata(annotation: Any, found: list[Any]) -> list[Any]:
    """The metadata of an annotation and of the members of its unions."""
    found.extend(getattr(annotation, "__metadata__", ()))
    for member in getattr(annotation, "__args__", ()):
        _metadata(member, found)
    return found


def _of_predictions(by_sensor: dict[str, Any], path: str) -> Iterator[tuple[str, int, str]]:
    """`predictions` is the one mapping with lists in it: sensor, pose, beams."""
    for sensor, by_pose in by_sensor.items():
        if isinstance(by_pose, dict):
            for pose, ranges in by_pose.items():
                if isinstance(ranges, list):
                    yield f"{path}.{sensor}.{pose}", len(ranges), "beams"
