"""The table of roles: every call of the service, by HTTP and Zenoh, with the roles that may make it.

A call that is not in this table may be made by an operator alone, once a key exists; a test fails where a route or a
method is missing here. Calls have the names of their methods on Zenoh; those that only HTTP has are named likewise.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

from voa_msgs.callers import Role

ROLES: tuple[Role, ...] = get_args(Role)
EVERYBODY: frozenset[Role] = frozenset(ROLES)
SENSORS: frozenset[Role] = frozenset({"sensor", "operator"})
ARMS: frozenset[Role] = frozenset({"arm", "operator"})
OPERATORS: frozenset[Role] = frozenset({"operator"})

Concern = Literal["session", "robot", "sessions"]
"""Subject of a call to which keys may be bound: one session, one robot, or sessions in general, which a key that is
bound to sessions may not open. Lists show a bound key what it may read."""


@dataclass(frozen=True)
class Call:
    """A call of the service, by whichever protocol.

    Attributes:
        name: name of its method on Zenoh.
        roles: roles that may make it.
        routes: method and path of HTTP; empty where it can be made on Zenoh only.
        on: its subject, to which keys may be bound; None: a key's sessions and robots do not matter.
        writes: True if it changes what the service stores, or what a robot does: it is recorded in the audit.
        heavy: True if it may take long; fewer of these are allowed per time.
        public: True if it is answered without a key, too.
    """

    name: str
    roles: frozenset[Role]
    routes: tuple[str, ...] = ()
    on: Concern | None = None
    writes: bool = False
    heavy: bool = False
    public: bool = False


def _read(name: str, *routes: str, on: Concern | None = None, heavy: bool = False) -> Call:
    return Call(name, EVERYBODY, routes, on, heavy=heavy)


def _write(name: str, roles: frozenset[Role], *routes: str, on: Concern | None = None, heavy: bool = False) -> Call:
    return Call(name, roles, routes, on, writes=True, heavy=heavy)


_SESSION = "/v1/sessions/{session}"
_DOCS_FILES = "GET /static-offline-docs/{file}"

CALLS: tuple[Call, ...] = (
    Call("service.alive", EVERYBODY, ("GET /livez",), public=True),
    Call("service.health", EVERYBODY, ("GET /readyz",), public=True),
    _read("service.metrics", "GET /metrics"),
    _read("service.describe", "GET /openapi.json", "GET /docs", "GET /docs/oauth2-redirect", _DOCS_FILES),
    _read("service.open", "GET /"),
    _read("caller.get", "GET /v1/caller"),
    _read("object.get", "GET /v1/objects/{object}"),
    _read("object.list", "GET /v1/objects"),
    _read("object.mesh", "GET /v1/objects/{object}/mesh.stl", "GET /v1/objects/{object}/mesh", heavy=True),
    _read("object.stable_poses", "GET /v1/objects/{object}/stable-poses", heavy=True),
    _write("object.create", OPERATORS, "POST /v1/objects", heavy=True),
    _write("object.delete", OPERATORS, "DELETE /v1/objects/{object}"),
    _read("lidar.list", "GET /v1/lidars"),
    _read("scenario.get", "GET /v1/scenarios/{scenario}"),
    _read("scenario.list", "GET /v1/scenarios"),
    _read("scenario.warnings", "GET /v1/scenarios/{scenario}/warnings", heavy=True),
    _read("scenario.predict", "POST /v1/scenarios/{scenario}/predictions", heavy=True),
    _write("scenario.create", OPERATORS, "POST /v1/scenarios", heavy=True),
    _write("scenario.delete", OPERATORS, "DELETE /v1/scenarios/{scenario}"),
    _read("session.get", f"GET {_SESSION}", on="session"),
    _read("session.list", "GET /v1/sessions"),
    _read("session.follow", f"GET {_SESSION}/events", on="session"),
    _read("history.get", f"GET {_SESSION}/history", on="session"),
    _read("voa.rank", f"GET {_SESSION}/voa", f"POST {_SESSION}/voa", on="session", heavy=True),
    _read("grasp.rank", f"GET {_SESSION}/grasps", on="session"),
    _write("session.create", OPERATORS, "POST /v1/sessions", on="sessions"),
    _write("session.delete", OPERATORS, f"DELETE {_SESSION}", on="session"),
    _write("belief.put", OPERATORS, f"PUT {_SESSION}/belief", on="session"),
    _write("scan.apply", SENSORS, f"POST {_SESSION}/scans", on="session"),
    _write("scan.put", SENSORS, on="session"),
    _write("look.announce", SENSORS, f"POST {_SESSION}/looks", on="session"),
    _write("look.cancel", SENSORS, f"DELETE {_SESSION}/looks/{{look}}", on="session"),
    _write("outcome.report", ARMS, f"POST {_SESSION}/grasp-outcomes", on="session"),
    _read("update.compute", "POST /v1/updates"),
    _read("ranking.compute", "POST /v1/rankings", heavy=True),
    _read("robot.list", "GET /v1/robots"),
    _read("robot.scan", "GET /v1/robots/{robot}/scan", on="robot"),
    _write("robot.look", SENSORS, "POST /v1/robots/{robot}/look", on="robot"),
    _write("robot.claim", OPERATORS, "PUT /v1/robots/{robot}/session", on="robot"),
)
"""Every call of the service. The metrics and the description of the calls need a key like any other call: both say
something about the laboratory, and Prometheus can send a key."""

BY_NAME: Mapping[str, Call] = {call.name: call for call in CALLS}
SCAN_PUT = BY_NAME["scan.put"]
UNLISTED = Call("unlisted", OPERATORS)
"""Call for everything that is not in the table."""
