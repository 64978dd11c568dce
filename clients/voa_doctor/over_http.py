"""Checks over HTTP: the service runs, is ready, uses the same version of the messages, and its clock agrees."""

import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from importlib.metadata import version
from urllib.parse import urlsplit

import httpx2
from pydantic import ValidationError

from voa_client import ApiKey, Caller
from voa_doctor.findings import Budget, Finding
from voa_doctor.memory import check_memory
from voa_doctor.reaching import reach
from voa_doctor.sessions import sessions_of
from voa_msgs import WIRE_VERSION
from voa_msgs.problems import Health, Problem
from voa_msgs.robots import Robots
from voa_msgs.sessions import Session

CLOCK_S = 0.1
"""Difference of clocks above which there is a warning, seconds."""
_SECONDS = 2.0
_TRIES = 3


@dataclass
class Responses:
    """Responses of the service that other checks need.

    They are its health, its robots, the sessions that the robots' scans go to, and how far its clock is ahead.
    """

    health: Health | None = None
    robots: Robots | None = None
    sessions: list[Session] = field(default_factory=list)
    ahead: timedelta = timedelta()
    """Time by which the service's clock is ahead of this machine's."""


def check_http(url: str, budget: Budget, responses: Responses, key: ApiKey) -> Iterator[Finding]:
    """Run the checks over HTTP; they end early if the service cannot be reached."""
    parts = urlsplit(url)
    port = parts.port or (443 if parts.scheme == "https" else 80)
    reached = reach("HTTP", parts.hostname or "", port, budget)
    yield reached
    if reached.state != "ok":
        return
    with httpx2.Client(base_url=url, timeout=_SECONDS, headers=key.headers()) as http:
        alive = _alive(http, budget)
        yield alive
        if alive.state != "ok":
            return
        yield from _ready(http, budget, responses)
        yield from _key(http, budget)
        responses.robots = _robots(http, budget)
        if responses.robots is not None:
            responses.sessions = sessions_of(http, responses.robots, budget)


def robots_after(url: str, seconds: float, budget: Budget, key: ApiKey) -> Robots | None:
    """Return the service's report on robots after a number of seconds; None: it no longer responds."""
    time.sleep(budget.step(seconds))
    with httpx2.Client(base_url=url, timeout=_SECONDS, headers=key.headers()) as http:
        return _robots(http, budget)


def _alive(http: httpx2.Client, budget: Budget) -> Finding:
    check = "service"
    try:
        response = http.get("/livez", timeout=budget.step(_SECONDS))
        Health.model_validate_json(response.raise_for_status().content, extra="ignore")
    except httpx2.TimeoutException:
        return Finding(
            check, "wrong", "accepts connections and does not answer", "it hangs: look at its log, restart it"
        )
    except httpx2.TransportError as error:
        return Finding(
            check,
            "wrong",
            f"does not answer over HTTP: {error}",
            "check the port: another program seems to listen there",
        )
    except httpx2.HTTPStatusError as error:
        seen = f"/livez answers {error.response.status_code}"
        return Finding(check, "wrong", seen, "another program listens there, or a proxy does not reach the service")
    except ValidationError:
        return Finding(check, "wrong", "/livez has an answer that is not the service's", "check the URL")
    return Finding(check, "ok", "runs")


def _ready(http: httpx2.Client, budget: Budget, responses: Responses) -> Iterator[Finding]:
    try:
        offsets = []
        for _ in range(_TRIES):
            began, sent = time.monotonic(), datetime.now(UTC)
            response = http.get("/readyz", timeout=budget.step(_SECONDS))
            took = time.monotonic() - began
            if not response.is_success:
                yield _not_ready(response)
                return
            health = Health.model_validate_json(response.content, extra="ignore")
            if health.now is not None:
                offsets.append((took / 2.0, (health.now - sent).total_seconds() - took / 2.0))
    except (httpx2.HTTPError, ValidationError) as error:
        yield Finding("ready", "wrong", f"/readyz: {error}", "look at the service's log")
        return
    responses.health = health
    yield Finding("ready", "ok", health.status)
    yield _software(health)
    yield _wire(health)
    yield from check_memory(health.memory)
    if offsets:
        unsure, offset = min(offsets)
        responses.ahead = timedelta(seconds=offset)
        yield clocks("clock", offset, unsure)


def _key(http: httpx2.Client, budget: Budget) -> Iterator[Finding]:
    """Check the caller's key; without a finding where the service has no keys, or is older than keys."""
    try:
        response = http.get("/v1/caller", timeout=budget.step(_SECONDS))
        if response.status_code == 401:
            seen = Problem.model_validate_json(response.content, extra="ignore").detail
            yield Finding("key", "wrong", seen, "name a file with a key: --key-file FILE, or VOA_KEY_FILE")
        elif response.is_success:
            caller = Caller.model_validate_json(response.content, extra="ignore")
            if caller.key is not None:
                yield Finding("key", "ok", f"{caller.name}, {caller.role}")
    except (httpx2.HTTPError, ValidationError) as error:
        yield Finding("key", "warning", f"/v1/caller: {error}", "look at the service's log")


def _not_ready(response: httpx2.Response) -> Finding:
    try:
        why = Problem.model_validate_json(response.content, extra="ignore").detail
    except ValidationError:
        why = f"/readyz answers {response.status_code}"
    return Finding("ready", "wrong", why, "check that its database is reachable, and look at the service's log")


def _software(health: Health) -> Finding:
    ours = version("voa")
    if health.version in (None, ours):
        return Finding(
            "software",
            "ok",
            f"version {ours} on both sides" if health.version else "the service does not report its version",
        )
    return Finding(
        "software",
        "warning",
        f"version {health.version} of the service, {ours} on this machine",
        "update the older one",
    )


def _wire(health: Health) -> Finding:
    theirs = health.wire_version
    if theirs == WIRE_VERSION:
        return Finding("messages", "ok", f"version {theirs} on both sides")
    older = "the service" if (theirs or 0) < WIRE_VERSION else "this machine"
    return Finding(
        "messages", "wrong", f"version {theirs} of the service, {WIRE_VERSION} on this machine", f"update {older}"
    )


def clocks(check: str, offset_s: float, unsure_s: float) -> Finding:
    """Check the difference of two clocks, seconds; `offset_s` is positive if the other one is ahead of ours."""
    seen = f"{abs(offset_s):.3f} s {'ahead of' if offset_s > 0 else 'behind'} ours (within {unsure_s:.3f} s)"
    if abs(offset_s) - unsure_s > CLOCK_S:
        return Finding(check, "warning", seen, "set both clocks by NTP or chrony: scans and poses are matched by time")
    return Finding(check, "ok", seen)


def _robots(http: httpx2.Client, budget: Budget) -> Robots | None:
    try:
        response = http.get("/v1/robots", timeout=budget.step(_SECONDS)).raise_for_status()
        return Robots.model_validate_json(response.content, extra="ignore")
    except (httpx2.HTTPError, ValidationError):
        return None
