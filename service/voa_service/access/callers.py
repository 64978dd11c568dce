"""Callers: who makes a call, by which role, and for which sessions and robots."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from datetime import datetime
from typing import Protocol

from voa_msgs import callers as messages
from voa_msgs.callers import Role
from voa_service.access.roles import CALLS, UNLISTED, Call
from voa_service.failures import Forbidden
from voa_store.records import RobotClaim


class Acting(Protocol):
    """Part that robots take in sessions, as keys that are bound to robots are checked by it."""

    def claim_of(self, robot: str) -> RobotClaim | None:
        """Return the claim on a robot; None: there is none."""

    def take_part(self, session: str, robots: Collection[str]) -> bool:
        """Return True if one of some robots takes part in a session, or there is no such session."""


@dataclass(frozen=True)
class Caller:
    """A caller whose key was accepted, or anybody where the service has no keys.

    Attributes:
        name: of the key.
        role: of the key.
        key: id of the key; None: the service has no keys.
        sessions: ids of the only sessions that the key is for; None: any.
        robots: names of the only robots that the key is for; None: any.
        expires_at: time from which the key is no longer valid; None: never.
    """

    name: str
    role: Role
    key: str | None = None
    sessions: frozenset[str] | None = None
    robots: frozenset[str] | None = None
    expires_at: datetime | None = None

    @property
    def withdraws_as(self) -> str | None:
        """Name under which this caller may withdraw announced looks, its own alone; None: it may withdraw any."""
        return None if self.role == "operator" else self.name

    def message(self) -> messages.Caller:
        """Return the message about this caller, with the names of the calls that its role may make."""
        return messages.Caller(
            name=self.name,
            role=self.role,
            key=self.key,
            sessions=None if self.sessions is None else sorted(self.sessions),
            robots=None if self.robots is None else sorted(self.robots),
            expires_at=self.expires_at,
            calls=sorted(call.name for call in CALLS if self._may(call)),
        )

    def _may(self, call: Call) -> bool:
        return self.role in call.roles and not (call.on == "sessions" and self.sessions is not None)

    def check_role(self, call: Call) -> None:
        """Return if the caller's role may make a call.

        Raises:
            Forbidden: it may not.
        """
        if self.role not in call.roles:
            allowed = " or ".join(sorted(call.roles))
            raise Forbidden(
                f"{call.name}: the key {self.name!r} has the role {self.role}; this call needs the role {allowed}"
            )

    def check_subject(self, call: Call, subject: str | None) -> None:
        """Return if the caller's key is for the session or robot that a call concerns.

        Args:
            call: that is made.
            subject: id of the session, or name of the robot; None: not known, or there is none.

        Raises:
            Forbidden: the key is for others.
        """
        if call is UNLISTED and (self.sessions, self.robots) != (None, None):
            raise Forbidden(f"the key {self.name!r} is for certain sessions or robots only, not for this path")
        if call.on == "sessions" and self.sessions is not None:
            raise Forbidden(f"{call.name}: the key {self.name!r} is for certain sessions only, and may not open others")
        if call.on == "session" and subject is not None:
            self.check_session(subject)
        if call.on == "robot" and subject is not None:
            self.check_robot(subject)

    def check_session(self, session: str | None) -> None:
        """Return if the key is for a session, or none is named; raises Forbidden if it is for others only."""
        if self.sessions is not None and session is not None and session not in self.sessions:
            raise Forbidden(f"the key {self.name!r} is not for session {session[:80]!r}")

    def check_acting(self, session: str, robot: str | None, acting: Acting) -> None:
        """Return if the key is bound to no robots, or may write to a session as one of its robots.

        A call that names a robot must name one of the key's, and a robot that a session has claimed acts in that
        session alone; one that was released from every session acts in none. A call that names none is for keys that
        are bound to the session as well, and for robots that take part in the session: it has claimed them, or they
        have announced a look there.

        Args:
            session: id of the session that the call changes.
            robot: name of the robot that the call names; None: it names none.
            acting: part that robots take in sessions.

        Raises:
            Forbidden: the key is for other robots, or for robots that have nothing to do with the session.
        """
        if self.robots is None:
            return
        if robot is not None:
            self.check_robot(robot)
            claim = acting.claim_of(robot)
            if claim not in (None, RobotClaim(session)):
                state = "was released" if claim.session is None else f"session {claim.session!r} has claimed"
                raise Forbidden(
                    f"the key {self.name!r} acts as robot {robot[:80]!r}, which {state}: claim it for session "
                    f"{session[:80]!r} first"
                )
        elif session not in (self.sessions or ()) and not acting.take_part(session, self.robots):
            raise Forbidden(
                f"the key {self.name!r} is for robots, of which none takes part in session {session[:80]!r}: announce "
                "the look with the name of the robot, claim the robot for the session, or bind a key to the session"
            )

    def sees_robot(self, robot: str, session: str | None) -> bool:
        """Return True if the key is for a robot, and for the session that its scans are applied to."""
        is_bound_to_others = self.robots is not None and robot not in self.robots
        return not is_bound_to_others and (None in (self.sessions, session) or session in (self.sessions or ()))

    def check_session_of(self, session_of_robot: Callable[[], str | None]) -> None:
        """Return if the key is for the session that a robot's scans are applied to, or is bound to none.

        Args:
            session_of_robot: returns that session; None: there is none.

        Raises:
            Forbidden: the key is for other sessions.
        """
        if self.sessions is not None:
            self.check_session(session_of_robot())

    def check_robot(self, robot: str | None) -> None:
        """Return if the key is for a robot, or none is named; raises Forbidden if it is for other robots only."""
        if self.robots is not None and robot is not None and robot not in self.robots:
            raise Forbidden(f"the key {self.name!r} is not for robot {robot[:80]!r}")


MAPPING = Caller("mapping", "sensor")
"""Sender of what arrives on the ROS 2 topics of mapped robots, whose messages carry no key."""
RETENTION = Caller("retention", "operator")
"""Caller that deletes old sessions: the service itself, after `VOA_RETENTION_DAYS`."""
ANONYMOUS = Caller("anonymous", "operator")
"""Anybody, where the service has no keys."""
