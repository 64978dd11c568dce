"""The way over Zenoh: the router, the session with it, the replicas behind it, and whether they may be asked.

Zenoh is silent about what goes wrong: no service, a wrong root and a rule that forbids it all look like no answer. So
each step looks for what would tell one from the other.
"""

import time
from collections.abc import Iterator
from contextlib import ExitStack

import zenoh
from pydantic import ValidationError

from voa_cli.doctor.findings import Budget, Finding, TookTooLong
from voa_cli.doctor.reaching import reach
from voa_client import ZenohAddress
from voa_client.zenoh_session import NoRouter, joined
from voa_msgs import WIRE_VERSION
from voa_msgs.keys import Attachment, Keys
from voa_msgs.problems import Health, Problem

_OPEN_S = 2.0
_ASK_S = 2.0
_FROZEN_AFTER = 0.8
"""Of that time: a router that refuses says so at once."""
_TCP = ("tcp", "tls", "ws")
_SHARED_MEMORY = Finding(
    "shared memory",
    "ok",
    "off in voa",
    "if scans of a ROS 2 node on the router's own machine vanish under load, turn it off there too",
)


def check_router(address: ZenohAddress, budget: Budget, stack: ExitStack) -> tuple[list[Finding], zenoh.Session | None]:
    """Whether there is a router, and whether it takes us.

    Args:
        address: of the router, and as whom.
        budget: the time that is left.
        stack: closes the session.

    Returns:
        The findings, and the open session; None: there is none.
    """
    kind, _, where = address.endpoint.partition("/")
    host, _, port = where.partition("?")[0].rpartition(":")
    findings = []
    if kind in _TCP and port.isdigit():
        findings.append(reach("router", host.strip("[]"), int(port), budget))
        if findings[0].state != "ok":
            return findings, None
    finding, session = _opened(address, budget, stack)
    return [*findings, finding], session


def _opened(address: ZenohAddress, budget: Budget, stack: ExitStack) -> tuple[Finding, zenoh.Session | None]:
    check, began = "zenoh session", time.monotonic()
    as_whom = "as nobody" if address.user is None else f"as {address.user!r}"
    context = joined(address, more={"transport/unicast/open_timeout": round(1000 * _OPEN_S)})
    try:
        session = budget.within(2.0 * _OPEN_S, context.__enter__)
    except (NoRouter, TookTooLong):
        if time.monotonic() - began >= _FROZEN_AFTER * _OPEN_S:
            seen = "takes connections and does not answer"
            return Finding(check, "wrong", seen, "frozen, or no Zenoh router: restart it, or name the right port"), None
        seen = f"the router is there and refuses us {as_whom}"
        advice = "check user and password: --zenoh zenoh://USER:PASSWORD@HOST:PORT; a TLS router: zenoh+tls://"
        return Finding(check, "wrong", seen, advice), None
    stack.push(context)
    routers = ", ".join(str(zid) for zid in session.info.routers_zid())
    return Finding(check, "ok", f"joined {as_whom}; router {routers or 'unknown'}"), session


def check_service(session: zenoh.Session, keys: Keys, health: Health | None, budget: Budget) -> Iterator[Finding]:
    """Whether replicas of the service are there, whether they answer, and whether it is the service that HTTP knows.

    Args:
        session: with the router.
        keys: below our root.
        health: what the service said by HTTP; None: it was not asked, or did not answer.
        budget: the time that is left.
    """
    replicas = sorted(keys.last(key) for key in alive(session, keys.replica("*"), budget))
    yield _replicas(session, keys, replicas, budget)
    yield _asked(session, keys, replicas, budget)
    if health is not None:
        yield _same(keys, health, replicas)
    yield _SHARED_MEMORY


def alive(session: zenoh.Session, expression: str, budget: Budget) -> list[str]:
    """Keys of the liveliness tokens that are seen."""
    seconds = budget.step(_ASK_S)
    replies = session.liveliness().get(expression, timeout=seconds)
    return [str(reply.ok.key_expr) for reply in replies if reply.ok is not None]


def _replicas(session: zenoh.Session, keys: Keys, replicas: list[str], budget: Budget) -> Finding:
    if replicas:
        return Finding("replicas", "ok", f"{len(replicas)} under {keys.root}: {', '.join(replicas)}")
    elsewhere = sorted({key.rpartition("/replica/")[0] for key in alive(session, "**/replica/*", budget)})
    if elsewhere:
        seen = f"none under {keys.root}, but under {', '.join(elsewhere)}"
        return Finding("replicas", "wrong", seen, f"another root: --zenoh zenoh://HOST:PORT/{elsewhere[0]}")
    advice = "start it with --zenoh and this router, or let this user see liveliness tokens"
    return Finding("replicas", "wrong", f"none under {keys.root}", advice)


def _asked(session: zenoh.Session, keys: Keys, replicas: list[str], budget: Budget) -> Finding:
    check, key = "asking", keys.rpc("service.health")
    beside = Attachment(wire=WIRE_VERSION).model_dump_json(exclude_none=True)
    began = time.monotonic()
    replies = list(session.get(key, payload=b"{}", attachment=beside, timeout=budget.step(_ASK_S)))
    took = 1e3 * (time.monotonic() - began)
    if not replies:
        return Finding(check, "wrong", f"nobody answers at {key}", _nobody(replicas))
    answer = replies[0]
    try:
        if answer.ok is not None:
            told = Health.model_validate_json(answer.ok.payload.to_bytes(), extra="ignore")
            return Finding(check, "ok", f"{told.replica} answers in {took:.0f} ms: {told.status}")
        body = b"" if answer.err is None else answer.err.payload.to_bytes()
        if body == b"Timeout":
            return Finding(check, "wrong", f"no answer at {key} in time", "it hangs: look at its log, restart it")
        return Finding(check, "wrong", Problem.model_validate_json(body, extra="ignore").detail, "look at its log")
    except ValidationError:
        return Finding(check, "wrong", f"what answers at {key} is not ours", "is the root right?")


def _nobody(replicas: list[str]) -> str:
    if replicas:
        return "the replica is there: the router's rules (access_control) forbid this user to query below the root"
    return "it is not running, or on another router or root, or the router's rules (access_control) forbid the query"


def _same(keys: Keys, health: Health, replicas: list[str]) -> Finding:
    """Whether the process behind the URL is one of those behind the router."""
    check = "HTTP and Zenoh"
    if health.replica in replicas:
        return Finding(check, "ok", "the same service")
    match health.zenoh:
        case "off":
            advice = "start it with --zenoh ENDPOINT"
            return Finding(check, "wrong", "the service behind the URL is not told of any router", advice)
        case "connecting":
            seen = "the service behind the URL has not reached its router"
            return Finding(check, "wrong", seen, "does its --zenoh name this router, and the right password?")
        case _:
            seen = f"the service behind the URL ({health.replica}) is not seen under {keys.root} on this router"
            return Finding(check, "wrong", seen, "two routers, or two roots: compare its --zenoh and --zenoh-root")
