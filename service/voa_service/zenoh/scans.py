"""`scan/<session>/<robot>`: raw scans that nobody waits for an answer to.

A sample has a name, so that it takes effect once although every replica hears it: its attachment's `id`, else its
publisher and sequence number, else the time that the router gave it with a digest of its payload.
"""

import hashlib
import json
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import structlog
import zenoh
from zenoh.handlers import Callback

from voa_msgs.keys import Keys
from voa_msgs.sessions import ScanRequest
from voa_ros.cdr import InvalidCdr, decode_laser_scan
from voa_ros.messages import header_contradiction
from voa_ros.scans import scan_message
from voa_ros.topics import LASER_SCAN, type_name
from voa_service.failures import BeamGridMismatch, Failure, InternalError, InvalidRequest, Overloaded, TooLarge
from voa_service.requests.attachments import add_place, read_attachment
from voa_service.requests.bodies import json_object, message
from voa_service.requests.idempotency import idempotency_key, scope_of, write_of
from voa_service.services import Services
from voa_service.usecases.robots import LookOutcome
from voa_service.zenoh.mailboxes import MOST_WAITING, MOST_WAITING_BYTES, Later, Mailboxes
from voa_service.zenoh.outbox import Outbox
from voa_service.zenoh.refusals import not_accepted
from voa_service.zenoh.replicas import Replicas

_WORKERS = 4
_END_SECONDS = 0.4


@dataclass(frozen=True)
class Heard:
    """A sample with a scan, as it came in."""

    session: str
    robot: str
    key: str
    payload: bytes
    encoding: str
    attachment: bytes | None
    name: str | None
    """Of the sample; None: nothing tells it from another one like it."""
    second: bool = False
    """Another replica should have worked on it by now."""


class Scans:
    """The subscriber, and the workers behind it."""

    def __init__(
        self, services: Services, keys: Keys, replicas: Replicas, outbox: Outbox, grace_seconds: float
    ) -> None:
        self._services = services
        self._keys = keys
        self._replicas = replicas
        self._outbox = outbox
        self._boxes = Mailboxes(self._work, _WORKERS, MOST_WAITING, MOST_WAITING_BYTES)
        self._later: Later[Heard] = Later(grace_seconds, self._hand_on, MOST_WAITING, MOST_WAITING_BYTES)
        replicas.when_one_leaves(self._later.hasten)
        services.metrics.gauge("voa_scans_waiting", "Scans heard, not applied yet.", lambda: self._boxes.waiting)

    def close(self) -> None:
        """End the workers."""
        self._later.close()
        self._boxes.close()

    @contextmanager
    def on(self, session: zenoh.Session) -> Iterator[None]:
        """Hear scans for the length of a `with`."""
        with session.declare_subscriber(self._keys.scan("*", "*"), Callback(self._heard, indirect=False)):
            yield
        for _ in range(self._boxes.drain(_END_SECONDS)):
            self._services.metrics.zenoh("scan dropped at the end")

    def _heard(self, sample: zenoh.Sample) -> None:
        """In a Zenoh thread: hand over, or refuse."""
        if sample.kind != zenoh.SampleKind.PUT:
            return
        key = str(sample.key_expr)
        self._services.metrics.zenoh("scan heard")
        if "*" in key:
            self._services.metrics.zenoh("scan refused: for nobody in particular")
            return
        session, robot = key.split("/")[-2:]
        self._services.robots.heard(robot, "scan", key, session)
        size, most = len(sample.payload), self._services.limits.scan_bytes
        if size > most:
            failure = TooLarge(f"expected a scan of at most {most} bytes, got {size}")
            self._refuse(session, robot, key, failure)
            return
        payload = sample.payload.to_bytes()
        attachment = None if sample.attachment is None else sample.attachment.to_bytes()
        heard = Heard(session, robot, key, payload, str(sample.encoding), attachment, name_of(sample, payload))
        if self._replicas.owns(f"{session}/{robot}"):
            self._hand_on(heard)
        elif heard.name is None:  # nothing could tell whether another replica has worked on it
            self._services.metrics.zenoh("scan without a name left to another replica")
        else:
            for _ in range(self._later.put(replace(heard, second=True), size)):
                self._services.metrics.zenoh("scan of another replica forgotten")

    def _hand_on(self, heard: Heard) -> None:
        if not self._boxes.put(f"{heard.session}/{heard.robot}", heard, len(heard.payload)):
            detail = "more scans of this robot are waiting than can be worked on: send fewer, or by scan.apply"
            self._refuse(heard.session, heard.robot, heard.key, Overloaded(detail))

    def _work(self, heard: Heard) -> None:
        """In a worker thread."""
        structlog.contextvars.clear_contextvars()
        structlog.contextvars.bind_contextvars(request_id=secrets.token_hex(8))
        try:
            self._apply(heard)
        except Failure as failure:
            self._refuse(heard.session, heard.robot, heard.key, failure)
        except Exception as error:
            structlog.get_logger().exception("unexpected error", exc_info=error)
            defect = InternalError("this is a defect of the service; its log has the request id")
            self._refuse(heard.session, heard.robot, heard.key, defect)

    def _apply(self, heard: Heard) -> None:
        attached = read_attachment(heard.attachment)
        fields = _fields(heard, self._services)
        add_place(fields, attached)
        request = message(ScanRequest, fields, self._services.limits)
        key = idempotency_key(attached.id or heard.name, scope_of(heard.session), "scan", request)
        sessions = self._services.sessions
        if heard.second and key is not None and sessions.has_answered(key):
            return
        answered = sessions.apply_scan(heard.session, request, write_of("scan", json.dumps(fields).encode(), key))
        outcome = LookOutcome.model_validate_json(answered.body)
        self._services.robots.looked(heard.robot, "scan", heard.key, heard.session, request, outcome)
        if not outcome.update.accepted:
            self._refuse(heard.session, heard.robot, heard.key, not_accepted(outcome.update.reason))

    def _refuse(self, session: str, robot: str, key: str, failure: Failure) -> None:
        why = f"{failure.kind}: {failure.detail}"
        self._services.metrics.zenoh(f"scan refused: {failure.kind}")
        if self._services.robots.refused(robot, "scan", key, why):
            structlog.get_logger().warning("scan refused", key=key, why=why)
        if self._replicas.owns(f"{session}/{robot}"):  # else another replica says so to the robot
            self._outbox.refused(session, robot, failure)


def name_of(sample: zenoh.Sample, payload: bytes) -> str | None:
    """What tells a sample from every other one, for all who hear it; None: nothing does."""
    source = sample.source_info
    if source is not None:
        return f"{source.source_id.zid}:{source.source_id.eid}:{source.source_sn}"
    if sample.timestamp is not None:
        return f"{sample.timestamp}:{hashlib.blake2b(payload, digest_size=16).hexdigest()}"
    return None


def _fields(heard: Heard, services: Services) -> dict[str, Any]:
    """The fields of a `ScanRequest` that the payload holds.

    Raises:
        Failure: it is neither the JSON nor the CDR of a scan.
    """
    kind, _, schema = heard.encoding.partition(";")
    bare = kind in ("zenoh/bytes", "zenoh/string", "")
    if kind in ("application/json", "text/json") or (bare and heard.payload.lstrip()[:1] == b"{"):
        return json_object(heard.payload, services.limits)
    if kind == "application/cdr" or (bare and heard.payload[:1] == b"\0"):
        found = type_name(schema)
        if found not in (None, LASER_SCAN.name):
            raise InvalidRequest(f"expected a {LASER_SCAN.name}, found a {found}")
        try:
            scan = decode_laser_scan(heard.payload, services.limits.beams)
        except InvalidCdr as error:
            raise InvalidRequest(str(error)) from error
        wrong = header_contradiction(scan)
        if wrong is not None:
            raise BeamGridMismatch(wrong)
        return {"scan": scan_message(scan).model_dump(exclude_unset=True)}
    raise InvalidRequest(f"expected application/json or application/cdr, got {heard.encoding!r}")
