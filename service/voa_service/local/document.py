"""Document that a ranking without HTTP is made from."""

from pathlib import Path
from typing import Any

from pydantic import Field

from voa_msgs.base import Message, Positive
from voa_msgs.objects import UpAxis
from voa_msgs.scenarios import ScenarioRequest
from voa_service.failures import InvalidRequest
from voa_service.requests.bodies import read
from voa_service.settings import Limits

UNLIMITED = Limits(**dict.fromkeys(Limits.model_fields, 2**62))
"""Limits that no request on this machine exceeds: its user alone decides what it has memory and time for."""


class MeshFile(Message):
    """File of the scenario's object, on this machine."""

    path: str
    """Path of the file; its ending is the type of the file."""
    scale: Positive = 1.0
    """Metres per unit of the file."""
    up: UpAxis | None = None
    """Axis of the file that is up; null: the usual one of its type."""

    def content(self) -> bytes:
        """Read the file.

        Raises:
            InvalidRequest: it cannot be read.
        """
        try:
            return Path(self.path).read_bytes()
        except OSError as error:
            raise InvalidRequest(f"mesh.path: {self.path}: {error.strerror}") from error


class Document(Message):
    """A scenario and the ranking that is wanted of it."""

    scenario: ScenarioRequest
    """Body of POST /v1/scenarios; its `object` is replaced where there is a mesh file."""
    mesh: MeshFile | None = None
    """File of its object; null: all predictions are data."""
    ranking: dict[str, Any] = Field(default={"belief": None})
    """Body of POST /v1/rankings without its field `scenario`."""


def read_document(content: bytes) -> Document:
    """Read a document from JSON, of any size.

    Raises:
        Failure: it is not JSON, or not a document.
    """
    return read(Document, content, UNLIMITED)
