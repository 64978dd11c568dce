"""The mapped robot in a simulated process: its looks are applied one after another, by whichever process is first."""

from collections import deque
from collections.abc import Callable

from tests.simulation.scheduler import Scheduler, Signal
from voa_msgs.warnings import ProbableMistake
from voa_ros.looks import GatheredLook
from voa_service.failures import Failure
from voa_service.guard import EXPECTED_ERRORS, failure_of
from voa_service.usecases.claims import Claims
from voa_service.usecases.robot_reports import Standing
from voa_service.usecases.updates import Updates
from voa_service.zenoh.applying import DueLook, apply_look
from voa_service.zenoh.ledger import LookLedger

ROBOT_NAME = "tb3"
_IDLE_SECONDS = 60.0


class _Idle:
    """The robot's own state, which no test here reads."""

    waiting_for: str | None = None
    warnings: list[ProbableMistake]
    standing = Standing()

    def __init__(self) -> None:
        self.warnings = []

    def request(self) -> None:
        """Do nothing: each revolution is a look."""


IDLE = _Idle()


class SimulatedRobot:
    """The robot in mode `every`: each look that is received becomes an update of the session that it belongs to.

    Args:
        scheduler: of the tasks.
        scenario: that the robot is mapped to.
        claims: use cases about claims.
        updates: use cases that change a session.
        settled: called with each session that a look was found to belong to, and when the search began.
        applied: called with the number of each look, its session, and what came of it.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        scenario: str,
        claims: Claims,
        updates: Updates,
        settled: Callable[[str | None, float], None],
        applied: Callable[[int, str, str], None],
    ) -> None:
        self._scheduler = scheduler
        self._scenario = scenario
        self._claims = claims
        self._updates = updates
        self._settled = settled
        self._applied = applied
        self._due: deque[tuple[int, GatheredLook]] = deque()
        self._signal = Signal()
        self._ledger: LookLedger | None = None
        self._newest = 0.0

    def in_order(self, delay: float) -> float:
        """Return a delay after which a message arrives no sooner than those that were published before it."""
        self._newest = max(self._newest, self._scheduler.now + delay)
        return self._newest - self._scheduler.now

    def receive(self, number: int, look: GatheredLook) -> None:
        """Queue a look; called by the scheduler."""
        self._due.append((number, look))
        self._scheduler.notify(self._signal)

    def run(self) -> None:
        """Apply looks for as long as the process lives."""
        while True:
            while not self._due:
                self._scheduler.wait(self._signal, _IDLE_SECONDS)
            number, look = self._due.popleft()
            session = ""
            try:
                began = self._scheduler.now
                belongs_to = self._claims.settle(ROBOT_NAME, self._scenario)
                self._settled(belongs_to, began)
                if belongs_to is None:
                    continue
                session = belongs_to
                if self._ledger is None or self._ledger.session != session:
                    self._ledger = LookLedger(self._updates.sessions, session, ROBOT_NAME, None)
                self._ledger.take(look)
                outcome = apply_look(self._updates, DueLook(ROBOT_NAME, look, self._ledger, self._ledger.version))
            except EXPECTED_ERRORS as error:
                failure: Failure = failure_of(error)
                self._applied(number, session, failure.kind)
            else:
                result = "taken" if outcome is None else "accepted" if outcome.update.accepted else "kept"
                self._applied(number, session, result)
