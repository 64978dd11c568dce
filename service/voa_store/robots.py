"""Reads and writes the claims and the accepted looks of mapped robots."""

from sqlalchemy import Engine

from voa_store import claims
from voa_store.engines import statement, transaction
from voa_store.looks import newest_looks
from voa_store.records import RobotClaim, RobotLook


class RobotRecords:
    """Storage of claims and looks of mapped robots, on the engines of the store that inherits it."""

    _writer: Engine
    _single: Engine

    def robot_session(self, robot: str, scenario: str) -> str | None:
        """Find the session that the next look of a robot, mapped to a scenario, belongs to; None: there is none."""
        with statement(self._single) as connection:
            return claims.find(connection, robot, scenario).id

    def robot_claim(self, robot: str) -> RobotClaim | None:
        """Return the claim on a robot, on whichever scenario; None: there is none, or its session was deleted."""
        with statement(self._single) as connection:
            return claims.claimed(connection, robot)

    def settle_robot(self, robot: str, scenario: str) -> str | None:
        """Claim a robot for the session that `robot_session` finds; returns that session, None: there is none."""
        with statement(self._single) as connection:
            assignment = claims.find(connection, robot, scenario)
        if assignment.settled or assignment.session is None:  # nothing to write: the usual case
            return assignment.id
        with transaction(self._writer) as connection:
            return claims.settle(connection, robot, scenario)

    def claim_robot(self, robot: str, session: str | None) -> bool:
        """Claim a robot for a session, or release it from every session (None); False: there is no such session."""
        with transaction(self._writer) as connection:
            return claims.put(connection, robot, session)

    def robot_looks(self, id_: str, robot: str, limit: int) -> list[RobotLook]:
        """Read at most `limit` looks of a robot that a session has accepted, the newest first."""
        with statement(self._single) as connection:
            return newest_looks(connection, id_, robot, limit)
