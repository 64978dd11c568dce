"""A remote call under way: its payload, of which the method takes the parts that it expects."""

from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from voa_msgs.base import Message
from voa_msgs.keys import Attachment
from voa_service.access.callers import ANONYMOUS, Caller
from voa_service.requests.large_json import text
from voa_service.rpc.parameters import Identified, InSession
from voa_service.services import Services


@dataclass
class Call:
    """A call of a method.

    Attributes:
        fields: of the payload, without those that the method has taken.
        attachment: JSON that came beside the payload.
        services: the use cases.
        caller: that makes the call.
        subject: id of the session that the call concerns, once it was taken; for the audit.
        robot: name of the robot that the call concerns, once it was taken; for the audit.
        size: bytes of the payload.
        writes: True if the call changes what it concerns.
    """

    fields: dict[str, Any]
    attachment: Attachment
    services: Services
    size: int
    caller: Caller = ANONYMOUS
    writes: bool = False
    subject: str | None = None
    robot: str | None = None

    def take(self, kind: type[Message]) -> Any:
        """Take the fields of a message out of the payload, and check them; raises Failure."""
        own = {name: self.fields.pop(name) for name in kind.model_fields if name in self.fields}
        return self.services.reader.message(kind, own, self.size)

    def session(self) -> str:
        """Take the id of the session that the call concerns, `session` or `id`, out of the payload.

        Raises:
            Failure: there is none, or the caller's key is not for that session, or may not change it.
        """
        if "session" not in self.fields and "id" in self.fields:
            self.fields["session"] = self.fields.pop("id")
        taken: InSession = self.take(InSession)
        self.subject = taken.session
        self.caller.check_session(taken.session)
        if self.writes:
            robot = self.fields.get("robot")
            named = robot if isinstance(robot, str) else None
            self.caller.check_acting(taken.session, named, self.services.claims)
        return taken.session

    def id(self) -> str:
        """Take the id of the object or scenario that the call concerns out of the payload; raises Failure."""
        taken: Identified = self.take(Identified)
        return taken.id

    def body(self, kind: type[BaseModel]) -> Any:
        """Read a message from the fields that were not taken, none of which may be left over; raises Failure."""
        return self.services.reader.message(kind, self.fields, self.size)

    def received(self) -> bytes:
        """Write the fields that were not taken as JSON, for the history of a session."""
        return text(self.fields).encode()
