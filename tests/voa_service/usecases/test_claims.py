"""Claims of mapped robots: for sessions on the scenario of the mapping alone, and durable."""

from datetime import UTC, datetime

import pytest

from tests.support.quiet_robot import QuietRobot
from tests.support.serving import Service, data_scenario
from voa_service.failures import ClaimConflict, InvalidRequest, NotFound, UnknownReference
from voa_service.usecases.claims import Claims
from voa_service.usecases.robots import Robots


@pytest.fixture
def claims(service: Service, data_id: str) -> Claims:
    """Claims of two robots: one is mapped to the data scenario, the other to a fixed session."""
    store = service.inside.sessions.store
    robots = Robots(lambda: datetime(2026, 1, 2, tzinfo=UTC), store.robot_session)
    robots.mapped("free", "free/scan", QuietRobot(), scenario=data_id)
    robots.mapped("fixed", "fixed/scan", QuietRobot(), session="S")
    return Claims(store, robots)


def test_a_robot_stays_with_the_session_that_claimed_it_until_the_next_claim(
    claims: Claims, service: Service, data_id: str
) -> None:
    first, second = service.open(data_id), service.open(data_id)
    assert claims.peek("free", data_id) == second, "the newest session on its scenario"
    claims.claim("free", first)
    service.open(data_id)
    assert claims.peek("free", data_id) == claims.settle("free", data_id) == first
    claims.claim("free", second)
    assert claims.peek("free", data_id) == second
    claims.claim("free", None)
    assert claims.peek("free", data_id) is claims.settle("free", data_id) is None


def test_looking_up_a_session_claims_nothing_and_settling_does(claims: Claims, service: Service) -> None:
    scenario = service.create(data_scenario(name="settled"))
    first = service.open(scenario)
    assert claims.peek("other", scenario) == first
    second = service.open(scenario)
    assert claims.settle("other", scenario) == second
    service.open(scenario)
    assert claims.peek("other", scenario) == second


def test_claims_that_no_mapping_allows_are_refused(claims: Claims, service: Service, data_id: str) -> None:
    elsewhere = service.open(service.create(data_scenario(name="elsewhere")))
    with pytest.raises(NotFound, match="the mapped robots are 'fixed', 'free'") as refused:
        claims.claim("nobody", None)
    assert refused.value.more == {"known": ["fixed", "free"]}
    with pytest.raises(ClaimConflict, match=r"names a fixed session \('S'\)"):
        claims.claim("fixed", None)
    with pytest.raises(ClaimConflict, match="is mapped to scenario"):
        claims.claim("free", elsewhere)
    with pytest.raises(UnknownReference, match="there is no session 'nothing'"):
        claims.claim("free", "nothing")


def test_a_new_session_can_claim_robots_that_are_mapped_to_its_scenario(claims: Claims, data_id: str) -> None:
    claims.check([], data_id)
    claims.check(["free"], data_id)
    with pytest.raises(InvalidRequest, match="got 'free' 2 times"):
        claims.check(["free", "free"], data_id)
    with pytest.raises(UnknownReference, match=r"^body\.robots: there is no mapped robot 'nobody'"):
        claims.check(["free", "nobody"], data_id)
    with pytest.raises(ClaimConflict, match="names a fixed session"):
        claims.check(["fixed"], data_id)
    with pytest.raises(ClaimConflict, match="the session is on scenario 'another'"):
        claims.check(["free"], "another")


def test_a_process_without_robots_names_the_option_that_maps_them(service: Service) -> None:
    with pytest.raises(NotFound, match="voa serve --robots FILE"):
        service.inside.claims.claim("free", None)
