"""What all messages share: strictness, names, vectors, and marks for the limits that a service sets."""

from dataclasses import dataclass
from typing import Annotated, Any

from annotated_types import Ge, Len
from pydantic import BaseModel, ConfigDict, GetJsonSchemaHandler, StringConstraints
from pydantic_core import CoreSchema


class Message(BaseModel):
    """Strict (no number from a string or a bool), closed, immutable; NaN and infinity are refused."""

    model_config = ConfigDict(
        strict=True, extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True
    )


@dataclass(frozen=True)
class LimitedBy:
    """Marks a list whose length a setting of the service limits; `limit` is the setting's name.

    The service enforces it and states it as `maxItems` in its OpenAPI document.
    """

    limit: str

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Name the limit in the schema; the service puts its number beside."""
        return handler(schema) | {"x-limit": self.limit}


Name = Annotated[str, StringConstraints(min_length=1, max_length=128)]
NotNegative = Annotated[float, Ge(0.0)]
Point2 = Annotated[list[float], Len(2, 2)]
Point3 = Annotated[list[float], Len(3, 3)]
Quaternion = Annotated[list[float], Len(4, 4)]
Range = NotNegative | None
"""A range in metres. In scans null means missing; in predictions it means no-return."""

Ranges = Annotated[list[Range], Len(1), LimitedBy("beams")]
Distribution = Annotated[list[NotNegative], Len(1), LimitedBy("poses")]
"""Probabilities over the scenario's poses, in its order: finite, at least 0, summing to 1 within 1e-6."""


class Page(Message):
    """One page of a list; its `items` are of the list's kind."""

    next: str | None
    """Opaque: hand it back as `after` for the next page; null on the last one."""
