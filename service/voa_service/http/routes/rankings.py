"""/v1/sessions/{id}/voa, /v1/sessions/{id}/grasps and /v1/rankings."""

from typing import Annotated

from fastapi import APIRouter, Query, Response

from voa_msgs.rankings import Definition, RankedGrasps, Ranking, RankingRequest, VoaRequest
from voa_service.http.calls import strict_route
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import answer
from voa_service.services import Services


def routes(services: Services) -> APIRouter:
    """Where to look, what to grasp."""
    router = APIRouter(prefix="/v1", tags=["rankings"], route_class=strict_route(services.reader))
    rankings = services.rankings

    @router.get("/sessions/{id}/voa", response_model=Ranking, responses=problems(404, 422, 503))
    async def rank_looks(
        id: str,
        definition: Annotated[Definition, Query(description="Of VOA.")] = "posterior",
        outcomes: Annotated[bool, Query(description="Whether to list what each look could find.")] = False,
    ) -> Response:
        """The scenario's sensor configurations by what looking from them is worth."""
        request = VoaRequest(definition=definition, outcomes=outcomes)
        return await answer(services.heavy, lambda: rankings.of_session(id, request), exclude_unset=True)

    @router.post("/sessions/{id}/voa", response_model=Ranking, responses=problems(400, 404, 413, 422, 503))
    async def rank_given_looks(id: str, request: VoaRequest | None = None) -> Response:
        """The same for any sensor poses, over the grasps that are reachable now."""
        asked = request or VoaRequest()
        return await answer(services.heavy, lambda: rankings.of_session(id, asked), exclude_unset=True)

    @router.get("/sessions/{id}/grasps", response_model=RankedGrasps, responses=problems(404, 422, 503))
    async def rank_grasps(
        id: str,
        grasps: Annotated[
            list[str] | None,
            Query(description="The grasps that are reachable now, repeated or with commas between; without it, all."),
        ] = None,
    ) -> Response:
        """Grasps by their expected score."""
        return await answer(services.quick, lambda: rankings.grasps(id, grasps))

    @router.post("/rankings", response_model=Ranking, responses=problems(400, 413, 422, 503), tags=["stateless"])
    async def rank_once(request: RankingRequest) -> Response:
        """Rank looks for the belief in the request (null: the scenario's prior); nothing is stored."""
        return await answer(services.heavy, lambda: rankings.once(request), exclude_unset=True)

    return router
