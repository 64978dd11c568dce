"""Routes /livez, /readyz and /metrics."""

from fastapi import APIRouter, Response
from prometheus_client import CONTENT_TYPE_LATEST
from starlette.responses import PlainTextResponse

from voa_msgs.problems import Health
from voa_service.failures import NotReady, Overloaded
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import answer
from voa_service.services import Services


def routes(services: Services) -> APIRouter:
    """Make the routes for process supervisors, load balancers and Prometheus."""
    router = APIRouter(tags=["health"])

    @router.get(
        "/livez", response_model=Health, response_description="The process is alive.", response_model_exclude_unset=True
    )
    async def is_alive() -> Health:
        """Probe whether the process is alive."""
        return Health(status="alive")

    @router.get(
        "/readyz",
        response_model=Health,
        responses=problems(NotReady, Overloaded),
        response_description="The process is ready, with its version, clock and connections.",
    )
    async def is_ready() -> Response:
        """Probe whether the process can read and write its store.

        The process is ready without a connection to a Zenoh router; `zenoh` in the response reports its state.
        """
        return await answer(services.probes, services.health.ready)

    @router.get("/metrics", response_class=PlainTextResponse, response_description="Metrics as text.")
    async def get_metrics() -> Response:
        """Read the metrics of the process in the text format of Prometheus."""
        return Response(services.metrics.text(), media_type=CONTENT_TYPE_LATEST)

    return router
