"""Errors on the wire: RFC 9457 problem documents; and how the service is."""

from datetime import datetime
from typing import Annotated, Literal

from pydantic import Field

from voa_msgs.base import Message


class ProblemField(Message):
    """One field that is not as expected."""

    field: str
    """Where it stands, as a path: `body.poses.0.name`."""
    problem: str


class Problem(Message):
    """What went wrong, and what to do."""

    type: Annotated[str, Field(examples=["urn:voa:problem:not-found"])]
    """`urn:voa:problem:<kind>`: the name to program against."""
    title: str
    status: int
    detail: str
    request_id: str | None = None
    """As in the service's log."""
    errors: list[ProblemField] | None = None
    """Field by field, where a body is not as expected."""
    version: int | None = None
    """The session's version, where the request asked for another."""
    retry_after_s: float | None = None
    """When to try again, where that makes sense."""
    known: list[str] | None = None
    """The names that exist, where one does not."""


class Memory(Message):
    """Upper bounds of what each part of the service may hold, in MiB, and what there is for their sum."""

    total_mebibytes: int
    """Memory that the service may use."""
    source: Literal["setting", "cgroup", "machine"]
    """Who says so: `VOA_MEMORY_MEBIBYTES`, the limit of its container or unit, or the machine."""
    sum_mebibytes: int
    process_mebibytes: int
    """The process itself."""
    cache_mebibytes: int
    """Cuts, predictions and weights that are kept."""
    workers_mebibytes: int
    """Threads that rank, each in its largest block of weights."""
    meshes_mebibytes: int
    """Processes that read mesh files."""
    bodies_mebibytes: int
    """Requests that are received, parsed and validated."""


class Health(Message):
    """Whether the process is alive, or ready to serve."""

    status: str
    version: str | None = None
    """Of the software."""
    wire_version: int | None = None
    """Of the messages."""
    replica: str | None = None
    """The name of this process."""
    zenoh: Literal["off", "connecting", "connected"] | None = None
    database: str | None = None
    """The database's software and its version ("SQLite 3.53.4"); null from a service that does not say."""
    now: datetime | None = None
    """The service's clock."""
    memory: Memory | None = None
