"""Outputs and inputs of robots, by what their mappings switch on, and by several replicas."""

import math
import subprocess
import sys
import threading
from contextlib import ExitStack
from pathlib import Path

from tests.support.bus import bridged, stranger
from tests.support.ros_tools import EVERY, RosLab, Tool
from tests.support.routers import Router
from tests.support.serving import Service, serving
from tests.support.waiting import wait_for
from tests.voa_service.ros_tools.test_inputs import boolean, marked, put
from tests.voa_service.zenoh.ros_lab import laser_scan
from voa_ros.outputs.types import DETECTION


def own_threads() -> list[str]:
    return sorted(thread.name for thread in threading.enumerate() if thread.name.startswith("voa-ros"))


def test_a_robot_without_outputs_costs_no_thread_and_no_message(lab: RosLab) -> None:
    tool = Tool(lab.bus, "tb3_1/**")
    lab.map("")
    lab.prefer([0.25, 0.75])
    lab.map(EVERY)
    tool.wait("belief")
    assert own_threads() == ["voa-ros-outputs"]
    lab.map("")
    wait_for(lambda: own_threads() == [], "the end of the thread")


def test_a_service_without_outputs_does_not_import_rosbags() -> None:
    program = (
        "import sys\nimport voa_service.zenoh.entry, voa_service.bootstrap\n"
        "assert 'rosbags' not in sys.modules, 'rosbags is imported'\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def applied_already(services: list[Service]) -> int:
    lines = [line for service in services for line in service.http.get("/metrics").text.splitlines()]
    return sum(
        int(float(line.split()[-1])) for line in lines if "ROS input applied already" in line and "_total" in line
    )


def test_two_replicas_publish_a_version_once_and_apply_an_input_once(tmp_path: Path, own_router: Router) -> None:
    mapping = tmp_path / "robots.toml"
    mapping.write_text("")
    with ExitStack() as stack:
        services = [stack.enter_context(serving(tmp_path)) for _ in range(2)]
        leaving = stack.enter_context(ExitStack())
        leaving.enter_context(bridged(services[0], own_router, robots=mapping, grace_seconds=0.2))
        stack.enter_context(bridged(services[1], own_router, robots=mapping, grace_seconds=0.2))
        bus = stack.enter_context(stranger(own_router.endpoint))
        own = RosLab(services[0], bus, mapping)
        tool = Tool(bus)
        own.map(EVERY + "[robot.inputs]\noutcome = true\n")
        wait_for(lambda: [each["robot"] for each in services[1].get("/v1/robots")["items"]] == ["tb3_1"], "both")
        tool.wait("belief")
        before = len(tool.on("belief"))
        for service in services:  # a commit of either replica is published by the responsible one
            answer = service.http.put(f"/v1/sessions/{own.session}/belief", json={"belief": [0.3, 0.7]})
            assert answer.is_success
            tool.wait("belief", before + 1)
            before += 1
        put(own, "tb3_1/voa/outcome", boolean(True))
        wait_for(lambda: applied_already(services) == 1, "the other replica to leave it")
        assert services[1].get(f"/v1/sessions/{own.session}")["version"] == 3
        tool.wait("belief", before + 1)
        assert len(tool.on("belief")) == before + 1
        leaving.close()
        assert services[1].http.put(f"/v1/sessions/{own.session}/belief", json={"belief": [0.6, 0.4]}).is_success
        tool.wait("belief", before + 2)


def test_a_stock_robot_and_a_stock_arm_need_messages_of_ros_alone(lab: RosLab) -> None:
    """A person marks the object, a lidar looks from a place, the arm takes the best grasp, and reports its attempt."""
    tool = Tool(lab.bus)
    lab.map(EVERY + "[robot.inputs]\nprior = true\noutcome = true\n", more='look = { mode = "every" }')
    put(lab, "tb3_1/voa/prior", marked(0.0, 0.0, math.pi / 4))  # both poses are as likely
    tool.wait("belief", 2)
    predicted = lab.service.post(f"/v1/scenarios/{lab.scenario}/predictions", {"sensors": ["E"]})
    ranges = [math.inf if value is None else value for value in predicted["ranges"][0][1]]
    put(lab, "tb3_1/scan", laser_scan(ranges, 100.0, math.tau / 360))
    seen = tool.read(DETECTION, "belief", 3)
    assert seen.results[0].hypothesis.class_id == "B"
    assert seen.results[0].hypothesis.score > 0.5
    put(lab, "tb3_1/voa/outcome", boolean(True))
    tool.wait("belief", 4)
    kinds = [entry["kind"] for entry in lab.service.get(f"/v1/sessions/{lab.session}/history")["items"]]
    assert kinds == ["prior", "belief", "scan", "outcome"]
