"""Routes that change the belief of a session: by a scan, by the outcome of a grasp, or by another belief."""

from fastapi import APIRouter, Request, Response

from voa_msgs.sessions import (
    BeliefRequest,
    OutcomeRequest,
    ScanRequest,
    Session,
    UpdatedSession,
)
from voa_service.failures import (
    BeamGridMismatch,
    Damaged,
    IdempotencyKeyReused,
    MeshRequired,
    NotFound,
    RuleFailed,
    StaleVersion,
    UnknownReference,
)
from voa_service.http.authentication import check_acting
from voa_service.http.calls import strict_route
from voa_service.http.headers import IfMatch, Key, versions
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import SessionId, versioned
from voa_service.requests.idempotency import idempotency_key, scope_of, write_of
from voa_service.services import Services
from voa_store.records import StoredResponse

_WRITE_PROBLEMS = (NotFound, StaleVersion, IdempotencyKeyReused, Damaged)


def routes(services: Services) -> APIRouter:
    """Make the routes that change the belief of a session."""
    router = APIRouter(prefix="/v1", tags=["sessions"], route_class=strict_route(services.reader))
    updates = services.updates

    @router.post(
        "/sessions/{id}/scans",
        response_model=UpdatedSession,
        responses=problems(*_WRITE_PROBLEMS, UnknownReference, MeshRequired, BeamGridMismatch, RuleFailed),
        response_description="The session after the scan, with its version as ETag.",
    )
    async def apply_scan(
        id: SessionId,
        request: ScanRequest,
        http: Request,
        key: Key = None,
        if_match: IfMatch = None,
    ) -> Response:
        """Update the belief of a session by a scan.

        A scan that is not accepted gives status 200 too: `update.accepted` is false, `update.reason` says why, and the
        version stays.
        """
        body = await http.body()

        def done() -> StoredResponse:
            named = idempotency_key(key, scope_of(id), "scan", request)
            check_acting(http, services, id, named)
            return updates.apply_scan(id, request, write_of("scan", body, named, versions(if_match)))

        return await versioned(services.writes, done)

    @router.put(
        "/sessions/{id}/belief",
        response_model=Session,
        responses=problems(*_WRITE_PROBLEMS),
        response_description="The session with the new belief, with its version as ETag.",
    )
    async def put_belief(
        id: SessionId,
        request: BeliefRequest,
        http: Request,
        key: Key = None,
        if_match: IfMatch = None,
    ) -> Response:
        """Replace the belief of a session, or reset it to the prior."""
        body = await http.body()

        def done() -> StoredResponse:
            named = idempotency_key(key, scope_of(id), "belief", request)
            check_acting(http, services, id, named)
            return updates.put_belief(id, request, write_of("belief", body, named, versions(if_match)))

        return await versioned(services.writes, done)

    @router.post(
        "/sessions/{id}/grasp-outcomes",
        response_model=UpdatedSession,
        responses=problems(*_WRITE_PROBLEMS, UnknownReference),
        response_description="The session after the outcome, with its version as ETag.",
    )
    async def report_outcome(
        id: SessionId,
        request: OutcomeRequest,
        http: Request,
        key: Key = None,
        if_match: IfMatch = None,
    ) -> Response:
        """Update the belief of a session by the outcome of a grasp attempt.

        `object_moved` says how probable it is that the attempt moved the object; otherwise it lies where it was.
        """
        body = await http.body()

        def done() -> StoredResponse:
            named = idempotency_key(key, scope_of(id), "outcome", request)
            check_acting(http, services, id, named)
            return updates.report_outcome(id, request, write_of("outcome", body, named, versions(if_match)))

        return await versioned(services.writes, done)

    return router
