"""Attacks over Zenoh on whoever follows a session: anybody on a router without an access list may put there.

A follower and an arm that waits for a grasp worth trying are on the bus with the stranger; the session moves through
HTTP meanwhile. Bounds: every version is followed, late by less than a poll (3 s), and nothing but the service ends
either of them.
"""

import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import httpx2
from zenoh import Encoding

from tests.chaos.attack import Attack, Outcome
from tests.support.bus import Stranger, stranger
from tests.support.replicas import Replica, replicas
from tests.support.routers import router
from tests.support.serving import data_scenario
from tests.support.waiting import wait_for
from voa_client import ArmClient, Client
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import BeliefRequest, Session, SessionRequest

_POLL_S = 3.0
_MOVES = 5
_FLOOD_S = 5.0
_FLOOD_MOVES = 10
_CALLS_PER_S = 15.0
"""Calls of a follower per second: 10 for forged versions, and for each of 2 real versions a session and its history."""
_UNSURE = BeliefRequest(belief=[0.4, 0.3, 0.3])
_SURE = BeliefRequest(belief=[1.0, 0.0, 0.0])
_NO_GRASP = 0.99


@dataclass
class _Followed:
    """Versions that somebody who follows a session has seen, by the clock."""

    at: dict[int, float] = field(default_factory=dict)
    end: str = ""

    def follow(self, client: Client, session: str) -> None:
        """Follow until the end, and note why it came."""
        try:
            for each in client.follow(session):
                self.at.setdefault(each.version or 0, time.monotonic())
            self.end = "ended"
        except Exception as error:
            self.end = type(error).__name__

    def wait(self, client: Client, session: str) -> None:
        """Wait as an arm does, and note why the wait is over."""
        try:
            self.end = ArmClient(client, session).wait_until(_NO_GRASP).reason
        except Exception as error:
            self.end = type(error).__name__


@dataclass
class _Scene:
    """A service, somebody who follows a session, an arm that waits, and a stranger on the same router."""

    bus: str
    service: Replica
    client: Client
    session: Session
    stranger: Stranger
    followed: _Followed
    waited: _Followed
    moved: dict[int, float] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """Key on which the session's versions are published."""
        return self.stranger.keys.belief(self.session.id)

    def put(self, payload: bytes, version: str) -> None:
        """Put what the service never said."""
        self.stranger.session.put(self.key, payload, encoding=Encoding.APPLICATION_JSON, attachment=version.encode())

    def forged(self, version: int) -> bytes:
        """The session at a version where it is not."""
        return self.session.model_copy(update={"version": version}).model_dump_json().encode()

    def move(self, belief: BeliefRequest = _UNSURE) -> None:
        """Replace the belief, and note when the new version was stored."""
        version = self.client.put_belief(self.session.id, belief).version or 0
        self.moved[version] = time.monotonic()

    def late_s(self) -> float:
        """Wait for the newest version, at most two polls, and return by how much the latest one came late."""
        end = time.monotonic() + 2 * _POLL_S
        while time.monotonic() < end and not self.followed.end and max(self.moved) not in self.followed.at:
            time.sleep(0.01)
        lates = [self.followed.at[version] - at for version, at in self.moved.items() if version in self.followed.at]
        return max(lates, default=0.0)


@contextmanager
def _scene(folder: Path) -> Iterator[_Scene]:
    with ExitStack() as stack:
        bus = stack.enter_context(router())
        options = ("--zenoh", bus.endpoint, "--log-level", "WARNING")
        (service,) = stack.enter_context(replicas(f"sqlite:///{folder / 'voa.db'}", folder, 1, *options))
        wait_for(lambda: service.zenoh == "connected", "the service on the bus")
        client = stack.enter_context(Client(service.url))
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
        session = client.create_session(SessionRequest(scenario=scenario.id))
        follower, arm = (stack.enter_context(Client(bus.endpoint)) for _ in range(2))
        scene = _Scene(
            bus.endpoint,
            service,
            client,
            session,
            stack.enter_context(stranger(bus.endpoint)),
            _Followed(),
            _Followed(),
        )
        for target, own in ((scene.followed.follow, follower), (scene.waited.wait, arm)):
            threading.Thread(target=target, args=(own, session.id), daemon=True).start()
        wait_for(lambda: 0 in scene.followed.at, "the follower to see the session")
        scene.move()
        wait_for(lambda: 1 in scene.followed.at, "the follower to see it move")
        scene.moved.clear()
        yield scene


def _attacked(folder: Path, attack: Callable[[_Scene], None]) -> Outcome:
    """Attack, then move the session some times, end the wait by a belief that is sure, and the session."""
    with _scene(folder) as scene:
        attack(scene)
        for _ in range(_MOVES):
            scene.move()
        return _judged(scene, [], figures_held=True)


def _judged(scene: _Scene, figures: list[str], *, figures_held: bool) -> Outcome:
    """Fate of the follower and of the arm, once the session has moved."""
    late = scene.late_s()
    moved = len(scene.moved)
    seen = [version for version in scene.moved if version in scene.followed.at]
    broken_off = scene.followed.end
    went_on = not scene.waited.end
    scene.move(_SURE)
    with_reason = went_on and _becomes(lambda: scene.waited.end in {"score", "no_look_pays"})
    scene.client.delete_session(scene.session.id)
    ended = not broken_off and _becomes(lambda: scene.followed.end == "ended")
    sees = f"{len(seen)} of {moved} versions seen"
    figure = ", ".join([sees, f"late by {late:.2f} s" if seen else "blind", *figures])
    survived = (
        f"follower {'until the real end' if ended else broken_off or 'did not end'}, "
        f"arm {'until there was a grasp' if with_reason else scene.waited.end or 'never woke'}"
    )
    held = len(seen) == moved and late < _POLL_S and ended and with_reason and figures_held
    return Outcome(figure, survived, held)


def _becomes(condition: Callable[[], bool]) -> bool:
    """Whether a condition comes true within three polls."""
    try:
        return wait_for(condition, "it", 3 * _POLL_S)
    except AssertionError:
        return False


def forged_version(folder: Path) -> Outcome:
    """Put a version that the session will never reach."""
    return _attacked(folder, lambda scene: scene.put(scene.forged(10**12), str(10**12)))


def forged_delete(folder: Path) -> Outcome:
    """Put a deletion of a session that still exists."""
    return _attacked(folder, lambda scene: scene.stranger.session.delete(scene.key))


def garbage(folder: Path) -> Outcome:
    """Bytes that are no session, and sessions that are another one's."""

    def attack(scene: _Scene) -> None:
        other = scene.session.model_copy(update={"id": "other", "version": 2}).model_dump_json().encode()
        for payload in (b"\0", b"", b"[" * 100_000, b"{}", b'{"version": ' + b"9" * 5_000 + b"}", other):
            for version in ("2", "", "-1", "9" * 5_000):
                scene.put(payload, version)

    return _attacked(folder, attack)


def flood(folder: Path) -> Outcome:
    """Forged versions, garbage and deletes as fast as they can be put, while the session moves."""
    with _scene(folder) as scene:
        before, began = _gets(scene.service), time.monotonic()
        command = [sys.executable, "-m", "tests.chaos.flooding", scene.bus, scene.key, str(_FLOOD_S)]
        flooding = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        session = scene.session.model_dump_json()
        talking = threading.Thread(target=lambda: outputs.append(flooding.communicate(session)[0]), daemon=True)
        outputs: list[str] = []
        talking.start()
        while flooding.poll() is None:
            scene.move()
            time.sleep(_FLOOD_S / _FLOOD_MOVES)
        talking.join()
        took = time.monotonic() - began
        per_s = (_gets(scene.service) - before) / 2 / took  # there are two on the bus
        figures = [f"{int(outputs[0]) / _FLOOD_S:.0f} forged a second", f"{per_s:.1f} calls a second by each"]
        return _judged(scene, figures, figures_held=per_s < _CALLS_PER_S)


def _gets(service: Replica) -> float:
    """Count the requests over Zenoh for a session or its history."""
    lines = httpx2.get(f"{service.url}/metrics", timeout=30.0).raise_for_status().text.splitlines()
    counted = [line for line in lines if line.startswith("voa_rpc_requests_total{")]
    wanted = ('method="session.get"', 'method="history.get"')
    return sum(float(line.rpartition(" ")[2]) for line in counted if any(each in line for each in wanted))


_BOUND = "each version, late by less than 3 s"

ATTACKS = [
    Attack(
        "forged version on the bus",
        "2026-11-28: 0 of 5 versions seen, blind until the session's end",
        _BOUND,
        forged_version,
    ),
    Attack("forged delete on the bus", "2026-11-28: 0 of 5 versions seen, the follower ended", _BOUND, forged_delete),
    Attack(
        "garbage on the bus",
        "2026-11-28: 0 of 5 versions seen, UnexpectedResponseError ended the follower",
        _BOUND,
        garbage,
    ),
    Attack(
        "flood on the bus",
        "2026-11-28: UnexpectedResponseError ended the follower and the arm",
        f"{_BOUND}; at most 15 calls a second",
        flood,
    ),
]
