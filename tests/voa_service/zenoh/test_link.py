"""The link to a router, with a real one: when it counts as connected, and what a start waits for."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import zenoh

from tests.support.routers import router
from tests.support.waiting import wait_for
from voa_service.runtime.metrics import Metrics
from voa_service.settings import ZenohSettings
from voa_service.usecases.health import Link
from voa_service.zenoh.link import ZenohLink

NO_ROUTER = "tcp/127.0.0.1:1"


def state_of(link: Link) -> str:
    """State of a link now; mypy takes an attribute that was compared for constant."""
    return link.state


def test_the_link_is_connected_once_every_part_has_made_its_declarations() -> None:
    entered, may_declare, link = threading.Event(), threading.Event(), Link()

    @contextmanager
    def slow(_: zenoh.Session) -> Iterator[None]:
        entered.set()
        assert may_declare.wait(60.0)
        yield

    with router() as own:
        joining = ZenohLink(ZenohSettings(connect=[own.endpoint]), link, Metrics(), [slow])
        try:
            assert entered.wait(60.0)
            joining.wait_for_first_try(0.0)
            assert state_of(link) == "connecting", "a message that is published now passes the service by"
            may_declare.set()
            joining.wait_for_first_try(60.0)
            assert state_of(link) == "connected"
            own.kill()
            wait_for(lambda: state_of(link) == "connecting", "the loss of the router")
        finally:
            joining.close()
    assert state_of(link) == "off"


def test_a_start_waits_for_no_router_that_does_not_answer() -> None:
    link = Link()
    joining = ZenohLink(ZenohSettings(connect=[NO_ROUTER]), link, Metrics(), [])
    try:
        joining.wait_for_first_try(60.0)
        assert state_of(link) == "connecting"
    finally:
        joining.close()
