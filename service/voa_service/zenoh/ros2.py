"""ROS 2 topics of mapped robots: their scans are gathered into looks, which update the sessions they are mapped to.

Every replica receives all messages and gathers looks at the same stops. The responsible replica applies a look at once,
the others after a delay, unless the session has it by then. A look that the session does not accept is published as
refused, like a scan that cannot be used, and the robot's next revolutions make another look.
"""

import secrets
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import structlog
import zenoh
from zenoh.handlers import Callback

from voa_ros.latched import declare_latched_subscriber
from voa_ros.robots import RobotMapping, Subscription, load
from voa_ros.topics import POSE_WITH_COVARIANCE_STAMPED, expressions, match_key
from voa_service.access.audit import record_write
from voa_service.access.callers import MAPPING
from voa_service.failures import Failure, InvalidRequest, NotAccepted, Overloaded, TooLarge
from voa_service.guard import guarded
from voa_service.services import Services
from voa_service.zenoh.applying import DueLook, apply_look
from voa_service.zenoh.deferred import Deferred, finish
from voa_service.zenoh.joining import FOLLOW_SECONDS
from voa_service.zenoh.mailboxes import MOST_WAITING, MOST_WAITING_BYTES, Mailboxes
from voa_service.zenoh.mapped_robot import MappedRobot
from voa_service.zenoh.outbox import Outbox
from voa_service.zenoh.refusals import not_accepted
from voa_service.zenoh.replicas import Replicas
from voa_service.zenoh.samples import Sample

_WORKERS = 2

Beside = Callable[[zenoh.Session, RobotMapping], AbstractContextManager[object]]
"""Context manager that is entered while a robot is mapped."""


@dataclass(frozen=True)
class _Look:
    """A look that is due, with its robot and the key expression of the message that completed it."""

    robot: MappedRobot
    key: str
    due: DueLook


class Ros2:
    """Subscribers to the mapped topics, with their workers; the mapping file is read again when it changes.

    Args:
        services: use cases and limits.
        mapping: file that maps the ROS 2 topics of robots to sessions.
        replicas: decides which replica applies a look at once.
        outbox: publishes refusals.
        grace_seconds: delay after which a replica that is not responsible applies a look.
        left: returns the seconds that messages which were received may take at the end.
        beside: context manager that serves ROS tools while a robot is mapped.
    """

    def __init__(
        self,
        services: Services,
        mapping: Path,
        replicas: Replicas,
        outbox: Outbox,
        grace_seconds: float,
        left: Callable[[], float],
        beside: Beside,
    ) -> None:
        self._services = services
        self._beside = beside
        self._file = mapping
        self._replicas = replicas
        self._outbox = outbox
        self._left = left
        self._robots: dict[str, tuple[MappedRobot, ExitStack]] = {}
        self._read: str | None = None
        self._boxes: Mailboxes[tuple[MappedRobot, Sample | _Look]] = Mailboxes(
            self._work, _WORKERS, MOST_WAITING, MOST_WAITING_BYTES
        )
        self._deferred: Deferred[_Look] = Deferred(grace_seconds, self._hand_on, MOST_WAITING, MOST_WAITING_BYTES)
        replicas.when_one_leaves(self._deferred.hasten)

    def close(self) -> None:
        """Handle the messages that were received, as long as there is time, and end the workers."""
        for _ in range(finish(self._boxes, self._deferred, self._left)):
            self._services.metrics.zenoh("ROS message dropped at the end")
        self._deferred.close()
        self._boxes.close()

    @contextmanager
    def on(self, session: zenoh.Session) -> Iterator[None]:
        """Subscribe to the mapped topics within a `with` block."""
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
            self._read = None  # another session with a router must subscribe again

    @contextmanager
    def finishing(self, _session: zenoh.Session) -> Iterator[None]:
        """Handle the messages that were received, at the end of a `with` block; another replica may not have them."""
        yield
        finish(self._boxes, self._deferred, self._left)

    def _watch(self, session: zenoh.Session, ended: threading.Event) -> None:
        while not ended.wait(FOLLOW_SECONDS):
            self._follow_file(session)

    def _follow_file(self, session: zenoh.Session) -> None:
        """Follow the mapping file if it has changed; a file with a mistake leaves the current mapping in force."""
        try:
            text = self._file.read_text(encoding="utf-8")
            if text == self._read:
                return
            self._read = text
            wanted = {mapping.name: mapping for mapping in load(text)}
        except Exception as error:  # any mistake in the file leaves the mapping in force
            why = f"{self._file.name}: {error}"
            if self._services.robots.mapping_error != why:
                structlog.get_logger().warning(
                    "the mapping file is not used, the previous mapping stays in force", error=why
                )
            self._services.robots.mapping_error = why
            return
        self._services.robots.mapping_error = None
        for name, (robot, _) in list(self._robots.items()):
            if wanted.get(name) != robot.mapping:
                self._drop(name)
        added = [MappedRobot(mapping, self._services) for name, mapping in wanted.items() if name not in self._robots]
        with suppress(Failure):  # robots that are not prepared join their sessions with their first messages
            for robot in added:
                robot.prepare()
        for robot in added:
            self._add(session, robot)
        structlog.get_logger().info("the mapping file was read", robots=sorted(wanted))

    def _add(self, session: zenoh.Session, robot: MappedRobot) -> None:
        mapping, stack = robot.mapping, ExitStack()
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
        stack.enter_context(self._beside(session, mapping))

    def _drop(self, name: str) -> None:
        _, stack = self._robots.pop(name)
        stack.close()
        self._services.robots.unmapped(name)

    def _receive(self, robot: MappedRobot, subscription: Subscription, sample: zenoh.Sample) -> None:
        """Queue a message for a worker thread, or refuse it; called in a Zenoh thread."""
        key, type_ = str(sample.key_expr), subscription.type
        named = match_key(subscription.topic, key, robot.mapping.domain)
        if sample.kind != zenoh.SampleKind.PUT or named is None:
            return
        if named.type_name not in (None, type_.name):
            detail = f"expected a {type_.name}, found a {named.type_name}: is it the right topic?"
            self._refuse(robot, key, InvalidRequest(detail))
            return
        size, most = len(sample.payload), self._services.limits.scan_bytes
        self._services.metrics.zenoh(f"{type_.name.rpartition('/')[2]} received")
        if size > most:
            self._refuse(robot, key, TooLarge(f"expected a message of at most {most} bytes, got {size}"))
            return
        attachment = None if sample.attachment is None else sample.attachment.to_bytes()
        received = Sample(type_, key, sample.payload.to_bytes(), attachment, time.monotonic())
        if not self._boxes.put(robot.name, (robot, received), size):
            self._refuse(robot, key, Overloaded("too many messages are waiting: send fewer"))

    def _hand_on(self, look: _Look) -> None:
        if not self._boxes.put(look.robot.name, (look.robot, look), 0):
            look.robot.rejected(look.due, Overloaded.kind)
            self._refuse(look.robot, look.key, Overloaded("too many messages are waiting: send fewer"))

    def _work(self, item: tuple[MappedRobot, Sample | _Look]) -> None:
        """Handle a message or a look, in a worker thread."""
        structlog.contextvars.clear_contextvars()
        structlog.contextvars.bind_contextvars(request_id=secrets.token_hex(8))
        robot, received = item
        try:
            with guarded():
                if isinstance(received, _Look):
                    self._apply(received)
                else:
                    self._gather(robot, received)
        except Failure as failure:
            self._refuse(robot, received.key, failure)

    def _gather(self, robot: MappedRobot, sample: Sample) -> None:
        """Receive a message, and apply the look that it completes, if any, now or after a delay."""
        due = robot.receive(sample)
        if due is None:
            return
        look = _Look(robot, sample.key, due)
        if self._replicas.owns(robot.name):
            self._apply(look)
        else:
            for _ in range(self._deferred.put(look, 0)):
                self._services.metrics.zenoh("look of another replica dropped")

    def _apply(self, look: _Look) -> None:
        """Apply a look unless the session has it; after a failure the robot's stop may make another look."""
        robot, due = look.robot, look.due
        try:
            with guarded():
                outcome = apply_look(self._services.updates, due)
        except Failure as failure:
            robot.rejected(due, failure.kind)
            session, named = due.ledger.session, robot.name
            record_write(MAPPING, "look.apply", failure.status, session=session, robot=named)
            raise
        if outcome is None:
            self._services.metrics.zenoh("look applied already")
            return
        session, request = due.ledger.session, due.taken.request
        self._services.robots.looked(robot.name, "ros2", look.key, session, request, outcome)
        if not outcome.update.accepted:
            robot.rejected(due, outcome.update.reason or NotAccepted.kind)
            self._refuse(robot, look.key, not_accepted(outcome.update.reason))

    def _refuse(self, robot: MappedRobot, key: str, failure: Failure) -> None:
        why = f"{failure.kind}: {failure.detail}"
        self._services.metrics.zenoh(f"ROS message refused: {failure.kind}")
        if self._services.robots.refused(robot.name, "ros2", key, why):
            structlog.get_logger().warning("a ROS message was refused", robot=robot.name, key=key, why=why)
        if self._replicas.owns(robot.name):  # else the responsible replica publishes the refusal
            self._outbox.refused(robot.session or "none", robot.name, failure)
