"""List of a lab's clients on its Zenoh router: read from TOML and checked."""

import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any

LOGINS = ("certificates", "passwords", "both")
"""Ways to log in to the router."""
OUTPUTS = ("belief", "poses", "markers", "grasps", "best_grasp", "place", "numbers/*")
"""Usual topics of the service's outputs for ROS tools, below `voa/` in the namespace of a robot."""
_TYPES = {str: "a text", bool: "true or false", int: "a number", list: "a list", dict: "a section"}
_MORE = {"robot": {"namespace"}, "viewer": {"scans"}}
"""Entries that clients of a kind have beside those of all."""
_ROOT = re.compile(r"[A-Za-z0-9_.-]+(?:/[A-Za-z0-9_.-]+)*")
_NAME = re.compile(r"[A-Za-z0-9_.-]+")
_TOPIC = re.compile(r"(?:[A-Za-z0-9_]+|\*)(?:/(?:[A-Za-z0-9_]+|\*))*(?:/\*\*)?")


class InvalidList(ValueError):
    """Error for a list that is not valid; its text says what was expected."""


@dataclass(frozen=True)
class Client:
    """Client of the router, as the list describes it.

    Attributes:
        kind: `service`, `robot`, `arm` or `viewer`.
        name: common name of its certificate, or user name; of a robot also the last chunk of the keys of its scans.
        publishes: ROS 2 topics that it publishes, with `*` and `/**` at the end as wildcards.
        receives: ROS 2 topics that it receives, written in the same way.
        outputs: topics of the service's outputs about a robot, of which only the service is a publisher.
        domain: ROS_DOMAIN_ID in the keys of rmw_zenoh.
        scans: True for a viewer that receives the raw scans of all robots, with the API keys beside them.
    """

    kind: str
    name: str
    publishes: tuple[str, ...] = ()
    receives: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()
    domain: int = 0
    scans: bool = False


@dataclass(frozen=True)
class Lab:
    """List of a lab: its clients, and how they log in.

    Attributes:
        root: root of the service's keys.
        login: `certificates`, `passwords` or `both`.
        listen: endpoints of the router.
        files: paths of certificates and passwords on the router's machine.
        clients: the service first.
    """

    root: str
    login: str
    listen: tuple[str, ...]
    files: Mapping[str, str]
    clients: tuple[Client, ...]


def read(text: str) -> Lab:
    """Read a list; raises InvalidList."""
    try:
        given = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InvalidList(str(error)) from error
    _check_names(given, {"root", "login", "listen", "files", "service", "robot", "arm", "viewer"}, "the list")
    service = _typed(given, "service", dict, {})
    if not service:
        raise InvalidList("expected a section [service] with the name of the service")
    clients = [_client("service", service)]
    for kind in ("robot", "arm", "viewer"):
        clients += [_client(kind, each) for each in _typed(given, kind, list, [])]
    root, login = _typed(given, "root", str, "voa/v1/default"), _typed(given, "login", str, "certificates")
    listen = _typed(given, "listen", list, ["tls/[::]:7447"])
    if not _ROOT.fullmatch(root):
        raise InvalidList(f"root: expected parts of letters, digits, '_', '.' and '-' between slashes, got {root!r}")
    if login not in LOGINS:
        raise InvalidList(f"login: expected one of {', '.join(LOGINS)}, got {login!r}")
    if login != "passwords" and not all(each.startswith(("tls/", "quic/")) for each in listen):
        raise InvalidList(f"listen: login by {login} needs TLS: expected endpoints such as tls/[::]:7447, got {listen}")
    lab = Lab(root, login, tuple(listen), _typed(given, "files", dict, {}), tuple(clients))
    _check(lab)
    return lab


def _typed(given: Mapping[str, Any], name: str, kind: type, default: Any) -> Any:
    """Return an entry, or the default where it is missing; raises InvalidList for a value of another type."""
    value = given.get(name, default)
    if type(value) is not kind:
        raise InvalidList(f"{name}: expected {_TYPES[kind]}, got {value!r}")
    return value


def _client(kind: str, given: Any) -> Client:
    if not isinstance(given, dict):
        raise InvalidList(f"expected sections [[{kind}]], got {given!r}")
    known = {"name", "publishes", "receives", "domain"} | _MORE.get(kind, set())
    _check_names(given, known, f"[[{kind}]]")
    name = _typed(given, "name", str, "")
    if not _NAME.fullmatch(name):
        raise InvalidList(f"name of a {kind}: expected letters, digits, '_', '.' and '-', got {name!r}")
    publishes, receives = (
        tuple(str(topic).removeprefix("/") for topic in _typed(given, word, list, []))
        for word in ("publishes", "receives")
    )
    outputs: tuple[str, ...] = ()
    if kind == "robot" and (namespace := _typed(given, "namespace", str, name).strip("/")):
        publishes += (f"{namespace}/**",)
        outputs = tuple(f"{namespace}/voa/{topic}" for topic in OUTPUTS)
    for topic in (*publishes, *receives):
        if not _TOPIC.fullmatch(topic):
            raise InvalidList(f"{kind} {name}: expected a topic such as tb3_1/odom or tb3_1/**, got {topic!r}")
    domain, scans = _typed(given, "domain", int, 0), _typed(given, "scans", bool, False)
    return Client(kind, name, publishes, receives, outputs, domain, scans)


def _check_names(given: Mapping[str, Any], known: set[str], what: str) -> None:
    unknown = sorted(set(given) - known)
    if unknown:
        raise InvalidList(f"{what} has no {unknown[0]!r}: expected {', '.join(sorted(known))}")


def _check(lab: Lab) -> None:
    """Refuse a list in which a name stands for two clients, or a topic opens keys that belong to another client."""
    names = [client.name for client in lab.clients]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InvalidList(f"expected names that differ, {twice!r} stands there twice")
    for client in lab.clients:
        for topic in (*client.publishes, *client.receives):
            if any(intersect(each, f"{lab.root}/**") for each in keys_of([topic], "*")):
                raise InvalidList(f"{client.kind} {client.name}: topic {topic!r} would open keys of the service")
    for one, other in combinations([each for each in lab.clients if each.kind == "robot"], 2):
        for mine in one.publishes:
            for theirs in other.publishes:
                if intersect(mine, theirs):
                    raise InvalidList(f"robots {one.name} and {other.name} would both publish {mine!r}")


def intersect(one: str, other: str) -> bool:
    """Return True if a key could match both key expressions, whose chunks may be `*` and `**`."""

    def meet(a: list[str], b: list[str]) -> bool:
        if not a or not b:
            return all(chunk == "**" for chunk in a + b)
        if "**" in (a[0], b[0]):
            return meet(a[1:], b) or meet(a, b[1:]) if a[0] == "**" else meet(b, a)
        return (a[0] == b[0] or "*" in (a[0], b[0])) and meet(a[1:], b[1:])

    return meet(one.split("/"), other.split("/"))


def keys_of(topics: Iterable[str], domain: int | str = "*") -> list[str]:
    """List the keys of topics: as a bridge writes them, and as rmw_zenoh does, with domain, type and hash.

    Args:
        topics: names of topics.
        domain: ROS_DOMAIN_ID; `*`: any, as programs subscribe that do not know the domain of a robot.
    """
    listed = []
    for topic in topics:
        listed += [topic, f"{domain}/{topic}" if topic.endswith("/**") else f"{domain}/{topic}/*/*"]
    return listed
