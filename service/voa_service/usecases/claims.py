"""Claims: which session each mapped robot's scans are for, once and for all processes."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from voa_service.failures import ClaimConflict, InvalidRequest, NotFound, UnknownReference
from voa_service.ports import Store
from voa_service.usecases.robots import MappedTo, Robots


@dataclass(frozen=True)
class Claims:
    """Claims of mapped robots: the session that each one's scans are for.

    A robot stays with its session until that is deleted, or another one claims the robot. Nothing else moves it:
    neither a new session on its scenario nor a ranking.
    """

    store: Store
    robots: Robots

    def peek(self, robot: str, scenario: str) -> str | None:
        """Find the session that a look of a robot, mapped to a scenario, would go to now; changes nothing.

        None: there is no session for it yet, or the robot was said to be nobody's.
        """
        return self.store.robot_session(robot, scenario)

    def settle(self, robot: str, scenario: str) -> str | None:
        """Find the session as `peek` does, and make it the robot's own.

        To be called when a look is due. Durable, and safe where several processes do so at once: the first decides,
        and all return the same.
        """
        return self.store.settle_robot(robot, scenario)

    def claim(self, robot: str, session: str | None) -> None:
        """Say whose session a mapped robot's scans are for from now on; None: nobody's until the next claim.

        Raises:
            Failure: no such robot is mapped (404), there is no such session (422), or the mapping contradicts it (409).
        """
        mapped = self.robots.mapped_to(robot)
        if mapped is None:
            known = self.robots.names()
            raise NotFound(_no_robot(robot, known), known=known)
        _check_free(robot, mapped)
        if session is None:
            self.store.claim_robot(robot, None)
            return
        state = self.store.get_session(session)
        if state is not None:
            _check_scenario(robot, mapped, state.scenario)
        if state is None or not self.store.claim_robot(robot, session):
            raise UnknownReference(f"there is no session {session!r}: open it with POST /v1/sessions")

    def check(self, robots: Sequence[str], scenario: str) -> None:
        """Refuse robots that a new session on a scenario cannot claim.

        Raises:
            Failure: one comes twice, or no such robot is mapped (422), or its mapping contradicts it (409).
        """
        for robot, count in Counter(robots).items():
            if count > 1:
                raise InvalidRequest(f"body.robots: expected names that differ, got {robot!r} {count} times")
            mapped = self.robots.mapped_to(robot)
            if mapped is None:
                known = self.robots.names()
                raise UnknownReference(f"body.robots: {_no_robot(robot, known)}", known=known)
            _check_free(robot, mapped)
            _check_scenario(robot, mapped, scenario)


def _no_robot(robot: str, known: Sequence[str]) -> str:
    """Say that a robot is not mapped, and which are."""
    if not known:
        return f"there is no mapped robot {robot!r}: this process maps none, see `voa serve --robots FILE`"
    return f"there is no mapped robot {robot!r}: the mapping has {', '.join(map(repr, known))}"


def _check_free(robot: str, mapped: MappedTo) -> None:
    """Refuse a claim on a robot whose mapping names a session: it cannot be moved."""
    if mapped.scenario is None:
        raise ClaimConflict(
            f"the mapping of robot {robot!r} names its session ({mapped.session!r}): write `scenario` there instead of "
            "`session`, so that it can be claimed",
        )


def _check_scenario(robot: str, mapped: MappedTo, scenario: str) -> None:
    """Refuse a session on another scenario than the mapping's."""
    if mapped.scenario != scenario:
        raise ClaimConflict(
            f"robot {robot!r} is mapped to scenario {mapped.scenario!r}, the session is on {scenario!r}: claim it for "
            "a session on its own scenario, or change the mapping",
        )
