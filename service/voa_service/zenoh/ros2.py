"""ROS 2 topics of mapped robots: their scans, gathered into looks, update the sessions that they are mapped to.

Every replica receives everything and gathers the same looks. One of them applies a look at once, the others after a
while, unless the session has it by then. A look that the session does not accept is published like a scan that cannot
be used, and the robot's next revolutions make another.
"""

import secrets
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import structlog
import zenoh
from zenoh.handlers import Callback

from voa_ros.robots import RobotMapping, Subscription, load
from voa_ros.topics import POSE_WITH_COVARIANCE_STAMPED, expressions, match_key
from voa_service.failures import Failure, InternalError, InvalidRequest, NotAccepted, Overloaded, TooLarge
from voa_service.services import Services
from voa_service.zenoh.applying import DueLook, apply_look
from voa_service.zenoh.latched import declare_latched_subscriber
from voa_service.zenoh.mailboxes import MOST_WAITING, MOST_WAITING_BYTES, Later, Mailboxes
from voa_service.zenoh.mapped_robot import FOLLOW_SECONDS, MappedRobot
from voa_service.zenoh.outbox import Outbox
from voa_service.zenoh.refusals import not_accepted
from voa_service.zenoh.replicas import Replicas
from voa_service.zenoh.samples import Sample

_WORKERS = 2
_END_SECONDS = 0.4


@dataclass(frozen=True)
class _Look:
    """A look to be applied."""

    robot: MappedRobot
    key: str
    due: DueLook


class Ros2:
    """The subscribers, the workers behind them, and the mapping, read again when its file changes."""

    def __init__(
        self, services: Services, mapping: Path, replicas: Replicas, outbox: Outbox, grace_seconds: float
    ) -> None:
        self._services = services
        self._file = mapping
        self._replicas = replicas
        self._outbox = outbox
        self._robots: dict[str, tuple[MappedRobot, ExitStack]] = {}
        self._read: str | None = None
        self._boxes: Mailboxes[tuple[MappedRobot, Sample | _Look]] = Mailboxes(
            self._work, _WORKERS, MOST_WAITING, MOST_WAITING_BYTES
        )
        self._later: Later[_Look] = Later(grace_seconds, self._hand_on, MOST_WAITING, MOST_WAITING_BYTES)
        replicas.when_one_leaves(self._later.hasten)

    def close(self) -> None:
        """End the workers."""
        self._later.close()
        self._boxes.close()

    @contextmanager
    def on(self, session: zenoh.Session) -> Iterator[None]:
        """Listen to the mapped topics for the length of a `with`."""
        ended = threading.Event()
        self._follow_file(session)
        thread = threading.Thread(target=self._watch, args=(session, ended), name="voa-mapping")
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()
            for name in list(self._robots):
                self._drop(name)
            for _ in range(self._boxes.drain(_END_SECONDS)):
                self._services.metrics.zenoh("ROS message dropped at the end")

    def _watch(self, session: zenoh.Session, ended: threading.Event) -> None:
        while not ended.wait(FOLLOW_SECONDS):
            self._follow_file(session)

    def _follow_file(self, session: zenoh.Session) -> None:
        """Do as the file says, if it says something else than before; what is wrong in it changes nothing."""
        try:
            text = self._file.read_text(encoding="utf-8")
            if text == self._read:
                return
            self._read = text
            wanted = {mapping.name: mapping for mapping in load(text)}
        except Exception as error:  # whatever is wrong with the file, the mapping in force goes on
            why = f"{self._file.name}: {error}"
            if self._services.robots.mapping_error != why:
                structlog.get_logger().warning("mapping not read, the old one holds", error=why)
            self._services.robots.mapping_error = why
            return
        self._services.robots.mapping_error = None
        for name, (robot, _) in list(self._robots.items()):
            if wanted.get(name) != robot.mapping:
                self._drop(name)
        for name, mapping in wanted.items():
            if name not in self._robots:
                self._add(session, mapping)
        structlog.get_logger().info("mapping read", robots=sorted(wanted))

    def _add(self, session: zenoh.Session, mapping: RobotMapping) -> None:
        robot = MappedRobot(mapping, self._services)
        stack = ExitStack()
        for subscription in mapping.subscriptions:
            latched = subscription.type == POSE_WITH_COVARIANCE_STAMPED
            for expression in expressions(subscription.topic, mapping.domain):
                receive = Callback(partial(self._receive, robot, subscription), indirect=False)
                declare = declare_latched_subscriber if latched else zenoh.Session.declare_subscriber
                stack.callback(declare(session, expression, receive).undeclare)
        self._robots[mapping.name] = robot, stack
        self._services.robots.mapped(
            mapping.name, mapping.scan_topic, robot, scenario=mapping.scenario, session=mapping.session
        )

    def _drop(self, name: str) -> None:
        _, stack = self._robots.pop(name)
        stack.close()
        self._services.robots.unmapped(name)

    def _receive(self, robot: MappedRobot, subscription: Subscription, sample: zenoh.Sample) -> None:
        """In a Zenoh thread: hand over, or refuse."""
        key, type_ = str(sample.key_expr), subscription.type
        named = match_key(subscription.topic, key, robot.mapping.domain)
        if sample.kind != zenoh.SampleKind.PUT or named is None:
            return
        if named.type_name not in (None, type_.name):
            found = f"expected a {type_.name}, found a {named.type_name}: is it the right topic?"
            self._refuse(robot, key, InvalidRequest(found))
            return
        size, most = len(sample.payload), self._services.limits.scan_bytes
        self._services.metrics.zenoh(f"{type_.name.rpartition('/')[2]} heard")
        if size > most:
            self._refuse(robot, key, TooLarge(f"expected a message of at most {most} bytes, got {size}"))
            return
        attachment = None if sample.attachment is None else sample.attachment.to_bytes()
        received = Sample(type_, key, sample.payload.to_bytes(), attachment, time.monotonic())
        if not self._boxes.put(robot.name, (robot, received), size):
            self._refuse(robot, key, Overloaded("more messages are waiting than this service can work on"))

    def _hand_on(self, look: _Look) -> None:
        if not self._boxes.put(look.robot.name, (look.robot, look), 0):
            look.robot.rejected(look.due, Overloaded.kind)
            self._refuse(look.robot, look.key, Overloaded("more messages are waiting than can be worked on"))

    def _work(self, item: tuple[MappedRobot, Sample | _Look]) -> None:
        """In a worker thread."""
        structlog.contextvars.clear_contextvars()
        structlog.contextvars.bind_contextvars(request_id=secrets.token_hex(8))
        robot, what = item
        try:
            if isinstance(what, _Look):
                self._apply(what)
                return
            due = robot.receive(what)
            if due is None:
                return
            look = _Look(robot, what.key, due)
            if self._replicas.owns(robot.name):
                self._apply(look)
            else:
                for _ in range(self._later.put(look, 0)):
                    self._services.metrics.zenoh("look forgotten")
        except Failure as failure:
            self._refuse(robot, what.key, failure)
        except Exception as error:
            structlog.get_logger().exception("unexpected error", exc_info=error)
            defect = InternalError("this is a defect of the service; its log has the request id")
            self._refuse(robot, what.key, defect)

    def _apply(self, look: _Look) -> None:
        """Apply a look unless the session has it; a look that comes to nothing does not use up the robot's stop."""
        robot, due = look.robot, look.due
        try:
            answer = apply_look(self._services.sessions, due)
        except BaseException as error:
            robot.rejected(due, error.kind if isinstance(error, Failure) else InternalError.kind)
            raise
        if answer is None:
            self._services.metrics.zenoh("look applied already")
            return
        session, request = due.ledger.session, due.taken.request
        self._services.robots.looked(robot.name, "ros2", look.key, session, request, answer)
        if not answer.update.accepted:
            robot.rejected(due, answer.update.reason or NotAccepted.kind)
            self._refuse(robot, look.key, not_accepted(answer.update.reason))

    def _refuse(self, robot: MappedRobot, key: str, failure: Failure) -> None:
        why = f"{failure.kind}: {failure.detail}"
        self._services.metrics.zenoh(f"ROS message refused: {failure.kind}")
        if self._services.robots.refused(robot.name, "ros2", key, why):
            structlog.get_logger().warning("ROS message refused", robot=robot.name, key=key, why=why)
        if self._replicas.owns(robot.name):  # else another replica says so to the robot
            self._outbox.refused(robot.session or "none", robot.name, failure)
