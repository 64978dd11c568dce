"""Routes /v1/robots: reports about robots on Zenoh, requests for looks, and claims."""

from fastapi import APIRouter, Request, Response

from voa_msgs.robots import ClaimRequest, RobotReport, Robots, RobotScan
from voa_service.failures import ClaimConflict, NotFound, UnknownReference
from voa_service.http.authentication import caller_of
from voa_service.http.calls import strict_route
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import RobotName, answer
from voa_service.services import Services


def routes(services: Services) -> APIRouter:
    """Make the routes that list robots, request looks of them, and claim them for sessions."""
    router = APIRouter(prefix="/v1/robots", tags=["robots"], route_class=strict_route(services.reader))

    @router.get("", response_model=Robots, response_description="The robots, by name.")
    async def list_robots(http: Request) -> Response:
        """List the robots whose scans were received, or whose topics are mapped.

        The counts are of the scans that this process of the service has received since it started. A key that is bound
        to robots is shown these, and one that is bound to sessions the robots of these, and robots without a session.
        """
        return await answer(services.reads, lambda: services.robots.reports(caller_of(http).sees_robot))

    @router.post(
        "/{robot}/look",
        response_model=RobotReport,
        responses=problems(NotFound),
        response_description="The report about the robot.",
    )
    async def request_look(robot: RobotName, http: Request) -> Response:
        """Request a look from a mapped robot: its next scans become one.

        The mapping of the robot must have the look mode `on_request`.
        """

        def requested() -> RobotReport:
            caller_of(http).check_session_of(lambda: services.robots.report(robot).session)
            return services.robots.request_look(robot)

        return await answer(services.reads, requested)

    @router.get(
        "/{robot}/scan",
        response_model=RobotScan,
        responses=problems(NotFound),
        response_description="The scan, and where it was taken.",
    )
    async def robot_scan(robot: RobotName, http: Request) -> Response:
        """Get the newest scan of a robot, whether it was accepted or not.

        It is the newest one that this process of the service could decode since it started.
        """

        def newest() -> RobotScan:
            scan = services.robots.scan(robot)
            caller_of(http).check_session(scan.session)
            return scan

        return await answer(services.reads, newest)

    @router.put(
        "/{robot}/session",
        response_model=RobotReport,
        responses=problems(NotFound, ClaimConflict, UnknownReference),
        response_description="The report about the robot.",
    )
    async def claim_robot(robot: RobotName, request: ClaimRequest, http: Request) -> Response:
        """Claim a mapped robot for a session: its scans are applied to that session from now on.

        With null, its scans are applied to no session until the next claim. The first look of a robot that was never
        claimed claims it for the newest session on its scenario. A claim ends when the session is deleted, or when
        another session claims the robot.
        """

        if request.session is not None:
            caller_of(http).check_session(request.session)

        def claimed() -> RobotReport:
            caller_of(http).check_session_of(lambda: services.robots.report(robot).session)
            services.claims.claim(robot, request.session)
            return services.robots.report(robot)

        return await answer(services.writes, claimed)

    return router
