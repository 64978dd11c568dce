"""The real service, reached in every way that there is."""

from collections.abc import Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.support.routers import Router, router
from tests.support.serving import Service, box_obj, data_scenario, serving
from tests.voa_client.blocking import blocking
from voa_client import Client
from voa_client._in_process import AsyncInProcessTransport, InProcessTransport
from voa_client.local import running
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import SessionRequest
from voa_service.rpc.entry import Rpc


@dataclass(frozen=True)
class Everywhere:
    """Two services: one at a URL and behind a router, and one in this process."""

    url: str
    router: Router
    inside: Rpc

    def client(self, way: str) -> AbstractContextManager[Client]:
        """A client by transport and colour, as in "zenoh async"."""
        transport, colour = way.split()
        if transport == "in-process":
            if colour == "sync":
                return Client(InProcessTransport(self.inside))
            return blocking(AsyncInProcessTransport(self.inside))
        address = self.url if transport == "http" else f"zenoh://127.0.0.1:{self.router.port}"
        return Client(address) if colour == "sync" else blocking(address)


@pytest.fixture(scope="module")
def everywhere(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Everywhere]:
    folder: Path = tmp_path_factory.mktemp("everywhere")
    inside: Service
    with router() as own, serving(folder) as inside:
        options = ["--database-url", f"sqlite:///{folder / 'other.db'}", "--zenoh", own.endpoint]
        with running("voa_service", options, folder / "log") as service:
            yield Everywhere(service.url, own, Rpc(inside.inside))


WAYS = [f"{transport} {colour}" for transport in ("http", "zenoh", "in-process") for colour in ("sync", "async")]


@pytest.fixture(scope="module", params=WAYS)
def way(request: pytest.FixtureRequest) -> str:
    result: str = request.param
    return result


@pytest.fixture(scope="module")
def client(everywhere: Everywhere, way: str) -> Iterator[Client]:
    with everywhere.client(way) as own:
        yield own


@pytest.fixture(scope="module")
def other(everywhere: Everywhere, way: str) -> Iterator[Client]:
    """A second client of the service that `client` calls."""
    with everywhere.client(f"{way.split(maxsplit=1)[0]} sync") as own:
        yield own


@pytest.fixture(scope="module")
def scenario(client: Client) -> str:
    return client.create_scenario(ScenarioRequest.model_validate(data_scenario())).id


@pytest.fixture
def session(client: Client, scenario: str) -> str:
    return client.create_session(SessionRequest(scenario=scenario)).id


@pytest.fixture
def box(tmp_path: Path) -> Path:
    path = tmp_path / "box.obj"
    path.write_text(box_obj(), encoding="utf-8")
    return path
