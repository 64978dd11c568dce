"""Records of the store: objects, scenarios, sessions, their histories, and the writes that make them."""

from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime
from typing import Generic, Literal, NamedTuple, TypeVar

from voa_core.filtering import Belief
from voa_core.objects import Object

T = TypeVar("T")

UpAxis = Literal["+Y", "+Z"]
"""Axis of a mesh file that points up, and becomes z."""


@dataclass(frozen=True, eq=False)
class StoredObject:
    """A mesh with its name and the axis of its file that became z."""

    object: Object
    name: str
    created_at: datetime
    up: UpAxis = "+Z"


@dataclass(frozen=True)
class Upload:
    """A mesh file and the options that it was read with; together they decide which mesh it becomes."""

    sha256: str
    """SHA-256 of the file's bytes, as 64 lower-case hexadecimal digits."""
    type: str
    """File type, the ending of its name in lower case: "obj", "stl", ..."""
    scale: float
    """Metres per unit of the file."""
    up: UpAxis
    """Axis of the file that became z."""


@dataclass(frozen=True)
class StoredScenario:
    """A scenario as canonical JSON with every default written out; its id is the digest of its content."""

    id: str
    name: str
    body: str
    created_at: datetime
    summary: str = "{}"
    """Facts that lists show beside the name, as JSON; written once, with the scenario, and read by lists alone."""
    object: str | None = None
    """Digest of the mesh that the scenario needs; None: it needs none."""


@dataclass(frozen=True, eq=False)
class SessionState:
    """A session at one version: scenario, belief, prior, times and looks."""

    id: str
    scenario: str
    version: int
    belief: Belief
    prior: Belief
    last_fit_rmsd_mm: float | None
    created_at: datetime
    updated_at: datetime
    summary: str | None = None
    """Facts about the belief that lists show, as JSON; None in sessions from before summaries were stored."""
    looks: str | None = None
    """Record of the looks and attempts since the belief began, on which later updates depend, as JSON; None: none."""
    under_way: str | None = None
    """Announced looks whose scans have not arrived yet, as JSON; None: none. They belong to no version."""


class RobotClaim(NamedTuple):
    """The claim on a robot.

    Attributes:
        session: id of the session that has claimed it; None: the robot was released from every session.
    """

    session: str | None


class SessionMark(NamedTuple):
    """Values of a session's row that differ after every change of the session."""

    version: int
    updated_at: str
    under_way: str | None


@dataclass(frozen=True)
class ListedObject:
    """A mesh in a list, without its vertices and faces."""

    id: str
    name: str
    extents: tuple[float, float, float]
    """Edges of the axis-aligned bounding box, metres."""
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
    """Summary of the stored scenario, JSON."""
    created_at: datetime


@dataclass(frozen=True)
class ListedSession:
    """A session in a list, without its beliefs."""

    id: str
    scenario: str
    version: int
    last_fit_rmsd_mm: float | None
    summary: str | None
    """Summary of this version, JSON; None in sessions from before summaries were stored."""
    created_at: datetime
    updated_at: datetime


@dataclass(frozen=True)
class Listed(Generic[T]):
    """A page of a list, and the cursor of the next page; None: this is the last page."""

    items: list[T]
    next: str | None


@dataclass(frozen=True)
class IdempotencyKey:
    """A caller's name for one logical call: within `scope`, equal keys mean the same call."""

    scope: str
    key: str
    fingerprint: str
    """Digest of the request: the same key with another fingerprint is a mistake of the caller."""


@dataclass(frozen=True)
class StoredResponse:
    """Response to a write, kept under its idempotency key: the JSON body and the session's version."""

    body: str
    version: int


HistoryKind = Literal["prior", "scan", "outcome", "belief"]
WriteKind = HistoryKind | Literal["look"]
"""Kind of a write; the announcement of a look makes no version, and so no entry of the history."""


@dataclass(frozen=True, eq=False)
class HistoryEntry:
    """A version in the history of a session: the state at that version, and the request that made it."""

    state: SessionState
    kind: HistoryKind
    request: str
    """Body of the request as it was received."""
    report: str | None
    """JSON of the `voa_msgs.sessions.UpdateReport` of an observation; None for the prior and for stated beliefs."""


@dataclass(frozen=True)
class RobotLook:
    """A look of a mapped robot that a session has accepted or may accept."""

    robot: str
    number: int
    """Number of the look among those of this robot that the session has accepted, from 1."""
    digest: str
    """Digest of the look's times and ranges: equal wherever the same revolutions were received."""


@dataclass(frozen=True)
class Write:
    """A request to change a session, as it was received."""

    kind: WriteKind
    request: str
    """Body of the request as it was received."""
    key: IdempotencyKey | None
    if_match: frozenset[int] | None
    """Versions of the session that the caller would accept; None: any version."""
    look: RobotLook | None = None
    """Look of a mapped robot that a scan is; counted when the scan is accepted, and no number is counted twice."""


@dataclass(eq=False)
class SessionChange:
    """A write to one session that is in progress, within the transaction of `Store.change`.

    Attributes:
        state: the session, locked, at the version that the caller accepts. None: the write was answered before under
            its idempotency key; `response` is that stored response, and nothing may be changed.
        after: the session's state after the write; None: the write changes nothing. Where its version is that of
            `state`, announced looks alone have changed.
        report: JSON for the history: the result of an observation.
    """

    state: SessionState | None
    after: SessionState | None = None
    report: str | None = None
    _response: StoredResponse | None = field(default=None, init=False)

    @classmethod
    def answered(cls, response: StoredResponse) -> "SessionChange":
        """Build the change of a write that was answered before: it has the stored response, and no state."""
        change = cls(None)
        change.respond(response)
        return change

    @property
    def response(self) -> StoredResponse:
        """Response to the write, which is stored under its key.

        Raises:
            RuntimeError: `respond` has not been called, a defect of the caller.
        """
        if self._response is None:
            raise RuntimeError("a change of a session must end with a response: call SessionChange.respond")
        return self._response

    def respond(self, response: StoredResponse, after: SessionState | None = None, report: str | None = None) -> None:
        """Set the result of the write: it is stored when the transaction ends.

        Args:
            response: for the caller, and for repetitions of this call.
            after: the session's new state; None: the write changes nothing.
            report: JSON for the history.
        """
        self._response, self.after, self.report = response, after, report


Step = Callable[[SessionChange, SessionState], None]
"""A function that computes the next state of a session from its present one, and calls `SessionChange.respond`."""


@dataclass(frozen=True)
class StoredKey:
    """An API key as it is stored: its digest, never the key itself."""

    id: str
    """Part of the key's text by which it is looked up; not secret."""
    digest: bytes = field(repr=False)
    """SHA-256 of the key's whole text."""
    name: str
    """Name of the caller; several active keys of a name let a key be replaced without a gap."""
    role: str
    """Role of the caller, which says what calls it may make."""
    created_at: datetime
    sessions: tuple[str, ...] | None = None
    """Ids of the only sessions that the key is for; None: any."""
    robots: tuple[str, ...] | None = None
    """Names of the only robots that the key is for; None: any."""
    expires_at: datetime | None = None
    """Time from which the key is no longer valid; None: never."""
    revoked_at: datetime | None = None
    """Time at which a person revoked the key; None: it is not revoked."""
    last_used_at: datetime | None = None
    """Time of a recent use, exact to about a minute; None: never used."""

    def is_active(self, now: datetime) -> bool:
        """True if the key is neither revoked nor expired."""
        return self.revoked_at is None and (self.expires_at is None or now < self.expires_at)
