"""Problem documents (RFC 9457), and the health of the service."""

from datetime import datetime
from typing import Annotated, Literal

from pydantic import Field

from voa_msgs.base import Message


class ProblemField(Message):
    """Mistake in a field of a request."""

    field: str
    """Path of the field, such as `body.poses.0.name`."""
    problem: str
    """Text that says what was expected of the field."""


class Problem(Message):
    """Problem document of RFC 9457: why a request was refused, and what to do."""

    type: Annotated[str, Field(examples=["urn:voa:problem:not-found"])]
    """Kind of the problem, `urn:voa:problem:<kind>`: the field for programs to compare."""
    title: str
    """Kind of the problem in words, the same for all problems of a kind."""
    status: int
    """Status of the HTTP response."""
    detail: str
    """Text for people: what was expected, what was received, and what to do."""
    request_id: str | None = None
    """Identifier of the request in the log of the service."""
    errors: list[ProblemField] | None = None
    """Mistakes of an invalid request, field by field; null for other problems."""
    version: int | None = None
    """Current version of the session, where `If-Match` named another; null for other problems."""
    retry_after_s: float | None = None
    """Seconds to wait before the request is repeated; null where repeating it does not help."""
    known: list[str] | None = None
    """Names that exist, at most 100, where the request names one that does not; null for other problems."""


class Memory(Message):
    """Memory limits of the parts of the service, MiB, and the memory that is available to all of them."""

    total_mebibytes: int
    """Memory that is available to the service, MiB."""
    source: Literal["setting", "cgroup", "machine"]
    """Origin of `total_mebibytes`: `VOA_MEMORY_MEBIBYTES`, the limit of the container or unit, or the machine."""
    sum_mebibytes: int
    """Sum of the limits of all parts, MiB."""
    process_mebibytes: int
    """Memory of the idle process, MiB."""
    cache_mebibytes: int
    """Most memory of cached cuts, predictions and weights, MiB."""
    workers_mebibytes: int
    """Most memory of the threads that compute rankings, each with its largest block of weights, MiB."""
    meshes_mebibytes: int
    """Most memory of the processes that read mesh files, MiB."""
    bodies_mebibytes: int
    """Most memory of the requests that are being received and validated, MiB."""


class Health(Message):
    """Health of a process of the service."""

    status: str
    """Status: `alive` from `/livez`, `ready` from `/readyz`."""
    version: str | None = None
    """Version of the software; null from `/livez`."""
    wire_version: int | None = None
    """Version of the messages; null from `/livez`."""
    replica: str | None = None
    """Name of this process, unique among the replicas; null from `/livez`."""
    zenoh: Literal["off", "connecting", "connected"] | None = None
    """State of the connection to a Zenoh router; null from `/livez`."""
    database: str | None = None
    """Name and version of the database software ("SQLite 3.53.4"); null where it is not reported."""
    now: datetime | None = None
    """Time by the clock of the service, UTC; null from `/livez`."""
    memory: Memory | None = None
    """Memory limits of the service; null from `/livez`."""
