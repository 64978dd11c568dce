"""/v1/robots: what was heard of robots on Zenoh."""

from fastapi import APIRouter, Response

from voa_msgs.robots import ClaimRequest, RobotReport, Robots
from voa_service.http.calls import strict_route
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import answer
from voa_service.services import Services


def routes(services: Services) -> APIRouter:
    """See which robots are heard, ask one for a look, say whose session one is."""
    router = APIRouter(prefix="/v1/robots", tags=["robots"], route_class=strict_route(services.reader))

    @router.get("", response_model=Robots, responses=problems(503))
    async def list_robots() -> Response:
        """Robots whose scans this process heard since it started, or whose topics are mapped."""
        return await answer(services.reads, services.robots.reports)

    @router.post("/{robot}/look", response_model=RobotReport, responses=problems(404, 422, 503))
    async def request_look(robot: str) -> Response:
        """The next scans of a mapped robot whose looks are on request are to be one."""
        return await answer(services.reads, lambda: services.robots.request_look(robot))

    @router.put("/{robot}/session", response_model=RobotReport, responses=problems(400, 404, 409, 413, 422, 503))
    async def claim_robot(robot: str, request: ClaimRequest) -> Response:
        """Say whose session a mapped robot's scans are for from now on; null: nobody's until the next claim.

        A robot that nobody has claimed belongs to the newest session on its scenario when its first look is due, and
        stays there until that session is deleted or another one claims it.
        """

        def claimed() -> RobotReport:
            services.claims.claim(robot, request.session)
            return services.robots.report(robot)

        return await answer(services.writes, claimed)

    return router
