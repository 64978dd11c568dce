"""A follower taken step by step: a service that is only said to be there, and a clock that only its waits move."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from tests.voa_client.test_attempts import SESSION, problem
from voa_client._attempts import Patience
from voa_client._errors import VoaClientError
from voa_client._following import Following, Pause, Result, Send, Wait, next_step
from voa_client._mailbox import Batch
from voa_client._responses import Response
from voa_client._transport import Deleted, Lost, State
from voa_msgs.sessions import Session

ID = "s"
POLL_S = 3.0


def body(version: int, /, **changed: Any) -> bytes:
    """The session at a version, whose time of commit is its version in seconds."""
    fields = json.loads(SESSION.body) | {"id": ID, "version": version, "updated_at": at(version)}
    return json.dumps(fields | changed).encode()


def at(version: int) -> str:
    """Time at which a version was committed."""
    return f"2026-01-01T00:{version // 60:02d}:{version % 60:02d}Z"


def hints(*versions: int, **changed: Any) -> Batch:
    """Samples of a bus about versions."""
    return Batch(hinted=True, bodies={version: [body(version, **changed)] for version in versions})


def news(*each: State | Deleted | Lost) -> Batch:
    """Events that a service publishes by itself."""
    return Batch(each)


@dataclass
class Service:
    """A scripted service: its session has a version or is deleted, and a failure can replace every response.

    Attributes:
        version: of its only session; None: it was deleted.
        spoilt: response that replaces every other; None: no replacement.
        requested: the calls that were made.
        paused: every pause, seconds.
        waited: every wait, seconds.
    """

    version: int | None = 0
    spoilt: Response | VoaClientError | None = None
    now: float = 0.0
    requested: list[str] = field(default_factory=list)
    paused: list[float] = field(default_factory=list)
    waited: list[float | None] = field(default_factory=list)

    def following(self, for_s: float | None = None) -> Following:
        """A follower by the clock of this service."""
        return Following(ID, Patience(clock=lambda: self.now, chance=lambda: 0.0), for_s)

    def follow(
        self, following: Following, batches: Sequence[Batch | int | None], poll_s: float | None = POLL_S
    ) -> tuple[list[Session], Lost | None]:
        """The sessions that are handed out, and how the watch ended (None too where the batches did).

        Args:
            following: the follower.
            batches: what comes of its waits, one after another; a number moves the session there first, and None
                deletes it, before the next wait.
            poll_s: as the transport's.
        """
        sessions: list[Session] = []
        steps, left, result = following.steps(poll_s), list(batches), None
        while True:
            step = next_step(steps, result)
            result = None
            match step:
                case Session():
                    sessions.append(step)
                case Pause(seconds):
                    self.paused.append(seconds)
                    self.now += seconds
                case Send(call, _):
                    self.requested.append(call.rpc)
                    result = self._answer(call.rpc, call.query)
                case Wait(seconds, _):
                    while left and not isinstance(left[0], Batch):
                        self.version = left.pop(0)  # type: ignore[assignment] # versions and batches take turns
                    if not left:
                        steps.close()
                        return sessions, None
                    self.waited.append(seconds)
                    result = left.pop(0)  # type: ignore[assignment] # the loop above has taken the versions
                    if isinstance(result, Batch) and result.is_empty:
                        self.now += seconds or 0.0
                case _:
                    return sessions, step

    def _answer(self, rpc: str, query: Mapping[str, Any]) -> Result:
        if self.spoilt is not None:
            return self.spoilt
        if self.version is None:
            return problem("not-found", 404)
        if rpc == "session.get":
            return Response(body(self.version))
        first = int(query["after"]) + 1
        items: list[dict[str, Any]] = [
            {"version": each, "kind": "belief", "at": at(each), "request": {}, "update": None}
            for each in range(first, min(first + 3, self.version + 1))
        ]
        more = str(items[-1]["version"]) if items and items[-1]["version"] != self.version else None
        return Response(json.dumps({"items": items, "next": more}).encode())
