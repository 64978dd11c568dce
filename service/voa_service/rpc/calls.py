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
from voa_store.records import IdempotencyKey


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
    """

    fields: dict[str, Any]
    attachment: Attachment
    services: Services
    size: int
    caller: Caller = ANONYMOUS
    subject: str | None = None
    robot: str | None = None

    def take(self, kind: type[Message]) -> Any:
        """Take the fields of a message out of the payload, and check them; raises Failure."""
        own = {name: self.fields.pop(name) for name in kind.model_fields if name in self.fields}
        return self.services.reader.message(kind, own, self.size)

    def session(self) -> str:
        """Take the id of the session that the call concerns, `session` or `id`, out of the payload.

        Raises:
            Failure: there is none, or the caller's key is not for that session.
        """
        if "session" not in self.fields and "id" in self.fields:
            self.fields["session"] = self.fields.pop("id")
        taken: InSession = self.take(InSession)
        self.subject = taken.session
        self.caller.check_session(taken.session)
        return taken.session

    def check_acting(self, session: str, key: IdempotencyKey | None, robot: str | None = None) -> None:
        """Return if the caller's key may change a session, or the call repeats one that was answered.

        Args:
            session: id of the session.
            key: idempotency key of the call, if it has one.
            robot: name of the robot that the call names; None: it names none.

        Raises:
            Forbidden: the key is bound to other robots, or to robots that have nothing to do with the session.
        """
        acting = self.services.acting
        if self.caller.robots is not None and not acting.is_answered(key):
            self.caller.check_acting(session, robot, acting)

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
