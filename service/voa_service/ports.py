"""What the use cases need from the world."""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Generic, Literal, Protocol, TypeVar

from voa_core.filtering import Belief
from voa_core.objects import Object
from voa_msgs.objects import UpAxis

T = TypeVar("T")

Clock = Callable[[], datetime]
"""The time, in UTC."""

IdSource = Callable[[], str]
"""A new name that nobody has yet, of `[A-Za-z0-9]`."""

MeshReader = Callable[[bytes, str, float, UpAxis], Object]
"""Reads an untrusted mesh file of a type ("obj", ...), scaled, that axis turned to z; raises `failures.Failure`."""


@dataclass(frozen=True, eq=False)
class StoredObject:
    """A mesh with its name, and the axis of its file that became z."""

    object: Object
    name: str
    created_at: datetime
    up: UpAxis = "+Z"


@dataclass(frozen=True)
class Upload:
    """A mesh file, and how it was read: everything that decides which mesh it becomes."""

    sha256: str
    """Of its bytes, in lower-case hexadecimal digits."""
    type: str
    """The ending of its name, in lower case: "obj", ..."""
    scale: float
    """Metres per unit of the file."""
    up: UpAxis
    """The axis of the file that became z."""


@dataclass(frozen=True)
class StoredScenario:
    """A scenario as canonical JSON of the filled-in request, named by its digest."""

    id: str
    name: str
    body: str
    created_at: datetime
    summary: str = "{}"
    """Facts that lists show of it beside its name, as JSON; kept when it is stored, and read by lists alone."""


@dataclass(frozen=True, eq=False)
class SessionState:
    """One running estimate."""

    id: str
    scenario: str
    version: int
    belief: Belief
    prior: Belief
    last_fit_rmsd_mm: float | None
    created_at: datetime
    updated_at: datetime
    summary: str | None = None
    """Facts that lists show of its belief, as JSON; None: nobody has said."""


@dataclass(frozen=True)
class ListedObject:
    """A mesh in a list, without its vertices and faces."""

    id: str
    name: str
    extents: tuple[float, float, float]
    """Of its bounding box, metres."""
    faces: int
    watertight: bool
    up: UpAxis
    created_at: datetime


@dataclass(frozen=True)
class ListedScenario:
    """A scenario in a list, without its body."""

    id: str
    name: str
    summary: str
    """As it was stored."""
    created_at: datetime


@dataclass(frozen=True)
class ListedSession:
    """A session in a list, without its beliefs."""

    id: str
    scenario: str
    version: int
    last_fit_rmsd_mm: float | None
    summary: str | None
    """As it was stored with this version; None: it is one of before summaries were kept."""
    created_at: datetime
    updated_at: datetime


@dataclass(frozen=True)
class Listed(Generic[T]):
    """Some items of a list, and where it goes on."""

    items: list[T]
    next: str | None


@dataclass(frozen=True)
class IdempotencyKey:
    """A caller's name for one logical call: within `scope`, the same key means the same call."""

    scope: str
    key: str
    fingerprint: str
    """Digest of what is asked: the same key with another one is a mistake."""


@dataclass(frozen=True)
class Answered:
    """What a write was answered, kept with its idempotency key: the JSON body and the session's version."""

    body: str
    version: int


@dataclass(frozen=True, eq=False)
class Step:
    """The effect of one write on a session.

    `after` is None where the write was answered but changed nothing; `report` goes to the history.
    """

    after: SessionState | None
    answer: Answered
    report: str | None


HistoryKind = Literal["prior", "scan", "outcome", "belief"]


@dataclass(frozen=True, eq=False)
class HistoryEntry:
    """One version of a session: the state that it left, and what made it."""

    state: SessionState
    kind: HistoryKind
    request: str
    """The body as it was received."""
    report: str | None
    """A `voa_msgs.sessions.UpdateReport`."""


@dataclass(frozen=True)
class RobotLook:
    """A look of a mapped robot, as a session counts it."""

    robot: str
    number: int
    """Counts the looks of this robot that the session has accepted, from 1."""
    digest: str
    """Of its times and ranges; the same wherever the same revolutions are received."""


@dataclass(frozen=True)
class Write:
    """One write to a session as it came in."""

    kind: HistoryKind
    request: str
    """The body as it was received."""
    key: IdempotencyKey | None
    if_match: frozenset[int] | None
    """The versions that the caller would accept; None: any."""
    look: RobotLook | None = None
    """The robot's look that a scan is; it is counted where the scan is accepted, and no number is counted twice."""


class Store(Protocol):
    """Keeps every answered write. All methods block; they are called from worker threads.

    Every method raises `Failure` (503, with a time to try again) where the database does not work, and `Failure`
    (500, `damaged`) where a session that it reads is not as it was written.
    """

    @property
    def software(self) -> str:
        """Name the database's software and its version ("SQLite 3.53.4")."""

    @property
    def troubles(self) -> int:
        """Count how often the database has failed a call so far."""

    def ping(self) -> None:
        """Return if the store can be read and written; raise whatever is wrong. Costs a small commit."""

    def close(self) -> None:
        """Release what is held."""

    def listen(self, moved: Callable[[str], None]) -> None:
        """Call `moved` with each session that another process changes, where the database tells; from any thread."""

    def put_object(self, stored: StoredObject) -> tuple[StoredObject, bool]:
        """Store a mesh unless an equal one is there; the one that is there then, and whether it is new."""

    def get_object(self, id_: str) -> StoredObject | None:
        """The mesh with that digest."""

    def list_objects(self, limit: int, after: str | None) -> Listed[ListedObject]:
        """Oldest first."""

    def put_upload(self, upload: Upload, object_: str) -> None:
        """Remember that a file became the mesh with a digest, which is stored."""

    def find_upload(self, upload: Upload) -> StoredObject | None:
        """Find the mesh that a file became when it was uploaded; None: it never was."""

    def put_scenario(self, stored: StoredScenario) -> tuple[StoredScenario, bool]:
        """Store a scenario unless an equal one is there; the one that is there then, and whether it is new."""

    def get_scenario(self, id_: str) -> StoredScenario | None:
        """The scenario with that digest."""

    def list_scenarios(self, limit: int, after: str | None) -> Listed[ListedScenario]:
        """Oldest first."""

    def get_answer(self, key: IdempotencyKey) -> Answered | None:
        """What was answered under a key; `Failure` if the request was another."""

    def create_session(
        self, state: SessionState, write: Write, answer: Answered, robots: Sequence[str] = ()
    ) -> Answered:
        """Store a new session with its prior as history, and claim `robots` for it, all or nothing.

        With a key seen before it returns what was answered then, and changes nothing.
        """

    def get_session(self, id_: str) -> SessionState | None:
        """The session as it stands."""

    def session_mark(self, id_: str) -> Hashable | None:
        """Another one whenever the session has moved: all that is asked of one that has not."""

    def robot_session(self, robot: str, scenario: str) -> str | None:
        """Find the session that a look of a robot, mapped to a scenario, would be for now; None: there is none.

        In this order: the session that the robot belongs to, where that exists and is on this scenario; none, where
        the robot was said to be nobody's; where its session was deleted, the newest session on the scenario that was
        opened after that one; the newest session on the scenario.
        """

    def settle_robot(self, robot: str, scenario: str) -> str | None:
        """Make the session that `robot_session` finds the robot's own, where there is one.

        Durable, and the same for all processes: of those that do so at once the first decides, and all return that.
        """

    def claim_robot(self, robot: str, session: str | None) -> bool:
        """Say whose session a robot's scans are for, None: nobody's; returns False where there is no such session."""

    def list_sessions(self, limit: int, after: str | None) -> Listed[ListedSession]:
        """Oldest first."""

    def change_session(self, id_: str, write: Write, step: Callable[[SessionState], Step]) -> Answered | None:
        """Apply one write in one transaction; None if there is no such session.

        In this order: the idempotency key (seen before: that answer again, or `Failure` if the request was
        another), the version that the caller has seen (`Failure` if stale), then `step`, which must be pure and
        quick: writers on one session wait for each other; last, where the step changed the session, the robot's look
        is counted (`Failure` if its number was counted before, and nothing is changed).
        """

    def robot_looks(self, id_: str, robot: str, limit: int) -> list[RobotLook]:
        """At most `limit` looks of a robot that a session has accepted, the newest first."""

    def history(self, id_: str, after: int, limit: int, most_bytes: int | None = None) -> list[HistoryEntry]:
        """Read at most `limit` versions of a session above `after`, ascending; -1 begins with the prior.

        Fewer, and at least one, where they would have more than `most_bytes` bytes (None: no bound).
        """

    def delete_session(self, id_: str, key: IdempotencyKey | None, if_match: frozenset[int] | None) -> bool:
        """Remove a session with its history; whether it was there. Key and version as in `change_session`.

        It is gone for everybody on return; the rows of a long history are removed afterwards, a few at a time.
        """
