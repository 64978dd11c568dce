"""Warnings: probable mistakes in scenarios, scans and meshes that can be computed nevertheless."""

from typing import Literal

from voa_msgs.base import Message

WarningKind = Literal[
    "angle-in-degrees",
    "every-while-parked",
    "extent",
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
    "probably-absent",
    "scan-mirrored",
    "scan-turned",
    "twin-poses",
    "up-axis",
    "workspace-misses-pose",
]
"""Kinds of warnings."""


class ProbableMistake(Message):
    """Warning about input that can be computed, but that its author probably did not intend.

    A warning changes neither a result, nor the identifier of a scenario, nor the history of a session.
    """

    kind: WarningKind
    """Kind of the mistake: the field for programs to compare."""
    detail: str
    """Text for people, with names and numbers, that says what to do."""
    poses: list[str] | None = None
    """Names of the poses concerned; null or absent: none."""
    sensors: list[str] | None = None
    """Names of the sensor configurations concerned; null or absent: none."""


class Warnings(Message):
    """List of the probable mistakes in a scenario."""

    items: list[ProbableMistake]
    """Warnings; empty: no mistake was detected."""
