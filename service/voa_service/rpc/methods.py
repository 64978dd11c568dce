"""The service's methods by name (DESIGN.md, 5.4), for entrypoints without paths and verbs: Zenoh, and this process.

A payload is the body of the HTTP call plus `session`, or `id`, where HTTP has it in the path; answers are the HTTP
bodies. Beyond the contract's methods there is one for each HTTP call that robots make: `object.stable_poses`,
`lidar.list`, `service.health`, `robot.list`, `robot.look`.
"""

import secrets
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import structlog
from annotated_types import Ge, Gt, Le
from pydantic import BaseModel, ValidationError

from voa_msgs import WIRE_VERSION
from voa_msgs.base import Id, Message, Name
from voa_msgs.bounds import LimitedBy
from voa_msgs.keys import Attachment
from voa_msgs.objects import MeshType, ObjectUpload, Sha256, UpAxis
from voa_msgs.rankings import RankingRequest, VoaRequest
from voa_msgs.robots import LookRequest
from voa_msgs.scenarios import PredictionsRequest, ScenarioRequest
from voa_msgs.sessions import BeliefRequest, OutcomeRequest, ScanRequest, SessionRequest, UpdateRequest
from voa_service.failures import Failure, InvalidRequest, NotFound, document, of_message, wire_failure
from voa_service.guard import guarded
from voa_service.requests import large
from voa_service.requests.idempotency import ANYONE, idempotency_key, scope_of, write_of
from voa_service.requests.reading import json_value
from voa_service.runtime.logs import is_wanted
from voa_service.runtime.queues import WorkQueue
from voa_service.services import Services
from voa_service.settings import Limits
from voa_service.usecases.rankings import Question
from voa_store.records import HistoryKind, StoredResponse

_PAGE = 100
_MOST_ATTACHED = 65_536


class _Page(Message):
    limit: Annotated[int, Ge(1), Le(1000)] = _PAGE
    after: str | None = None


class _ObjectPage(_Page):
    sha256: Sha256 | None = None
    type: MeshType | None = None
    scale: Annotated[float, Gt(0.0)] | None = None
    up: UpAxis | None = None


class _One(Message):
    id: Id


class _Session(Message):
    session: Id


class _Reachable(Message):
    grasps: Annotated[list[Name], LimitedBy("grasps")] | None = None


class _Nothing(Message):
    pass


@dataclass(frozen=True)
class RpcAnswer:
    """The body of an answer, or the problem document."""

    body: bytes
    is_problem: bool
    version: int | None = None
    """Of the session, where the answer is about one."""


@dataclass
class Call:
    """A method that was called: what is left of its payload, and who calls."""

    fields: dict[str, Any]
    attached: Attachment
    services: Services
    size: int
    """Bytes of the payload."""

    def take(self, kind: type[Message]) -> Any:
        """The fields of `kind`, taken out of the payload and checked."""
        own = {name: self.fields.pop(name) for name in kind.model_fields if name in self.fields}
        return self.services.reader.message(kind, own, self.size)

    def session(self) -> str:
        """The session that the call is about, `session` or `id`."""
        if "session" not in self.fields and "id" in self.fields:
            self.fields["session"] = self.fields.pop("id")
        taken: _Session = self.take(_Session)
        return taken.session

    def id(self) -> str:
        """The object or scenario that the call is about."""
        taken: _One = self.take(_One)
        return taken.id

    def body(self, kind: type[BaseModel]) -> Any:
        """Everything that is left."""
        return self.services.reader.message(kind, self.fields, self.size)

    def received(self) -> bytes:
        """What is left as JSON, for the history."""
        return "".join(large.pieces(self.fields)).encode()


Work = Callable[[Call], BaseModel | StoredResponse | bytes]


@dataclass(frozen=True)
class _Method:
    work: Work
    queue: WorkQueue


class Rpc:
    """All methods over given services."""

    def __init__(self, services: Services) -> None:
        self._services = services
        self._methods = _methods(services)

    def queue(self, method: str) -> WorkQueue:
        """Where calls of a method wait; those of none that exists with the reads."""
        known = self._methods.get(method)
        return self._services.reads if known is None else known.queue

    def answer(self, method: str, payload: bytes, attachment: bytes | None = None) -> RpcAnswer:
        """Call a method, in this thread; whatever goes wrong is a problem document."""
        structlog.contextvars.clear_contextvars()
        structlog.contextvars.bind_contextvars(request_id=secrets.token_hex(8))
        began = time.perf_counter()
        status = 200
        try:
            with guarded():
                return self._answer(method, payload, attachment)
        except Failure as failure:
            status = failure.status
            return RpcAnswer(document(failure), is_problem=True)
        finally:
            seconds = time.perf_counter() - began
            self._services.metrics.rpc(method if method in self._methods else "none", status, seconds)
            if is_wanted("INFO"):
                structlog.get_logger().info("rpc", method=method, status=status, milliseconds=round(1e3 * seconds, 3))

    def _answer(self, method: str, payload: bytes, attachment: bytes | None) -> RpcAnswer:
        known = self._methods.get(method)
        if known is None:
            detail = f"there is no method {method[:80]!r}"
            raise NotFound(detail, known=sorted(self._methods))
        attached = attachment_of(attachment)
        if attached.wire not in (None, WIRE_VERSION):
            raise wire_failure(attached.wire)
        done = known.work(Call(self._services.reader.fields(payload), attached, self._services, len(payload)))
        if isinstance(done, StoredResponse):
            return RpcAnswer(done.body.encode(), is_problem=False, version=done.version)
        if isinstance(done, bytes):
            return RpcAnswer(done, is_problem=False)
        return RpcAnswer(large.dumped(done, exclude_unset=False), is_problem=False)


def attachment_of(attachment: bytes | None) -> Attachment:
    """What stands beside a payload.

    Raises:
        Failure: it is not what is expected there.
    """
    if not attachment:
        return Attachment()
    if len(attachment) > _MOST_ATTACHED:
        raise InvalidRequest(f"expected an attachment of at most {_MOST_ATTACHED} bytes, got {len(attachment)}")
    try:
        found = json_value(attachment, Limits())
    except Failure as failure:
        raise InvalidRequest(f"attachment: {failure.detail}") from failure
    try:
        return Attachment.model_validate(found)
    except ValidationError as error:
        raise of_message(Attachment, error, "attachment") from error


def _methods(services: Services) -> Mapping[str, _Method]:
    objects, scenarios, sessions, rankings = services.objects, services.scenarios, services.sessions, services.rankings
    updates = services.updates
    reads, writes, heavy = services.reads, services.writes, services.heavy
    return {
        "object.create": _Method(_create_object, services.meshes),
        "object.get": _Method(_one(objects.get), reads),
        "object.list": _Method(_list_objects, reads),
        "object.stable_poses": _Method(_one(objects.stable_poses), services.rests),
        "lidar.list": _Method(_given(_Nothing, lambda _: scenarios.lidars()), reads),
        "scenario.create": _Method(_given(ScenarioRequest, lambda request: scenarios.create(request)[0]), heavy),
        "scenario.get": _Method(_one(scenarios.get), reads),
        "scenario.list": _Method(_listing(scenarios.list), reads),
        "scenario.warnings": _Method(_one(scenarios.warnings), heavy),
        "scenario.predict": _Method(lambda call: scenarios.predict(call.id(), call.body(PredictionsRequest)), heavy),
        "session.create": _Method(_create_session, writes),
        "session.get": _Method(_get_session, reads),
        "session.list": _Method(_listing(sessions.list), reads),
        "session.delete": _Method(_delete_session, writes),
        "belief.put": _Method(_write("belief", BeliefRequest, updates.put_belief), writes),
        "scan.apply": _Method(_write("scan", ScanRequest, updates.apply_scan), writes),
        "outcome.report": _Method(_write("outcome", OutcomeRequest, updates.report_outcome), writes),
        "voa.rank": _Method(_ranked(lambda call: rankings.of_session(call.session(), call.body(VoaRequest))), heavy),
        "grasp.rank": _Method(_rank_grasps, reads),
        "history.get": _Method(_history, reads),
        "update.compute": _Method(_given(UpdateRequest, updates.update_once), reads),
        "ranking.compute": _Method(_ranked(lambda call: rankings.once(call.body(RankingRequest))), heavy),
        "service.health": _Method(_given(_Nothing, lambda _: services.health.ready()), services.probes),
        "robot.list": _Method(_given(_Nothing, lambda _: services.robots.reports()), reads),
        "robot.look": _Method(_given(LookRequest, lambda asked: services.robots.request_look(asked.robot)), reads),
    }


def _given(kind: type[BaseModel], act: Callable[[Any], BaseModel]) -> Work:
    """A method whose payload is one message."""
    return lambda call: act(call.body(kind))


def _listing(act: Callable[[int, str | None], BaseModel]) -> Work:
    """A method that answers a page."""

    def work(call: Call) -> BaseModel:
        page: _Page = call.body(_Page)
        return act(page.limit, page.after)

    return work


def _one(get: Callable[[str], BaseModel]) -> Work:
    """A method about one object or scenario."""

    def work(call: Call) -> BaseModel:
        id_ = call.id()
        call.body(_Nothing)
        return get(id_)

    return work


def _ranked(ask: Callable[[Call], Question]) -> Work:
    """A method that ranks looks; nobody says on Zenoh that they wait no more, so only the service's end stops it."""

    def work(call: Call) -> bytes:
        question = ask(call)
        return call.services.rankings.answer(question, call.services.heavy.check).to(question)

    return work


def _write(kind: HistoryKind, body: type[Message], act: Callable[[str, Any, Any], StoredResponse]) -> Work:
    """A method that moves a session."""

    def work(call: Call) -> StoredResponse:
        id_ = call.session()
        if kind == "scan":
            place_in(call.fields, call.attached)
        received = call.received()
        request = call.body(body)
        key = idempotency_key(call.attached.id, scope_of(id_), kind, request)
        return act(id_, request, write_of(kind, received, key))

    return work


def _create_object(call: Call) -> BaseModel:
    upload: ObjectUpload = call.body(ObjectUpload)
    return call.services.objects.create(upload.file, upload.filename, upload.name, upload.scale, upload.up)[0]


def _list_objects(call: Call) -> BaseModel:
    asked: _ObjectPage = call.body(_ObjectPage)
    file = asked.sha256, asked.type, asked.scale, asked.up
    return call.services.objects.list(asked.limit, asked.after, *file)


def _create_session(call: Call) -> StoredResponse:
    received = call.received()
    request = call.body(SessionRequest)
    key = idempotency_key(call.attached.id, ANYONE, "create session", request)
    return call.services.sessions.create(request, write_of("prior", received, key))


def _get_session(call: Call) -> StoredResponse:
    id_ = call.session()
    call.body(_Nothing)
    return call.services.sessions.response(id_)


def _delete_session(call: Call) -> BaseModel:
    id_ = call.session()
    call.body(_Nothing)
    call.services.sessions.delete(id_, idempotency_key(call.attached.id, scope_of(id_), "delete", None), None)
    return _Nothing()


def _history(call: Call) -> BaseModel:
    id_ = call.session()
    page: _Page = call.body(_Page)
    return call.services.sessions.history(id_, page.limit, page.after)


def _rank_grasps(call: Call) -> BaseModel:
    id_ = call.session()
    reachable: _Reachable = call.body(_Reachable)
    return call.services.rankings.grasps(id_, reachable.grasps)


def place_in(fields: dict[str, Any], attached: Attachment) -> None:
    """Where a scan was taken goes into its body from beside it.

    Raises:
        Failure: both say it.
    """
    beside = attached.model_dump(include={"sensor", "sensor_pose"}, exclude_none=True)
    if not beside:
        return
    if fields.get("sensor") is not None or fields.get("sensor_pose") is not None:
        raise InvalidRequest("the payload and its attachment both say where the scan was taken: expected one of them")
    fields.update(beside)
