"""Examination and scans of the robots for all open pages: once per process, while somebody looks."""

import asyncio
import logging
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from datetime import datetime

from voa_client import ApiKey, VoaClientError
from voa_console.context import Console
from voa_console.robots.previews import Previews
from voa_console.robots.readings import Reading
from voa_console.watching.news import Callback, News
from voa_doctor.examination import examine
from voa_doctor.findings import Finding
from voa_doctor.robots import check_robots
from voa_msgs.robots import Robots

EXAMINE_S = 10.0
"""Pause between two examinations of the service, seconds."""
RENEW_S = 1.0
"""Pause between two requests for the robots' scans, seconds."""
_FIRST_S = 0.1
"""Pause before the first report on robots, seconds."""
_BEFORE = 5
"""Number of reports, one per second, over which refusals count as present."""


Examination = Callable[[str, str | None], list[Finding]]
"""Function that returns the findings about the service at a URL, given a key; None: the key of this process."""


def examine_by(url: str, key: str | None) -> list[Finding]:
    """Examine the service at a URL by a key; None: by the key of this process, if it has one."""
    return examine(url, key=ApiKey.given(key))


class RobotsWatch:
    """Findings about the service and its robots, and previews of their scans, while a page subscribes.

    Args:
        console: parts of the console.
        examination: returns the findings about a service; it runs in a thread.
    """

    def __init__(self, console: Console, examination: Examination = examine_by) -> None:
        self.findings: list[Finding] | None = None
        """Newest findings about the service, without those about robots; None: there are none yet."""
        self.examined_at: datetime | None = None
        """Time of the newest examination, by the clock of the service; None: there was none yet."""
        self.previews = Previews(console.client, console.hub)
        self._console = console
        self._examination = examination
        self._news = News()
        self._tasks: list[asyncio.Task[None]] = []
        self._due = asyncio.Event()
        self._wanted = asyncio.Event()
        self._before: deque[Robots] = deque(maxlen=_BEFORE)

    @property
    def is_examining(self) -> bool:
        """True while an examination runs that was requested, or is due."""
        return self._due.is_set() or self.findings is None

    def subscribe(self, callback: Callback) -> Callback:
        """Call `callback` at each new result from now on; return the function that ends that."""
        leave = self._news.subscribe(callback)
        if not self._tasks:
            self._due.set()
            self._tasks = [
                asyncio.create_task(self._examine(), name="voa-console-examination"),
                asyncio.create_task(self._renew(), name="voa-console-previews"),
            ]

        def unsubscribe() -> None:
            leave()
            if not len(self._news):
                for task in self._tasks:
                    task.cancel()
                self._tasks = []

        return unsubscribe

    def examine_now(self) -> None:
        """Examine the service at once, and compare every robot's next scan."""
        self._due.set()
        for report in self._console.hub.robots():
            self.previews.forget(report.robot)
        self._news.publish()

    def want(self, robot: str, reading: Reading) -> None:
        """Let the outline of a robot's scan be predicted in a reading, soon."""
        preview = self.previews.get(robot)
        if preview is not None and reading not in preview.wanted:
            preview.wanted.add(reading)
            self._wanted.set()

    def robot_findings(self, now: datetime) -> list[Finding]:
        """Check the robots by the newest reports.

        Args:
            now: time by the clock of the service.
        """
        hub = self._console.hub
        robots = Robots(items=list(hub.robots()), mapping_error=hub.mapping_error)
        if not self._before or self._before[-1].items != robots.items:
            self._before.append(robots)
        before = self._before[0] if len(self._before) > 1 else None
        return list(check_robots(robots, now, before))

    async def _examine(self) -> None:
        while True:
            self.findings = await self._findings()
            self.examined_at = self._console.hub.now()
            self._due.clear()
            self._news.publish()
            with suppress(TimeoutError):
                await asyncio.wait_for(self._due.wait(), EXAMINE_S)

    async def _findings(self) -> list[Finding]:
        url = self._console.settings.url
        if not url.startswith(("http://", "https://")):
            advice = "for a full examination: voa doctor --url http://SERVICE:8000 --zenoh tcp/ROUTER:7447"
            return [Finding("service", "ok", f"this console reaches it by Zenoh ({url})", advice)]
        try:
            return of_service(await asyncio.to_thread(self._examination, url, self._console.key))
        except Exception as error:  # a check that fails must not end the examinations
            logging.getLogger("voa.console").exception("the examination failed")
            return [Finding("examination", "wrong", f"it failed: {error}", "run voa doctor, and report the mistake")]

    async def _renew(self) -> None:
        while True:
            try:
                await self.previews.renew(self._console.hub.robots())
                self._news.publish()
            except VoaClientError:  # the banner of the page says so
                await asyncio.sleep(RENEW_S)
            except Exception:  # one scan that cannot be shown must not keep the others from being shown
                logging.getLogger("voa.console").exception("the robots' scans could not be renewed")
                await asyncio.sleep(RENEW_S)
            with suppress(TimeoutError):
                await asyncio.wait_for(self._wanted.wait(), RENEW_S if self._console.hub.robots() else _FIRST_S)
            self._wanted.clear()


def of_service(findings: Sequence[Finding]) -> list[Finding]:
    """Select the findings that are about no single robot and its mapping, which the page draws by itself."""
    return [_without_nagging(finding) for finding in findings if not is_of_robots(finding)]


def _without_nagging(finding: Finding) -> Finding:
    """Take it for no warning that the console does not know the router, if the service has reached it."""
    if finding.check != "zenoh" or "(connected)" not in finding.seen:
        return finding
    advice = "to check the router, too: voa doctor --zenoh tcp/HOST:7447"
    return Finding("zenoh", "ok", "the service has reached its router", advice)


def is_of_robots(finding: Finding) -> bool:
    """True if a finding is about one robot, about all of them, or about their mapping."""
    return finding.check in ("robots", "mapping") or finding.check.startswith("robot ")


def of_robot(findings: Sequence[Finding], robot: str) -> list[Finding]:
    """Select the findings about one robot, named "scans" or by the kind of their warning."""
    name = f"robot {robot}"
    selected = [each for each in findings if each.check == name or each.check.startswith(f"{name}: ")]
    return [replace(each, check=each.check.removeprefix(name).removeprefix(": ") or "scans") for each in selected]
