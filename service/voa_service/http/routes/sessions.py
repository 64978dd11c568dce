"""/v1/sessions and /v1/updates."""

from collections.abc import Callable

from fastapi import APIRouter, Request, Response

from voa_msgs.sessions import (
    ScanRequest,
    Session,
    SessionPage,
    SessionRequest,
    UpdatedEstimate,
    UpdatedSession,
    UpdateRequest,
)
from voa_service.http.headers import IfMatch, Key, etag, idempotency_key, versions, write_of
from voa_service.http.limits import check
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import DEFAULT_PAGE, After, PageLimit, answer
from voa_service.ports import Answered
from voa_service.services import Services

_ANYONE = "caller:anonymous"


def routes(services: Services) -> APIRouter:
    """Open sessions, send scans, read beliefs."""
    router = APIRouter(prefix="/v1", tags=["sessions"])
    sessions = services.sessions

    async def versioned(work: Callable[[], Answered], status: int = 200) -> Response:
        done = await services.quick.run(work)
        return Response(done.body, status, etag(done.version), "application/json")

    @router.post("/sessions", status_code=201, response_model=Session, responses=problems(400, 413, 422, 503))
    async def create_session(request: SessionRequest, http: Request, key: Key = None) -> Response:
        """Open a session: version 0, the prior as belief."""
        check(request, services.limits)
        write = write_of("prior", await http.body(), idempotency_key(key, _ANYONE, "create session", request))
        return await versioned(lambda: sessions.create(request, write), 201)

    @router.get("/sessions", response_model=SessionPage, responses=problems(422, 503))
    async def list_sessions(limit: PageLimit = DEFAULT_PAGE, after: After = None) -> Response:
        """All sessions without their beliefs, oldest first."""
        return await answer(services.quick, lambda: sessions.list(limit, after))

    @router.get("/sessions/{id}", response_model=Session, responses=problems(404, 422, 503))
    async def get_session(id: str) -> Response:  # noqa: A002 - the contract's name
        """One session as it stands."""

        def work() -> Answered:
            session = sessions.get(id)
            return Answered(session.model_dump_json(), session.version or 0)

        return await versioned(work)

    @router.delete("/sessions/{id}", status_code=204, responses=problems(404, 412, 422, 503))
    async def delete_session(
        id: str,  # noqa: A002 - the contract's name
        key: Key = None,
        if_match: IfMatch = None,
    ) -> Response:
        """Remove a session and its history."""
        named = idempotency_key(key, f"session:{id}", "delete", None)
        await services.quick.run(lambda: sessions.delete(id, named, versions(if_match)))
        return Response(status_code=204)

    @router.post(
        "/sessions/{id}/scans",
        response_model=UpdatedSession,
        responses=problems(400, 404, 412, 413, 422, 503),
    )
    async def apply_scan(
        id: str,  # noqa: A002 - the contract's name
        request: ScanRequest,
        http: Request,
        key: Key = None,
        if_match: IfMatch = None,
    ) -> Response:
        """Update the belief by a raw scan; one that is not accepted changes nothing and says why."""
        check(request, services.limits)
        named = idempotency_key(key, f"session:{id}", "scan", request)
        write = write_of("scan", await http.body(), named, if_match)
        return await versioned(lambda: sessions.apply_scan(id, request, write))

    @router.post("/updates", response_model=UpdatedEstimate, responses=problems(400, 413, 422, 503), tags=["stateless"])
    async def update_once(request: UpdateRequest) -> Response:
        """Update the belief in the request; nothing is stored."""
        check(request, services.limits)
        return await answer(services.quick, lambda: sessions.update_once(request))

    return router
