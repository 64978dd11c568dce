"""Warnings: what is probably a mistake, in something that can be computed all the same."""

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
    "scan-mirrored",
    "scan-turned",
    "twin-poses",
    "up-axis",
    "workspace-misses-pose",
]


class ProbableMistake(Message):
    """One warning: something that can be computed, but that its author probably did not mean.

    A warning changes nothing: neither a result, nor the digest that names a scenario, nor a session's history.
    """

    kind: WarningKind
    detail: str
    """A sentence with names and numbers, and what to do about it."""
    poses: list[str] | None = None
    """The poses that it is about; absent where it is about none."""
    sensors: list[str] | None = None
    """The sensor configurations that it is about; absent where it is about none."""


class Warnings(Message):
    """Everything that is probably a mistake in one scenario; empty where all is well."""

    items: list[ProbableMistake]
