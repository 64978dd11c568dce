"""Routes /v1/sessions/{id}/looks: announce looks that are under way, and withdraw them."""

from typing import Annotated

from fastapi import APIRouter, Path, Request, Response

from voa_msgs.looks import AnnouncedLook, LookAnnouncement
from voa_service.failures import Damaged, IdempotencyKeyReused, MeshRequired, NotFound, UnknownReference
from voa_service.http.authentication import caller_of, check_acting
from voa_service.http.calls import strict_route
from voa_service.http.headers import Key
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import SessionId, versioned
from voa_service.requests.idempotency import idempotency_key, scope_of, write_of
from voa_service.services import Services
from voa_store.records import StoredResponse


def routes(services: Services) -> APIRouter:
    """Make the routes that announce looks of a session."""
    router = APIRouter(prefix="/v1", tags=["sessions"], route_class=strict_route(services.reader))

    @router.post(
        "/sessions/{id}/looks",
        status_code=201,
        response_model=AnnouncedLook,
        responses=problems(NotFound, IdempotencyKeyReused, Damaged, UnknownReference, MeshRequired),
        response_description="The look was announced.",
    )
    async def announce_look(id: SessionId, request: LookAnnouncement, http: Request, key: Key = None) -> Response:
        """Announce a look that is under way, so that other robots plan around it.

        A scan from its place ends the announcement, and so do its deletion and 120 seconds. The session lists announced
        looks as `under_way`, and its rankings count them as `pending`. An announcement makes no version. A session
        keeps the newest 64.
        """
        body, caller = await http.body(), caller_of(http)

        def done() -> StoredResponse:
            named = idempotency_key(key, scope_of(id), "look", request)
            check_acting(http, services, id, named, request.robot)
            by = None if caller.key is None else caller.name
            return services.looks.announce(id, request, write_of("look", body, named), by)

        return await versioned(services.writes, done, 201)

    @router.delete(
        "/sessions/{id}/looks/{look}",
        status_code=204,
        responses=problems(NotFound, IdempotencyKeyReused, Damaged),
        response_description="The look is no longer under way.",
    )
    async def cancel_look(
        id: SessionId,
        look: Annotated[str, Path(description="Identifier of the announced look.")],
        http: Request,
        key: Key = None,
    ) -> Response:
        """Withdraw an announced look.

        In a service with keys, the key that announced it may do so, and every operator.
        """

        def done() -> StoredResponse:
            named = idempotency_key(key, scope_of(id), f"cancel look {look}", None)
            check_acting(http, services, id, named)
            return services.looks.cancel(id, look, write_of("look", b"", named), caller_of(http).withdraws_as)

        await services.writes.run(done)
        return Response(status_code=204)

    return router
