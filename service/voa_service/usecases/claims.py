"""Claims: the session that the scans of each mapped robot belong to, stored for all processes."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from voa_service.failures import ClaimConflict, InvalidRequest, NotFound, UnknownReference
from voa_service.ports import Store
from voa_service.usecases.robots import MappedTo, Robots
from voa_store.records import RobotClaim


@dataclass(frozen=True)
class Claims:
    """Use cases about claims of mapped robots for sessions.

    A robot stays with its session until the session is deleted, or the robot is claimed for another one. Nothing else
    moves it: neither a new session on its scenario nor a ranking.

    Attributes:
        store: where claims are kept.
        robots: the mapped robots.
    """

    store: Store
    robots: Robots

    def peek(self, robot: str, scenario: str) -> str | None:
        """Find the session that the next look of a robot, mapped to a scenario, belongs to; changes nothing.

        Returns:
            Id of the session; None: there is no session on the scenario, or the robot was released from every session.
        """
        return self.store.robot_session(robot, scenario)

    def settle(self, robot: str, scenario: str) -> str | None:
        """Claim a robot, when its look is due, for the session that `peek` finds.

        The claim is durable. If several processes settle a robot at once, the first one decides, and all return the
        same session.

        Returns:
            Id of the session; None: there is none.
        """
        return self.store.settle_robot(robot, scenario)

    def claim_of(self, robot: str) -> RobotClaim | None:
        """Return the claim on a robot, that of its mapping or a stored one; None: there is none.

        Other than `peek` it does not choose a session for a robot that was never claimed.
        """
        mapped = self.robots.mapped_to(robot)
        if mapped is not None and mapped.session is not None:
            return RobotClaim(mapped.session)
        return self.store.robot_claim(robot)

    def claim(self, robot: str, session: str | None) -> None:
        """Claim a mapped robot for a session, or release it from every session until the next claim (None).

        Raises:
            NotFound: no robot of this name is mapped.
            UnknownReference: there is no such session.
            ClaimConflict: the robot's mapping does not allow the claim.
        """
        mapped = self.robots.mapped_to(robot)
        if mapped is None:
            known = self.robots.names()
            raise NotFound(_not_mapped(robot, known), known=known)
        _check_claimable(robot, mapped)
        if session is None:
            self.store.claim_robot(robot, None)
            return
        state = self.store.get_session(session)
        if state is not None:
            _check_scenario(robot, mapped, state.scenario)
        if state is None or not self.store.claim_robot(robot, session):
            raise UnknownReference(f"there is no session {session!r}: open it with POST /v1/sessions")

    def check(self, robots: Sequence[str], scenario: str) -> None:
        """Check that a new session on a scenario can claim robots.

        Raises:
            InvalidRequest: a robot is named twice.
            UnknownReference: no robot of this name is mapped.
            ClaimConflict: a robot's mapping does not allow the claim.
        """
        for robot, count in Counter(robots).items():
            if count > 1:
                raise InvalidRequest(f"body.robots: expected names that differ, got {robot!r} {count} times")
            mapped = self.robots.mapped_to(robot)
            if mapped is None:
                known = self.robots.names()
                raise UnknownReference(f"body.robots: {_not_mapped(robot, known)}", known=known)
            _check_claimable(robot, mapped)
            _check_scenario(robot, mapped, scenario)


def _not_mapped(robot: str, known: Sequence[str]) -> str:
    """Explain that a robot is not mapped, and list those that are."""
    if not known:
        return f"there is no mapped robot {robot!r}: this process maps no robots, see `voa serve --robots FILE`"
    return f"there is no mapped robot {robot!r}: the mapped robots are {', '.join(map(repr, known))}"


def _check_claimable(robot: str, mapped: MappedTo) -> None:
    """Refuse a claim on a robot whose mapping names a fixed session."""
    if mapped.scenario is None:
        raise ClaimConflict(
            f"the mapping of robot {robot!r} names a fixed session ({mapped.session!r}): write `scenario` instead of "
            "`session` in the mapping, so that sessions can claim the robot",
        )


def _check_scenario(robot: str, mapped: MappedTo, scenario: str) -> None:
    """Refuse a session on a scenario other than the mapping's."""
    if mapped.scenario != scenario:
        raise ClaimConflict(
            f"robot {robot!r} is mapped to scenario {mapped.scenario!r}, the session is on scenario {scenario!r}: "
            "claim the robot for a session on its own scenario, or change its mapping",
        )
