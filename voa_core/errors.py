"""Errors of the mathematics, all of them with a message for the author of the input.

VoaError
|-- InvalidInput            a value is not as expected; the message says what was expected
|-- UnknownName             a name is not among those that exist; the message lists them
|   `-- RuleNotInstalled    no installed package provides the update rule
|-- NoMesh                  a prediction is needed, and there is neither data nor a mesh for it
|-- BeamGridMismatch        the beams of a scan are not those of the given predictions
`-- RuleFault               an update rule of another package failed
"""

from collections.abc import Sequence

_LISTED = 12


class VoaError(ValueError):
    """Base class of every error that `voa_core` raises on purpose."""


class InvalidInput(VoaError):
    """A value that is not as expected.

    Attributes:
        field: name of the value, as the caller knows it.
        expected: values that are allowed, in words.
        got: the value that was given, in words.
    """

    def __init__(self, field: str, expected: str, got: str) -> None:
        self.field = field
        self.expected = expected
        self.got = got
        super().__init__(f"{field}: expected {expected}, got {got}")


class UnknownName(VoaError):
    """A name that is not among those that exist.

    Attributes:
        what: kind of the named object, such as "pose".
        name: the unknown name.
        known: the names that exist.
    """

    def __init__(self, what: str, name: str, known: Sequence[str]) -> None:
        self.what = what
        self.name = name
        self.known = list(known)
        listed = ", ".join(map(repr, self.known[:_LISTED]))
        more = f" and {len(self.known) - _LISTED} more" if len(self.known) > _LISTED else ""
        super().__init__(f"there is no {what} {name!r}; there are: {listed}{more}")


class RuleNotInstalled(UnknownName):
    """An update rule of another package that is not installed where the scenario is computed."""

    def __init__(self, name: str, installed: Sequence[str]) -> None:
        super().__init__("installed update rule", name, installed)
        listed = ", ".join(map(repr, self.known[:_LISTED])) or "none"
        self.args = (
            f"the update rule {name!r} is not installed here; installed are: {listed}. Install the Python package that "
            "provides it (entry points of the group 'voa.rules') beside the service, and start the service again",
        )


class NoMesh(VoaError):
    """A prediction at a sensor pose for which there is neither data nor a mesh."""


class BeamGridMismatch(VoaError):
    """A scan whose beams are not the lidar's, where no prediction for its own beams can be made."""


class RuleFault(VoaError):
    """A failure of an update rule of another package: it raised an error, or returned no usable result.

    Attributes:
        name: of the update rule.
    """

    def __init__(self, name: str, method: str, got: str, expected: str) -> None:
        self.name = name
        super().__init__(
            f"the update rule {name!r}, which another package provides, failed in {method}: expected {expected}, "
            f"got {got}"
        )
