"""Acting robots: in which sessions a robot takes part, by which keys that are bound to robots are checked."""

from collections.abc import Collection
from dataclasses import dataclass

from voa_service.mapping.under_way import announced_looks
from voa_service.usecases.claims import Claims
from voa_service.usecases.sessions import Sessions
from voa_store.records import IdempotencyKey, RobotClaim


@dataclass(frozen=True)
class ActingRobots:
    """Use cases about the part that robots take in sessions.

    Attributes:
        claims: of robots for sessions.
        sessions: use cases about whole sessions.
    """

    claims: Claims
    sessions: Sessions

    def claim_of(self, robot: str) -> RobotClaim | None:
        """Return the claim on a robot; None: there is none."""
        return self.claims.claim_of(robot)

    def take_part(self, session: str, robots: Collection[str]) -> bool:
        """Return True if one of some robots takes part in a session, or there is no such session.

        A robot takes part in the session that has claimed it, and until one has, in those where a look of it is under
        way. One that was released from every session takes part in none.
        """
        claims = {robot: self.claim_of(robot) for robot in robots}
        if RobotClaim(session) in claims.values():
            return True
        mark = self.sessions.store.session_mark(session)
        if mark is None:
            return True
        free = {robot for robot, claim in claims.items() if claim is None}
        return any(look.robot in free for look in announced_looks(mark.under_way, self.sessions.now()))

    def is_answered(self, key: IdempotencyKey | None) -> bool:
        """Return True if a call with this idempotency key was answered: its repetition changes nothing.

        Raises:
            StoreError: the key was used for another request.
        """
        return key is not None and self.sessions.has_response(key)
