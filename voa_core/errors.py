"""What can be wrong with the numbers that the mathematics is given.

VoaError
|-- InvalidInput        a value is not what was expected; says what was
|-- UnknownName         a name is not among those that exist; lists them
|-- NoMesh              a prediction is needed and nothing can make it
`-- BeamGridMismatch    a scan's beams are not those of the given predictions
"""

from collections.abc import Sequence

_LISTED = 12


class VoaError(ValueError):
    """Root of every error that `voa_core` raises on purpose."""


class InvalidInput(VoaError):
    """A value is not what was expected.

    `field` names it the way the caller does; the message says what was expected and what came.
    """

    def __init__(self, field: str, expected: str, got: str) -> None:
        self.field = field
        self.expected = expected
        self.got = got
        super().__init__(f"{field}: expected {expected}, got {got}")


class UnknownName(VoaError):
    """A name is not among those that exist."""

    def __init__(self, what: str, name: str, known: Sequence[str]) -> None:
        self.what = what
        self.name = name
        self.known = list(known)
        listed = ", ".join(map(repr, self.known[:_LISTED]))
        more = f" and {len(self.known) - _LISTED} more" if len(self.known) > _LISTED else ""
        super().__init__(f"there is no {what} {name!r}; there are: {listed}{more}")


class NoMesh(VoaError):
    """A prediction is needed at a sensor pose for which there is neither data nor a mesh."""


class BeamGridMismatch(VoaError):
    """The scan's beams are not the lidar's, and cannot be, or point nobody knows where, or have no predictions."""
