"""Inputs from ROS tools: a pose of the object that a person marks, and outcomes of attempts of the best grasp.

Every replica receives every sample. The responsible one applies it at once, the others after a delay unless that has
happened; the name of the sample is the idempotency key, so that it takes effect once.
"""

import hashlib
import secrets
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import partial

import structlog
import zenoh
from zenoh.handlers import Callback

from voa_msgs.sessions import BeliefRequest, OutcomeRequest
from voa_ros.cdr import InvalidCdr, decode_bool, decode_pose
from voa_ros.priors import UnusablePrior, marked_belief
from voa_ros.robots import RobotMapping
from voa_ros.topics import (
    BOOL,
    POSE_WITH_COVARIANCE_STAMPED,
    InvalidRmwAttachment,
    MessageType,
    RmwAttachment,
    expressions,
    match_key,
)
from voa_service.access.audit import record_write
from voa_service.access.callers import MAPPING
from voa_service.failures import Failure, IdempotencyKeyReused, InvalidRequest, NotAccepted, Overloaded, not_found
from voa_service.guard import guarded
from voa_service.requests.idempotency import idempotency_key, scope_of, write_of
from voa_service.services import Services
from voa_service.zenoh.deferred import Deferred, finish
from voa_service.zenoh.mailboxes import Mailboxes
from voa_service.zenoh.outbox import Outbox
from voa_service.zenoh.replicas import Replicas
from voa_service.zenoh.scans import name_of
from voa_store.records import IdempotencyKey

_MOST_WAITING = 256
_MOST_BYTES = 4_096


@dataclass(frozen=True)
class Received:
    """Sample of an input.

    Attributes:
        type: of its message.
        key: key that it was published on.
        payload: message as CDR.
        name: of the sample, equal at every replica; None: it has none.
        is_deferred: True where another replica is responsible for it, and should have applied it before.
    """

    type: MessageType
    key: str
    payload: bytes
    name: str | None
    is_deferred: bool = False


class Inputs:
    """Subscribers to the inputs of one robot, with their worker.

    Args:
        services: use cases.
        mapping: of the robot, with its inputs.
        replicas: decides which replica applies an input at once.
        outbox: publishes refusals.
        grace_seconds: delay after which another replica applies it.
        left: returns the seconds that inputs which were received may take at the end.
    """

    def __init__(
        self,
        services: Services,
        mapping: RobotMapping,
        replicas: Replicas,
        outbox: Outbox,
        grace_seconds: float,
        left: Callable[[], float],
    ) -> None:
        self._services = services
        self._mapping = mapping
        self._replicas = replicas
        self._outbox = outbox
        self._left = left
        most_bytes = _MOST_WAITING * _MOST_BYTES
        self._boxes: Mailboxes[Received] = Mailboxes(self._work, 1, _MOST_WAITING, most_bytes)
        self._deferred: Deferred[Received] = Deferred(grace_seconds, self._hand_on, _MOST_WAITING, most_bytes)

    def close(self) -> None:
        """Apply the inputs that were received, as long as there is time, and end the worker."""
        for _ in range(finish(self._boxes, self._deferred, self._left)):
            self._services.metrics.zenoh("ROS input dropped at the end")
        self._deferred.close()
        self._boxes.close()

    @contextmanager
    def on(self, session: zenoh.Session) -> Iterator[None]:
        """Receive inputs within a `with` block."""
        inputs, mapping = self._mapping.inputs, self._mapping
        chosen = [(inputs.prior, POSE_WITH_COVARIANCE_STAMPED), (inputs.outcome, BOOL)]
        with ExitStack() as stack:
            for topic, type_ in chosen:
                if topic is None:
                    continue
                resolved = mapping.topic(topic)
                for expression in expressions(resolved, mapping.domain):
                    receive = Callback(partial(self._receive, resolved, type_), indirect=False)
                    stack.enter_context(session.declare_subscriber(expression, receive))
            yield

    def _receive(self, topic: str, type_: MessageType, sample: zenoh.Sample) -> None:
        """Queue a sample, or refuse it; called in a Zenoh thread."""
        key = str(sample.key_expr)
        named = match_key(topic, key, self._mapping.domain)
        if sample.kind != zenoh.SampleKind.PUT or named is None:
            return
        if named.type_name not in (None, type_.name):
            self._refuse(type_, key, InvalidRequest(f"expected a {type_.name} on {topic}, got a {named.type_name}"))
            return
        if len(sample.payload) > _MOST_BYTES:
            size = len(sample.payload)
            self._refuse(type_, key, InvalidRequest(f"expected a {type_.name} on {topic}, got {size} bytes"))
            return
        payload = sample.payload.to_bytes()
        received = Received(type_, key, payload, _name(sample, payload))
        if self._replicas.owns(self._mapping.name):
            self._hand_on(received)
        elif received.name is not None:  # without a name no replica could detect that another one has applied it
            self._deferred.put(replace(received, is_deferred=True), len(payload))

    def _hand_on(self, received: Received) -> None:
        if not self._boxes.put(self._mapping.name, received, len(received.payload)):
            detail = "too many messages of this robot are waiting: send fewer"
            self._refuse(received.type, received.key, Overloaded(detail))

    def _work(self, received: Received) -> None:
        """Apply an input, or publish why it had no effect; in a worker thread."""
        structlog.contextvars.clear_contextvars()
        structlog.contextvars.bind_contextvars(request_id=secrets.token_hex(8))
        session: str | None = None
        try:
            with guarded():
                session = self._services.robots.report(self._mapping.name).session
                self._apply(session, received)
        except IdempotencyKeyReused:  # as the outcome of another grasp, which was the best one then
            self._services.metrics.zenoh("ROS input applied already")
        except Failure as failure:
            self._refuse(received.type, received.key, failure, session)

    def _apply(self, session: str | None, received: Received) -> None:
        if session is None:
            raise not_found("session yet of robot", self._mapping.name)
        try:
            if received.type == BOOL:
                self._apply_outcome(session, received)
            else:
                self._apply_prior(session, received)
        except (InvalidCdr, UnusablePrior) as error:
            raise InvalidRequest(f"{received.key}: {error}") from error

    def _apply_prior(self, session: str, received: Received) -> None:
        """Replace the belief by the one that follows from a marked pose of the object."""
        state = self._services.sessions.state(session)
        poses = self._services.scenarios.get(state.scenario).poses
        marked = decode_pose(received.payload)
        request = BeliefRequest(belief=marked_belief(poses, state.prior.p.tolist(), marked, self._mapping))
        key = idempotency_key(received.name, scope_of(session), "belief", request)
        if self._is_applied(received, key):
            return
        done = self._services.updates.put_belief(session, request, write_of("belief", _body(request), key))
        self._record(received.type, session, 200, done.version)
        structlog.get_logger().info("the object was marked", robot=self._mapping.name, session=session)

    def _apply_outcome(self, session: str, received: Received) -> None:
        """Report the outcome of an attempt of the grasp that is best at this moment."""
        success = decode_bool(received.payload)
        best = self._services.sessions.message(self._services.sessions.state(session)).best_grasp
        if best is None:
            raise NotAccepted("an outcome needs a best grasp, and every grasp scores 0 under the belief")
        moved = self._mapping.inputs.object_moved
        request = OutcomeRequest(grasp=best, success=success, object_moved=moved)
        key = idempotency_key(received.name, scope_of(session), "outcome", request)
        if self._is_applied(received, key):
            return
        done = self._services.updates.report_outcome(session, request, write_of("outcome", _body(request), key))
        self._record(received.type, session, 200, done.version)
        structlog.get_logger().info("an outcome was reported", robot=self._mapping.name, grasp=best, success=success)

    def _record(self, type_: MessageType, session: str | None, result: int, version: int | None = None) -> None:
        """Record an input that was applied or refused in the audit."""
        call = "outcome.report" if type_ == BOOL else "belief.put"
        record_write(MAPPING, call, result, session=session, robot=self._mapping.name, version=version)

    def _is_applied(self, received: Received, key: IdempotencyKey | None) -> bool:
        """Return True for a deferred input that the responsible replica has applied."""
        if not received.is_deferred or key is None or not self._services.sessions.has_response(key):
            return False
        self._services.metrics.zenoh("ROS input applied already")
        return True

    def _refuse(self, type_: MessageType, key: str, failure: Failure, session: str | None = None) -> None:
        why = f"{failure.kind}: {failure.detail}"
        robot = self._mapping.name
        self._services.metrics.zenoh(f"ROS input refused: {failure.kind}")
        structlog.get_logger().warning("an input from ROS was refused", robot=robot, key=key, why=why)
        if self._replicas.owns(robot):  # else the responsible replica records and publishes the refusal
            self._record(type_, session, failure.status)
            self._outbox.refused(self._mapping.session or "none", robot, failure)


def _body(request: BeliefRequest | OutcomeRequest) -> bytes:
    return request.model_dump_json().encode()


def _name(sample: zenoh.Sample, payload: bytes) -> str | None:
    """Return a name for a sample, equal at every replica and no longer than an idempotency key may be."""
    attachment = None if sample.attachment is None else sample.attachment.to_bytes()
    try:
        name = name_of(sample, payload) if attachment is None else RmwAttachment.decode(attachment).name
    except InvalidRmwAttachment:
        name = name_of(sample, payload)
    return None if name is None else f"ros:{hashlib.blake2b(name.encode(), digest_size=16).hexdigest()}"
