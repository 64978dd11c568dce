"""The set-ups of RViz, Foxglove and PlotJuggler can be read, and name topics that are published with their types."""

import json
import re
from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree as Xml

import pytest
import zenoh
from ruamel.yaml import YAML

from tests.deploy.pages import REPOSITORY, page
from voa_ros.outputs import types
from voa_ros.outputs.selection import published
from voa_ros.robots import RobotMapping, load

FOLDER = REPOSITORY / "deploy" / "ros"
TOPIC = re.compile(r"/tb3_1/[a-z0-9_/]+")


@pytest.fixture(scope="module")
def mapping() -> RobotMapping:
    """The mapping that the page shows."""
    (block,) = [each for each in page("ros-tools").blocks("toml") if "[[robot]]" in each.text]
    (robot,) = load(block.text)
    return robot


@pytest.fixture(scope="module")
def outputs(mapping: RobotMapping) -> dict[str, str]:
    return {f"/{topic}": type_ for topic, type_ in published(mapping).items()}


@pytest.fixture(scope="module")
def inputs(mapping: RobotMapping) -> set[str]:
    return {f"/{mapping.topic(topic)}" for topic in mapping.inputs.topics}


def displays() -> list[dict[str, Any]]:
    rviz = YAML(typ="safe").load((FOLDER / "voa.rviz").read_text())
    return list(rviz["Visualization Manager"]["Displays"])


SHOWS = {
    "rviz_default_plugins/MarkerArray": types.MARKER_ARRAY,
    "rviz_default_plugins/PoseArray": types.POSE_ARRAY,
    "rviz_default_plugins/Pose": types.POSE_STAMPED,
}
"""Type that each class of display subscribes to."""


def test_the_page_switches_every_output_on(outputs: dict[str, str]) -> None:
    assert set(outputs.values()) == set(types.TYPES)


def test_each_display_of_rviz_shows_a_topic_of_its_type(outputs: dict[str, str]) -> None:
    shown = {each["Topic"]["Value"]: SHOWS[each["Class"]] for each in displays() if "Topic" in each}
    assert shown == {topic: outputs[topic] for topic in shown}
    assert len(shown) == 4


def test_rviz_draws_in_the_frame_of_the_messages_and_marks_the_prior(mapping: RobotMapping, inputs: set[str]) -> None:
    manager = YAML(typ="safe").load((FOLDER / "voa.rviz").read_text())["Visualization Manager"]
    assert manager["Global Options"]["Fixed Frame"] == mapping.outputs.frame_id
    (tool,) = [each for each in manager["Tools"] if each["Class"] == "rviz_default_plugins/SetInitialPose"]
    assert tool["Topic"]["Value"] in inputs


def test_rviz_knows_every_namespace_of_the_markers() -> None:
    (scene,) = [each for each in displays() if each["Class"] == "rviz_default_plugins/MarkerArray"]
    assert set(scene["Namespaces"]) == {"table", "belief", "looks", "scan", "robot", "grasp"}


def panels(layout: Any) -> Iterator[str]:
    """Yield the panels of a layout of Foxglove."""
    if isinstance(layout, str):
        yield layout
    else:
        yield from panels(layout["first"])
        yield from panels(layout["second"])


def test_the_layout_of_foxglove_is_complete_and_names_published_topics(
    outputs: dict[str, str], inputs: set[str]
) -> None:
    text = (FOLDER / "foxglove.json").read_text()
    layout = json.loads(text)
    assert sorted(panels(layout["layout"])) == sorted(layout["configById"])
    assert set(TOPIC.findall(text)) <= set(outputs) | inputs
    for panel, config in layout["configById"].items():
        for path in config.get("paths", []):
            topic, _, field = path["value"].partition(".")
            assert (panel.partition("!")[0], outputs[topic], field) == ("Plot", types.FLOAT, "data")


def test_the_layout_of_plotjuggler_plots_every_number(outputs: dict[str, str]) -> None:
    root = Xml.parse(FOLDER / "plotjuggler.xml").getroot()  # noqa: S314 - a file of this repository
    numbers = {topic for topic, type_ in outputs.items() if type_ == types.FLOAT}
    assert {topic.attrib["name"] for topic in root.iter("topic")} == numbers
    assert {curve.attrib["name"] for curve in root.iter("curve")} == {f"{topic}/data" for topic in numbers}


def test_the_bridge_lets_the_topics_pass(outputs: dict[str, str], inputs: set[str]) -> None:
    text = (FOLDER / "bridge.json5").read_text()
    zenoh.Config.from_json5(text)
    (allowed,) = re.findall(r'subscribers: \["([^"]*)"\]', text)
    assert all(re.fullmatch(allowed, topic) for topic in outputs)
    (sent,) = re.findall(r"publishers: \[([^\]]*)\]", text)
    assert set(re.findall('"([^"]*)"', sent)) == inputs
