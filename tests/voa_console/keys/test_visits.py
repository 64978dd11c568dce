"""Visits end when they are not used, and no page of a visit that has ended stays."""

from typing import cast

from voa_console.context import Console
from voa_console.keys.visits import Visits

CONSOLE = cast(Console, "a console")
OTHER = cast(Console, "another console")


class Clock:
    """Clock that stands still until it is set."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def visits(clock: Clock, ended: list[Console], most: int = 10, most_of_key: int = 10) -> Visits:
    return Visits(ended.append, clock, idle_s=100.0, most=most, most_of_key=most_of_key)


def test_a_visit_is_known_by_its_secret_alone() -> None:
    own = visits(Clock(), [])
    secret = own.begin(CONSOLE)
    visit = own.get(secret)
    assert visit is not None
    assert visit.console is CONSOLE
    assert own.get(None) is None
    assert own.get(secret[:-1]) is None
    assert secret not in repr(own.__dict__)
    assert own.begin(CONSOLE) != secret


def test_a_visit_without_a_page_ends_after_a_while_and_with_a_page_it_stays() -> None:
    clock, ended = Clock(), list[Console]()
    own = visits(clock, ended)
    left, stayed = own.begin(CONSOLE), own.begin(OTHER)
    visit = own.get(stayed)
    assert visit is not None
    close = own.open_page(visit, lambda: None)
    clock.now = 101.0
    own.end_idle()
    assert ended == [CONSOLE]
    assert own.get(left) is None
    close()
    clock.now = 200.0
    assert own.get(stayed) is visit, "it counts as used while its page was open"
    clock.now = 301.0
    assert own.get(stayed) is None


def test_pages_leave_when_their_visit_ends() -> None:
    clock, ended, left = Clock(), list[Console](), list[str]()
    own = visits(clock, ended)
    secret = own.begin(CONSOLE)
    visit = own.get(secret)
    assert visit is not None
    close = own.open_page(visit, lambda: left.append("closed before"))
    own.open_page(visit, lambda: left.append("open"))
    close()
    close()
    assert own.is_visited(CONSOLE)
    own.end(secret)
    own.end(secret)
    assert (left, ended) == (["open"], [CONSOLE])
    assert not own.is_visited(CONSOLE)
    own.open_page(visit, lambda: left.append("opened too late"))
    assert left == ["open", "opened too late"]


def test_beyond_the_most_visits_the_one_that_waits_for_the_longest_time_ends() -> None:
    clock, ended = Clock(), list[Console]()
    own = visits(clock, ended, most=2)
    first = own.begin(CONSOLE)
    clock.now = 1.0
    second = own.begin(OTHER)
    clock.now = 2.0
    own.get(first)
    third = own.begin(CONSOLE)
    assert [own.get(each) is None for each in (first, second, third)] == [False, True, False]
    assert ended == [OTHER]


def test_visits_of_a_key_make_room_for_each_other_and_end_none_of_another_key() -> None:
    clock, ended = Clock(), list[Console]()
    own = visits(clock, ended, most=4, most_of_key=2)
    others = [own.begin(OTHER), own.begin(OTHER)]
    secrets = []
    for _ in range(5):
        clock.now += 1.0
        secrets.append(own.begin(CONSOLE))
    assert [own.get(each) is None for each in secrets] == [True, True, True, False, False]
    assert all(own.get(each) is not None for each in others)
    assert ended == [CONSOLE] * 3


def test_visits_without_an_open_page_make_room_first() -> None:
    clock, left = Clock(), list[str]()
    own = visits(clock, [], most=3, most_of_key=2)
    secrets = [own.begin(CONSOLE)]
    visit = own.get(secrets[0])
    assert visit is not None
    own.open_page(visit, lambda: left.append("opened first"))
    for console in (CONSOLE, CONSOLE, OTHER, cast(Console, "a third console")):
        clock.now += 1.0
        secrets.append(own.begin(console))
    assert [own.get(each) is None for each in secrets] == [False, True, True, False, False]
    assert left == []
