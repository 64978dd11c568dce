"""Routes /v1/sessions: open, list, read and delete sessions, and read their histories."""

import json
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from voa_msgs.sessions import (
    HistoryPage,
    Session,
    SessionPage,
    SessionRequest,
)
from voa_service.failures import (
    ClaimConflict,
    Damaged,
    IdempotencyKeyReused,
    NotFound,
    StaleVersion,
    UnknownReference,
)
from voa_service.http.authentication import caller_of, check_acting
from voa_service.http.calls import strict_route
from voa_service.http.headers import IfMatch, Key, location, versions
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import DEFAULT_PAGE, After, PageLimit, SessionId, answer, versioned
from voa_service.requests.idempotency import idempotency_key, scope_of, scope_of_caller, write_of
from voa_service.services import Services
from voa_store.records import StoredResponse


def routes(services: Services) -> APIRouter:
    """Make the routes that open, read and delete sessions."""
    router = APIRouter(prefix="/v1", tags=["sessions"], route_class=strict_route(services.reader))
    sessions = services.sessions

    @router.post(
        "/sessions",
        status_code=201,
        response_model=Session,
        responses=problems(ClaimConflict, IdempotencyKeyReused, UnknownReference),
        response_description="The session was opened.",
    )
    async def create_session(request: SessionRequest, http: Request, key: Key = None) -> Response:
        """Open a session on a scenario.

        The session starts at version 0 with the prior as its belief. The scans of the mapped robots that `robots` names
        are applied to it from now on.
        """
        body, caller = await http.body(), caller_of(http)

        def done() -> StoredResponse:
            for robot in request.robots or ():
                caller.check_robot(robot)
            named = idempotency_key(key, scope_of_caller(caller.name), "create session", request)
            return sessions.create(request, write_of("prior", body, named))

        response = await versioned(services.writes, done, 201)
        response.headers.update(location(json.loads(bytes(response.body))["id"]))
        return response

    @router.get("/sessions", response_model=SessionPage, response_description="A page of sessions, oldest first.")
    async def list_sessions(http: Request, limit: PageLimit = DEFAULT_PAGE, after: After = None) -> Response:
        """List the sessions without their beliefs, oldest first.

        A key that is bound to sessions is shown these.
        """
        return await answer(services.reads, lambda: sessions.list(limit, after, caller_of(http).sessions))

    @router.get(
        "/sessions/{id}",
        response_model=Session,
        responses=problems(NotFound, Damaged),
        response_description="The session, with its version as ETag.",
    )
    async def get_session(id: SessionId) -> Response:
        """Read the current belief and best grasp of a session."""
        return await versioned(services.reads, lambda: sessions.response(id))

    @router.delete(
        "/sessions/{id}",
        status_code=204,
        responses=problems(NotFound, StaleVersion, IdempotencyKeyReused, Damaged),
        response_description="The session was deleted.",
    )
    async def delete_session(
        id: SessionId,
        http: Request,
        key: Key = None,
        if_match: IfMatch = None,
    ) -> Response:
        """Delete a session and its history."""

        def done() -> None:
            named = idempotency_key(key, scope_of(id), "delete", None)
            check_acting(http, services, id, named)
            sessions.delete(id, named, versions(if_match))

        await services.writes.run(done)
        return Response(status_code=204)

    @router.get(
        "/sessions/{id}/history",
        response_model=HistoryPage,
        responses=problems(NotFound, Damaged),
        response_description="A page of versions in ascending order, the prior first.",
    )
    async def get_history(
        id: SessionId,
        limit: PageLimit = DEFAULT_PAGE,
        after: After = None,
        beliefs: Annotated[bool, Query(description="True: each version has its belief and best grasp, too.")] = False,
    ) -> Response:
        """List the versions of a session with the requests that caused them.

        The history is complete: applying its requests again gives the same beliefs.
        """
        return await answer(services.reads, lambda: sessions.history(id, limit, after, beliefs=beliefs))

    return router
