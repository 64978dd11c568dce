"""Routes /v1/scenarios and /v1/lidars."""

from fastapi import APIRouter, Response

from voa_msgs.lidars import LidarPresets
from voa_msgs.scenarios import Predictions, PredictionsRequest, Scenario, ScenarioPage, ScenarioRequest
from voa_msgs.warnings import Warnings
from voa_service.failures import InUse, MeshRequired, NotFound, TooLarge, UnknownReference
from voa_service.http.calls import strict_route
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import DEFAULT_PAGE, After, PageLimit, ScenarioId, answer, created
from voa_service.services import Services


def routes(services: Services) -> APIRouter:
    """Make the routes that store, read and check scenarios, and predict scans."""
    router = APIRouter(prefix="/v1", tags=["scenarios"], route_class=strict_route(services.reader))
    scenarios = services.scenarios

    @router.get("/lidars", response_model=LidarPresets, response_description="The presets.")
    async def list_lidars() -> Response:
        """List the presets of lidars that a scenario can name."""
        return await answer(services.reads, scenarios.lidars)

    @router.post(
        "/scenarios",
        status_code=201,
        response_model=Scenario,
        responses={
            200: {"model": Scenario, "description": "The same scenario was stored before."},
            **problems(UnknownReference, MeshRequired),
        },
        response_description="The scenario was stored.",
    )
    async def create_scenario(request: ScenarioRequest) -> Response:
        """Store a scenario under a digest of its content.

        The identifier is the digest of the content with all defaults filled in: the same scenario again gives the same
        identifier and status 200. `warnings` in the response lists probable mistakes, such as a yaw in degrees.
        """
        return await created(services.heavy, lambda: scenarios.create(request))

    @router.get("/scenarios", response_model=ScenarioPage, response_description="A page of scenarios, oldest first.")
    async def list_scenarios(limit: PageLimit = DEFAULT_PAGE, after: After = None) -> Response:
        """List the stored scenarios, oldest first."""
        return await answer(services.reads, lambda: scenarios.list(limit, after))

    @router.get(
        "/scenarios/{id}",
        response_model=Scenario,
        responses=problems(NotFound),
        response_description="The scenario with every default filled in.",
    )
    async def get_scenario(id: ScenarioId) -> Response:
        """Read a stored scenario with every default filled in."""
        return await answer(services.reads, lambda: scenarios.get(id))

    @router.delete(
        "/scenarios/{id}",
        status_code=204,
        responses=problems(NotFound, InUse),
        response_description="The scenario was deleted.",
    )
    async def delete_scenario(id: ScenarioId) -> Response:
        """Delete a scenario that no session is on."""
        await services.writes.run(lambda: scenarios.delete(id))
        return Response(status_code=204)

    @router.get(
        "/scenarios/{id}/warnings",
        response_model=Warnings,
        responses=problems(NotFound),
        response_description="The probable mistakes; an empty list where there are none.",
    )
    async def get_warnings(id: ScenarioId) -> Response:
        """Check a scenario for probable mistakes.

        Every pair of pose and sensor configuration is checked. The `warnings` of a scenario itself come from at most
        2000 such pairs.
        """
        return await answer(services.heavy, lambda: scenarios.warnings(id))

    @router.post(
        "/scenarios/{id}/predictions",
        response_model=Predictions,
        responses=problems(NotFound, TooLarge, UnknownReference, MeshRequired),
        response_description="The predicted ranges: sensors x poses x beams, metres.",
    )
    async def predict(id: ScenarioId, request: PredictionsRequest | None = None) -> Response:
        """Predict the scans that the object would give at each pose.

        Without a body, the scans are predicted for all sensor configurations of the scenario.
        """
        return await answer(services.heavy, lambda: scenarios.predict(id, request))

    return router
