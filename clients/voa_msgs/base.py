"""What all messages share: strictness, names, vectors, and marks for the limits that a service sets."""

import math
from collections.abc import Iterable, Iterator
from itertools import islice
from typing import Annotated, Any

from annotated_types import Ge, Le, Len
from pydantic import BaseModel, BeforeValidator, ConfigDict, JsonValue, StringConstraints
from pydantic_core import PydanticKnownError

from voa_msgs.bounds import LimitedBy, OneMistake


class Message(BaseModel):
    """Strict (no number from a string or a bool), closed, immutable; NaN and infinity are refused."""

    model_config = ConfigDict(
        strict=True, extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True
    )


MOST_NESTED = 64
MOST_FREE_VALUES = 100_000
MOST_FREE_CHARACTERS = 1_000_000


def _kept(value: Any) -> Any:
    """Refuse free values that cannot be kept and given back: nested without end, too large, not Unicode, not finite."""
    level = [value]
    values = characters = 0
    for _ in range(MOST_NESTED + 1):
        values += len(level)
        texts = [item for item in level if isinstance(item, str)]
        texts += [key for item in level if isinstance(item, dict) for key in item if isinstance(key, str)]
        characters += sum(map(len, texts))
        if values > MOST_FREE_VALUES or characters > MOST_FREE_CHARACTERS:
            most = f"{MOST_FREE_VALUES} values and {MOST_FREE_CHARACTERS} characters"
            raise ValueError(f"expected at most {most} in one place: keep the rest elsewhere, and its name here")
        if any(isinstance(item, float) and not math.isfinite(item) for item in level):
            raise PydanticKnownError("finite_number")
        if any("\ud800" <= character <= "\udfff" for text in texts if not text.isascii() for character in text):
            raise ValueError("expected Unicode text, got half of a surrogate pair")
        nested = [item for item in level if isinstance(item, list | dict)]
        if not nested:
            return value
        level = list(islice(_children(nested), MOST_FREE_VALUES + 1))
    raise ValueError(f"expected at most {MOST_NESTED} levels of lists and objects")


def _children(nested: Iterable[list[Any] | dict[str, Any]]) -> Iterator[Any]:
    for item in nested:
        yield from item.values() if isinstance(item, dict) else item


Free = Annotated[JsonValue, BeforeValidator(_kept)]
"""The user's own JSON, at most `MOST_NESTED` levels deep and `MOST_FREE_VALUES` values large; kept and returned."""

Name = Annotated[str, StringConstraints(min_length=1, max_length=128, pattern=r"^[^\x00]*$")]
"""Any text without a NUL, which PostgreSQL could not keep."""
Id = Name
"""A name that the service gave."""
MOST = 1e6
"""No length, angle or parameter of a lab is larger; beyond it squares and products stop being numbers."""
LEAST = 1e-9
"""Nor is one that must be above 0 smaller."""
Real = Annotated[float, Ge(-MOST), Le(MOST)]
NotNegative = Annotated[float, Ge(0.0), Le(MOST)]
Positive = Annotated[float, Ge(LEAST), Le(MOST)]
Point2 = Annotated[list[Real], OneMistake(), Len(2, 2)]
Point3 = Annotated[list[Real], OneMistake(), Len(3, 3)]
Quaternion = Annotated[list[Real], OneMistake(), Len(4, 4)]
Range = Annotated[float, Ge(0.0)] | None
"""A range in metres. In scans null means missing; in predictions it means no-return."""

Ranges = Annotated[list[Range], Len(1), LimitedBy("beams")]
Distribution = Annotated[list[NotNegative], Len(1), LimitedBy("poses")]
"""Probabilities over the scenario's poses, in its order: finite, at least 0, summing to 1 within 1e-6."""


class Page(Message):
    """One page of a list; its `items` are of the list's kind."""

    next: str | None
    """Opaque: hand it back as `after` for the next page; null on the last one."""
