"""Start of the outputs and inputs for ROS tools, of each robot whose mapping switches them on."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

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
    """

    services: Services
    keys: Keys
    replicas: Replicas
    outbox: Outbox
    grace_seconds: float

    @contextmanager
    def on(self, session: zenoh.Session, mapping: RobotMapping) -> Iterator[None]:
        """Publish the outputs of a robot and receive its inputs within a `with` block; nothing where all are off."""
        with ExitStack() as stack:
            if mapping.inputs.topics:
                inputs = Inputs(self.services, mapping, self.replicas, self.outbox, self.grace_seconds)
                stack.callback(inputs.close)
                stack.enter_context(inputs.on(session))
            if mapping.outputs.topics:
                from voa_service.ros_tools.publishing import Publisher  # noqa: PLC0415 - imports rosbags

                publisher = Publisher(self.services, mapping, self.replicas, self.keys)
                stack.enter_context(publisher.on(session))
            yield
