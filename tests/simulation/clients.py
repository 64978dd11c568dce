"""The simulated clients: each does its operations in order, and repeats a write with a key until it is answered."""

from functools import partial

from tests.simulation.plan import REPLICAS, Operation
from tests.simulation.requests import (
    Reply,
    Request,
    announcement,
    creation,
    deletion,
    gathered,
    observation,
    reading,
    withdrawal,
)
from tests.simulation.robot import ROBOT_NAME
from tests.simulation.world import PublishedLook, World

_ATTEMPTS = 12
_EXPECTED_REFUSALS = {"not-found", "stale-version", "not-ready", "overloaded"}


class Client:
    """A client with the operations that it does.

    Args:
        number: of the client.
        world: that it lives in.
    """

    def __init__(self, number: int, world: World) -> None:
        self._number = number
        self._world = world
        self._announced: list[tuple[str, str]] = []
        """Announced looks, each as its session and id."""

    def run(self) -> None:
        """Do all operations, and say that no more will come."""
        for operation in self._world.plan.operations:
            if operation.client == self._number:
                self._world.scheduler.pause(operation.think)
                self._do(operation)
        self._world.busy -= 1

    def create(self, number: int, slot: int) -> None:
        """Open a session, until it is answered, and use it in a slot from then on."""
        request = creation(number, self._world.scenario)
        self._world.records.creations.append(request)
        reply = self._sent(request, f"create{number}")
        if reply is not None and reply.response is not None:
            self._world.sessions[slot] = reply.facts["id"]

    def _do(self, operation: Operation) -> None:
        session = self._world.sessions[operation.slot]
        if operation.kind == "look":
            self._publish(operation)
        elif session:
            special = {
                "read": self._read,
                "renew": self._renew,
                "announce": self._announce,
                "cancel": self._cancel,
                "claim": self._claim,
            }
            special.get(operation.kind, self._observe)(operation, session)

    def _read(self, operation: Operation, session: str) -> None:
        self._sent(reading(session), f"read{operation.number}")

    def _renew(self, operation: Operation, session: str) -> None:
        """Delete a session, and open another in its place."""
        self._sent(deletion(operation.number, session), f"delete{operation.number}")
        self.create(operation.number, operation.slot)

    def _announce(self, operation: Operation, session: str) -> None:
        reply = self._sent(announcement(operation, session), f"announce{operation.number}")
        if reply is not None and reply.response is not None:
            self._announced.append((session, reply.facts["id"]))

    def _cancel(self, operation: Operation, _session: str) -> None:
        """Withdraw the oldest look that this client has announced, in whatever session."""
        if self._announced:
            session, look = self._announced.pop(0)
            self._sent(withdrawal(operation, session, look), f"cancel{operation.number}")

    def _observe(self, operation: Operation, session: str) -> None:
        """Send a scan, an outcome or a belief."""
        known = self._world.known.get((self._number, session))
        self._sent(observation(operation, session, known), f"{operation.kind}{operation.number}")

    def _sent(self, request: Request, name: str) -> Reply | None:
        """Send a request; one with a key again and again until it is answered."""
        world = self._world
        for attempt in range(_ATTEMPTS):
            replica = world.replicas[self._draw(REPLICAS)]
            reply = world.send(request, replica, f"{name}/{attempt}")
            if reply is not None and (reply.failure is None or reply.failure.status not in (500, 503)):
                self._learn(request, reply)
                return reply
            if request.key is None:
                return None
            world.scheduler.pause(0.05 * (attempt + 1))
        return None

    def _learn(self, request: Request, reply: Reply) -> None:
        if reply.failure is not None and reply.failure.kind not in _EXPECTED_REFUSALS:
            self._world.records.refusals.append(f"{request.key}: {reply.failure.kind}: {reply.failure.detail}")
        if reply.response is not None and request.session:
            self._world.known[self._number, request.session] = reply.response.version

    def _publish(self, operation: Operation) -> None:
        """Publish the revolutions of a look, which every living process receives."""
        look = gathered(operation)
        body = look.request.model_dump_json(exclude_unset=True, exclude_none=True)  # as `apply_look` stores it
        self._world.records.looks.append(PublishedLook(operation.number, body, self._world.scheduler.now))
        for replica in self._world.replicas:
            robot = replica.robot
            if robot is not None:
                delay = 0.03 * self._world.scheduler.generator(f"look{operation.number}/{replica.name}").random()
                self._world.scheduler.at(robot.in_order(delay), partial(robot.receive, operation.number, look))

    def _claim(self, operation: Operation, session: str) -> None:
        """Claim the mapped robot for a session, without a key."""
        replica = self._world.replicas[self._draw(REPLICAS)]
        self._world.claim(replica, f"claim{operation.number}", session, ROBOT_NAME)

    def _draw(self, count: int) -> int:
        task = self._world.scheduler.current
        return 0 if task is None else task.random.randrange(count)
