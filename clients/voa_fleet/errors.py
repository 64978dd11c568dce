"""What can go wrong in the fleet on purpose."""


class FleetError(Exception):
    """Root of what this package raises on purpose."""


class InvalidObject(FleetError):
    """A folder does not describe an object; says what is wrong with it."""


class UnknownName(FleetError):
    """Something is asked for by a name that does not exist; lists what does."""

    def __init__(self, kind: str, name: str, known: list[str]) -> None:
        super().__init__(f"no {kind} {name!r}; there are: {', '.join(known) or 'none'}")


class UnstableSimulation(FleetError):
    """The physics gave numbers that mean nothing; the settings are to blame, not the grasp."""


class NoGraphics(FleetError):
    """Pictures are wanted and there is no OpenGL to draw them; says how to get it."""
