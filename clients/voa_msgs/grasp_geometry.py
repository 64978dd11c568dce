"""Geometry of a grasp: the convention for a grasp's `data` that simulators, consoles and arm controllers read.

The service stores `data` and returns it unchanged; it never reads it.
"""

import math
from typing import Annotated, Any, Literal

from annotated_types import Gt
from pydantic import ConfigDict, model_validator

from voa_msgs.base import Real
from voa_msgs.described import Described

Vector = tuple[Real, Real, Real]
_PERPENDICULAR = 1e-3


class GraspGeometry(Described):
    """Pose and width of a parallel gripper for a grasp; a grasp's `data` may hold other keys beside these."""

    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False)

    frame: Literal["world"] = "world"
    """Frame of the vectors. A grasp is fixed in the world frame, because the object's pose is not known."""
    tool_centre_point: Vector
    """Point midway between the fingertips when they close, metres."""
    approach: Vector
    """Direction in which the fingers point and approach, of any length above 0."""
    closing: Vector
    """Direction along which the fingers close, perpendicular to the approach, of any length above 0."""
    width_m: Annotated[Real, Gt(0.0)] | None = None
    """Width of the object between the fingers, metres; null: not known."""

    @model_validator(mode="after")
    def _check_directions(self) -> "GraspGeometry":
        approach, closing = math.hypot(*self.approach), math.hypot(*self.closing)
        if approach == 0.0 or closing == 0.0:
            raise ValueError("expected `approach` and `closing` of a length above 0")
        along = sum(a * c for a, c in zip(self.approach, self.closing, strict=True))
        if abs(along) > _PERPENDICULAR * approach * closing:
            raise ValueError("expected `closing` perpendicular to `approach`")
        return self


def grasp_geometry(data: Any) -> GraspGeometry | None:
    """Read the geometry from a grasp's `data`; None if `data` holds none (no key `tool_centre_point`).

    Raises:
        ValidationError: `data` has the key `tool_centre_point`, but does not follow the convention.
    """
    if not isinstance(data, dict) or "tool_centre_point" not in data:
        return None
    return GraspGeometry.model_validate(data)
