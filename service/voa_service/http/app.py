"""The HTTP application around given services."""

from importlib.metadata import version

from fastapi import FastAPI
from fastapi.routing import APIRoute
from fastapi_offline import FastAPIOffline

from voa_connections.in_flight import ByteBudget, BytesInFlight
from voa_connections.settings import MEBIBYTE, ConnectionSettings
from voa_service.console import ConsolePort, no_console
from voa_service.http import openapi, problems
from voa_service.http.access import Access
from voa_service.http.authentication import Authentication
from voa_service.http.direct import Direct
from voa_service.http.middleware import BodyLimit, RequestLog, WireVersion
from voa_service.http.refusals import refusal_response
from voa_service.http.routes import (
    caller,
    events,
    health,
    looks,
    objects,
    observations,
    rankings,
    robots,
    root,
    scenarios,
    sessions,
    stateless,
)
from voa_service.services import Services

_DESCRIPTION = (
    "Where should the lidar look before the arm grasps? Keeps a belief over the poses of an object, updates it from "
    "raw lidar scans, ranks sensor poses by their Value of Assistance and names the best grasp. SI units; one world "
    "frame, z up. Errors are RFC 9457 problem documents; `type` is the name to program against."
)


def create_app(services: Services, budget: ByteBudget | None = None, console: ConsolePort = no_console) -> FastAPI:
    """Build the HTTP application; the caller, who built the services, releases them.

    Args:
        services: use cases and queues.
        budget: bytes of request bodies that may be held at once; None: a budget of the default size.
        console: returns the port of the console that runs beside the service.
    """
    if budget is None:
        budget = ByteBudget(ConnectionSettings().in_flight_mebibytes * MEBIBYTE)
    app = FastAPIOffline(
        title="Value of Assistance for grasping",
        version=version("voa"),
        description=_DESCRIPTION,
        redoc_url=None,
        generate_unique_id_function=lambda route: route.name,
        telemetry={"tracing": False, "metrics": False, "logs": False},
    )
    modules = (
        objects,
        scenarios,
        sessions,
        observations,
        looks,
        events,
        rankings,
        stateless,
        robots,
        caller,
        health,
    )
    routers = [module.routes(services) for module in modules]
    for router in routers:
        app.include_router(router)
    described = [route for router in routers for route in router.routes if isinstance(route, APIRoute)]
    app.router.middleware_stack = Direct(app.router.middleware_stack, described, services.reader)
    root.install(app, console)
    problems.install(app)
    openapi.install(app, services.limits, lambda: services.gate.keyring.is_closed)
    app.add_middleware(WireVersion)
    app.add_middleware(BodyLimit, limits=services.limits)
    app.add_middleware(BytesInFlight, budget=budget, respond=refusal_response)
    app.add_middleware(Authentication, gate=services.gate)
    app.add_middleware(Access, names=services.names)
    app.add_middleware(RequestLog, metrics=services.metrics)
    return app
