"""Findings of the examination, sorted by whom they are about."""

import asyncio
from typing import NoReturn

from voa_client import AsyncClient, AsyncInProcessTransport
from voa_console.context import Console
from voa_console.robots.watching import RobotsWatch, of_robot, of_service
from voa_console.settings import ConsoleSettings
from voa_console.watching.hub import Hub
from voa_doctor.findings import Finding

FINDINGS = [
    Finding("HTTP", "ok", "accepts connections"),
    Finding("zenoh", "warning", "the service uses Zenoh (connected), which was not checked", "name its router"),
    Finding("robots", "warning", "none"),
    Finding("robot a", "wrong", "silent"),
    Finding("robot a: poor-fit", "warning", "bad"),
    Finding("robot ab", "ok", "fine"),
    Finding("mapping", "wrong", "no TOML"),
]


def test_findings_about_robots_are_not_about_the_service() -> None:
    assert [finding.check for finding in of_service(FINDINGS)] == ["HTTP", "zenoh"]


def test_a_router_that_the_service_has_reached_is_no_warning() -> None:
    assert of_service(FINDINGS)[1].state == "ok"
    waiting = Finding("zenoh", "warning", "the service uses Zenoh (connecting), which was not checked", "name it")
    assert of_service([waiting]) == [waiting]


def test_findings_about_a_robot_are_its_own() -> None:
    assert [finding.check for finding in of_robot(FINDINGS, "a")] == ["scans", "poor-fit"]
    assert [finding.check for finding in of_robot(FINDINGS, "ab")] == ["scans"]


def test_the_service_is_examined_by_the_key_of_the_page() -> None:
    examined: list[tuple[str, str | None]] = []

    def examination(url: str, key: str | None) -> list[Finding]:
        examined.append((url, key))
        return FINDINGS

    async def whole() -> None:
        client = AsyncClient(AsyncInProcessTransport(Nobody()))
        console = Console(ConsoleSettings("http://lab"), client, Hub(client), "of a browser")
        watch = RobotsWatch(console, examination)
        arrived = asyncio.Event()
        leave = watch.subscribe(lambda: arrived.set() if watch.findings else None)
        async with asyncio.timeout(20.0):
            await arrived.wait()
        leave()

    asyncio.run(whole())
    assert examined == [("http://lab", "of a browser")]


class Nobody:
    """Service that is not called."""

    def answer(self, method: str, payload: bytes, attachment: bytes | None = None) -> NoReturn:
        raise AssertionError(method)
