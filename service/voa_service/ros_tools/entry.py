"""Start of the outputs and inputs for ROS tools, of each robot whose mapping switches them on."""

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field

import zenoh

from voa_msgs.keys import Keys
from voa_ros.robots import RobotMapping
from voa_service.ros_tools.inputs import Inputs
from voa_service.services import Services
from voa_service.zenoh.outbox import Outbox
from voa_service.zenoh.replicas import Replicas


@dataclass(frozen=True)
class RosTools:
    """Outputs and inputs of mapped robots.

    Attributes:
        services: use cases.
        keys: key expressions of the service.
        replicas: decides which replica publishes, and which applies an input at once.
        outbox: publishes refusals.
        grace_seconds: delay after which a replica that is not responsible applies an input.
        left: returns the seconds that inputs which were received may take at the end.
        ending: threads that apply the last inputs of robots which are mapped no more.
    """

    services: Services
    keys: Keys
    replicas: Replicas
    outbox: Outbox
    grace_seconds: float
    left: Callable[[], float]
    ending: list[threading.Thread] = field(default_factory=list)

    @contextmanager
    def on(self, session: zenoh.Session, mapping: RobotMapping) -> Iterator[None]:
        """Publish the outputs of a robot and receive its inputs within a `with` block; nothing where all are off."""
        with ExitStack() as stack:
            if mapping.inputs.topics:
                inputs = Inputs(self.services, mapping, self.replicas, self.outbox, self.grace_seconds, self.left)
                stack.callback(self._end, inputs)
                stack.enter_context(inputs.on(session))
            if mapping.outputs.topics:
                from voa_service.ros_tools.publishing import Publisher  # noqa: PLC0415 - imports rosbags

                publisher = Publisher(self.services, mapping, self.replicas, self.keys)
                stack.enter_context(publisher.on(session))
            yield

    @contextmanager
    def finishing(self, _session: zenoh.Session) -> Iterator[None]:
        """Apply the inputs that were received, at the end of a `with` block."""
        yield
        self.close()

    def close(self) -> None:
        """Wait until the inputs that were received are applied, as long as there is time."""
        for thread in self.ending:
            thread.join(self.left())

    def _end(self, inputs: Inputs) -> None:
        """Apply the last inputs of a robot in a thread: those of other robots, and another mapping, need not wait."""
        self.ending[:] = [each for each in self.ending if each.is_alive()]
        thread = threading.Thread(target=inputs.close, name="voa-inputs", daemon=True)
        thread.start()
        self.ending.append(thread)
