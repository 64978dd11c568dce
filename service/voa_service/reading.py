"""Messages from bytes, for entrypoints without a framework that does it: the same limits and errors as over HTTP."""

import json
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from voa_service.failures import INVALID, MALFORMED, TOO_LARGE, Failure, malformed, of_message
from voa_service.limits import check
from voa_service.settings import Limits

M = TypeVar("M", bound=BaseModel)


def json_object(payload: bytes, limits: Limits) -> dict[str, Any]:
    """The JSON object in a payload; an empty one where there is none.

    Raises:
        Failure: too large, not JSON in UTF-8, or not an object.
    """
    if len(payload) > limits.body_bytes:
        raise Failure(TOO_LARGE, f"expected a payload of at most {limits.body_bytes} bytes, got {len(payload)}")
    if payload.count(b",") > limits.numbers:
        raise Failure(TOO_LARGE, f"expected a payload of at most {limits.numbers} values")
    if not payload:
        return {}
    try:
        text = payload.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise Failure(MALFORMED, f"expected JSON in UTF-8: {error}") from error
    if "\0" in text:
        raise Failure(MALFORMED, "expected JSON in UTF-8, got a NUL byte")
    try:
        found = json.loads(text)
    except json.JSONDecodeError as error:
        raise malformed(error.msg, text, error.pos) from error
    except (ValueError, RecursionError) as error:  # a number of thousands of digits; nested without end
        raise Failure(MALFORMED, "expected JSON in UTF-8, nested a few hundred deep at most") from error
    if not isinstance(found, dict):
        raise Failure(INVALID, f"expected a JSON object, got {type(found).__name__}")
    return found


def message(kind: type[M], fields: dict[str, Any], limits: Limits) -> M:
    """A message from its fields.

    Raises:
        Failure: it is not as expected, or larger than the limits.
    """
    try:
        read = kind.model_validate(fields)
    except ValidationError as error:
        raise of_message(kind, error, "body") from error
    check(read, limits)
    return read
