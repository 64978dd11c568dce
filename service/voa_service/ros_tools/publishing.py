"""Publication of the session of one robot to ROS tools, in a thread of its own.

Every version is published when `belief/<session>` says that there is one, whichever replica made it, by the replica
that is responsible for the robot: two replicas do not publish twice. The newest messages are published again every few
seconds, because a plain publisher of Zenoh keeps nothing for tools that are started after it.
"""

import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager

import structlog
import zenoh
from zenoh import CongestionControl
from zenoh.handlers import Callback

from voa_msgs.keys import Keys
from voa_msgs.rankings import Ranking
from voa_ros.outputs.selection import OutputMessage, belief_messages, place_messages, published, scene_messages
from voa_ros.robots import RobotMapping
from voa_scene.shapes import Scene
from voa_service.failures import Failure, NotFound
from voa_service.guard import guarded
from voa_service.ros_tools.encoding import Encoder
from voa_service.ros_tools.gathering import Facts, Gatherer
from voa_service.ros_tools.keys import Addresses, announcements
from voa_service.ros_tools.rankings import Version, VersionRankings
from voa_service.services import Services
from voa_service.zenoh.replicas import Replicas

POLL_SECONDS = 1.0
"""Polling interval for the robot's session and for versions that no message announced, in seconds."""


class Publisher:
    """Publishes the outputs of one robot.

    Args:
        services: use cases.
        mapping: of the robot, with its outputs.
        replicas: decides which replica publishes.
        keys: key expressions of the service.
    """

    def __init__(self, services: Services, mapping: RobotMapping, replicas: Replicas, keys: Keys) -> None:
        self._services = services
        self._mapping = mapping
        self._replicas = replicas
        self._keys = keys
        self._encoder = Encoder()
        self._addresses = Addresses(mapping)
        self._gatherer = Gatherer(services)
        self._wake = threading.Event()
        self._ended = False
        self._rankings = VersionRankings(services, self._wake.set)
        self._version: Version | None = None
        """Session and version that were published; None: nothing was."""
        self._placed: Version | None = None
        """Session and version whose recommended place was published."""
        self._facts: Facts | None = None
        self._ranking: Ranking | None = None
        self._ranked: Version | None = None
        """Session and version that `_ranking` is of."""
        self._newest: dict[str, list[tuple[OutputMessage, bytes]]] = {}
        """Newest repeated messages of each topic, encoded."""
        self._repeated = time.monotonic()

    @contextmanager
    def on(self, session: zenoh.Session) -> Iterator[None]:
        """Publish on a Zenoh session within a `with` block."""
        thread = threading.Thread(target=self._run, args=(session,), name="voa-ros-outputs", daemon=True)
        thread.start()
        receive = Callback(self._receive, indirect=False)
        types = {topic: self._encoder.type(name) for topic, name in published(self._mapping).items()}
        try:
            with ExitStack() as stack:
                for token in announcements(self._mapping, str(session.info.zid()), types):
                    stack.enter_context(session.liveliness().declare_token(token))
                stack.enter_context(session.declare_subscriber(self._keys.belief("*"), receive))
                yield
        finally:
            self._ended = True
            self._wake.set()
            self._rankings.stop()
            thread.join(POLL_SECONDS)

    def _receive(self, sample: zenoh.Sample) -> None:
        """Wake the thread for a new version of the robot's session; called in a Zenoh thread."""
        version = self._version
        if version is None or str(sample.key_expr) == self._keys.belief(version[0]):
            self._wake.set()

    def _run(self, session: zenoh.Session) -> None:
        while not self._ended:
            try:
                with guarded():
                    self._step(session)
            except Failure as failure:  # the next poll tries again
                structlog.get_logger().warning(
                    "the outputs to ROS were not published", robot=self._mapping.name, why=failure.detail
                )
            self._wake.wait(min(POLL_SECONDS, self._mapping.outputs.repeat_s))
            self._wake.clear()

    def _step(self, session: zenoh.Session) -> None:
        """Publish whatever is new, or due again."""
        if self._services.health.link.state != "connected" or not self._replicas.owns(self._mapping.name):
            self._forget()  # all of it is published again once this replica is responsible, and can publish
            return
        version = self._current()
        if version is None:
            if self._version is not None:
                self._forget()
                self._publish(session, scene_messages(self._mapping, Scene(()), None))
                self._newest.clear()
            return
        if version != self._version:
            self._publish_version(session, version)
        if self._mapping.outputs.needs_ranking and self._ranked != self._version and self._version is not None:
            self._publish_ranking(session, self._version)
        if time.monotonic() - self._repeated >= self._mapping.outputs.repeat_s:
            self._repeated = time.monotonic()
            for messages in self._newest.values():
                self._put(session, messages)

    def _current(self) -> Version | None:
        """Return the robot's session and its version; None: there is none."""
        try:
            own = self._services.robots.report(self._mapping.name).session
        except NotFound:  # the robot was unmapped meanwhile
            return None
        mark = None if own is None else self._services.sessions.store.session_mark(own)
        return None if own is None or mark is None else (own, mark.version)

    def _forget(self) -> None:
        self._version = self._facts = self._ranking = self._ranked = None
        self._newest.clear()

    def _publish_version(self, session: zenoh.Session, version: Version) -> None:
        """Publish belief and scene of a version; its towers are those of the version before until it is ranked."""
        if self._version is not None and self._version[0] != version[0]:
            self._forget()
        state = self._services.sessions.state(version[0])
        outputs, gatherer = self._mapping.outputs, self._gatherer
        facts = gatherer.gather(state, with_scene=outputs.markers is not None)
        bounds = None if outputs.belief is None else gatherer.bounds(facts.scenario)
        self._facts, self._version = facts, (state.id, state.version)
        self._newest.clear()  # a message that this version does not have must not be repeated
        messages = belief_messages(self._mapping, facts.scenario, facts.session, facts.ranked, bounds)
        self._publish(session, [*messages, *self._scene(facts)])

    def _publish_ranking(self, session: zenoh.Session, version: Version) -> None:
        """Publish towers and the recommended place of a version, as soon as it is ranked."""
        ranking, facts = self._rankings.poll(version), self._facts
        if ranking is None or facts is None:
            return
        self._ranking, self._ranked = ranking, version
        messages = self._scene(facts)
        if self._placed != version:
            self._placed = version
            messages += place_messages(self._mapping, facts.scenario, ranking)
        self._publish(session, messages)

    def _scene(self, facts: Facts) -> list[OutputMessage]:
        outputs = self._mapping.outputs
        if outputs.markers is None:
            return []
        mesh = self._gatherer.mesh(facts.scenario, outputs.meshes)
        return scene_messages(self._mapping, facts.scene(self._ranking), mesh)

    def _publish(self, session: zenoh.Session, messages: Sequence[OutputMessage]) -> None:
        made: dict[str, list[tuple[OutputMessage, bytes]]] = {}
        for message in messages:
            encoded = self._encoder.encode(message.type, message.fields)
            made.setdefault(message.topic, []).append((message, encoded))
        for topic, encoded_messages in made.items():
            self._put(session, encoded_messages)
            if encoded_messages[0][0].repeated:
                self._newest[topic] = encoded_messages

    def _put(self, session: zenoh.Session, messages: Sequence[tuple[OutputMessage, bytes]]) -> None:
        for message, payload in messages:
            address = self._addresses.next(message.topic, self._encoder.type(message.type))
            session.put(address.key, payload, attachment=address.attachment, congestion_control=CongestionControl.BLOCK)
            self._services.metrics.zenoh("ROS message published")
