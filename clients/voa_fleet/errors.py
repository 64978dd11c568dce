"""Errors that the fleet raises on purpose."""


class FleetError(Exception):
    """Base class of all errors that this package raises on purpose."""


class InvalidObject(FleetError):
    """A folder does not describe an object, or a value of its description is not allowed; the message says which."""


class InvalidPolicy(FleetError):
    """An installed package offers a policy that cannot be loaded or is none; the message names the package."""


class UnknownName(FleetError):
    """No object, pose, grasp, robot or policy has the requested name; the message lists the names that exist."""

    def __init__(self, kind: str, name: str, known: list[str]) -> None:
        super().__init__(f"no {kind} {name!r}; there are: {', '.join(known) or 'none'}")


class UnstableSimulation(FleetError):
    """The simulation gave numbers without a meaning: its settings are at fault, not the grasp."""


class NoGraphics(FleetError):
    """No picture can be drawn, because OpenGL or another program is missing; the message says how to install it."""
