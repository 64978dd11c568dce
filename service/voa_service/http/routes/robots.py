"""/v1/robots: what was heard of robots on Zenoh."""

from fastapi import APIRouter, Response

from voa_msgs.robots import RobotReport, Robots
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import answer
from voa_service.services import Services


def routes(services: Services) -> APIRouter:
    """See which robots are heard, ask one for a look."""
    router = APIRouter(prefix="/v1/robots", tags=["robots"])

    @router.get("", response_model=Robots, responses=problems(503))
    async def list_robots() -> Response:
        """Robots whose scans this process heard since it started, or whose topics are mapped."""
        return await answer(services.quick, services.robots.reports)

    @router.post("/{robot}/look", response_model=RobotReport, responses=problems(404, 422, 503))
    async def request_look(robot: str) -> Response:
        """The next scans of a mapped robot whose looks are on request are to be one."""
        return await answer(services.quick, lambda: services.robots.request_look(robot))

    return router
