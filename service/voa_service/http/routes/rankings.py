"""/v1/sessions/{id}/voa, /v1/sessions/{id}/grasps and /v1/rankings."""

from collections.abc import Callable
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from voa_msgs.rankings import Definition, RankedGrasps, Ranking, RankingRequest, VoaRequest
from voa_service.http.calls import strict_route
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import answer, unless_gone
from voa_service.services import Services
from voa_service.usecases.rankings import Question


def routes(services: Services) -> APIRouter:
    """Where to look, what to grasp."""
    router = APIRouter(prefix="/v1", tags=["rankings"], route_class=strict_route(services.reader))
    rankings = services.rankings

    async def ranked(ask: Callable[[], Question]) -> Response:
        question = await services.reads.run(lambda: _with_key(ask()))
        answer = await services.heavy.share(question.key, lambda check: rankings.answer(question, check))
        return Response(answer.to(question), media_type="application/json")

    @router.get("/sessions/{id}/voa", response_model=Ranking, responses=problems(404, 413, 422, 503))
    async def rank_looks(
        id: str,
        http: Request,
        definition: Annotated[Definition, Query(description="Of VOA.")] = "posterior",
        outcomes: Annotated[bool, Query(description="Whether to list what each look could find.")] = False,
    ) -> Response:
        """The scenario's sensor configurations by what looking from them is worth."""
        request = VoaRequest(definition=definition, outcomes=outcomes)
        return await unless_gone(http, ranked(lambda: rankings.of_session(id, request)))

    @router.post("/sessions/{id}/voa", response_model=Ranking, responses=problems(400, 404, 413, 422, 503))
    async def rank_given_looks(id: str, http: Request, request: VoaRequest | None = None) -> Response:
        """The same for any sensor poses, over the grasps that are reachable now."""
        asked = request or VoaRequest()
        return await unless_gone(http, ranked(lambda: rankings.of_session(id, asked)))

    @router.get("/sessions/{id}/grasps", response_model=RankedGrasps, responses=problems(404, 422, 503))
    async def rank_grasps(
        id: str,
        grasps: Annotated[
            list[str] | None,
            Query(description="The grasps that are reachable now, repeated or with commas between; without it, all."),
        ] = None,
    ) -> Response:
        """Grasps by their expected score."""
        return await answer(services.reads, lambda: rankings.grasps(id, grasps))

    @router.post("/rankings", response_model=Ranking, responses=problems(400, 413, 422, 503), tags=["stateless"])
    async def rank_once(request: RankingRequest, http: Request) -> Response:
        """Rank looks for the belief in the request (null: the scenario's prior); nothing is stored."""
        return await unless_gone(http, ranked(lambda: rankings.once(request)))

    return router


def _with_key(question: Question) -> Question:
    """The question, its key worked out in this thread."""
    assert question.key  # noqa: S101 - it is kept from here on
    return question
