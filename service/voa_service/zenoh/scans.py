"""Raw scans on `scan/<session>/<robot>`: applied to their session, without a response to the robot.

Every replica receives every sample, and a sample takes effect once because its name is its idempotency key: the `id` of
its attachment, else its publisher and sequence number, else its router's timestamp with a digest of its payload.
"""

import hashlib
import json
import secrets
from collections.abc import Callable, Iterator
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
from voa_service.access.audit import record_write
from voa_service.access.callers import ANONYMOUS, Caller
from voa_service.access.roles import SCAN_PUT
from voa_service.failures import BeamGridMismatch, Failure, InvalidRequest, Overloaded, TooLarge, TooManyWithoutKey
from voa_service.guard import guarded
from voa_service.requests.attachments import add_place, identified, read_attachment
from voa_service.requests.bodies import json_object, message
from voa_service.requests.idempotency import idempotency_key, scope_of, write_of
from voa_service.services import Services
from voa_service.usecases.robots import LookOutcome
from voa_service.zenoh.deferred import Deferred, finish
from voa_service.zenoh.mailboxes import MOST_WAITING, MOST_WAITING_BYTES, Mailboxes
from voa_service.zenoh.outbox import Outbox
from voa_service.zenoh.refusals import not_accepted
from voa_service.zenoh.replicas import Replicas
from voa_store.records import IdempotencyKey

_WORKERS = 4
_ORIGINS = "robots that put scans"
"""Group of the origins of puts without a valid key: whoever puts a scan chooses the name of its robot."""


@dataclass(frozen=True)
class ReceivedScan:
    """A sample with a scan, as it was received.

    Attributes:
        session: id of the session that the scan is for.
        robot: name of the robot that sent it.
        key: key expression that it was published on.
        payload: the scan, as JSON or CDR; empty where it is too large to be kept.
        size: of the scan as it was put, bytes.
        encoding: of the payload, as Zenoh states it.
        attachment: bytes beside the payload, if there are any.
        name: of the sample, unique to it; None: an equal sample could not be distinguished.
        caller: that put it.
        is_deferred: True where another replica is responsible for it, and should have handled it before.
    """

    session: str
    robot: str
    key: str
    payload: bytes
    size: int
    encoding: str
    attachment: bytes | None
    name: str | None
    caller: Caller
    is_deferred: bool = False


class Scans:
    """The subscriber to raw scans, with its workers.

    Args:
        services: use cases and limits.
        keys: key expressions of the service.
        replicas: decides which replica handles a scan at once.
        outbox: publishes refusals.
        grace_seconds: delay after which a replica that is not responsible handles a scan.
        left: returns the seconds that scans which were received may take at the end.
    """

    def __init__(
        self,
        services: Services,
        keys: Keys,
        replicas: Replicas,
        outbox: Outbox,
        grace_seconds: float,
        left: Callable[[], float],
    ) -> None:
        self._services = services
        self._keys = keys
        self._replicas = replicas
        self._outbox = outbox
        self._left = left
        self._boxes = Mailboxes(self._work, _WORKERS, MOST_WAITING, MOST_WAITING_BYTES)
        self._deferred: Deferred[ReceivedScan] = Deferred(
            grace_seconds, self._hand_on, MOST_WAITING, MOST_WAITING_BYTES
        )
        replicas.when_one_leaves(self._deferred.hasten)
        services.metrics.gauge(
            "voa_scans_waiting", "Scans that were received and not applied yet.", lambda: self._boxes.waiting
        )

    def close(self) -> None:
        """Apply the scans that were received, as long as there is time, and end the workers."""
        for _ in range(finish(self._boxes, self._deferred, self._left)):
            self._services.metrics.zenoh("scan dropped at the end")
        self._deferred.close()
        self._boxes.close()

    @contextmanager
    def on(self, session: zenoh.Session) -> Iterator[None]:
        """Subscribe to scans within a `with` block."""
        with session.declare_subscriber(self._keys.scan("*", "*"), Callback(self._receive, indirect=False)):
            yield

    @contextmanager
    def finishing(self, _session: zenoh.Session) -> Iterator[None]:
        """Apply the scans that were received, at the end of a `with` block; another replica may not have them."""
        yield
        finish(self._boxes, self._deferred, self._left)

    def _receive(self, sample: zenoh.Sample) -> None:
        """Queue a scan for a worker thread, or refuse it; called in a Zenoh thread."""
        if sample.kind != zenoh.SampleKind.PUT:
            return
        key = str(sample.key_expr)
        self._services.metrics.zenoh("scan received")
        if "*" in key:
            self._services.metrics.zenoh("scan refused: no single session and robot")
            return
        session, robot = key.split("/")[-2:]
        attachment = None if sample.attachment is None else sample.attachment.to_bytes()
        caller = self._admitted(attachment, session, robot, key)
        if caller is None:
            return
        size = len(sample.payload)
        payload = b"" if size > self._services.limits.scan_bytes else sample.payload.to_bytes()
        named = name_of(sample, payload)
        scan = ReceivedScan(session, robot, key, payload, size, str(sample.encoding), attachment, named, caller)
        if self._replicas.owns(f"{session}/{robot}"):
            self._hand_on(scan)
        elif scan.name is None:  # no replica could detect that another one has applied it
            self._services.metrics.zenoh("scan without a name left to another replica")
        else:
            for _ in range(self._deferred.put(replace(scan, is_deferred=True), size)):
                self._services.metrics.zenoh("scan of another replica dropped")

    def _admitted(self, attachment: bytes | None, session: str, robot: str, key: str) -> Caller | None:
        """Return the caller that put a scan, by the key in its attachment, before the scan takes any room.

        None: it may not put scans for this session and robot, or not so many, and that was reported; without a valid
        key it is reported so many times in a period only.
        """
        gate = self._services.gate
        if not gate.keyring.is_closed:
            return ANONYMOUS
        caller: Caller | None = None
        try:
            caller = identified(gate, attachment, SCAN_PUT, f"robot {robot}", _ORIGINS)[1]
            caller.check_robot(robot)
            gate.admit(caller, SCAN_PUT, session)
        except Failure as failure:
            if isinstance(failure, TooManyWithoutKey):
                self._services.metrics.zenoh("scan refused: without a valid key, too often")
                return None
            record_write(caller, SCAN_PUT.name, failure.status, session=session, robot=robot)
            self._refuse(session, robot, key, failure)
            return None
        return caller

    def _hand_on(self, scan: ReceivedScan) -> None:
        if not self._boxes.put(f"{scan.session}/{scan.robot}", scan, len(scan.payload)):
            detail = "too many scans of this robot are waiting: send fewer, or by the remote call scan.apply"
            self._refuse(scan.session, scan.robot, scan.key, Overloaded(detail))

    def _work(self, scan: ReceivedScan) -> None:
        """Apply a scan, or publish why it had no effect; in a worker thread."""
        structlog.contextvars.clear_contextvars()
        structlog.contextvars.bind_contextvars(request_id=secrets.token_hex(8))
        try:
            with guarded():
                self._apply(scan)
        except Failure as failure:
            record_write(scan.caller, SCAN_PUT.name, failure.status, session=scan.session, robot=scan.robot)
            self._refuse(scan.session, scan.robot, scan.key, failure)

    def _apply(self, scan: ReceivedScan) -> None:
        try:
            fields, request, key = self._read(scan)
        except Failure:
            self._count(scan, None)
            raise
        sessions, updates = self._services.sessions, self._services.updates
        if scan.is_deferred and key is not None and sessions.has_response(key):
            # Its caller was checked when it took effect, and the robot may have moved to another session since.
            self._services.robots.put(scan.robot, scan.key, scan.session, request)
            return
        self._count(scan, request)
        response = updates.apply_scan(scan.session, request, write_of("scan", json.dumps(fields).encode(), key))
        outcome = LookOutcome.model_validate_json(response.body)
        version = outcome.version
        record_write(scan.caller, SCAN_PUT.name, 200, session=scan.session, robot=scan.robot, version=version)
        self._services.robots.looked(scan.robot, "scan", scan.key, scan.session, request, outcome)
        if not outcome.update.accepted:
            self._refuse(scan.session, scan.robot, scan.key, not_accepted(outcome.update.reason))

    def _read(self, scan: ReceivedScan) -> tuple[dict[str, Any], ScanRequest, IdempotencyKey | None]:
        """Return the fields of a scan, the request that they make, and its idempotency key; raises Failure."""
        most = self._services.limits.scan_bytes
        if scan.size > most:
            raise TooLarge(f"expected a scan of at most {most} bytes, got {scan.size}")
        attachment = read_attachment(scan.attachment)
        fields = _fields(scan, self._services)
        add_place(fields, attachment)
        request = message(ScanRequest, fields, self._services.limits)
        key = idempotency_key(attachment.id or scan.name, scope_of(scan.session), "scan", request)
        return fields, request, key

    def _count(self, scan: ReceivedScan, request: ScanRequest | None) -> None:
        """Count a scan, readable or not, in the report on its robot; raises Forbidden if the robot may not put it."""
        scan.caller.check_acting(scan.session, scan.robot, self._services.acting)
        self._services.robots.put(scan.robot, scan.key, scan.session, request)

    def _refuse(self, session: str, robot: str, key: str, failure: Failure) -> None:
        why = f"{failure.kind}: {failure.detail}"
        self._services.metrics.zenoh(f"scan refused: {failure.kind}")
        if self._services.robots.refused(robot, "scan", key, why):
            structlog.get_logger().warning("a scan was refused", key=key, why=why)
        if self._replicas.owns(f"{session}/{robot}"):  # else the responsible replica publishes the refusal
            self._outbox.refused(session, robot, failure)


def name_of(sample: zenoh.Sample, payload: bytes) -> str | None:
    """Return a name for a sample, unique to it and equal at every replica; None where it has nothing unique."""
    source = sample.source_info
    if source is not None:
        return f"{source.source_id.zid}:{source.source_id.eid}:{source.source_sn}"
    if sample.timestamp is not None:
        return f"{sample.timestamp}:{hashlib.blake2b(payload, digest_size=16).hexdigest()}"
    return None


def _fields(received: ReceivedScan, services: Services) -> dict[str, Any]:
    """Read the fields of a `ScanRequest` from a payload of JSON, or of the CDR of a `sensor_msgs/LaserScan`.

    Raises:
        Failure: the payload is neither.
    """
    kind, _, schema = received.encoding.partition(";")
    bare = kind in ("zenoh/bytes", "zenoh/string", "")
    if kind in ("application/json", "text/json") or (bare and received.payload.lstrip()[:1] == b"{"):
        return json_object(received.payload, services.limits)
    if kind == "application/cdr" or (bare and received.payload[:1] == b"\0"):
        type_ = type_name(schema)
        if type_ not in (None, LASER_SCAN.name):
            raise InvalidRequest(f"expected a {LASER_SCAN.name}, found a {type_}")
        try:
            scan = decode_laser_scan(received.payload, services.limits.beams)
        except InvalidCdr as error:
            raise InvalidRequest(str(error)) from error
        contradiction = header_contradiction(scan)
        if contradiction is not None:
            raise BeamGridMismatch(contradiction)
        return {"scan": scan_message(scan).model_dump(exclude_unset=True)}
    raise InvalidRequest(f"expected application/json or application/cdr, got {received.encoding!r}")
