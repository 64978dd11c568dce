"""The methods of remote calls: a table from names to the work of each, and the queue in which its calls wait.

A payload is the body of the HTTP request plus `session`, or `id`, where HTTP has it in the path; responses are the
bodies of HTTP. Beside the methods of the contract there is one for each HTTP request that robots make:
`object.stable_poses`, `lidar.list`, `service.health`, `robot.list`, `robot.scan` and `robot.look`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from pydantic import BaseModel

from voa_msgs.base import Message
from voa_msgs.looks import LookAnnouncement
from voa_msgs.objects import ObjectUpload
from voa_msgs.rankings import RankingRequest, VoaRequest
from voa_msgs.robots import LookRequest
from voa_msgs.scenarios import PredictionsRequest, ScenarioRequest
from voa_msgs.sessions import BeliefRequest, OutcomeRequest, ScanRequest, SessionRequest, UpdateRequest
from voa_service.requests.attachments import add_place
from voa_service.requests.idempotency import idempotency_key, scope_of, scope_of_caller, write_of
from voa_service.rpc.calls import Call
from voa_service.rpc.parameters import Announced, HistoryPage, NoParameters, ObjectPage, Page, Reachable, Thinning
from voa_service.runtime.queues import WorkQueue
from voa_service.services import Services
from voa_service.usecases.rankings import Question
from voa_store.records import StoredResponse, WriteKind

Work = Callable[[Call], BaseModel | StoredResponse | bytes]
"""Work of a method: from a call to the response, as a message, a stored response, or JSON."""


@dataclass(frozen=True)
class Method:
    """A method: its work, and the queue in whose threads it is done."""

    work: Work
    queue: WorkQueue


def methods_of(services: Services) -> Mapping[str, Method]:
    """Make the table of all methods, by name."""
    objects, scenarios, rankings, updates = services.objects, services.scenarios, services.rankings, services.updates
    reads, writes, heavy = services.reads, services.writes, services.heavy
    return {
        "object.create": Method(_create_object, services.meshes),
        "object.get": Method(_one(objects.get), reads),
        "object.delete": Method(_deleting(objects.delete), writes),
        "object.list": Method(_list_objects, reads),
        "object.mesh": Method(_object_mesh, services.rests),
        "object.stable_poses": Method(_one(objects.stable_poses), services.rests),
        "lidar.list": Method(_given(NoParameters, lambda _: scenarios.lidars()), reads),
        "scenario.create": Method(_given(ScenarioRequest, lambda request: scenarios.create(request)[0]), heavy),
        "scenario.get": Method(_one(scenarios.get), reads),
        "scenario.delete": Method(_deleting(scenarios.delete), writes),
        "scenario.list": Method(_listing(scenarios.list), reads),
        "scenario.warnings": Method(_one(scenarios.warnings), heavy),
        "scenario.predict": Method(lambda call: scenarios.predict(call.id(), call.body(PredictionsRequest)), heavy),
        "session.create": Method(_create_session, writes),
        "session.get": Method(_get_session, reads),
        "session.list": Method(_list_sessions, reads),
        "session.delete": Method(_delete_session, writes),
        "look.announce": Method(_announce_look, writes),
        "look.cancel": Method(_cancel_look, writes),
        "belief.put": Method(_write("belief", BeliefRequest, updates.put_belief), writes),
        "scan.apply": Method(_write("scan", ScanRequest, updates.apply_scan), writes),
        "outcome.report": Method(_write("outcome", OutcomeRequest, updates.report_outcome), writes),
        "voa.rank": Method(_ranked(lambda call: rankings.of_session(call.session(), call.body(VoaRequest))), heavy),
        "grasp.rank": Method(_rank_grasps, reads),
        "history.get": Method(_history, reads),
        "update.compute": Method(_given(UpdateRequest, updates.update_once), reads),
        "ranking.compute": Method(_ranked(lambda call: rankings.once(call.body(RankingRequest))), heavy),
        "service.health": Method(_given(NoParameters, lambda _: services.health.ready()), services.probes),
        "robot.list": Method(_list_robots, reads),
        "robot.scan": Method(_robot_scan, reads),
        "robot.look": Method(_request_look, reads),
        "caller.get": Method(_caller, reads),
    }


def _given(kind: type[BaseModel], act: Callable[[Any], BaseModel]) -> Work:
    """Make the work of a method whose payload is one message."""
    return lambda call: act(call.body(kind))


def _listing(act: Callable[[int, str | None], BaseModel]) -> Work:
    """Make the work of a method that answers with a page of a list."""

    def work(call: Call) -> BaseModel:
        page: Page = call.body(Page)
        return act(page.limit, page.after)

    return work


def _one(get: Callable[[str], BaseModel]) -> Work:
    """Make the work of a method about one object or scenario."""

    def work(call: Call) -> BaseModel:
        id_ = call.id()
        call.body(NoParameters)
        return get(id_)

    return work


def _deleting(delete: Callable[[str], None]) -> Work:
    """Make the work of a method that deletes one object or scenario."""

    def work(call: Call) -> BaseModel:
        id_ = call.id()
        call.body(NoParameters)
        delete(id_)
        return NoParameters()

    return work


def _ranked(question_of: Callable[[Call], Question]) -> Work:
    """Make the work of a method that ranks looks.

    Zenoh does not report that a caller has stopped waiting, so only the end of the service stops a ranking.
    """

    def work(call: Call) -> bytes:
        question = question_of(call)
        return call.services.rankings.answer(question, call.services.heavy.check).to(question)

    return work


def _write(kind: WriteKind, body: type[Message], act: Callable[[str, Any, Any], StoredResponse]) -> Work:
    """Make the work of a method that changes a session."""

    def work(call: Call) -> StoredResponse:
        id_ = call.session()
        if kind == "scan":
            add_place(call.fields, call.attachment)
        received = call.received()
        request = call.body(body)
        key = idempotency_key(call.attachment.id, scope_of(id_), kind, request)
        call.check_acting(id_, key, request.robot if isinstance(request, LookAnnouncement) else None)
        return act(id_, request, write_of(kind, received, key))

    return work


def _announce_look(call: Call) -> BaseModel | StoredResponse | bytes:
    caller = call.caller
    by = None if caller.key is None else caller.name
    return _write("look", LookAnnouncement, partial(call.services.looks.announce, by=by))(call)


def _cancel_look(call: Call) -> BaseModel:
    id_ = call.session()
    look: Announced = call.body(Announced)
    key = idempotency_key(call.attachment.id, scope_of(id_), f"cancel look {look.look}", None)
    call.check_acting(id_, key)
    call.services.looks.cancel(id_, look.look, write_of("look", b"", key), call.caller.withdraws_as)
    return NoParameters()


def _create_object(call: Call) -> BaseModel:
    upload: ObjectUpload = call.body(ObjectUpload)
    return call.services.objects.create(upload.file, upload.filename, upload.name, upload.scale, upload.up)[0]


def _list_objects(call: Call) -> BaseModel:
    page: ObjectPage = call.body(ObjectPage)
    return call.services.objects.list(page.limit, page.after, page.sha256, page.type, page.scale, page.up)


def _object_mesh(call: Call) -> BaseModel:
    id_ = call.id()
    thinning: Thinning = call.body(Thinning)
    return call.services.objects.mesh(id_, thinning.most_faces)


def _create_session(call: Call) -> StoredResponse:
    received = call.received()
    request = call.body(SessionRequest)
    for robot in request.robots or ():
        call.caller.check_robot(robot)
    key = idempotency_key(call.attachment.id, scope_of_caller(call.caller.name), "create session", request)
    return call.services.sessions.create(request, write_of("prior", received, key))


def _list_sessions(call: Call) -> BaseModel:
    page: Page = call.body(Page)
    return call.services.sessions.list(page.limit, page.after, call.caller.sessions)


def _get_session(call: Call) -> StoredResponse:
    id_ = call.session()
    call.body(NoParameters)
    return call.services.sessions.response(id_)


def _delete_session(call: Call) -> BaseModel:
    id_ = call.session()
    call.body(NoParameters)
    key = idempotency_key(call.attachment.id, scope_of(id_), "delete", None)
    call.check_acting(id_, key)
    call.services.sessions.delete(id_, key, None)
    return NoParameters()


def _history(call: Call) -> BaseModel:
    id_ = call.session()
    page: HistoryPage = call.body(HistoryPage)
    return call.services.sessions.history(id_, page.limit, page.after, beliefs=page.beliefs)


def _request_look(call: Call) -> BaseModel:
    request: LookRequest = call.body(LookRequest)
    call.robot = request.robot
    call.caller.check_robot(request.robot)
    call.caller.check_session_of(lambda: call.services.robots.report(request.robot).session)
    return call.services.robots.request_look(request.robot)


def _robot_scan(call: Call) -> BaseModel:
    request: LookRequest = call.body(LookRequest)
    call.robot = request.robot
    call.caller.check_robot(request.robot)
    scan = call.services.robots.scan(request.robot)
    call.caller.check_session(scan.session)
    return scan


def _list_robots(call: Call) -> BaseModel:
    call.body(NoParameters)
    return call.services.robots.reports(call.caller.sees_robot)


def _caller(call: Call) -> BaseModel:
    call.body(NoParameters)
    return call.caller.message()


def _rank_grasps(call: Call) -> BaseModel:
    id_ = call.session()
    reachable: Reachable = call.body(Reachable)
    return call.services.rankings.grasps(id_, reachable.grasps)
