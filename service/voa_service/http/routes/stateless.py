"""Routes /v1/updates and /v1/rankings: computations with the belief in the request, which store nothing."""

from fastapi import APIRouter, Request, Response

from voa_msgs.rankings import Ranking, RankingRequest
from voa_msgs.sessions import UpdatedEstimate, UpdateRequest
from voa_service.failures import BeamGridMismatch, MeshRequired, RuleFailed, UnknownReference
from voa_service.http.calls import strict_route
from voa_service.http.openapi import problems
from voa_service.http.routes.rankings import ranked
from voa_service.http.routes.responses import answer, unless_gone
from voa_service.services import Services


def routes(services: Services) -> APIRouter:
    """Make the routes that compute without a session."""
    router = APIRouter(prefix="/v1", tags=["stateless"], route_class=strict_route(services.reader))

    @router.post(
        "/updates",
        response_model=UpdatedEstimate,
        responses=problems(UnknownReference, MeshRequired, BeamGridMismatch, RuleFailed),
        response_description="The estimate after the scan; `version` is null.",
    )
    async def update_once(request: UpdateRequest) -> Response:
        """Update the belief in the request by a scan, without storing anything."""
        return await answer(services.reads, lambda: services.updates.update_once(request))

    @router.post(
        "/rankings",
        response_model=Ranking,
        responses=problems(UnknownReference, MeshRequired, RuleFailed),
        response_description="The looks, the largest net value first; `version` is null.",
    )
    async def rank_once(request: RankingRequest, http: Request) -> Response:
        """Rank looks by Value of Assistance for the belief in the request, without storing anything."""
        return await unless_gone(http, ranked(services, lambda: services.rankings.once(request)))

    return router
