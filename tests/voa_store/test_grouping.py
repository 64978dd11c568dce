"""Items that wait while others are done make up the next group; each thread returns when its own item is done."""

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import pytest

from tests.support.waiting import wait_for
from voa_store.errors import Busy
from voa_store.grouping import Groups

SECONDS = 60.0


@dataclass(frozen=True)
class Item:
    id: str
    number: int = 0


class Gate:
    """Work that does groups one at a time, and the first of them only when it is let go."""

    def __init__(self, error: Exception | None = None) -> None:
        self.groups: list[list[Item]] = []
        self.entered, self.let_go = threading.Event(), threading.Event()
        self._error = error
        self._at_work = threading.Lock()

    def do(self, group: Sequence[Item]) -> None:
        assert self._at_work.acquire(blocking=False), "two groups at once"
        self.groups.append(list(group))
        self.entered.set()
        assert self.let_go.wait(SECONDS)
        self._at_work.release()
        if self._error is not None:
            raise self._error


def _waits(groups: Groups[Item], count: int) -> bool:
    return len(groups._waiting) == count


def joined(groups: Groups[Item], gate: Gate, waiting: Sequence[Item], pool: ThreadPoolExecutor) -> list["Future[None]"]:
    """Let a first item be at work, and the others wait for it, in this order."""
    futures = [pool.submit(groups.join, Item("first"))]
    assert gate.entered.wait(SECONDS)
    for count, item in enumerate(waiting, 1):
        futures.append(pool.submit(groups.join, item))
        wait_for(partial(_waits, groups, count), "the item to wait")
    return futures


def test_what_waits_is_done_together_and_an_item_alone_waits_for_nobody() -> None:
    gate = Gate()
    groups = Groups[Item](gate.do, 8, SECONDS)
    with ThreadPoolExecutor(4) as pool:
        futures = joined(groups, gate, [Item("a"), Item("b"), Item("c")], pool)
        gate.let_go.set()
        for future in futures:
            future.result(SECONDS)
    assert gate.groups == [[Item("first")], [Item("a"), Item("b"), Item("c")]]


@pytest.mark.parametrize(
    ("waiting", "expected"),
    [
        (["a1", "b1", "a2", "c1", "a3"], [["a1", "b1", "c1"], ["a2"], ["a3"]]),
        (["a1", "b1", "c1", "d1", "e1"], [["a1", "b1", "c1"], ["d1", "e1"]]),
    ],
)
def test_items_of_one_name_keep_their_order_and_a_group_its_size(waiting: list[str], expected: list[list[str]]) -> None:
    gate = Gate()
    groups = Groups[Item](gate.do, 3, SECONDS)
    with ThreadPoolExecutor(8) as pool:
        futures = joined(groups, gate, [Item(text[0], int(text[1])) for text in waiting], pool)
        gate.let_go.set()
        for future in futures:
            future.result(SECONDS)
    assert [[f"{item.id}{item.number}" for item in group] for group in gate.groups[1:]] == expected


def test_an_error_of_a_group_reaches_everybody_in_it_and_the_next_group_is_done() -> None:
    gate = Gate(OSError("broken"))
    groups = Groups[Item](gate.do, 2, SECONDS)
    with ThreadPoolExecutor(4) as pool:
        futures = joined(groups, gate, [Item("a"), Item("b"), Item("c")], pool)
        gate.let_go.set()
        assert [str(future.exception(SECONDS)) for future in futures] == ["broken"] * 4
    assert [len(group) for group in gate.groups] == [1, 2, 1]


def test_an_item_whose_group_does_not_begin_is_given_up_and_never_done() -> None:
    gate = Gate()
    groups = Groups[Item](gate.do, 2, 0.01)
    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(groups.join, Item("first"))
        assert gate.entered.wait(SECONDS)
        with pytest.raises(Busy, match="wait for the database"):
            groups.join(Item("late"))
        gate.let_go.set()
        first.result(SECONDS)
    groups.join(Item("afterwards"))
    assert gate.groups == [[Item("first")], [Item("afterwards")]]


def test_many_threads_each_have_every_item_done_once() -> None:
    done: list[Item] = []
    groups = Groups[Item](done.extend, 5, SECONDS)

    def joining(name: str) -> Callable[[], None]:
        def run() -> None:
            for number in range(200):
                groups.join(Item(name, number))
                assert done[-200 * 8 :].count(Item(name, number)) == 1

        return run

    with ThreadPoolExecutor(8) as pool:
        for future in [pool.submit(joining(f"{index}")) for index in range(8)]:
            future.result(SECONDS)
    for index in range(8):
        assert [item.number for item in done if item.id == str(index)] == list(range(200))
