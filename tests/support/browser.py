"""A real headless Chromium for the tests of the console, and the processes that it talks to.

One browser serves all tests of a module. A page that logs an error, or requests anything of another host than this
machine, fails its test. Screenshots go to the folder that `VOA_SCREENSHOTS` names, else to pytest's.
"""

import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import urlsplit

from playwright.sync_api import Browser, ConsoleMessage, Page, Request, expect, sync_playwright

from voa_client.local import running

WIDE = (1400, 900)
NARROW = (400, 800)
_HERE = {"127.0.0.1", "localhost", ""}
_FLAGS = [
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-gpu-compositing",
]
_WAIT_MS = 20_000.0
_LOST = re.compile(r"ERR_CONNECTION|ERR_SOCKET|ERR_EMPTY|WebSocket connection to|GPU stall|GL Driver")
"""Messages of Chromium itself about a console that was stopped on purpose, and about drawing without a GPU."""


@dataclass
class Watched:
    """Mistakes of a page that its test did not look for.

    Attributes:
        errors: messages of its console at level error, and exceptions.
        strangers: requests to other hosts than this machine.
    """

    errors: list[str] = field(default_factory=list)
    strangers: list[str] = field(default_factory=list)

    def watch(self, page: Page) -> None:
        """Note the mistakes of a page from now on."""
        page.on("console", self._message)
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("request", self._request)

    def check(self) -> None:
        """Fail if there was a mistake."""
        assert not self.errors, self.errors
        assert not self.strangers, self.strangers

    def _message(self, message: ConsoleMessage) -> None:
        if message.type == "error" and not _LOST.search(message.text):
            self.errors.append(message.text)

    def _request(self, request: Request) -> None:
        url = urlsplit(request.url)
        if url.scheme in ("http", "https", "ws", "wss") and url.hostname not in _HERE:
            self.strangers.append(request.url)


def chromium() -> str:
    """Return the path of Chromium, which `make test` installs."""
    path = shutil.which("chromium")
    assert path, "the tests of the console need Chromium; on Debian: apt-get install chromium"
    return path


@contextmanager
def headless() -> Iterator[Browser]:
    """Run a headless Chromium for the length of a `with`."""
    expect.set_options(timeout=_WAIT_MS)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), args=_FLAGS)
        yield browser
        browser.close()


@contextmanager
def opened(browser: Browser, size: tuple[int, int] = WIDE, *, dark: bool = False) -> Iterator[Page]:
    """Open an empty page in a profile of its own; fails at the end if the page made a mistake."""
    watched = Watched()
    with browser.new_context(
        viewport={"width": size[0], "height": size[1]}, color_scheme="dark" if dark else "light"
    ) as context:
        context.set_default_timeout(_WAIT_MS)
        page = context.new_page()
        watched.watch(page)
        yield page
    watched.check()


def picture(page: Page, name: str, folder: Path) -> Path:
    """Take a screenshot of a page as NAME.png, in the folder that `VOA_SCREENSHOTS` names or in `folder`."""
    path = Path(os.environ.get("VOA_SCREENSHOTS", "") or folder) / f"{name}.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=path)
    return path


@contextmanager
def console_of(service_url: str, folder: Path) -> Iterator[str]:
    """Run a console for the service at an address, in a process of its own; gives its URL."""
    with running("voa_console", ["--url", service_url], folder / "console.log", ready="/livez") as process:
        yield process.url
