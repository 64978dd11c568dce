"""A session's versions in order, whatever the news do; and cut off in every way that a test can make."""

import asyncio
import contextlib
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from tests.support.replicas import Replica, replicas
from tests.support.routers import Router, router
from tests.support.serving import data_scenario
from tests.support.waiting import wait_for
from tests.voa_client.blocking import blocking
from tests.voa_client.stepping import Service
from tests.voa_client.test_attempts import problem
from voa_client import AsyncClient, Client, NotFoundError, Retries, UnavailableError, UnreachableError, UsageError
from voa_client._attempts import TIMEOUT_S
from voa_client._errors import refusal
from voa_client._transport import Lost
from voa_client.local import running
from voa_msgs.problems import Problem
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import BeliefRequest, Session, SessionRequest

MOVE = BeliefRequest(belief=[0.2, 0.3, 0.5])
SECONDS = 30.0
Connect = Callable[..., AbstractContextManager[Client]]


def json_problem(kind: str, status: int) -> Problem:
    return Problem.model_validate_json(problem(kind, status).body)


def test_what_is_lost_is_waited_for_longer_each_time_until_something_comes() -> None:
    service = Service(0)
    following = service.following()
    gone = Lost(UnreachableError("gone"))
    assert [following.lost(gone) for _ in range(3)] == [0.1, 0.2, 0.4]
    service.follow(following, [])
    assert following.lost(gone) == 0.1
    assert following.lost(Lost(UnavailableError(json_problem("not-ready", 503)))) == 0.2


def test_a_session_that_no_longer_exists_has_ended() -> None:
    missing = Lost(refusal(json_problem("not-found", 404)))
    service = Service(0)
    following = service.following()
    with pytest.raises(NotFoundError):
        following.lost(missing)
    service.follow(following, [])
    following.lost(missing)
    assert following.is_over


def test_a_service_that_was_never_there_is_waited_for_as_long_as_a_call() -> None:
    service = Service(0)
    gone = Lost(UnreachableError("gone"))
    following = service.following()
    following.lost(gone)
    service.now = TIMEOUT_S
    with pytest.raises(UnreachableError):
        following.lost(gone)
    service.follow(following, [])
    service.now = 1e6
    following.lost(gone)


def test_the_end_bounds_every_wait() -> None:
    service = Service(0)
    following = service.following(for_s=0.15)
    assert (following.within(None), following.within(3.0), following.within(0.1)) == (0.15, 0.15, 0.1)
    service.follow(following, [])
    gone = Lost(UnreachableError("gone"))
    assert [following.lost(gone), following.lost(gone)] == [0.1, 0.15]
    service.now = 0.2
    assert following.is_over
    assert (following.within(None), following.lost(gone)) == (0.0, 0.0)
    assert Service().following().within(None) is None


class Follower(threading.Thread):
    """Follows in a thread of its own."""

    def __init__(self, client: Client, session: str) -> None:
        super().__init__(daemon=True)
        self.client, self.session = client, session
        self.versions: list[int] = []
        self.failed: Exception | None = None

    def run(self) -> None:
        try:
            for followed in self.client.follow(self.session):
                self.versions.append(followed.version or 0)
        except Exception as error:
            self.failed = error

    def sees(self, version: int) -> None:
        wait_for(lambda: self.failed or self.versions[-1:] == [version], f"version {version}", SECONDS)
        assert self.failed is None
        assert self.versions == sorted(set(self.versions))

    def ends(self) -> None:
        self.join(SECONDS)
        assert not self.is_alive()
        assert self.failed is None


def opened(client: Client) -> Session:
    scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
    return client.create_session(SessionRequest(scenario=scenario.id))


@pytest.fixture
def replica(tmp_path: Path) -> Iterator[Replica]:
    with replicas(f"sqlite:///{tmp_path / 'voa.db'}", tmp_path) as (own,):
        yield own


@pytest.mark.parametrize("connect", [Client, blocking])
def test_over_http_calls_and_followers_outlive_the_service(replica: Replica, connect: Connect) -> None:
    with Client(replica.url, attempt_s=2.0) as client, connect(replica.url) as apart:
        session = opened(client)
        follower = Follower(apart, session.id)
        follower.start()
        follower.sees(0)
        client.put_belief(session.id, MOVE)
        follower.sees(1)
        replica.kill()
        starting = threading.Timer(0.2, replica.launch)
        starting.start()
        assert client.put_belief(session.id, MOVE, key="through it all").version == 2
        starting.join()
        follower.sees(2)
        assert client.put_belief(session.id, MOVE, key="through it all").version == 2
        client.delete_session(session.id)
        follower.ends()
    assert follower.versions == [0, 1, 2]


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Router, str]]:
    folder: Path = tmp_path_factory.mktemp("lab")
    with router() as own:
        options = ["--database-url", f"sqlite:///{folder / 'voa.db'}", "--zenoh", own.endpoint]
        with running("voa_service", options, folder / "log") as service:
            yield own, service.url


@pytest.mark.parametrize("connect", [Client, blocking])
def test_over_zenoh_calls_and_followers_outlive_the_router(lab: tuple[Router, str], connect: Connect) -> None:
    own, url = lab
    with Client(url) as beside, Client(own.endpoint) as client, connect(own.endpoint) as apart:
        session = opened(client)
        follower = Follower(apart, session.id)
        follower.start()
        follower.sees(0)
        own.kill()
        for version in (1, 2):  # what is put now, nobody hears
            assert beside.put_belief(session.id, MOVE).version == version
        own.start()
        assert client.put_belief(session.id, MOVE).version == 3
        follower.sees(3)
        client.put_belief(session.id, MOVE)
        follower.sees(4)
        client.delete_session(session.id)
        follower.ends()


@pytest.mark.parametrize("connect", [Client, blocking])
@pytest.mark.parametrize("address", ["http://127.0.0.1:1", "tcp/127.0.0.1:1"])
def test_a_follower_of_no_service_raises_an_error(address: str, connect: Connect) -> None:
    with connect(address, timeout_s=0.4, attempt_s=0.2) as client, pytest.raises(UnreachableError):
        next(client.follow("s"))
    with connect(address, retries=Retries(first_s=0.01)) as client, pytest.raises(UnreachableError):
        list(client.follow("s", for_s=0.3))


def test_a_follower_that_leaves_takes_its_thread_along(replica: Replica) -> None:
    with Client(replica.url) as client:
        session = opened(client)
        for _ in range(3):
            with contextlib.closing(client.follow(session.id)) as sessions:
                assert next(sessions).version == 0
                assert "voa-events" in [thread.name for thread in threading.enumerate()]
            assert "voa-events" not in [thread.name for thread in threading.enumerate()]


@pytest.mark.parametrize("transport", ["http", "zenoh"])
def test_a_follower_whose_client_is_closed_raises_an_error(lab: tuple[Router, str], transport: str) -> None:
    own, url = lab
    with Client(url) as beside:
        session = opened(beside)
        with Client(url if transport == "http" else own.endpoint) as client:
            follower = Follower(client, session.id)
            follower.start()
            follower.sees(0)
        follower.join(SECONDS)
    assert not follower.is_alive()
    assert isinstance(follower.failed, UsageError)
    assert "closed" in str(follower.failed)


@pytest.mark.parametrize("transport", ["http", "zenoh"])
def test_so_is_one_within_an_event_loop(lab: tuple[Router, str], transport: str) -> None:
    own, url = lab

    async def follow(client: AsyncClient, session: str, received: asyncio.Event) -> None:
        async for _ in client.follow(session):
            received.set()

    async def main(session: str) -> None:
        received = asyncio.Event()
        async with AsyncClient(url if transport == "http" else own.endpoint) as client:
            following = asyncio.create_task(follow(client, session, received))
            await asyncio.wait_for(received.wait(), SECONDS)
        with pytest.raises(UsageError, match="closed"):
            await asyncio.wait_for(following, SECONDS)

    with Client(url) as beside:
        asyncio.run(main(opened(beside).id))
