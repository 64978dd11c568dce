"""Followers and arms on a bus where anybody may put anything, and new clients after a router's restart."""

import json
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path

import pytest
from zenoh import Encoding

from tests.support.bus import Stranger, stranger
from tests.support.routers import Router, router
from tests.support.serving import data_scenario
from tests.support.waiting import wait_for
from tests.voa_client.blocking import blocking, role_of
from tests.voa_client.test_following import MOVE, SECONDS, Follower, opened
from voa_client import Client, _following
from voa_client.local import running
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import BeliefRequest, SessionRequest

Connect = Callable[..., AbstractContextManager[Client]]
ROUNDS = 3
UNSURE = BeliefRequest(belief=[0.4, 0.3, 0.3])


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Router, str]]:
    folder: Path = tmp_path_factory.mktemp("lab")
    with router() as own:
        options = ["--database-url", f"sqlite:///{folder / 'voa.db'}", "--zenoh", own.endpoint]
        with running("voa_service", options, folder / "log") as service:
            yield own, service.url


def forge(bus: Stranger, session: str, body: dict[str, object]) -> None:
    """Put everything that could mislead whoever follows the session."""
    key, version = bus.keys.belief(session), body["version"]
    for forged in (version, 10**12, -1, None):
        payload = json.dumps(body | {"version": forged, "best_grasp": "forged"})
        for said in (str(forged), "7", "", "9" * 5_000, "²"):
            bus.session.put(key, payload, encoding=Encoding.APPLICATION_JSON, attachment=said.encode())
    for garbage in (b"", b"\0", b"[" * 100_000, json.dumps(body | {"id": "other"}).encode()):
        bus.session.put(key, garbage, attachment=str(version).encode())
        bus.session.put(key, garbage)
    for expression in (key, bus.keys.belief("*"), "**"):
        bus.session.put(expression, b"\0")
        bus.session.delete(expression)


@pytest.mark.parametrize("connect", [Client, blocking])
def test_nothing_that_a_stranger_puts_blinds_or_ends_a_follower_or_an_arm(
    lab: tuple[Router, str], connect: Connect
) -> None:
    own, url = lab
    with ExitStack() as stack:
        beside, apart, armed = (
            stack.enter_context(each) for each in (Client(url), connect(own.endpoint), connect(own.endpoint))
        )
        bus = stack.enter_context(stranger(own.endpoint))
        session = opened(beside)
        follower = Follower(apart, session.id)
        follower.start()
        follower.sees(0)
        reasons: list[str] = []
        arm = role_of(armed, "arm", session.id)
        waiting = threading.Thread(target=lambda: reasons.append(arm.wait_until(0.99).reason), daemon=True)
        waiting.start()
        for version in range(1, ROUNDS + 1):
            forge(bus, session.id, session.model_dump(mode="json") | {"version": version})
            beside.put_belief(session.id, UNSURE)
            follower.sees(version)
        assert reasons == []
        beside.put_belief(session.id, BeliefRequest(belief=[1.0, 0.0, 0.0]))
        waiting.join(SECONDS)
        assert reasons == ["no_look_pays"]
        follower.sees(ROUNDS + 1)
        beside.delete_session(session.id)
        follower.ends()
    assert follower.versions == list(range(ROUNDS + 2))


def test_after_a_restart_of_the_router_new_clients_get_their_first_answer(lab: tuple[Router, str]) -> None:
    own, url = lab
    with Client(url) as beside:
        scenario = beside.create_scenario(ScenarioRequest.model_validate(data_scenario())).id
        for round_ in range(ROUNDS):
            session = beside.create_session(SessionRequest(scenario=scenario)).id
            own.kill()
            own.start()
            with Client(own.endpoint) as reading, blocking(own.endpoint) as writing:
                assert reading.get_session(session).version == 0
                assert writing.put_belief(session, MOVE, key=f"round {round_}").version == 1
                assert next(reading.follow(session)).version == 1
            assert [entry.version for entry in beside.history(session)] == [0, 1]


def test_a_session_that_is_moved_quickly_is_followed_version_by_version(
    lab: tuple[Router, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    own, url = lab
    with Client(url) as beside, Client(own.endpoint) as apart:
        session = opened(beside)
        follower = Follower(apart, session.id)
        follower.start()
        follower.sees(0)

        def is_followed() -> bool:
            beside.put_belief(session.id, MOVE)
            return follower.versions[-1] != 0

        wait_for(is_followed, "the service to know of the follower", SECONDS)  # samples before that go to nobody
        first = beside.get_session(session.id).version or 0
        wait_for(lambda: follower.versions[-1] == first, "the newest version", SECONDS)
        monkeypatch.setattr(_following, "GRACE_S", SECONDS)  # on a busy machine a sample may take longer than usual
        for _ in range(40):
            beside.put_belief(session.id, MOVE)
        wait_for(lambda: follower.versions[-1] == first + 40, "the newest version", SECONDS)
        beside.delete_session(session.id)
        follower.ends()
    assert follower.versions[-41:] == list(range(first, first + 41))
    assert follower.versions == sorted(set(follower.versions)), "a version twice, or before an older one"
