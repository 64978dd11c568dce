"""Routes /v1/sessions/{id}/voa and /v1/sessions/{id}/grasps: rankings of looks and of grasps."""

from collections.abc import Callable
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from voa_msgs.rankings import Definition, RankedGrasps, Ranking, VoaRequest
from voa_service.failures import Damaged, MeshRequired, NotFound, RuleFailed, TooLarge, UnknownReference
from voa_service.http.calls import strict_route
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import SessionId, answer, unless_gone
from voa_service.services import Services
from voa_service.usecases.rankings import Question


def routes(services: Services) -> APIRouter:
    """Make the routes that rank the looks and the grasps of a session."""
    router = APIRouter(prefix="/v1", tags=["rankings"], route_class=strict_route(services.reader))
    rankings = services.rankings

    @router.get(
        "/sessions/{id}/voa",
        response_model=Ranking,
        responses=problems(NotFound, TooLarge, MeshRequired, Damaged, RuleFailed),
        response_description="The looks, the largest net value first.",
    )
    async def rank_looks(
        id: SessionId,
        http: Request,
        definition: Annotated[
            Definition | None,
            Query(
                description="Definition of VOA: gain of the best expected score, or of the executed grasp's; without "
                "it, `posterior` over exact scans and `executed` over simulated ones."
            ),
        ] = None,
        outcomes: Annotated[
            bool, Query(description="True to list, for each look, the expected result at each pose.")
        ] = False,
    ) -> Response:
        """Rank the sensor configurations of the scenario by Value of Assistance."""
        request = VoaRequest(definition=definition, outcomes=outcomes)
        return await unless_gone(http, ranked(services, lambda: rankings.of_session(id, request)))

    @router.post(
        "/sessions/{id}/voa",
        response_model=Ranking,
        responses=problems(NotFound, UnknownReference, MeshRequired, Damaged, RuleFailed),
        response_description="The looks, the largest net value first.",
    )
    async def rank_given_looks(id: SessionId, http: Request, request: VoaRequest | None = None) -> Response:
        """Rank the given sensor poses by Value of Assistance.

        The request may list any sensor poses, and the grasps that the arm can reach now. Without a body, all sensor
        configurations and grasps of the scenario are ranked.
        """
        return await unless_gone(http, ranked(services, lambda: rankings.of_session(id, request or VoaRequest())))

    @router.get(
        "/sessions/{id}/grasps",
        response_model=RankedGrasps,
        responses=problems(NotFound, UnknownReference, Damaged),
        response_description="The grasps, the largest expected score first.",
    )
    async def rank_grasps(
        id: SessionId,
        grasps: Annotated[
            list[str] | None,
            Query(description="Grasps that the arm can reach now, repeated or separated by commas; without it, all."),
        ] = None,
    ) -> Response:
        """Rank the grasps by expected score under the belief of a session."""
        return await answer(services.reads, lambda: rankings.grasps(id, grasps))

    return router


async def ranked(services: Services, read: Callable[[], Question]) -> Response:
    """Respond with a ranking; equal requests at the same time share one computation.

    Args:
        services: use cases and work queues.
        read: reads from the store what is to be ranked; runs in the queue of reads.
    """
    question = await services.reads.run(lambda: _with_key(read()))
    ranking = await services.heavy.share(question.key, lambda check: services.rankings.answer(question, check))
    return Response(ranking.to(question), media_type="application/json")


def _with_key(question: Question) -> Question:
    """Return the question after computing its key in this thread."""
    assert question.key  # noqa: S101 - it is cached from now on
    return question
