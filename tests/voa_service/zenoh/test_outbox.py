"""The service publishes versions in order, each once, also after failures."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from typing import Any, cast

import numpy as np
import pytest
import zenoh

from tests.support.waiting import wait_for
from voa_core.filtering import Belief
from voa_msgs.keys import Keys
from voa_msgs.sessions import Session
from voa_service.failures import InvalidRequest
from voa_service.runtime.metrics import Metrics
from voa_service.usecases.health import Link
from voa_service.zenoh import outbox as module
from voa_service.zenoh.outbox import Outbox
from voa_store.records import SessionState

KEYS = Keys()
NOON = datetime(2026, 1, 2, 12, tzinfo=UTC)
REFUSAL = InvalidRequest("expected a scan")


def state(version: int, session: str = "S") -> SessionState:
    belief = Belief(np.array([1.0]), np.array([0.0]))
    return SessionState(session, "A", version, belief, belief, None, NOON, NOON)


def message(state: SessionState) -> Session:
    return Session(
        id=state.id,
        scenario=state.scenario,
        version=state.version,
        poses=["P"],
        belief=[1.0],
        best_grasp=None,
        expected_score=0.0,
        entropy_nats=0.0,
        last_fit_rmsd_mm=None,
        created_at=NOON,
        updated_at=NOON,
    )


class Wire:
    """Keeps what is put, in order; a key that breaks it is lost."""

    def __init__(self, breaks: str = "") -> None:
        self.put_so_far: list[tuple[str, bytes | None]] = []
        self._breaks = breaks

    def put(self, key: str, payload: bytes, *, attachment: bytes | None, **how: Any) -> None:
        if self._breaks and self._breaks in key:
            raise RuntimeError("the session is closed")
        assert payload.startswith(b"{")
        self.put_so_far.append((key, attachment))

    def delete(self, key: str, **how: Any) -> None:
        self.put_so_far.append((key, None))


class Lab:
    """An outbox whose thread starts when everything is waiting in it: it finds one batch."""

    def __init__(self) -> None:
        self.link = Link()
        self.link.state = "connected"
        self.metrics = Metrics()
        self.outbox = Outbox(message, KEYS, self.link, self.metrics)

    def committed(self, *versions: int, session: str = "S") -> None:
        for version in versions:
            self.outbox.committed(session, state(version, session))

    @contextmanager
    def on(self, wire: Wire) -> Iterator[None]:
        with self.outbox.on(cast(zenoh.Session, wire)):
            yield

    def put(self, most: int, wire: Wire | None = None) -> list[tuple[str, bytes | None]]:
        """Publish until `most` messages were put; returns the key and attachment of each."""
        wire = wire or Wire()
        with self.on(wire):
            wait_for(lambda: len(wire.put_so_far) >= most, "what was waiting")
        return wire.put_so_far

    def count(self, event: str) -> int:
        counters = [line for line in self.metrics.text().decode().splitlines() if f'event="{event}"' in line]
        return sum(int(float(line.split()[-1])) for line in counters if line.startswith("voa_zenoh_samples_total"))


@pytest.fixture
def lab() -> Lab:
    return Lab()


def belief_of(session: str) -> str:
    return KEYS.belief(session)


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 11, 2, 10, 9)])
def test_commits_that_arrive_in_another_order_are_put_by_version(lab: Lab, order: tuple[int, ...]) -> None:
    lab.committed(*order)
    assert lab.put(len(order)) == [(belief_of("S"), str(version).encode()) for version in sorted(order)]
    assert lab.count("belief published") == len(order)


def test_the_end_of_a_session_is_put_after_its_versions_and_nothing_after_it(lab: Lab) -> None:
    lab.outbox.committed("S", None)
    lab.committed(2, 1)
    wire = Wire()
    with lab.on(wire):
        wait_for(lambda: len(wire.put_so_far) == 3, "the end")
        lab.committed(3)  # its thread was slow to tell
        lab.committed(0, session="T")
        wait_for(lambda: len(wire.put_so_far) == 4, "another session")
    ended = [(belief_of("S"), b"1"), (belief_of("S"), b"2"), (belief_of("S"), None)]
    assert wire.put_so_far == [*ended, (belief_of("T"), b"0")]


def test_what_cannot_be_put_does_not_hold_up_what_follows(lab: Lab) -> None:
    lab.committed(1, session="broken")
    lab.committed(1, 2)
    assert [attachment for _, attachment in lab.put(2, Wire(breaks="broken"))] == [b"1", b"2"]
    assert (lab.count("belief dropped"), lab.count("belief published")) == (1, 2)


def test_a_refusal_is_put_where_the_robot_listens(lab: Lab) -> None:
    lab.outbox.refused("S", "r1", REFUSAL)
    assert lab.put(1) == [(KEYS.refused("S", "r1"), None)]
    assert lab.count("refusal published") == 1


def fill(lab: Lab) -> None:
    lab.committed(*range(3))


def cut(lab: Lab) -> None:
    lab.link.state = "connecting"


@pytest.mark.parametrize(
    ("before", "most", "counted"), [(fill, 3, "belief dropped"), (cut, 100, "belief dropped without a router")]
)
def test_what_does_not_fit_or_cannot_be_put_is_counted_and_not_kept(
    lab: Lab, before: Callable[[Lab], None], most: int, counted: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_MOST_WAITING", most)
    before(lab)
    lab.committed(3, 4)
    lab.link.state = "connected"
    assert lab.count(counted) == 2
    monkeypatch.setattr(module, "_MOST_WAITING", 100)
    lab.committed(5)
    assert b"3" not in [attachment for _, attachment in lab.put(1)]


def test_what_is_left_at_the_end_is_counted(lab: Lab, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lab.outbox, "_run", lambda session: None)  # a put that hangs
    lab.committed(1, 2)
    with lab.on(Wire()):
        pass
    assert lab.count("belief dropped") == 2
