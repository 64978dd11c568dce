"""A session that cannot be followed says why."""

import asyncio

from tests.support.api_keys import key_for
from tests.support.serving import Service
from voa_client import ApiKey, AsyncClient, AsyncInProcessTransport, DeniedError, UnreachableError
from voa_client._errors import refusal
from voa_console.watching.hub import Hub
from voa_console.watching.watched import pause_after
from voa_msgs.problems import Problem
from voa_service.rpc.entry import Rpc


def test_a_session_that_the_key_is_not_for_is_not_followed(service: Service, data_id: str) -> None:
    session, other = service.open(data_id), service.open(data_id)
    key = ApiKey(key_for(service, "viewer", sessions=(other,)))

    async def story() -> None:
        client = AsyncClient(AsyncInProcessTransport(Rpc(service.inside), key))
        hub = Hub(client)
        changed = asyncio.Event()
        watched, allowed = hub.watch(session), hub.watch(other)
        leaves = [watched.subscribe(changed.set), allowed.subscribe(lambda: None)]
        async with asyncio.timeout(20.0):
            await changed.wait()
            assert await allowed.ready()
        assert isinstance(watched.error, DeniedError)
        assert "is not for session" in str(watched.error)
        assert (watched.session, watched.ended) == (None, False)
        assert (allowed.error, allowed.ended) == (None, False)
        for leave in leaves:
            leave()

    asyncio.run(story())


def test_a_session_that_the_key_may_not_see_is_requested_less_often() -> None:
    denied = refusal(Problem(type="urn:voa:problem:forbidden", title="Denied", status=403, detail="denied"))
    assert pause_after(denied) > pause_after(UnreachableError("away"))
