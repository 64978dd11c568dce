"""Console without pages of NiceGUI, over a service in this process: its page names the key by which it was admitted."""

import asyncio
from collections.abc import AsyncIterator, Callable, Coroutine, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass
from typing import Any

from fastapi import FastAPI, Request
from starlette.responses import PlainTextResponse
from starlette.testclient import TestClient

from tests.support.serving import Service
from tests.support.waiting import SECONDS
from voa_client import ApiKey, AsyncClient, AsyncInProcessTransport, Retries, VoaClientError
from voa_console.context import Console
from voa_console.keys.access import Access, Admitted
from voa_console.keys.admission import Admission, admitted_of
from voa_console.keys.forms import serve_forms
from voa_console.settings import ConsoleSettings
from voa_service.rpc.entry import Rpc

QUICK = Retries(first_s=0.01, most_s=0.02, within_s=0.05)
URL = "http://service"
NONSENSE = "voa_000000000000_" + "0" * 64
"""Text in the form of a key that no service has made."""


class Line(AsyncInProcessTransport):
    """Transport whose calls fail with `error`, or are not answered, if a test wants it; notes when it is closed."""

    def __init__(self, service: Service, key: ApiKey) -> None:
        super().__init__(Rpc(service.inside), key)
        self.error: VoaClientError | None = None
        self.hangs = self.is_closed = False

    async def send(self, call: Any, key: str | None, seconds: float) -> Any:
        if self.hangs:
            await asyncio.Event().wait()
        if self.error is not None:
            raise self.error
        return await super().send(call, key, seconds)

    async def close(self) -> None:
        self.is_closed = True


class Lines:
    """Clients of a service by key, as a console makes them."""

    def __init__(self, service: Service, own: str | None = None) -> None:
        self._service = service
        self._own = own
        self.made: list[Line] = []

    def connect(self, key: str | None) -> AsyncClient:
        line = Line(self._service, ApiKey(self._own if key is None else key))
        self.made.append(line)
        return AsyncClient(line, retries=QUICK)


@dataclass(frozen=True)
class Doors:
    """Console that a browser reaches by `http`."""

    http: TestClient
    access: Access
    lines: Lines

    def enter(self, key: str, to: str = "/") -> str:
        """Send the form with a key; return where it leads."""
        answer = self.http.post("/key", data={"key": key, "to": to})
        assert answer.status_code == 303, answer.text
        return answer.headers["location"]

    def caller(self) -> str:
        """Name of the key by which the page is admitted, or where the page leads."""
        answer = self.http.get("/")
        return answer.text if answer.status_code == 200 else answer.headers["location"]

    def notice(self, address: str) -> str:
        """Sentence that the page of the key shows at an address."""
        return self.access.notices.get(address.partition("notice=")[2])


@contextmanager
def doors(service: Service, own: str | None = None) -> Iterator[Doors]:
    """Open a console whose own key is `own`; None: it has none."""
    lines = Lines(service, own)
    settings = ConsoleSettings(URL)
    access = Access(settings, lines.connect, identify_s=SECONDS)

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        access.start()
        yield
        await access.close()

    app = FastAPI(lifespan=lifespan)

    @app.get("/{path:path}")
    def page(request: Request) -> PlainTextResponse:
        caller = admitted_of(request).console.caller
        return PlainTextResponse("unknown" if caller is None else caller.name)

    serve_forms(app, access)
    app.add_middleware(Admission, access=access)
    with TestClient(app, "http://127.0.0.1:8080", follow_redirects=False) as http:
        yield Doors(http, access, lines)


class Bench:
    """Access to a console without HTTP, with the clients that it has made and a clock that stands still."""

    def __init__(self, service: Service, own: str | None = None) -> None:
        self.now = 0.0
        self.lines = Lines(service, own)
        self.access = Access(ConsoleSettings(URL), self.lines.connect, lambda: self.now, SECONDS)

    def fail(self, error: VoaClientError | None) -> None:
        """Let every call fail from now on; None: none is answered any more."""
        for line in self.lines.made:
            line.error, line.hangs = error, error is None
        if error is None:
            self.access._identify_s = 0.01

    async def console(self, secret: str | None) -> Console:
        """Console by which a browser is admitted."""
        admitted = await self.access.admit(secret)
        assert isinstance(admitted, Admitted), admitted
        return admitted.console


@asynccontextmanager
async def opened(service: Service, own: str | None = None) -> AsyncIterator[Bench]:
    bench = Bench(service, own)
    bench.access.start()
    yield bench
    await bench.access.close()
    assert all(line.is_closed for line in bench.lines.made)


def run(service: Service, story: Callable[[Bench], Coroutine[Any, Any, None]], own: str | None = None) -> None:
    async def whole() -> None:
        async with opened(service, own) as bench:
            await story(bench)

    asyncio.run(whole())
