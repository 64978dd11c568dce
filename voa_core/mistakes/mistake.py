"""A probable mistake, and the parts of its sentence: lengths and lists of names."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

Kind = Literal[
    "angle-in-degrees",
    "grasp-never-succeeds",
    "length-in-millimetres",
    "no-workspace",
    "place-inside-object",
    "place-sees-nothing",
    "place-too-far",
    "place-too-near",
    "plane-misses-object",
    "poor-fit",
    "pose-height",
    "pose-never-seen",
    "scan-mirrored",
    "scan-turned",
    "twin-poses",
    "up-axis",
    "workspace-misses-pose",
]

_LISTED = 5


@dataclass(frozen=True)
class Mistake:
    """A probable mistake of the author of a scenario or a scan.

    Attributes:
        kind: sort of the mistake.
        detail: sentence with names and numbers that says how to correct it.
        poses, sensors: names of the poses and sensor configurations concerned.
    """

    kind: Kind
    detail: str
    poses: tuple[str, ...] = ()
    sensors: tuple[str, ...] = ()


def length(metres: float) -> str:
    """Write a length as a person reads it: in millimetres below a metre, else in metres."""
    return f"{1e3 * metres:.4g} mm" if metres < 1.0 else f"{metres:.4g} m"


def listed(what: str, names: Sequence[str]) -> str:
    """List the first five names, quoted, and count the others: "pose 'A'", or "poses 'A', 'B' and 3 more"."""
    named = ", ".join(map(repr, names[:_LISTED]))
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return f"{what}{'s' * (len(names) > 1)} {named}{more}"
