"""Samples in order for each sender, side by side for several, never without bound."""

import threading
from collections.abc import Iterator

import pytest

from tests.support.waiting import wait_for
from voa_service.zenoh.mailboxes import Mailboxes


class Worker:
    """Work that is let through one at a time, by name."""

    def __init__(self) -> None:
        self.done: list[tuple[str, int]] = []
        self.gates = {name: threading.Semaphore(0) for name in "ab"}

    def __call__(self, item: tuple[str, int]) -> None:
        assert self.gates[item[0]].acquire(timeout=30)
        self.done.append(item)


@pytest.fixture
def worker() -> Worker:
    return Worker()


@pytest.fixture
def boxes(worker: Worker) -> Iterator[Mailboxes[tuple[str, int]]]:
    own = Mailboxes(worker, workers=2, most_items=20, most_bytes=100)
    yield own
    for gate in worker.gates.values():
        gate.release(100)
    own.close()


def test_one_sender_is_served_in_order_and_does_not_hold_up_another(
    worker: Worker, boxes: Mailboxes[tuple[str, int]]
) -> None:
    for number in range(3):
        assert boxes.put("a", ("a", number), 1)
    assert boxes.put("b", ("b", 0), 1)
    worker.gates["b"].release()
    wait_for(lambda: worker.done == [("b", 0)], "the other sender")
    worker.gates["a"].release(3)
    wait_for(lambda: boxes.waiting == 0, "the first sender")
    assert worker.done[1:] == [("a", 0), ("a", 1), ("a", 2)]


def test_what_does_not_fit_is_refused_and_room_is_made_again(worker: Worker, boxes: Mailboxes[tuple[str, int]]) -> None:
    assert not boxes.put("a", ("a", 99), 101)
    assert all(boxes.put("a", ("a", number), 1) for number in range(5))
    assert not boxes.put("a", ("a", 5), 1), "a quarter is this box's share"
    assert boxes.put("b", ("b", 0), 20)
    assert boxes.put("b", ("b", 1), 20)
    assert not boxes.put("b", ("b", 2), 20), "by bytes too"
    for gate in worker.gates.values():
        gate.release(10)
    assert boxes.drain(30.0) == 0
    assert boxes.put("a", ("a", 6), 50)


def test_draining_says_what_is_left(worker: Worker, boxes: Mailboxes[tuple[str, int]]) -> None:
    assert boxes.put("a", ("a", 0), 1)
    assert boxes.put("a", ("a", 1), 1)
    assert boxes.drain(0.01) == 2
    worker.gates["a"].release(2)
    assert boxes.drain(30.0) == 0


def test_closing_drops_what_waits_and_takes_nothing_more(worker: Worker) -> None:
    own: Mailboxes[tuple[str, int]] = Mailboxes(worker, workers=1, most_items=10, most_bytes=100)
    assert own.put("a", ("a", 0), 1)
    assert own.put("a", ("a", 1), 1)
    worker.gates["a"].release(1)
    wait_for(lambda: worker.done == [("a", 0)], "the first")
    closing = threading.Thread(target=own.close)
    closing.start()
    worker.gates["a"].release(1)
    closing.join(30)
    assert not closing.is_alive()
    assert not own.put("a", ("a", 2), 1)
    assert len(worker.done) <= 2
