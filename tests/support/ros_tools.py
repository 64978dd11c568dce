"""Tool of ROS on the bus: it subscribes as a bridge does, and decodes by mcap-ros2-support, which this project does not
write."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tests.support.bus import Sample, Stranger, bridged, stranger
from tests.support.routers import Router
from tests.support.serving import Json, Service, box_obj, mesh_scenario, serving
from tests.support.waiting import wait_for
from voa_ros.outputs.types import DEFINITIONS

GRASPED: Json = {"tool_centre_point": [0.0, 0.0, 0.05], "approach": [0.0, 0.0, -2.0], "closing": [0.0, 3.0, 0.0]}
EVERY = """
[robot.outputs]
belief = true
poses = true
markers = true
grasps = true
best_grasp = true
place = true
numbers = true
repeat_s = 60.0
"""


class StockDecoder:
    """Decoder of CDR by mcap-ros2-support, from the text of message definitions."""

    def __init__(self) -> None:
        self._types = get_typestore(Stores.ROS2_JAZZY)
        for name, text in DEFINITIONS.items():
            self._types.register(get_types_from_msg(text, name))
        self._factory = DecoderFactory()
        self._decoders: dict[str, Callable[[bytes], Any]] = {}

    def decode(self, type_: str, payload: bytes) -> Any:
        """Decode a message; every field is an attribute."""
        if type_ not in self._decoders:
            text = self._types.generate_msgdef(type_, ros_version=2)[0].encode()
            schema = Schema(id=len(self._decoders) + 1, name=type_, encoding="ros2msg", data=text)
            decoder = self._factory.decoder_for("cdr", schema)
            assert decoder is not None
            self._decoders[type_] = decoder
        return self._decoders[type_](payload)


class Tool:
    """Subscriber to the topics of a robot."""

    def __init__(self, bus: Stranger, expression: str = "tb3_1/voa/**") -> None:
        self.samples: list[Sample] = bus.subscribe(expression)
        self._decoder = StockDecoder()

    def on(self, topic: str) -> list[Sample]:
        """Return the samples of a topic of the robot so far."""
        return [sample for sample in list(self.samples) if sample.key == f"tb3_1/voa/{topic}"]

    def wait(self, topic: str, count: int = 1) -> list[Sample]:
        """Wait for a number of samples on a topic."""
        wait_for(lambda: len(self.on(topic)) >= count, f"{count} samples on {topic}")
        return self.on(topic)

    def read(self, type_: str, topic: str, count: int = 1) -> Any:
        """Wait for the sample of a number on a topic, and decode it."""
        return self._decoder.decode(type_, self.wait(topic, count)[count - 1].payload)


class RosLab:
    """Service with one mapped robot, and a tool of ROS beside it."""

    def __init__(self, service: Service, bus: Stranger, mapping: Path) -> None:
        self.service = service
        self.bus = bus
        self.mapping = mapping
        self.scenario = service.create(self.scenario_of(service))
        self.session = service.open(self.scenario)

    @staticmethod
    def scenario_of(service: Service) -> Json:
        """Return a scenario of a box with the geometry of one of two grasps."""
        grasps = [{"name": "G1", "data": GRASPED}, {"name": "G2", "data": {"width_m": 0.018}}]
        return mesh_scenario(service.upload(box_obj()), grasps=grasps, spread={"xy_m": 0.01, "yaw_rad": 0.1})

    def map(self, text: str = EVERY, place: str = '{ from = "sensor", sensor = "E" }', more: str = "") -> None:
        """Write the mapping of the robot; returns when it is in force."""
        robot = f'[[robot]]\nname = "tb3_1"\nsession = "{self.session}"\nplace = {place}\n{more}\n{text}'
        self.mapping.write_text(robot)
        wait_for(lambda: [each["robot"] for each in self.service.get("/v1/robots")["items"]] == ["tb3_1"], "a mapping")

    def prefer(self, belief: list[float]) -> int:
        """Replace the belief; returns the new version."""
        answer = self.service.http.put(f"/v1/sessions/{self.session}/belief", json={"belief": belief})
        assert answer.is_success, answer.text
        return int(answer.json()["version"])


@contextmanager
def ros_lab(folder: Path, router: Router, **settings: Any) -> Iterator[RosLab]:
    """Run a service with a mapping, on a running router."""
    mapping = folder / "robots.toml"
    mapping.write_text("")
    with ExitStack() as stack:
        service = stack.enter_context(serving(folder))
        stack.enter_context(bridged(service, router, robots=mapping, **settings))
        yield RosLab(service, stack.enter_context(stranger(router.endpoint)), mapping)


def fields(message: Any, *names: str) -> tuple[Any, ...]:
    """Return the values of some fields of a decoded message."""
    return tuple(getattr(message, name) for name in names)
