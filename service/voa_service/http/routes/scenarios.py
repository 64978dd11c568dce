"""/v1/scenarios and /v1/lidars."""

from fastapi import APIRouter, Response

from voa_msgs.lidars import LidarPresets
from voa_msgs.scenarios import Predictions, PredictionsRequest, Scenario, ScenarioPage, ScenarioRequest
from voa_msgs.warnings import Warnings
from voa_service.http.calls import strict_route
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import DEFAULT_PAGE, After, PageLimit, answer, created
from voa_service.services import Services


def routes(services: Services) -> APIRouter:
    """Store scenarios, look at them, predict scans."""
    router = APIRouter(prefix="/v1", tags=["scenarios"], route_class=strict_route(services.reader))
    scenarios = services.scenarios

    @router.get("/lidars", response_model=LidarPresets, responses=problems(503))
    async def list_lidars() -> Response:
        """The lidars that a scenario can name."""
        return await answer(services.reads, scenarios.lidars)

    @router.post(
        "/scenarios",
        status_code=201,
        response_model=Scenario,
        responses={
            200: {"model": Scenario, "description": "The same scenario is there"},
            **problems(400, 413, 422, 503),
        },
    )
    async def create_scenario(request: ScenarioRequest) -> Response:
        """Store a scenario; its id is the digest of its content, defaults filled in."""
        return await created(services.heavy, lambda: scenarios.create(request))

    @router.get("/scenarios", response_model=ScenarioPage, responses=problems(422, 503))
    async def list_scenarios(limit: PageLimit = DEFAULT_PAGE, after: After = None) -> Response:
        """All scenarios, oldest first."""
        return await answer(services.reads, lambda: scenarios.list(limit, after))

    @router.get("/scenarios/{id}", response_model=Scenario, responses=problems(404, 422, 503))
    async def get_scenario(id: str) -> Response:
        """One scenario with every default filled in."""
        return await answer(services.reads, lambda: scenarios.get(id))

    @router.get("/scenarios/{id}/warnings", response_model=Warnings, responses=problems(404, 422, 503))
    async def get_warnings(id: str) -> Response:
        """Find what is probably wrong with a scenario, over all pairs of pose and sensor configuration.

        The warnings in the scenario's own answer come from at most 2000 such pairs.
        """
        return await answer(services.heavy, lambda: scenarios.warnings(id))

    @router.post("/scenarios/{id}/predictions", response_model=Predictions, responses=problems(400, 404, 413, 422, 503))
    async def predict(id: str, request: PredictionsRequest | None = None) -> Response:
        """The scans that every pose would give; null where nothing is in range."""
        return await answer(services.heavy, lambda: scenarios.predict(id, request))

    return router
