"""/v1/sessions."""

from fastapi import APIRouter, Request, Response

from voa_msgs.sessions import (
    HistoryPage,
    Session,
    SessionPage,
    SessionRequest,
)
from voa_service.http.calls import strict_route
from voa_service.http.headers import IfMatch, Key, versions
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import DEFAULT_PAGE, After, PageLimit, answer, versioned
from voa_service.requests.idempotency import ANYONE, idempotency_key, scope_of, write_of
from voa_service.services import Services
from voa_store.records import StoredResponse


def routes(services: Services) -> APIRouter:
    """Open sessions, read them, remove them."""
    router = APIRouter(prefix="/v1", tags=["sessions"], route_class=strict_route(services.reader))
    sessions = services.sessions

    @router.post("/sessions", status_code=201, response_model=Session, responses=problems(400, 409, 413, 422, 503))
    async def create_session(request: SessionRequest, http: Request, key: Key = None) -> Response:
        """Open a session: version 0, the prior as belief; the scans of `robots` go to it from now on."""
        body = await http.body()

        def done() -> StoredResponse:
            named = idempotency_key(key, ANYONE, "create session", request)
            return sessions.create(request, write_of("prior", body, named))

        return await versioned(services.writes, done, 201)

    @router.get("/sessions", response_model=SessionPage, responses=problems(422, 503))
    async def list_sessions(limit: PageLimit = DEFAULT_PAGE, after: After = None) -> Response:
        """All sessions without their beliefs, oldest first."""
        return await answer(services.reads, lambda: sessions.list(limit, after))

    @router.get("/sessions/{id}", response_model=Session, responses=problems(404, 422, 503))
    async def get_session(id: str) -> Response:
        """One session as it stands."""
        return await versioned(services.reads, lambda: sessions.response(id))

    @router.delete("/sessions/{id}", status_code=204, responses=problems(404, 412, 422, 503))
    async def delete_session(
        id: str,
        key: Key = None,
        if_match: IfMatch = None,
    ) -> Response:
        """Remove a session and its history."""
        named = idempotency_key(key, scope_of(id), "delete", None)
        await services.writes.run(lambda: sessions.delete(id, named, versions(if_match)))
        return Response(status_code=204)

    @router.get("/sessions/{id}/history", response_model=HistoryPage, responses=problems(404, 422, 503))
    async def get_history(
        id: str,
        limit: PageLimit = DEFAULT_PAGE,
        after: After = None,
    ) -> Response:
        """Every version and what made it, the prior first: enough to replay the session."""
        return await answer(services.reads, lambda: sessions.history(id, limit, after))

    return router
