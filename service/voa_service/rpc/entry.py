"""The entry of remote calls: finds the method of a call, does its work in this thread, and writes the response."""

import json
import secrets
import time
from dataclasses import dataclass

import structlog

from voa_msgs import WIRE_VERSION
from voa_msgs.keys import Attachment
from voa_service.access import roles as access
from voa_service.access.audit import record_write
from voa_service.access.callers import ANONYMOUS, Caller
from voa_service.failures import Failure, NotFound, TooManyWithoutKey, document, wire_failure
from voa_service.guard import guarded
from voa_service.requests.attachments import identified, read_attachment
from voa_service.requests.large_json import dumped
from voa_service.rpc.calls import Call
from voa_service.rpc.methods import methods_of
from voa_service.runtime.logs import is_wanted
from voa_service.runtime.queues import WorkQueue
from voa_service.services import Services
from voa_store.records import StoredResponse

ORIGIN = "callers of methods"
"""Origin of calls on Zenoh without a valid key: Zenoh does not say who calls."""


@dataclass(frozen=True)
class RpcAnswer:
    """Response to a remote call.

    Attributes:
        body: the response's JSON, or a problem document.
        is_problem: True where the body is a problem document.
        version: of the session, where the response is about one.
    """

    body: bytes
    is_problem: bool
    version: int | None = None


@dataclass(frozen=True)
class Admitted:
    """A call that its caller may make, before its payload is looked at.

    Attributes:
        method: name of the method.
        beside: attachment of the call.
        caller: that makes the call.
        request: id of the request, for the logs and in problem documents.
    """

    method: str
    beside: Attachment
    caller: Caller
    request: str


@dataclass
class _Record:
    """Facts about a call for the audit, as far as they are known."""

    call: access.Call
    caller: Caller | None = None
    made: Call | None = None
    created: str | None = None
    version: int | None = None


class Rpc:
    """All methods of the service, by name.

    Args:
        services: the use cases that the methods call.
    """

    def __init__(self, services: Services) -> None:
        self._services = services
        self._methods = methods_of(services)

    def queue(self, method: str) -> WorkQueue:
        """Return the queue in which calls of a method wait; calls of unknown methods wait with the reads."""
        known = self._methods.get(method)
        return self._services.reads if known is None else known.queue

    def may_repeat(self, method: str, attachment: bytes | None) -> bool:
        """Return True if a call that is answered twice changes nothing the second time: it reads, or has an id."""
        if not access.BY_NAME.get(method, access.UNLISTED).writes:
            return True
        try:
            return read_attachment(attachment).id is not None
        except Failure:
            return True  # it is refused

    def answer(self, method: str, payload: bytes, attachment: bytes | None = None) -> RpcAnswer:
        """Call a method in this thread, log and count the call; a failure becomes a problem document.

        Args:
            method: name, as in `scan.apply`.
            payload: JSON of the request; empty: no fields.
            attachment: JSON beside it, with the caller's API key where the service needs one; or None.
        """
        try:
            admitted = self.admit(method, attachment)
        except Failure as failure:
            return RpcAnswer(document(failure), is_problem=True)
        return self.perform(admitted, payload)

    def admit(self, method: str, attachment: bytes | None) -> Admitted:
        """Admit a call by its attachment alone, or log and count its refusal; needs no database, and does not wait.

        Args:
            method: name, as in `scan.apply`.
            attachment: JSON beside the payload, with the caller's API key where the service needs one; or None.

        Raises:
            Failure: the caller may not make the call.
        """
        request = secrets.token_hex(8)
        _bind(request)
        began = time.perf_counter()
        record = _Record(access.BY_NAME.get(method, access.UNLISTED))
        gate = self._services.gate
        try:
            with guarded():
                beside, record.caller = identified(gate, attachment, record.call, ORIGIN)
                gate.admit(record.caller, record.call)
        except Failure as failure:
            self._report(method, record, failure.status, began)
            raise
        return Admitted(method, beside, record.caller, request)

    def perform(self, admitted: Admitted, payload: bytes) -> RpcAnswer:
        """Do the work of a call that was admitted in this thread, log and count it; a failure becomes a document.

        Args:
            admitted: the call.
            payload: JSON of the request; empty: no fields.
        """
        method = admitted.method
        _bind(admitted.request, admitted.caller)
        began = time.perf_counter()
        status = 200
        record = _Record(access.BY_NAME.get(method, access.UNLISTED), admitted.caller)
        try:
            with guarded():
                return self._answer(method, payload, admitted.beside, record)
        except Failure as failure:
            status = failure.status
            return RpcAnswer(document(failure), is_problem=True)
        finally:
            self._report(method, record, status, began)

    def _report(self, method: str, record: _Record, status: int, began: float) -> None:
        """Count a call that is over, and log it."""
        seconds = time.perf_counter() - began
        self._services.metrics.rpc(method if method in self._methods else "none", status, seconds)
        if record.call.writes and not (record.caller is None and status == TooManyWithoutKey.status):
            _audit(record, status)
        if is_wanted("INFO"):
            structlog.get_logger().info("rpc", method=method, status=status, milliseconds=round(1e3 * seconds, 3))

    def _answer(self, method: str, payload: bytes, beside: Attachment, record: _Record) -> RpcAnswer:
        known = self._methods.get(method)
        if known is None:
            raise NotFound(f"there is no method {method[:80]!r}", known=sorted(self._methods))
        if beside.wire not in (None, WIRE_VERSION):
            raise wire_failure(beside.wire)
        fields = self._services.reader.fields(payload)
        caller = ANONYMOUS if record.caller is None else record.caller
        record.made = Call(fields, beside, self._services, len(payload), caller)
        response = known.work(record.made)
        if isinstance(response, StoredResponse):
            record.version = response.version
            if record.call.on == "sessions":
                record.created = json.loads(response.body)["id"]
            return RpcAnswer(response.body.encode(), is_problem=False, version=response.version)
        if isinstance(response, bytes):
            return RpcAnswer(response, is_problem=False)
        return RpcAnswer(dumped(response, exclude_unset=False), is_problem=False)


def _bind(request: str, caller: Caller | None = None) -> None:
    """Bind the id of a request, and the name of its caller, to the lines that this thread logs."""
    structlog.contextvars.clear_contextvars()
    structlog.contextvars.bind_contextvars(request_id=request)
    if caller is not None and caller.key is not None:
        structlog.contextvars.bind_contextvars(caller=caller.name)


def _audit(record: _Record, status: int) -> None:
    """Record a write."""
    session = record.created if record.made is None else record.made.subject or record.created
    robot = None if record.made is None else record.made.robot
    record_write(record.caller, record.call.name, status, session=session, robot=robot, version=record.version)
