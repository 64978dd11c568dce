"""Errors on the wire: RFC 9457 problem documents."""

from typing import Annotated

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
    known: list[str] | None = None
    """The names that exist, where one does not."""


class Health(Message):
    """Whether the process is alive, or ready to serve."""

    status: str
