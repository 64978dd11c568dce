"""Ports of the use cases: the store, the clock, the source of ids and the mesh reader that they are built with."""

from collections.abc import Callable, Collection, Mapping, Sequence
from datetime import datetime
from typing import Protocol

from voa_core.objects import Object
from voa_store.records import (
    HistoryEntry,
    IdempotencyKey,
    Listed,
    ListedObject,
    ListedScenario,
    ListedSession,
    RobotClaim,
    RobotLook,
    SessionChange,
    SessionMark,
    SessionState,
    Step,
    StoredKey,
    StoredObject,
    StoredResponse,
    StoredScenario,
    UpAxis,
    Upload,
    Write,
)

Clock = Callable[[], datetime]
"""A function that returns the current time, in UTC."""

IdSource = Callable[[], str]
"""A function that returns a new unique id, of characters `[A-Za-z0-9]`."""

MeshReader = Callable[[bytes, str, float, UpAxis], Object]
"""A function that reads an untrusted mesh file: content, type ("obj", ...), metres per unit, axis that becomes z.

It raises `failures.Failure`."""


class Contents(Protocol):
    """Scenarios and meshes by their digests, from which models are built."""

    def get_object(self, id_: str) -> StoredObject | None:
        """Read the mesh with a digest; None: there is none."""

    def get_scenario(self, id_: str) -> StoredScenario | None:
        """Read the scenario with a digest; None: there is none."""


class Store(Protocol):
    """Durable storage: every answered write is still there after a crash.

    All methods block; call them from worker threads. Every method raises `voa_store.errors.Unavailable` or `Busy` where
    the database does not work at the moment, and `DamagedData` where a session that it reads differs from what was
    written.
    """

    @property
    def software(self) -> str:
        """Name of the database's software with its version ("SQLite 3.53.4")."""

    @property
    def troubles(self) -> int:
        """Number of calls that the database has failed so far."""

    def ping(self) -> None:
        """Return if the store can be read and written, at the cost of a small commit; raise the error if not."""

    def warm(self) -> None:
        """Do what the first calls would have to do once, such as to connect; raises nothing."""

    def measure(self, observe: Callable[[float], None]) -> None:
        """Call `observe` with the wall time of each transaction and each single statement, seconds."""

    def close(self) -> None:
        """Close all connections and end all threads."""

    def listen(self, moved: Callable[[str], None]) -> None:
        """Call `moved`, from any thread, with the id of each session that another process changes.

        Does nothing where the database does not notify its clients (SQLite).
        """

    def put_object(self, stored: StoredObject) -> tuple[StoredObject, bool]:
        """Store a mesh unless an equal one is stored; returns the stored one, and True if it is new."""

    def get_object(self, id_: str) -> StoredObject | None:
        """Read the mesh with a digest; None: there is none."""

    def list_objects(self, limit: int, after: str | None) -> Listed[ListedObject]:
        """List at most `limit` meshes after a cursor, oldest first."""

    def put_upload(self, upload: Upload, object_: str) -> None:
        """Store that a file became the mesh with the digest `object_`, which is stored already."""

    def find_upload(self, upload: Upload) -> StoredObject | None:
        """Find the mesh that a file became when it was uploaded; None: it was never uploaded."""

    def put_scenario(self, stored: StoredScenario) -> tuple[StoredScenario, bool]:
        """Store a scenario unless an equal one is stored; returns the stored one, and True if it is new.

        Raises:
            ContentMissing: its object is not stored.
        """

    def delete_scenario(self, id_: str) -> bool:
        """Delete a scenario; False: there is none.

        Raises:
            InUse: a session is on it.
        """

    def delete_object(self, id_: str) -> bool:
        """Delete a mesh, and the records of the files that it was read from; False: there is none.

        Raises:
            InUse: a scenario needs it.
        """

    def get_scenario(self, id_: str) -> StoredScenario | None:
        """Read the scenario with a digest; None: there is none."""

    def list_scenarios(self, limit: int, after: str | None) -> Listed[ListedScenario]:
        """List at most `limit` scenarios after a cursor, oldest first."""

    def get_response(self, key: IdempotencyKey) -> StoredResponse | None:
        """Read the response stored under an idempotency key; None: the key has not been used.

        Raises:
            KeyReused: the key was used for another request.
        """

    def forget_responses(self, keep_s: float, pause: Callable[[float], object]) -> None:
        """Remove the responses that were stored more than `keep_s` seconds ago, a few at a time.

        `pause` sleeps for so many seconds between two transactions, and returns true to end early.
        """

    def create_session(
        self, state: SessionState, write: Write, response: StoredResponse, robots: Sequence[str] = ()
    ) -> StoredResponse:
        """Store a new session with its prior as version 0 of its history, and claim `robots` for it, all or nothing.

        Returns:
            `response` itself; or, where the write's key was used before, the response stored then, and nothing is
            changed.

        Raises:
            KeyReused: the key was used for another request.
        """

    def get_session(self, id_: str) -> SessionState | None:
        """Read the newest version of a session; None: there is no such session."""

    def newest_session(self) -> SessionState | None:
        """Read the session that was opened last, at its newest version; None: there is no session."""

    def session_mark(self, id_: str) -> SessionMark | None:
        """Return values that differ after every change of a session, read cheaply; None: there is no such session."""

    def robot_session(self, robot: str, scenario: str) -> str | None:
        """Find the session that the next look of a robot, mapped to a scenario, belongs to; None: there is none.

        The rules, in this order: the session that the robot is claimed for, if it exists and is on this scenario; none,
        if the robot was released from every session; if its session was deleted, the newest session on the scenario
        that was opened after that one; the newest session on the scenario.
        """

    def settle_robot(self, robot: str, scenario: str) -> str | None:
        """Claim a robot for the session that `robot_session` finds; returns that session, None: there is none.

        The claim is durable, and the first of several processes decides: all of them return the same session.
        """

    def robot_claim(self, robot: str) -> RobotClaim | None:
        """Return the claim on a robot, on whichever scenario; None: there is none, or its session was deleted."""

    def claim_robot(self, robot: str, session: str | None) -> bool:
        """Claim a robot for a session, or release it from every session (None); False: there is no such session."""

    def put_key(self, key: StoredKey) -> None:
        """Store a new API key; its id must be new."""

    def list_keys(self) -> list[StoredKey]:
        """List every API key that was ever made, revoked and expired ones too, oldest first."""

    def revoke_key(self, id_: str, at: datetime) -> bool:
        """Revoke an API key for good; False where there is none of this id, or it was revoked before."""

    def keys_used(self, used: Mapping[str, datetime]) -> None:
        """Store when API keys were last used, by their ids; of several processes, the newest time stays."""

    def list_sessions(
        self, limit: int, after: str | None, only: Collection[str] | None = None
    ) -> Listed[ListedSession]:
        """List at most `limit` sessions after a cursor, oldest first: those with the ids `only`, or all (None)."""

    def change(self, id_: str, write: Write, step: Step) -> SessionChange:
        """Change a session by a step, within one transaction, which is committed and on the disk on return.

        In this order: the session's row is locked, so that writers on one session wait for each other; the idempotency
        key is looked up (used before: the change has no `state`, only the stored response, and the step is not called);
        the checksum of the row is verified; the version is compared with the write's `if_match`; the step computes the
        new state quickly, and calls `respond`; the new version is appended to the history, the robot's look is counted,
        and the response is stored. An error of the step leaves everything unchanged.

        Writes to different sessions at the same time share a transaction. The step runs in the thread of any of them,
        in the context of the caller; once more where another write made that transaction fail.

        Raises:
            KeyReused: the key was used for another request.
            SessionMissing: there is no such session.
            VersionMismatch: the caller expects another version.
            LookRepeated: a look of this number was counted before; nothing is changed.
        """

    def robot_looks(self, id_: str, robot: str, limit: int) -> list[RobotLook]:
        """Read at most `limit` looks of a robot that a session has accepted, the newest first."""

    def history(self, id_: str, after: int, limit: int, most_bytes: int | None = None) -> list[HistoryEntry]:
        """Read at most `limit` versions of a session above `after`, ascending; -1 begins with the prior.

        Stops early, after at least one version, once requests, reports and beliefs add up to `most_bytes` bytes (None:
        no bound). Empty where there is no such session.
        """

    def delete_session(self, id_: str, key: IdempotencyKey | None, if_match: frozenset[int] | None) -> bool:
        """Delete a session with its history; True if it was there, or was deleted under this key before.

        Nobody can read it any more on return; the rows of a long history are removed afterwards, a few at a time.

        Raises:
            KeyReused: the key was used for another request.
            VersionMismatch: the caller expects another version.
        """
