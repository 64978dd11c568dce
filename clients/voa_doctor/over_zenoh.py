"""Checks over Zenoh: the router, the session with it, the service's replicas, and their responses.

Zenoh does not report why there is no response: no service, a wrong root, or an access rule of the router. So each check
looks for signs that distinguish these.
"""

import time
from collections.abc import Iterator
from contextlib import ExitStack

import zenoh
from pydantic import ValidationError

from voa_client import ZenohAddress
from voa_client.zenoh_session import NoRouter, joined
from voa_doctor.findings import Budget, Finding, TookTooLong
from voa_doctor.reaching import reach
from voa_msgs import WIRE_VERSION
from voa_msgs.keys import Attachment, Keys
from voa_msgs.problems import Health, Problem

_OPEN_S = 2.0
_QUERY_S = 2.0
_FROZEN_AFTER = 0.8
"""Share of the time limit after which a router counts as frozen; one that refuses does so at once."""
_TCP = ("tcp", "tls", "ws")
_SHARED_MEMORY = Finding(
    "shared memory",
    "ok",
    "off in the service and its clients",
    "if scans of a ROS 2 node on the router's machine are lost under load, turn it off there, too",
)


def check_router(address: ZenohAddress, budget: Budget, stack: ExitStack) -> tuple[list[Finding], zenoh.Session | None]:
    """Check that a router can be reached, and accepts the credentials.

    Args:
        address: of the router, with credentials.
        budget: time that is left.
        stack: closes the session.

    Returns:
        The findings, and the open session; None: it could not be opened.
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
    as_user = "without a user" if address.user is None else f"as {address.user!r}"
    context = joined(address, more={"transport/unicast/open_timeout": round(1000 * _OPEN_S)})
    try:
        session = budget.within(2.0 * _OPEN_S, context.__enter__)
    except (NoRouter, TookTooLong):
        if time.monotonic() - began >= _FROZEN_AFTER * _OPEN_S:
            seen = "accepts connections and does not answer"
            return Finding(
                check, "wrong", seen, "it is frozen, or no Zenoh router: restart it, or correct the port"
            ), None
        seen = f"the router runs, and refuses a session {as_user}"
        advice = "check user and password: --zenoh zenoh://USER:PASSWORD@HOST:PORT; a TLS router: zenoh+tls://"
        return Finding(check, "wrong", seen, advice), None
    stack.push(context)
    routers = ", ".join(str(zid) for zid in session.info.routers_zid())
    return Finding(check, "ok", f"connected {as_user}; router {routers or 'unknown'}"), session


def check_service(session: zenoh.Session, keys: Keys, health: Health | None, budget: Budget) -> Iterator[Finding]:
    """Check that replicas of the service run and answer, and that they are the service that answers over HTTP.

    Args:
        session: with the router.
        keys: of the service.
        health: state of the service, as received over HTTP; None: not received.
        budget: time that is left.
    """
    replicas = sorted(keys.last(key) for key in alive(session, keys.replica("*"), budget))
    yield _replicas(session, keys, replicas, budget)
    yield _query(session, keys, replicas, budget)
    if health is not None:
        yield _same_service(keys, health, replicas)
    yield _SHARED_MEMORY


def alive(session: zenoh.Session, expression: str, budget: Budget) -> list[str]:
    """Return the keys of the liveliness tokens that match a key expression."""
    seconds = budget.step(_QUERY_S)
    replies = session.liveliness().get(expression, timeout=seconds)
    return [str(reply.ok.key_expr) for reply in replies if reply.ok is not None]


def _replicas(session: zenoh.Session, keys: Keys, replicas: list[str], budget: Budget) -> Finding:
    if replicas:
        return Finding("replicas", "ok", f"{len(replicas)} under {keys.root}: {', '.join(replicas)}")
    elsewhere = sorted({key.rpartition("/replica/")[0] for key in alive(session, "**/replica/*", budget)})
    if elsewhere:
        seen = f"none under {keys.root}, but under {', '.join(elsewhere)}"
        return Finding("replicas", "wrong", seen, f"name that root: --zenoh zenoh://HOST:PORT/{elsewhere[0]}")
    advice = "start the service with --zenoh and this router, or let this user see liveliness tokens"
    return Finding("replicas", "wrong", f"none under {keys.root}", advice)


def _query(session: zenoh.Session, keys: Keys, replicas: list[str], budget: Budget) -> Finding:
    check, key = "asking", keys.rpc("service.health")
    beside = Attachment(wire=WIRE_VERSION).model_dump_json(exclude_none=True)
    began = time.monotonic()
    replies = list(session.get(key, payload=b"{}", attachment=beside, timeout=budget.step(_QUERY_S)))
    took = 1e3 * (time.monotonic() - began)
    if not replies:
        return Finding(check, "wrong", f"no answer at {key}", _advice_on_silence(replicas))
    reply = replies[0]
    try:
        if reply.ok is not None:
            state = Health.model_validate_json(reply.ok.payload.to_bytes(), extra="ignore")
            return Finding(check, "ok", f"{state.replica} answers in {took:.0f} ms: {state.status}")
        body = b"" if reply.err is None else reply.err.payload.to_bytes()
        if body == b"Timeout":
            return Finding(check, "wrong", f"no answer at {key} in time", "it hangs: look at its log, restart it")
        return Finding(check, "wrong", Problem.model_validate_json(body, extra="ignore").detail, "look at its log")
    except ValidationError:
        return Finding(check, "wrong", f"the answer at {key} is not the service's", "check the root of the keys")


def _advice_on_silence(replicas: list[str]) -> str:
    if replicas:
        return "the replica runs: the router's rules (access_control) forbid this user to query below the root"
    return (
        "the service is not running, or uses another router or root; or the router's access_control forbids the query"
    )


def _same_service(keys: Keys, health: Health, replicas: list[str]) -> Finding:
    """Check that the service at the URL is one of the replicas on the router."""
    check = "HTTP and Zenoh"
    if health.replica in replicas:
        return Finding(check, "ok", "the same service")
    match health.zenoh:
        case "off":
            advice = "start it with --zenoh ENDPOINT"
            return Finding(check, "wrong", "the service at the URL does not use Zenoh", advice)
        case "connecting":
            seen = "the service at the URL has not reached its router"
            return Finding(check, "wrong", seen, "check that its --zenoh names this router and the right password")
        case _:
            seen = f"the service at the URL ({health.replica}) is not seen under {keys.root} on this router"
            return Finding(check, "wrong", seen, "it uses another router or root: compare its --zenoh and --zenoh-root")
