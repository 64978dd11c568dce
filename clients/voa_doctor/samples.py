"""Samples of ROS 2 topics, collected for a few seconds."""

import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import zenoh

from voa_ros.topics import InvalidTopic, parse_key

_MOST = 64


@dataclass(frozen=True)
class Sample:
    """A message that was received on a topic of a robot.

    Attributes:
        payload: CDR.
        at_s: time of receipt, seconds since 1970.
        type_name: type in its key; None: the key has none.
        domain: ROS_DOMAIN_ID in its key; None: it came through a bridge.
    """

    payload: bytes
    at_s: float
    type_name: str | None
    domain: int | None


class Samples:
    """Collector of the first samples of each topic, in any domain; Zenoh's threads add to it."""

    def __init__(self) -> None:
        self._samples: dict[str, list[Sample]] = {}
        self._changed = threading.Condition()

    def receiver(self, topic: str) -> Callable[[zenoh.Sample], None]:
        """Make the callback for the subscribers of a topic."""

        def receive(sample: zenoh.Sample) -> None:
            try:
                key = parse_key(str(sample.key_expr))
            except InvalidTopic:
                return
            if key.topic != topic:
                return
            with self._changed:
                of_topic = self._samples.setdefault(topic, [])
                if len(of_topic) < _MOST:
                    of_topic.append(Sample(sample.payload.to_bytes(), time.time(), key.type_name, key.domain))
                    self._changed.notify_all()

        return receive

    def wait(self, wanted: Mapping[str, int], seconds: float) -> dict[str, list[Sample]]:
        """Wait until each topic has the wanted number of samples, at most `seconds`; return all samples by topic."""
        with self._changed:
            self._changed.wait_for(
                lambda: all(len(self._samples.get(topic, [])) >= count for topic, count in wanted.items()), seconds
            )
            return {topic: list(samples) for topic, samples in self._samples.items()}
