"""Plain Zenoh session of a program that knows the service by its keys alone, and a service on a router."""

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import zenoh
from zenoh import Encoding
from zenoh.handlers import Callback

from tests.support.routers import Router
from tests.support.serving import Service
from tests.support.waiting import wait_for
from voa_msgs.keys import Keys
from voa_msgs.links import session_config
from voa_service.settings import ZenohSettings
from voa_service.zenoh.entry import on_zenoh

SECONDS = 20.0


class Sample(NamedTuple):
    """Sample that a subscriber received."""

    key: str
    deleted: bool
    payload: bytes
    attachment: bytes | None

    @property
    def json(self) -> Any:
        return json.loads(self.payload)


class Problem(Exception):
    """Error for a query to which the response is a problem document."""

    def __init__(self, document: dict[str, Any]) -> None:
        super().__init__(document["detail"])
        self.document = document
        self.kind = str(document["type"]).rpartition(":")[2]


class Silence(Exception):
    """Error for a query without a response."""


class Stranger:
    """Plain Zenoh session, with the keys of the service."""

    def __init__(self, session: zenoh.Session, keys: Keys) -> None:
        self.session = session
        self.keys = keys
        self._lock = threading.Lock()
        self._subscribers: list[zenoh.Subscriber[None]] = []

    def call(self, method: str, body: Any = None, **beside: Any) -> Any:
        """Call a method of the service and return its response; raises Problem or Silence."""
        replies = self.replies(method, body, **beside)
        if not replies:
            raise Silence(method)
        (reply,) = replies
        if reply.ok is not None:
            return json.loads(reply.ok.payload.to_bytes())
        assert reply.err is not None
        payload = reply.err.payload.to_bytes()
        if payload == b"Timeout":
            raise Silence(method)
        raise Problem(json.loads(payload))

    def replies(self, method: str, body: Any = None, **beside: Any) -> list[zenoh.Reply]:
        """Call a method of the service and return all replies."""
        replies = self.session.get(
            self.keys.rpc(method),
            payload=None if body is None else json.dumps(body),
            encoding=Encoding.APPLICATION_JSON,
            attachment=json.dumps(beside) if beside else None,
            timeout=SECONDS,
        )
        return list(replies)

    def put_scan(self, session: str, body: Any, robot: str = "r1", **beside: Any) -> None:
        """Put a scan as JSON, or as CDR where the body is bytes."""
        self.session.put(
            self.keys.scan(session, robot),
            body if isinstance(body, bytes) else json.dumps(body),
            encoding=Encoding.APPLICATION_CDR if isinstance(body, bytes) else Encoding.APPLICATION_JSON,
            attachment=json.dumps(beside) if beside else None,
        )

    def subscribe(self, expression: str) -> list[Sample]:
        """Subscribe to a key expression; returns a list to which each sample is added."""
        samples: list[Sample] = []

        def on(sample: zenoh.Sample) -> None:
            attachment = None if sample.attachment is None else sample.attachment.to_bytes()
            deleted = sample.kind == zenoh.SampleKind.DELETE
            samples.append(Sample(str(sample.key_expr), deleted, sample.payload.to_bytes(), attachment))

        self._subscribers.append(self.session.declare_subscriber(expression, Callback(on, indirect=False)))
        return samples


@contextmanager
def stranger(endpoint: str, root: str = Keys().root) -> Iterator[Stranger]:
    """Open a plain session with a running router."""
    config = zenoh.Config()
    for path, value in session_config([endpoint], open_ms=5_000).items():
        config.insert_json5(path, json.dumps(value))
    with zenoh.open(config) as session:
        yield Stranger(session, Keys(root))


@contextmanager
def bridged(service: Service, router: Router, robots: Path | None = None, **settings: Any) -> Iterator[None]:
    """Connect a service of this process to a running router."""
    with on_zenoh(service.inside, ZenohSettings(connect=[router.endpoint], **settings), robots):
        wait_for(lambda: service.inside.health.link.state == "connected", "the service to join the router")
        yield
