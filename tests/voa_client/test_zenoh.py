"""The Zenoh transport against queryables that do what services should not, and routers that come, go and freeze."""

import json
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import pytest
import zenoh

from tests.support.routers import Router, router
from tests.voa_client.blocking import blocking
from tests.voa_client.test_attempts import SESSION, problem
from voa_client import Client, OverloadedError, Retries, TimedOutError, UnreachableError, UsageError, WireVersionError
from voa_client._zenoh_address import ZenohAddress
from voa_client._zenoh_link import config
from voa_msgs.keys import Attachment
from voa_msgs.links import session_config
from voa_msgs.sessions import BeliefRequest

ROOT = "voa/v1/lab7"
Connect = Callable[..., AbstractContextManager[Client]]
ONCE = Retries(within_s=0.0)
JSON = zenoh.Encoding.APPLICATION_JSON


@pytest.fixture(scope="module")
def own() -> Iterator[Router]:
    with router() as running:
        yield running


@pytest.fixture(params=[Client, blocking])
def connect(request: pytest.FixtureRequest, own: Router) -> Connect:
    def connected(**more: object) -> AbstractContextManager[Client]:
        client: AbstractContextManager[Client] = request.param(f"zenoh://127.0.0.1:{own.port}/{ROOT}", **more)
        return client

    return connected


@contextmanager
def answering(own: Router, answer: Callable[[zenoh.Query], object]) -> Iterator[None]:
    """A service with one answer to everything; what it holds on to is dropped at the end."""
    given = zenoh.Config()
    for name, value in session_config([own.endpoint]).items():
        given.insert_json5(name, json.dumps(value))
    with (
        zenoh.open(given) as session,
        session.declare_queryable(f"{ROOT}/rpc/*", zenoh.handlers.Callback(answer, indirect=False), complete=True),
    ):
        yield


def dropped(query: Any) -> None:
    """Zenoh's stub leaves the method untyped."""
    query.drop()


def test_attempts_share_key_and_body_and_say_what_is_spoken(own: Router, connect: Connect) -> None:
    received: list[tuple[str, bytes, Attachment]] = []

    def answer(query: zenoh.Query) -> None:
        with query:
            assert query.payload is not None
            assert query.attachment is not None
            attachment = Attachment.model_validate_json(query.attachment.to_bytes())
            received.append((str(query.key_expr), query.payload.to_bytes(), attachment))
            if len(received) == 1:
                query.reply_err(problem("overloaded", 503).body, encoding=JSON)
            elif len(received) == 3:
                query.reply(query.key_expr, SESSION.body, encoding=JSON, attachment=b'{"wire": 1, "version": 1}')

    with answering(own, answer), connect(keys=lambda: "the key") as client:
        assert client.put_belief("s", BeliefRequest(belief=None)).version == 1
    assert {key for key, _, _ in received} == {f"{ROOT}/rpc/belief.put"}
    assert {payload for _, payload, _ in received} == {b'{"belief":null,"session":"s"}'}
    assert {(attached.id, attached.wire) for *_, attached in received} == {("the key", 1)}
    assert len(received) == 3


def test_nobody_there_is_unreachable(connect: Connect) -> None:
    with connect(retries=ONCE) as client, pytest.raises(UnreachableError, match=r"voa/v1/lab7/rpc/service\.health"):
        client.ready()


def test_a_query_that_is_dropped_is_unreachable_and_one_that_is_kept_times_out(own: Router, connect: Connect) -> None:
    with (
        answering(own, dropped),
        connect(retries=ONCE) as client,
        pytest.raises(UnreachableError, match="no answer at"),
    ):
        client.ready()
    kept: list[zenoh.Query] = []
    began = time.monotonic()
    with answering(own, kept.append), connect(retries=ONCE, attempt_s=0.3) as client:
        with pytest.raises(TimedOutError):
            client.ready()
        for query in kept:
            dropped(query)
    assert time.monotonic() - began < 5.0


def test_problems_and_versions_arrive(own: Router, connect: Connect) -> None:
    def overloaded(query: zenoh.Query) -> None:
        with query:
            document = json.loads(problem("overloaded", 503).body) | {"retry_after_s": 2.5}
            query.reply_err(json.dumps(document), encoding=JSON)

    def newer(query: zenoh.Query) -> None:
        with query:
            query.reply(query.key_expr, b"{}", encoding=JSON, attachment=b'{"wire": 2}')

    with answering(own, overloaded), connect(retries=ONCE) as client, pytest.raises(OverloadedError) as refused:
        client.ready()
    assert refused.value.retry_after_s == 2.5
    with answering(own, newer), connect() as client, pytest.raises(WireVersionError, match="update this program"):
        client.ready()


def test_a_frozen_router_costs_no_more_than_the_time_of_the_call(own: Router, connect: Connect) -> None:
    def answer(query: zenoh.Query) -> None:
        with query:
            query.reply(query.key_expr, b'{"status": "ready"}', encoding=JSON)

    with answering(own, answer), connect(timeout_s=2.0, attempt_s=0.5) as client:
        client.ready()
        own.signal(signal.SIGSTOP)
        try:
            began = time.monotonic()
            with pytest.raises(UnreachableError):
                client.ready()
            assert time.monotonic() - began < 4.0
        finally:
            own.signal(signal.SIGCONT)
        assert client.ready().status == "ready"


@pytest.mark.parametrize("connect", [Client, blocking])
def test_a_router_with_passwords_wants_the_right_one(connect: Connect, tmp_path: Path) -> None:
    users = tmp_path / "users"
    users.write_text("arm:s3cret\n", encoding="utf-8")
    secured = {"transport/auth/usrpwd": {"user": "router", "password": "r", "dictionary_file": str(users)}}
    with router(secured) as own:
        good, bad = (f"zenoh://arm:{word}@127.0.0.1:{own.port}" for word in ("s3cret", "wrong"))
        with connect(good, retries=ONCE) as client, pytest.raises(UnreachableError, match="no answer at"):
            client.ready()
        with connect(bad, timeout_s=1.0) as client, pytest.raises(TimedOutError, match="refuses the cred") as refused:
            client.ready()
    assert "wrong" not in str(refused.value)


@pytest.mark.parametrize(
    ("address", "expected"),
    [
        ("tcp/10.0.0.1:7447", ZenohAddress("tcp/10.0.0.1:7447")),
        ("zenoh://lab", ZenohAddress("tcp/lab:7447")),
        ("zenoh://[::1]:9/", ZenohAddress("tcp/[::1]:9")),
        ("zenoh://a%40b:p%2Fw@lab:1/voa/v1/lab7", ZenohAddress("tcp/lab:1", "voa/v1/lab7", "a@b", "p/w")),
        (
            "zenoh+tls://lab:1?ca=/etc/ca.pem&cert=c.pem&key=k.pem",
            ZenohAddress("tls/lab:1", ca="/etc/ca.pem", cert="c.pem", key="k.pem"),
        ),
    ],
)
def test_addresses(address: str, expected: ZenohAddress) -> None:
    assert ZenohAddress.parse(address) == expected


@pytest.mark.parametrize("address", ["zenoh://u:s3cret@lab/a b", "zenoh://u:s3cret@", "zenoh://u:s3cret@lab?x=1"])
def test_a_bad_address_is_reported_without_its_password(address: str) -> None:
    with pytest.raises(UsageError) as refused:
        ZenohAddress.parse(address)
    assert "s3cret" not in str(refused.value)


def test_the_configuration_has_the_certificates() -> None:
    built = config(ZenohAddress("tls/lab:1", ca="ca.pem", cert="c.pem", key="k.pem"))
    tls = json.loads(built.get_json("transport/link/tls"))
    assert tls["root_ca_certificate"] == "ca.pem"
    assert (tls["connect_certificate"], tls["connect_private_key"], tls["enable_mtls"]) == ("c.pem", "k.pem", True)
    assert built.get_json("transport/shared_memory/enabled") == "false"
    assert json.loads(config(ZenohAddress("tcp/lab:1")).get_json("transport/link/tls/enable_mtls")) is None
