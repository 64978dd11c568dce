"""A call of the service as data, before it is sent, without I/O.

A `Call` holds the request in two forms: as a method, a path and a query for HTTP, and as the name of an rpc for the
other transports, whose payload has the ids and the query parameters beside the body's fields.
"""

import base64
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar
from urllib.parse import quote

from pydantic import BaseModel
from pydantic_core import to_json

from voa_client._errors import UsageError
from voa_msgs.base import Message
from voa_msgs.objects import UpAxis

M = TypeVar("M", bound=BaseModel)

_USE_HTTP = "make the client with the service's http:// address"


class Nothing(Message):
    """Empty response, to calls that return nothing."""


@dataclass(frozen=True)
class Upload:
    """A mesh file to upload: a multipart form over HTTP, base64 over other transports."""

    filename: str
    content: bytes
    name: str | None
    scale: float
    up: UpAxis | None = None

    def form(self) -> dict[str, str]:
        """Return the fields of the multipart form, without the file."""
        return {"scale": repr(self.scale)} | self._stated()

    def fields(self) -> dict[str, Any]:
        """Return the fields of the JSON payload, with the file in base64."""
        file = base64.b64encode(self.content).decode("ascii")
        return {"filename": self.filename, "file": file, "scale": float(self.scale)} | self._stated()

    def _stated(self) -> dict[str, str]:
        """Return the optional fields that the caller gave; the service has defaults for the others."""
        given = {"name": self.name, "up": self.up}
        return {name: value for name, value in given.items() if value is not None}


@dataclass(frozen=True)
class Call(Generic[M]):
    """A request to the service, before it is sent.

    Attributes:
        rpc: name of the method on Zenoh.
        method: of HTTP.
        path: of HTTP, with the names of `ids` in braces.
        response: class of the message in the response.
        ids: values for the names in the path.
        query: parameters of the query string; those that are None are left out.
        body: message to send; None: there is none.
        upload: file to send instead of a body.
        writes: True if the call takes an idempotency key.
        heavy: True if the response may take long, so that one long attempt is made instead of several short ones.
        if_match: version that the session must have; None: any.
        http_only: True if the service answers the call over HTTP only.
    """

    rpc: str
    method: str
    path: str
    response: type[M]
    ids: Mapping[str, str] = field(default_factory=dict)
    query: Mapping[str, str | int | float | list[str] | None] = field(default_factory=dict)
    body: BaseModel | None = None
    upload: Upload | None = None
    writes: bool = False
    heavy: bool = False
    if_match: int | None = None
    http_only: bool = False

    def __post_init__(self) -> None:
        for what, id_ in self.ids.items():
            if not id_:
                raise UsageError(f"{self.rpc}: {what}: expected an id, got an empty string")

    def check_has_rpc(self) -> None:
        """Raise UsageError if the call can be sent over HTTP only."""
        if self.http_only:
            raise UsageError(f"{self.rpc}: can be called over HTTP only; {_USE_HTTP}")
        if self.if_match is not None:
            raise UsageError(f"{self.rpc}: if_match can be used over HTTP only; {_USE_HTTP}")

    @property
    def url(self) -> str:
        """The path of HTTP, with the ids filled in."""
        return self.path.format(**{name: _quoted(id_) for name, id_ in self.ids.items()})

    @property
    def parameters(self) -> dict[str, str | int | float | list[str]]:
        """The parameters of the query that are not None."""
        return {name: value for name, value in self.query.items() if value is not None}

    def content(self) -> bytes | None:
        """Return the body of HTTP as JSON, with the fields that the caller has set; None if there is no body."""
        return None if self.body is None else self.body.model_dump_json(exclude_unset=True).encode()

    def payload(self) -> bytes:
        """Return the payload of an rpc as JSON: ids, parameters, and the fields of the body that the caller has set."""
        fields: dict[str, Any] = {} if self.body is None else self.body.model_dump(exclude_unset=True)
        if self.upload is not None:
            fields = self.upload.fields()
        return to_json(fields | dict(self.ids) | self.parameters)


def _quoted(id_: str) -> str:
    """Quote an id as one segment of a path; dots, too, where it has nothing else."""
    quoted = quote(id_, safe="")
    return quoted.replace(".", "%2E") if not quoted.strip(".") else quoted
