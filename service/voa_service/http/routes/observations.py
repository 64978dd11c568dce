"""What moves a session: scans, grasp outcomes, replaced beliefs; and /v1/updates, which stores nothing."""

from fastapi import APIRouter, Request, Response

from voa_msgs.sessions import (
    BeliefRequest,
    OutcomeRequest,
    ScanRequest,
    Session,
    UpdatedEstimate,
    UpdatedSession,
    UpdateRequest,
)
from voa_service.http.calls import strict_route
from voa_service.http.headers import IfMatch, Key, versions
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import answer, versioned
from voa_service.requests.idempotency import idempotency_key, scope_of, write_of
from voa_service.services import Services
from voa_store.records import StoredResponse

_WRITE_PROBLEMS = problems(400, 404, 412, 413, 422, 503)


def routes(services: Services) -> APIRouter:
    """Scans in, beliefs out."""
    router = APIRouter(prefix="/v1", tags=["sessions"], route_class=strict_route(services.reader))
    updates = services.updates

    @router.post(
        "/sessions/{id}/scans",
        response_model=UpdatedSession,
        responses=_WRITE_PROBLEMS,
    )
    async def apply_scan(
        id: str,
        request: ScanRequest,
        http: Request,
        key: Key = None,
        if_match: IfMatch = None,
    ) -> Response:
        """Update the belief by a raw scan; one that is not accepted changes nothing and says why."""
        body = await http.body()

        def done() -> StoredResponse:
            named = idempotency_key(key, scope_of(id), "scan", request)
            return updates.apply_scan(id, request, write_of("scan", body, named, versions(if_match)))

        return await versioned(services.writes, done)

    @router.put("/sessions/{id}/belief", response_model=Session, responses=_WRITE_PROBLEMS)
    async def put_belief(
        id: str,
        request: BeliefRequest,
        http: Request,
        key: Key = None,
        if_match: IfMatch = None,
    ) -> Response:
        """Replace the belief; null: back to the session's prior."""
        body = await http.body()

        def done() -> StoredResponse:
            named = idempotency_key(key, scope_of(id), "belief", request)
            return updates.put_belief(id, request, write_of("belief", body, named, versions(if_match)))

        return await versioned(services.writes, done)

    @router.post(
        "/sessions/{id}/grasp-outcomes",
        response_model=UpdatedSession,
        responses=_WRITE_PROBLEMS,
    )
    async def report_outcome(
        id: str,
        request: OutcomeRequest,
        http: Request,
        key: Key = None,
        if_match: IfMatch = None,
    ) -> Response:
        """Update the belief by what came of a grasp attempt that left the object where it was."""
        body = await http.body()

        def done() -> StoredResponse:
            named = idempotency_key(key, scope_of(id), "outcome", request)
            return updates.report_outcome(id, request, write_of("outcome", body, named, versions(if_match)))

        return await versioned(services.writes, done)

    @router.post("/updates", response_model=UpdatedEstimate, responses=problems(400, 413, 422, 503), tags=["stateless"])
    async def update_once(request: UpdateRequest) -> Response:
        """Update the belief in the request (null: the scenario's prior); nothing is stored."""
        return await answer(services.reads, lambda: updates.update_once(request))

    return router
