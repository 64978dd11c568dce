"""/livez, /readyz and /metrics."""

from fastapi import APIRouter, Response
from prometheus_client import CONTENT_TYPE_LATEST
from starlette.responses import PlainTextResponse

from voa_msgs.problems import Health
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import answer
from voa_service.services import Services


def routes(services: Services) -> APIRouter:
    """For whoever restarts processes and routes requests."""
    router = APIRouter(tags=["health"])

    @router.get("/livez", response_model=Health, response_model_exclude_unset=True)
    async def is_alive() -> Health:
        """The process answers."""
        return Health(status="alive")

    @router.get("/readyz", response_model=Health, responses=problems(503))
    async def is_ready() -> Response:
        """The store answers too; `zenoh` says whether this process is joined to a router."""
        return await answer(services.probes, services.health.ready)

    @router.get("/metrics", response_class=PlainTextResponse)
    async def get_metrics() -> Response:
        """Figures for Prometheus."""
        return Response(services.metrics.text(), media_type=CONTENT_TYPE_LATEST)

    return router
