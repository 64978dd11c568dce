"""Route /v1/caller: who the caller is, and what it may do."""

from fastapi import APIRouter, Request

from voa_msgs.callers import Caller
from voa_service.http.authentication import caller_of
from voa_service.http.calls import strict_route
from voa_service.services import Services


def routes(services: Services) -> APIRouter:
    """Make the route by which callers learn what they may do."""
    router = APIRouter(prefix="/v1", tags=["caller"], route_class=strict_route(services.reader))

    @router.get("/caller", response_model=Caller, response_description="The caller.")
    async def get_caller(http: Request) -> Caller:
        """Read who the caller is by its key, and which calls it may make.

        A service without keys calls everybody `anonymous`, with the role `operator`.
        """
        return caller_of(http).message()

    return router
