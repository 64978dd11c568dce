"""Base class of all messages, and the types of their fields: names, numbers within limits, vectors, distributions."""

import math
from collections.abc import Iterable, Iterator
from itertools import islice
from typing import Annotated, Any

from annotated_types import Ge, Le, Len
from pydantic import (
    BeforeValidator,
    ConfigDict,
    JsonValue,
    PlainValidator,
    StringConstraints,
    TypeAdapter,
    WithJsonSchema,
)
from pydantic_core import PydanticKnownError

from voa_msgs.bounds import LimitedBy, OneMistake
from voa_msgs.described import Described


class Message(Described):
    """Base class of all messages.

    A message is immutable and strict: it refuses unknown fields, NaN and infinity, and numbers given as strings or
    booleans. The docstring of a field becomes its description in the JSON schema.
    """

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


MOST_NESTED = 64
"""Most levels of lists and objects in the user's own JSON."""
MOST_FREE_VALUES = 100_000
"""Most values in one piece of the user's own JSON."""
MOST_FREE_CHARACTERS = 1_000_000
"""Most characters, keys included, in one piece of the user's own JSON."""


def _checked_free(value: Any) -> Any:
    """Return the user's own JSON unchanged; refuse it if it is nested too deep, too large, not text or not finite."""
    level = [value]
    values = characters = 0
    for _ in range(MOST_NESTED + 1):
        values += len(level)
        texts = [item for item in level if isinstance(item, str)]
        texts += [key for item in level if isinstance(item, dict) for key in item if isinstance(key, str)]
        characters += sum(map(len, texts))
        if values > MOST_FREE_VALUES or characters > MOST_FREE_CHARACTERS:
            most = f"{MOST_FREE_VALUES} values and {MOST_FREE_CHARACTERS} characters"
            raise ValueError(
                f"expected at most {most}: store larger data elsewhere, and put only a reference to it here"
            )
        if any(isinstance(item, float) and not math.isfinite(item) for item in level):
            raise PydanticKnownError("finite_number")
        if any("\ud800" <= character <= "\udfff" for text in texts if not text.isascii() for character in text):
            raise ValueError("expected Unicode text, got a surrogate without its partner")
        nested = [item for item in level if isinstance(item, list | dict)]
        if not nested:
            return value
        level = list(islice(_children(nested), MOST_FREE_VALUES + 1))
    raise ValueError(f"expected at most {MOST_NESTED} levels of lists and objects")


def _children(nested: Iterable[list[Any] | dict[str, Any]]) -> Iterator[Any]:
    for item in nested:
        yield from item.values() if isinstance(item, dict) else item


Free = Annotated[JsonValue, BeforeValidator(_checked_free)]
"""Any JSON of the user's own; the service stores it and returns it unchanged.

At most `MOST_NESTED` levels deep, `MOST_FREE_VALUES` values and `MOST_FREE_CHARACTERS` characters large.
"""

_JSON: TypeAdapter[Any] = TypeAdapter(Free)


def _free_object(value: Any) -> dict[str, Any]:
    """Read the user's own JSON, which must be an object; its size is bounded as that of `Free`."""
    checked: Any = _JSON.validate_python(value)
    if not isinstance(checked, dict):
        raise ValueError(f"expected an object of values by name, got {type(checked).__name__}")
    return checked


FreeObject = Annotated[dict[str, Any], PlainValidator(_free_object), WithJsonSchema({"type": "object"})]
"""A JSON object of the user's own, bounded as `Free`."""

Name = Annotated[str, StringConstraints(min_length=1, max_length=128, pattern=r"^[^\x00]*$")]
"""Text of 1 to 128 characters without NUL, which PostgreSQL cannot store."""
Id = Name
"""Identifier that the service gave to an object, a scenario or a session."""
MOST = 1e6
"""Largest length, angle or parameter that a message may have, so that squares and products stay finite."""
LEAST = 1e-9
"""Smallest value of a parameter that must be above 0."""
Real = Annotated[float, Ge(-MOST), Le(MOST)]
"""Any finite number within `MOST` of 0."""
NotNegative = Annotated[float, Ge(0.0), Le(MOST)]
"""Number from 0 to `MOST`."""
Positive = Annotated[float, Ge(LEAST), Le(MOST)]
"""Number from `LEAST` to `MOST`."""
Point2 = Annotated[list[Real], OneMistake(), Len(2, 2)]
"""Two numbers: x, y."""
Point3 = Annotated[list[Real], OneMistake(), Len(3, 3)]
"""Three numbers: x, y, z."""
Quaternion = Annotated[list[Real], OneMistake(), Len(4, 4)]
"""Four numbers: w, x, y, z."""
Range = Annotated[float, Ge(0.0)] | None
"""Range in metres, or null: in a scan a missing beam, in a prediction a no-return."""

Ranges = Annotated[list[Range], Len(1), LimitedBy("beams")]
"""Ranges of all beams, metres; one value per beam."""
Distribution = Annotated[list[NotNegative], Len(1), LimitedBy("poses")]
"""Probabilities of the poses of a scenario, in its order: finite, at least 0, with a sum of 1 within 1e-6."""


class Page(Message):
    """Page of a list: its items, and the cursor of the next page."""

    next: str | None
    """Cursor of the next page: send it as `after`; null on the last page."""
