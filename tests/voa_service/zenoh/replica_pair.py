"""Two processes on one database that receive the messages of one robot, and work on them sooner or later."""

import math
from collections.abc import Callable, Sequence
from typing import Any

from tests.support.serving import Service, data_scenario
from tests.voa_service.zenoh.ros_lab import laser_scan
from voa_ros.robots import RobotMapping, load
from voa_ros.topics import LASER_SCAN
from voa_service.failures import Failure
from voa_service.guard import guarded
from voa_service.zenoh.applying import DueLook, apply_look
from voa_service.zenoh.mapped_robot import MappedRobot
from voa_service.zenoh.samples import Sample

GOOD = (0.5, 0.5, math.inf, 1.0)
NOTHING = (0.0, 0.0, 0.0, 0.0)
"""Ranges of a lidar that spins up: no look of them is accepted."""
SCANS = 3
NAME = "tb3_1"
PERIOD_S = 0.2
"""Time of a revolution of the lidar."""


class ManualClock:
    """Monotonic time that stands until it is set forward, seconds."""

    def __init__(self) -> None:
        self.now = 1_000.0

    def __call__(self) -> float:
        """Return the time."""
        return self.now


class Process:
    """A process: a service, and the robot as it is mapped there.

    Args:
        service: of the process.
        mapping: of the robot.
        clock: monotonic time of the process, seconds.
    """

    def __init__(self, service: Service, mapping: RobotMapping, clock: Callable[[], float]) -> None:
        self.service = service
        self.clock = clock
        self.robot = MappedRobot(mapping, service.inside, clock)
        service.inside.robots.mapped(
            NAME, mapping.scan_topic, self.robot, scenario=mapping.scenario, session=mapping.session
        )
        self.robot.prepare()
        self.due: list[DueLook] = []
        """Looks that are not applied yet."""
        self.is_stuck = False
        """True while messages are received, and not worked on before `catch_up`."""
        self._waiting: list[Sample] = []

    def receive(self, payload: bytes, sensor: str, late_s: float = 0.0) -> None:
        """Receive a scan, which is worked on so many seconds after it came, or once the process catches up."""
        attachment = f'{{"sensor": "{sensor}"}}'.encode()
        self._waiting.append(Sample(LASER_SCAN, f"{NAME}/scan", payload, attachment, self.clock() - late_s))
        if not self.is_stuck:
            self.catch_up()

    def catch_up(self, leave: int = 0) -> None:
        """Work on the messages that wait, in order, except the newest `leave`."""
        while len(self._waiting) > leave:
            look = self.robot.receive(self._waiting.pop(0))
            if look is not None:
                self.due.append(look)

    def apply(self, most: int = 1_000) -> None:
        """Apply the looks that are due, at most so many, in order."""
        for _ in range(min(most, len(self.due))):
            due = self.due.pop(0)
            try:
                with guarded():
                    answer = apply_look(self.service.inside.updates, due)
            except Failure as failure:
                self.robot.rejected(due, failure.kind)
                continue
            if answer is not None and not answer.update.accepted:
                self.robot.rejected(due, str(answer.update.reason))


class Pair:
    """Two processes on one database, by one clock that each revolution sets forward."""

    def __init__(self, services: Sequence[Service]) -> None:
        self.services = services
        self.clock = ManualClock()
        self.scenario = services[0].create(data_scenario())
        self.session = services[0].open(self.scenario)
        self._turn = 0

    def processes(self, look: str = f"{{ scans = {SCANS} }}", to: str = "", count: int = 2) -> list[Process]:
        to = to or f'session = "{self.session}"'
        text = f'[[robot]]\nname = "{NAME}"\n{to}\nlook = {look}\nplace = {{ from = "attachment" }}\n'
        (mapping,) = load(text)
        return [Process(service, mapping, self.clock) for service in self.services[:count]]

    def revolution(
        self,
        sensor: str,
        to: Sequence[Process],
        ranges: Sequence[float] = GOOD,
        clock: bool = True,
        late_s: float = 0.0,
    ) -> None:
        self._turn += 1
        self.clock.now += PERIOD_S
        shifted = [value + 1e-4 * (self._turn % 7) if clock and value else value for value in ranges]
        payload = laser_scan(shifted, 100.0 + 0.2 * self._turn if clock else 0.0)
        for process in to:
            process.receive(payload, sensor, late_s)

    def stop(
        self,
        sensor: str,
        to: Sequence[Process],
        ranges: Sequence[float] = GOOD,
        clock: bool = True,
        late_s: float = 0.0,
    ) -> None:
        """As many revolutions as a look has."""
        for _ in range(SCANS):
            self.revolution(sensor, to, ranges, clock, late_s)

    def looks(self, session: str | None = None) -> list[Any]:
        """Places of the looks in the history, in order."""
        items = self.services[0].get(f"/v1/sessions/{session or self.session}/history?limit=1000")["items"]
        return [entry["request"]["sensor"] for entry in items if entry["kind"] == "scan"]
