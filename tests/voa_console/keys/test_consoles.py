"""Each key has one console, with a client that is open for as long as a browser uses the key."""

import asyncio

import pytest

from tests.support.api_keys import key_for
from tests.support.serving import Service
from tests.voa_console.keys.doors import Bench, Line, run


@pytest.fixture(scope="module")
def sessions(service: Service, data_id: str) -> tuple[str, str]:
    """Two sessions of a service that needs keys from now on."""
    opened = service.open(data_id), service.open(data_id)
    key_for(service, "operator")
    return opened


def test_two_keys_share_no_client_and_no_hub_and_two_browsers_with_one_key_share_both(
    service: Service, sessions: tuple[str, str]
) -> None:
    viewer, arm = key_for(service, "viewer", sessions=sessions[:1]), key_for(service, "arm")

    async def story(bench: Bench) -> None:
        secrets = [await bench.access.enter(key, None) for key in (viewer, arm, viewer)]
        consoles = [await bench.console(secret) for secret in secrets]
        assert consoles[0] is consoles[2]
        assert consoles[0].hub is not consoles[1].hub
        assert consoles[0].client is not consoles[1].client
        assert consoles[0].part(id) == consoles[2].part(id)
        assert consoles[0].part(id) != consoles[1].part(id)
        assert bench.access.consoles.own not in consoles
        assert consoles[0].may_see_session(sessions[0])
        assert not consoles[0].may_see_session(sessions[1])
        assert consoles[1].may_see_session(sessions[1])

    run(service, story)


def test_a_key_whose_last_visit_ends_while_another_one_begins_has_an_open_client(
    service: Service, sessions: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    key = key_for(service, "viewer")

    async def story(bench: Bench) -> None:
        first = await bench.access.enter(key, None)
        assert first is not None
        before = await bench.console(first)
        close = Line.close

        async def close_after_the_first_visit(line: Line) -> None:
            monkeypatch.setattr(Line, "close", close)
            bench.access.leave(first)
            await asyncio.gather(*(task for task in bench.access._tasks if task.get_name() == "voa-console-close"))
            await close(line)

        monkeypatch.setattr(Line, "close", close_after_the_first_visit)
        second = await bench.access.enter(key, None)
        assert await bench.console(second) is not before
        assert [line.is_closed for line in bench.lines.made] == [False, True, True, False]
        bench.now = 10.0
        await bench.console(second)

    run(service, story)
