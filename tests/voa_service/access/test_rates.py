"""Calls per key and time: counted for each key, heavy ones twice, and never for a service without keys."""

import pytest
from structlog.testing import capture_logs

from voa_service.access import rates
from voa_service.access.callers import ANONYMOUS, Caller
from voa_service.access.rates import Rates
from voa_service.access.roles import BY_NAME
from voa_service.failures import TooManyRequests, TooManyWithoutKey
from voa_service.settings import RateSettings

ANNA, BEN = Caller("anna", "operator", "1"), Caller("ben", "viewer", "2")
LIGHT, HEAVY = BY_NAME["session.get"], BY_NAME["voa.rank"]


class Clock:
    """Time that stands still until it is moved."""

    def __init__(self) -> None:
        self.at = 1_000.0

    def monotonic(self) -> float:
        return self.at


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    own = Clock()
    monkeypatch.setattr(rates, "time", own)
    return own


def test_a_call_too_many_is_refused_until_the_time_is_over(clock: Clock) -> None:
    own = Rates("3/minute", "100/minute", "1/minute")
    for _ in range(3):
        own.count(ANNA)
    clock.at += 10.5
    with pytest.raises(TooManyRequests, match="'anna' may make 3 calls per minute: try again in 50 s") as refused:
        own.count(ANNA)
    assert refused.value.headers == {"Retry-After": "50"}
    own.count(BEN)
    clock.at += 49.5
    own.count(ANNA)


def test_heavy_calls_have_a_rate_of_their_own(clock: Clock) -> None:
    own = Rates("10/second", "2/2 minutes", "1/minute")
    own.count_heavy(ANNA, HEAVY)
    own.count_heavy(ANNA, HEAVY)
    with pytest.raises(TooManyRequests, match="2 rankings and other heavy calls per 2 minutes"):
        own.count_heavy(ANNA, HEAVY)
    own.count_heavy(ANNA, LIGHT)


def test_callers_of_a_service_without_keys_are_not_counted() -> None:
    own = Rates("1/hour", "1/hour", "1/hour")
    for _ in range(5):
        own.count(ANONYMOUS)
        own.count_heavy(ANONYMOUS, HEAVY)


def test_lidars_of_5_hz_stay_within_the_defaults(clock: Clock) -> None:
    own = Rates(**RateSettings().model_dump())
    for _ in range(100):
        for _ in range(40):  # as many lidars share a key
            own.count(ANNA)
        clock.at += 0.2


def test_counters_can_be_read_and_removed(clock: Clock) -> None:
    own = rates._Counters()
    assert (own.incr("a", 10), own.incr("a", 10, 2), own.get("a"), own.get("b")) == (1, 3, 3, 0)
    assert (own.get_expiry("a"), own.get_expiry("b")) == (1_010.0, 1_000.0)
    clock.at += 10
    assert (own.get("a"), own.incr("a", 10)) == (0, 1)
    own.clear("a")
    assert (own.get("a"), own.check(), own.incr("c", 1), own.reset(), own.reset()) == (0, True, 1, 1, 0)
    assert own.base_exceptions is ValueError


def test_refusals_are_counted_by_origin_and_logged_once_a_period(clock: Clock) -> None:
    own = Rates("1/hour", "1/hour", "2/minute")
    with capture_logs() as lines:
        for _ in range(2):
            own.count_refused("host")
        for _ in range(3):
            with pytest.raises(TooManyWithoutKey, match="from host") as refused:
                own.count_refused("host")
        assert refused.value.headers == {"Retry-After": "60"}
        own.count_refused("other")
        assert [line["origin"] for line in lines] == ["host"]
        clock.at += 60
        own.count_refused("host")
    assert len(lines) == 1


def test_origins_that_a_stranger_makes_up_take_no_more_memory(clock: Clock) -> None:
    own = Rates("1/hour", "1/hour", "1/minute")
    for number in range(rates._MOST_ORIGINS):
        own.count_refused(f"robot {number}")
    own.count_refused("new")
    with pytest.raises(TooManyWithoutKey, match="came from others"):
        own.count_refused("newer")
    assert len(own._origins._counters) <= rates._MOST_ORIGINS + 1
    clock.at += 60
    own.count_refused("newest")
    assert len(own._origins._counters) == 1


@pytest.mark.parametrize(
    ("origin", "network"),
    [
        ("10.0.0.1", "10.0.0.1"),
        ("fd00:1:2:3:4:5:6:7", "fd00:1:2:3::/64"),
        ("::ffff:10.0.0.1", "10.0.0.1"),
        ("robot tb3_1", "robot tb3_1"),
    ],
)
def test_addresses_of_a_network_of_ipv6_count_together(origin: str, network: str) -> None:
    assert rates.network_of(origin) == network
