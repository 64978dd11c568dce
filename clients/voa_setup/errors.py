"""Errors that end the making of a scenario, each with a sentence that says what to do."""

from collections.abc import Sequence


class SetupError(Exception):
    """Base class of all errors that this package raises on purpose."""


class UnusableMesh(SetupError):
    """A mesh file cannot be read, or no scenario can be made of its mesh; the message says why, and what would help."""


class UnlikelySize(UnusableMesh):
    """The object has an unlikely size under a scale that nobody stated.

    Attributes:
        extent: largest extent of the mesh, in the unit of the file.
        scales: metres per unit under which the size is likely, the most usual first; may be empty.
    """

    def __init__(self, message: str, extent: float, scales: Sequence[float]) -> None:
        super().__init__(message)
        self.extent = extent
        self.scales = tuple(scales)


class InvalidOption(SetupError):
    """The value of an option cannot be used with this object; the message names values that can."""


class UnusableFolder(SetupError):
    """The files of a scenario cannot be written into a folder; the message says why."""
