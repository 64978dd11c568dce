"""Every kind of bad input gets its problem document, and leaves everything that is stored as it was."""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import pytest

from tests.support.quiet_robot import QuietRobot
from tests.support.serving import (
    LIDAR,
    PREDICTIONS,
    Json,
    Service,
    box_obj,
    changed,
    data_scenario,
    json_of,
    mesh_scenario,
    scan_of,
    serving,
)
from voa_service.settings import Limits

LIMITS = Limits(
    beams=64,
    poses=20,
    sensors=10,
    grasps=10,
    faces=100,
    upload_bytes=500_000,
    body_bytes=3_000_000,
    numbers=100_000,
    parts=250_000,
)
NAN, INF, HUGE = float("nan"), float("inf"), 10**400
INVALID, UNKNOWN, NO_MESH, CONFLICT = "invalid-request", "unknown-name", "no-mesh", "claim-conflict"
TYPE = "unsupported-media-type"

Change = tuple[str, Any]


class World(NamedTuple):
    """What the requests name: ids as they come."""

    service: Service
    data: str
    mesh: str
    object: str
    data_session: str
    mesh_session: str


@contextmanager
def some_world(folder: Path) -> Iterator[World]:
    """A service with two scenarios, a session on each, and a robot mapped to a scenario and one to a session."""
    with serving(folder, limits=LIMITS) as service:
        box = service.upload(box_obj())
        mesh = mesh_scenario(box, lidar={"preset": "lds-01", "beams": 60, "angle_increment": 0.1, "height_m": 0.02})
        data_id, mesh_id = service.create(data_scenario()), service.create(mesh)
        sessions = service.open(data_id), service.open(mesh_id)
        service.post(f"/v1/sessions/{sessions[0]}/scans", scan_of([0.5, 0.5, None, 1.0]))
        robots = service.inside.robots
        robots.mapped("free", "free/scan", QuietRobot(), scenario=data_id)
        robots.mapped("fixed", "fixed/scan", QuietRobot(), session=sessions[0])
        yield World(service, data_id, mesh_id, box, *sessions)


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    with some_world(tmp_path_factory.mktemp("bad")) as own:
        yield own


class Case(NamedTuple):
    """A request and what it must be answered; braces in the path stand for the world's ids."""

    name: str
    path: str
    body: Any
    status: int = 422
    kind: str = INVALID
    says: str = ""
    method: str = "POST"
    headers: Mapping[str, str] = MappingProxyType({})


def in_data_scenario(*rows: tuple[str, str, Any, str, str]) -> Iterator[Case]:
    """Rows of name, path in the scenario of data, value there, kind, what the detail must say."""
    for name, where, value, kind, says in rows:
        yield Case(f"scenario: {name}", "/v1/scenarios", changed(data_scenario(), where, value), 422, kind, says)


def in_mesh_scenario(*rows: tuple[str, str, Any, str, str]) -> Iterator[Case]:
    for name, where, value, kind, says in rows:
        body = changed(mesh_scenario("{object}"), where, value)
        yield Case(f"scenario of a mesh: {name}", "/v1/scenarios", body, 422, kind, says)


def without(body: Json, name: str) -> Json:
    return {key: value for key, value in body.items() if key != name}


def nested(levels: int) -> Any:
    value: Any = 0
    for _ in range(levels):
        value = [value]
    return value


RULE = "update"
PRIOR: Json = {"form": "pose_model", "categories": [{"pose": "A", "probability": 1.0}]}
GAUSS: Json = {"mean_xy": [0.0, 0.0], "covariance_xy": [[1.0, 0.0], [0.0, 1.0]]}


def prior(**changes: Any) -> Json:
    return {"form": "pose_model", "categories": [{"pose": "A", "probability": 1.0} | changes]}


SCENARIOS = [
    *in_data_scenario(
        ("no name", "name", "", INVALID, "name"),
        ("a name of 129 characters", "name", "n" * 129, INVALID, "128"),
        ("a number as name", "name", 5, INVALID, "string"),
        ("half a surrogate pair as name", "name", "\ud800", INVALID, "unicode"),
        ("an unknown field", "colour", "red", INVALID, "colour"),
        ("an unknown field in a pose", "poses.0.colour", "red", INVALID, "colour"),
        ("an unknown field in a grasp", "grasps.0.colour", "red", INVALID, "colour"),
        ("an unknown field in scores", "scores.colour", "red", INVALID, "colour"),
        ("an unknown field in a sensor", "sensors.0.colour", "red", INVALID, "colour"),
        ("an unknown field in the lidar", "lidar.colour", "red", INVALID, "colour"),
        ("an unknown field in the update", "update.colour", "red", INVALID, "colour"),
        ("an unknown field in the workspace", "workspace", {"min": [0, 0], "max": [1, 1], "z": 1}, INVALID, "z"),
        ("an unknown field in the prior", "prior", PRIOR | {"colour": 1}, INVALID, "colour"),
        ("no poses", "poses", [], INVALID, "poses"),
        ("too many poses", "poses", [{"name": str(i)} for i in range(21)], INVALID, "at most 20"),
        ("a pose name twice", "poses.1.name", "P1", INVALID, "'P1' twice"),
        ("a pose without a name", "poses.0", {}, INVALID, "name"),
        ("poses that are none", "poses", "P1", INVALID, "list"),
        ("a position of two numbers", "poses.0.position", [0, 0], INVALID, "position"),
        ("geometry of some poses", "poses.0.position", [0, 0, 0], INVALID, "of every pose, or of none"),
        ("no grasps", "grasps", [], INVALID, "grasps"),
        ("too many grasps", "grasps", [{"name": str(i)} for i in range(11)], INVALID, "at most 10"),
        ("a grasp name twice", "grasps.1.name", "G1", INVALID, "'G1' twice"),
        ("NaN in a grasp's data", "grasps.0.data", {"deep": [{"x": NAN}]}, INVALID, "finite"),
        ("infinity in a sensor's data", "sensors.0.data", [INF], INVALID, "finite"),
        ("data nested too deep", "grasps.0.data", nested(65), INVALID, "at most 64 levels"),
        ("data nested where parsers differ", "grasps.0.data", nested(220), INVALID, "at most 64 levels"),
        ("half a surrogate pair in data", "grasps.0.data", ["\ud800"], INVALID, "surrogate"),
        ("half a surrogate pair as key in data", "grasps.0.data", {"\udfff": 1}, INVALID, "surrogate"),
        ("too few rows of scores", "scores.probabilities", [[0.1, 0.2, 0.3]], INVALID, "one row per grasp (2)"),
        ("too many rows of scores", "scores.probabilities", [[0.1] * 3] * 3, INVALID, "one row per grasp (2)"),
        ("too few scores in a row", "scores.probabilities.1", [0.1, 0.2], INVALID, "one entry per pose (3)"),
        ("too many scores in a row", "scores.probabilities.1", [0.1] * 4, INVALID, "one entry per pose (3)"),
        ("no scores", "scores.probabilities", [], INVALID, "scores"),
        ("empty rows of scores", "scores.probabilities", [[], []], INVALID, "scores"),
        ("a score above 1", "scores.probabilities.0.0", 1.5, INVALID, "less than or equal to 1"),
        ("a negative score", "scores.probabilities.0.0", -0.1, INVALID, "greater than or equal to 0"),
        ("NaN as score", "scores.probabilities.0.0", NAN, INVALID, "scores"),
        ("infinity as score", "scores.probabilities.0.0", INF, INVALID, "scores"),
        ("a score as string", "scores.probabilities.0.0", "0.5", INVALID, "number"),
        ("a score as boolean", "scores.probabilities.0.0", True, INVALID, "number"),
        ("a huge integer as score", "scores.probabilities.0.0", HUGE, INVALID, "scores"),
        ("scores that are none", "scores", 5, INVALID, "scores"),
        ("scores in neither form", "scores", {}, INVALID, "scores"),
        ("scores in both forms", "scores.successes", [[1, 1, 1]] * 2, INVALID, "successes"),
        ("more successes than attempts", "scores", {"attempts": 2, "successes": [[3, 0, 0], [0, 0, 0]]}, INVALID, "2"),
        ("negative successes", "scores", {"attempts": 2, "successes": [[-1, 0, 0], [0, 0, 0]]}, INVALID, "0"),
        ("half a success", "scores", {"attempts": 2, "successes": [[0.5, 0, 0], [0, 0, 0]]}, INVALID, "integer"),
        ("no attempts", "scores", {"attempts": 0, "successes": [[0, 0, 0], [0, 0, 0]]}, INVALID, "attempts"),
        ("successes without attempts", "scores", {"successes": [[0, 0, 0], [0, 0, 0]]}, INVALID, "attempts"),
        ("huge successes", "scores", {"attempts": 2, "successes": [[HUGE, 0, 0], [0, 0, 0]]}, INVALID, "less than"),
        ("huge attempts", "scores", {"attempts": HUGE, "successes": [[0, 0, 0], [0, 0, 0]]}, INVALID, "less than"),
        ("no sensors", "sensors", [], INVALID, "sensors"),
        (
            "too many sensors",
            "sensors",
            [{"name": str(i), "x": 0, "y": 0, "yaw_rad": 0} for i in range(11)],
            INVALID,
            "at most 10",
        ),
        ("a sensor name twice", "sensors.1.name", "Q1", INVALID, "names that differ"),
        ("a sensor without x", "sensors.0", {"name": "Q1", "y": 0, "yaw_rad": 0}, INVALID, "x"),
        ("NaN as x", "sensors.0.x", NAN, INVALID, "finite"),
        ("infinity as yaw", "sensors.0.yaw_rad", -INF, INVALID, "finite"),
        ("a huge integer as x", "sensors.0.x", HUGE, INVALID, "x"),
        ("a huge number as x", "sensors.0.x", 1e300, INVALID, "1000000"),
        ("a string as x", "sensors.0.x", "0", INVALID, "number"),
        ("a boolean as x", "sensors.0.x", False, INVALID, "number"),
        ("a negative cost", "sensors.0.cost", -0.1, INVALID, "cost"),
        ("an unknown preset", "lidar.preset", "lds-99", UNKNOWN, "lds-01"),
        ("a lidar that is not complete", "lidar", without(LIDAR, "zero"), INVALID, "zero"),
        ("a lidar of nothing", "lidar", {}, INVALID, "preset"),
        ("no beams", "lidar.beams", 0, INVALID, "beams"),
        ("negative beams", "lidar.beams", -4, INVALID, "beams"),
        ("half a beam", "lidar.beams", 4.5, INVALID, "integer"),
        ("too many beams", "lidar.beams", 65, INVALID, "at most 64"),
        ("10^12 beams", "lidar.beams", 10**12, INVALID, "at most 64"),
        ("a huge integer of beams", "lidar.beams", HUGE, INVALID, "at most 64"),
        ("beams that do not turn", "lidar.angle_increment", 0.0, INVALID, "other than 0"),
        ("beams more than a turn apart", "lidar.angle_increment", 7.0, INVALID, "turn"),
        ("beams that hardly turn", "lidar.angle_increment", 1e-320, INVALID, "1e-06"),
        ("range_min above range_max", "lidar.range_min", 3.0, INVALID, "range_max"),
        ("a negative range_min", "lidar.range_min", -0.1, INVALID, "range_min"),
        ("range_max 0", "lidar.range_max", 0.0, INVALID, "range_max"),
        ("a zero that means something else", "lidar.zero", "hit", INVALID, "'missing' or 'no_return'"),
        ("a dropout of 1", "lidar.dropout", 1.0, INVALID, "dropout"),
        ("no noise", "lidar.noise_m", 0.0, INVALID, "noise_m"),
        ("an unknown rule", RULE, {"rule": "magic"}, INVALID, "'margin', 'exponential'"),
        ("a rule of another type", RULE, {"rule": 5}, INVALID, "rule"),
        ("no rule", RULE, {}, INVALID, "rule"),
        ("another rule's parameter", RULE, {"rule": "margin", "sigma_m": 1.0}, INVALID, "sigma_m"),
        ("a parameter that exponential has not", RULE, {"rule": "exponential", "margin_m": 0.1}, INVALID, "margin_m"),
        ("a margin of 0", RULE, {"rule": "margin", "margin_m": 0}, INVALID, "margin_m"),
        ("a negative sigma", RULE, {"rule": "gaussian", "sigma_m": -1.0}, INVALID, "sigma_m"),
        ("a sigma that vanishes", RULE, {"rule": "gaussian", "sigma_m": 1e-320}, INVALID, "sigma_m"),
        ("a sigma that overflows", RULE, {"rule": "gaussian", "sigma_m": 1e308}, INVALID, "sigma_m"),
        ("NaN as floor", RULE, {"rule": "inverse_rmsd", "floor_m": NAN}, INVALID, "floor_m"),
        ("a temper above 1", RULE, {"rule": "beam", "temper": 1.5}, INVALID, "temper"),
        (
            "beams that are nothing",
            RULE,
            {"rule": "beam", "z_hit": 0, "z_short": 0, "z_no_return": 0, "z_random": 0},
            INVALID,
            "sum above 0",
        ),
        ("a no_return_m of 0", RULE, {"rule": "exponential", "no_return_m": 0}, INVALID, "no_return_m"),
        ("an unknown policy", RULE, {"rule": "exponential", "on_no_match": "reset"}, INVALID, "nearest"),
        ("a score floor above a half", RULE, {"rule": "exponential", "score_floor": 0.6}, INVALID, "0.5"),
        ("a negative fit", RULE, {"rule": "exponential", "reject_above_rmsd_mm": -1}, INVALID, "reject"),
        ("a workspace inside out", "workspace", {"min": [1, 1], "max": [0, 0]}, INVALID, "min below max"),
        ("a workspace in one dimension", "workspace", {"min": [1], "max": [0, 0]}, INVALID, "min"),
        ("NaN in a workspace", "workspace", {"min": [NAN, 0], "max": [1, 1]}, INVALID, "finite"),
        ("neither object nor predictions", "predictions", None, INVALID, "object, predictions"),
        ("empty predictions", "predictions", {}, INVALID, "object, predictions"),
        ("predictions of some sensors", "predictions", without(PREDICTIONS, "Q2"), INVALID, "'Q2'"),
        ("predictions of an unknown sensor", "predictions.Q9", PREDICTIONS["Q1"], UNKNOWN, "'Q1', 'Q2'"),
        ("predictions of some poses", "predictions.Q1", without(PREDICTIONS["Q1"], "P3"), INVALID, "'P3'"),
        ("predictions of an unknown pose", "predictions.Q1.P9", [1, 1, 1, 1], UNKNOWN, "'P1', 'P2', 'P3'"),
        ("half a surrogate pair as sensor", "predictions.\ud800", PREDICTIONS["Q1"], INVALID, "unicode"),
        ("too few beams in one prediction", "predictions.Q1.P1", [0.5] * 3, INVALID, "equally many beams"),
        ("too few beams in all", "predictions.Q1", dict.fromkeys(("P1", "P2", "P3"), [0.5] * 3), INVALID, "4 beams"),
        ("too many beams in a prediction", "predictions.Q1.P1", [0.5] * 65, INVALID, "at most 64"),
        ("no beams in a prediction", "predictions.Q1.P1", [], INVALID, "P1"),
        ("a negative prediction", "predictions.Q1.P1.0", -0.5, INVALID, "P1"),
        ("NaN as prediction", "predictions.Q1.P1.0", NAN, INVALID, "finite"),
        ("infinity as prediction", "predictions.Q1.P1.0", INF, INVALID, "finite"),
        ("a string as prediction", "predictions.Q1.P1.0", "0.5", INVALID, "number"),
        ("an unknown object", "object", "nothing", UNKNOWN, "POST /v1/objects"),
        ("half a surrogate pair as object", "object", "\ud800", INVALID, "unicode"),
        ("a prior of another length", "prior", [0.5, 0.5], INVALID, "3"),
        ("a prior that sums to 0", "prior", [0, 0, 0], INVALID, "within 1e-6 of 1"),
        ("a prior that sums to 2", "prior", [1, 1, 0], INVALID, "within 1e-6 of 1"),
        ("a negative prior", "prior", [1.5, -0.5, 0], INVALID, "greater than or equal to 0"),
        ("NaN in a prior", "prior", [NAN, 0.5, 0.5], INVALID, "finite"),
        ("an empty prior", "prior", [], INVALID, "prior"),
        ("a number as prior", "prior", 1, INVALID, "prior"),
        ("a prior of more poses than allowed", "prior", [0.04] * 25, INVALID, "at most 20"),
        ("a pose model without geometry", "prior", prior(pose="P1"), NO_MESH, "position"),
        ("a pose model of an unknown pose", "prior", PRIOR, UNKNOWN, "'P1', 'P2', 'P3'"),
        ("an unknown form of prior", "prior", {"form": "magic"}, INVALID, "pose_model"),
    ),
    *in_mesh_scenario(
        ("poses without geometry", "poses", [{"name": "A"}, {"name": "B"}], INVALID, "position and quaternion_wxyz"),
        ("geometry of one pose", "poses.1", {"name": "B"}, INVALID, "of every pose, or of none"),
        ("a quaternion of 0", "poses.0.quaternion_wxyz", [0, 0, 0, 0], INVALID, "unit quaternion"),
        ("a quaternion of length 2", "poses.0.quaternion_wxyz", [2, 0, 0, 0], INVALID, "unit quaternion"),
        ("a quaternion of three numbers", "poses.0.quaternion_wxyz", [1, 0, 0], INVALID, "quaternion_wxyz"),
        ("a quaternion that overflows", "poses.0.quaternion_wxyz", [1e308] * 4, INVALID, "1000000"),
        ("NaN in a position", "poses.0.position.2", NAN, INVALID, "finite"),
        ("no height", "lidar", {"preset": "lds-01", "beams": 60}, INVALID, "height_m"),
        ("NaN as height", "lidar.height_m", NAN, INVALID, "finite"),
        ("no such object", "object", "0" * 64, UNKNOWN, "POST /v1/objects"),
        ("a preset's own beams beyond the limit", "lidar.beams", 65, INVALID, "at most 64"),
        ("categories that sum to 2", "prior", prior(probability=2.0), INVALID, "sum"),
        ("one way to rest in two categories", "prior", {**PRIOR, "categories": [
            {"pose": "A", "probability": 0.5}, {"pose": "B", "probability": 0.5}]}, INVALID, "rest differently"),
        ("no categories", "prior", {"form": "pose_model", "categories": []}, INVALID, "categories"),
        ("a mean without a covariance", "prior", prior(mean_xy=[0.0, 0.0]), INVALID, "both or neither"),
        ("a covariance that is none", "prior", prior(**GAUSS | {"covariance_xy": [[-1, 0], [0, 1]]}), INVALID, "posit"),
        ("a covariance of one row", "prior", prior(**GAUSS | {"covariance_xy": [[1, 0]]}), INVALID, "covariance_xy"),
        ("a negative concentration", "prior", prior(yaw_concentration=-1), INVALID, "yaw_concentration"),
    ),
]  # fmt: skip

GOOD = [0.5, 0.5, None, 1.0]
SCANS = "/v1/sessions/{data_session}/scans"
HERE: Json = {"x": 0.3, "y": 0.0, "yaw_rad": 3.14}


def scan(name: str, kind: str = INVALID, says: str = "", *, ranges: Any = GOOD, path: str = SCANS, **more: Any) -> Case:
    """A scan with other ranges or other fields."""
    return Case(f"scan: {name}", path, {"sensor": "Q1", "scan": {"ranges": ranges} | more}, 422, kind, says)


def placed(name: str, place: Json, kind: str, says: str, path: str = "/v1/sessions/{mesh_session}/scans") -> Case:
    return Case(f"scan: {name}", path, place | {"scan": {"ranges": [0.3] * 60}}, 422, kind, says)


SCAN_CASES = [
    scan("no ranges", says="ranges", ranges=[]),
    scan("90 000 beams", says="at most 64", ranges=[1.0] * 90_000),
    scan("one beam too many for the service", says="at most 64", ranges=[1.0] * 65),
    scan("another number of beams than the data", "beam-grid-mismatch", "4 from 0 rad", ranges=[1.0] * 5),
    scan("beams elsewhere than the data's", "beam-grid-mismatch", "0.1 rad", angle_min=0.01),
    scan("NaN as range", says="finite", ranges=[NAN, 1, 1, 1]),
    scan("infinity as range", says="finite", ranges=[INF, 1, 1, 1]),
    scan("a negative range", says="greater than or equal to 0", ranges=[-0.1, 1, 1, 1]),
    scan("a string as range", says="number", ranges=["1", 1, 1, 1]),
    scan("a boolean as range", says="number", ranges=[True, 1, 1, 1]),
    scan("a huge integer as range", says="ranges", ranges=[HUGE, 1, 1, 1]),
    scan("ranges that are no list", says="list", ranges="1,1,1,1"),
    scan("an index beyond the last beam in no_return", says="0 to 3", no_return=[4]),
    scan("a negative index in no_return", says="no_return", no_return=[-1]),
    scan("a huge index in no_return", says="0 to 3", no_return=[HUGE]),
    scan("half an index in no_return", says="integer", no_return=[0.5]),
    scan("more indices than beams are allowed", says="at most 64", no_return=[0] * 65),
    scan("beams that do not turn", says="other than 0", angle_increment=0.0),
    scan("beams that turn for ever", says="1000000", angle_increment=1e300),
    scan("beams more than a turn apart", says="turn", angle_increment=10.0),
    scan("NaN as angle", says="finite", angle_min=NAN),
    scan("a huge integer as angle", says="angle_min", angle_min=HUGE),
    scan("range_min above range_max", says="range_max", range_min=1.0, range_max=0.5),
    scan("range_min above the lidar's range_max", says="range_max", range_min=3.0),
    scan("range_max below the lidar's range_min", says="range_max", range_max=0.05),
    scan("a negative range_min", says="range_min", range_min=-1.0),
    scan("NaN as stamp", says="finite", stamp=NAN),
    scan("NaN deep in the stamp", says="finite", stamp={"a": [1, {"b": [NAN]}]}),
    scan("a stamp of 10^2 levels", says="at most 64 levels", stamp=nested(100)),
    scan("half a surrogate pair in the stamp", says="surrogate", stamp={"\ud800": 1}),
    scan("an unknown field", says="colour", colour="red"),
    scan("an unknown sensor", UNKNOWN, "'E', 'N'", path="/v1/sessions/{mesh_session}/scans"),
    Case("scan: an unknown field beside it", SCANS, scan_of(GOOD) | {"colour": 1}, says="colour"),
    Case("scan: neither sensor nor sensor_pose", SCANS, {"scan": {"ranges": GOOD}}, says="exactly one of"),
    Case("scan: both", SCANS, scan_of(GOOD) | {"sensor_pose": HERE}, says="exactly one of"),
    Case("scan: sensor null", SCANS, scan_of(GOOD) | {"sensor": None}, says="exactly one of"),
    Case("scan: no scan", SCANS, {"sensor": "Q1"}, says="scan"),
    Case("scan: half a surrogate pair as sensor", SCANS, scan_of(GOOD, "\ud800"), says="unicode"),
    Case("scan: sensor_pose without a mesh", SCANS, {"sensor_pose": HERE, "scan": {"ranges": GOOD}}, 422, NO_MESH),
    placed("a place that is no sensor_pose", HERE, INVALID, "x"),
    placed("an incomplete sensor_pose", {"sensor_pose": without(HERE, "x")}, INVALID, "sensor_pose.x"),
    placed("an unknown field in sensor_pose", {"sensor_pose": HERE | {"z": 0}}, INVALID, "z"),
    placed("NaN in sensor_pose", {"sensor_pose": HERE | {"x": NAN}}, INVALID, "finite"),
    placed("a sensor_pose at the end of the world", {"sensor_pose": HERE | {"x": 1e308}}, INVALID, "1000000"),
    placed("a negative uncertainty", {"sensor_pose": HERE | {"std": {"xy_m": -1}}}, INVALID, "xy_m"),
    placed("an unknown uncertainty", {"sensor_pose": HERE | {"std": {"z": 1}}}, INVALID, "z"),
]

UPDATE: Json = {"scenario": "{data}", "belief": [0.2, 0.3, 0.5], **scan_of(GOOD)}
RANK: Json = {"scenario": "{data}", "belief": [0.2, 0.3, 0.5]}
VOA = "/v1/sessions/{data_session}/voa"
OUTCOMES = "/v1/sessions/{data_session}/grasp-outcomes"
PREDICT = "/v1/scenarios/{data}/predictions"


def beliefs(path: str, body: Json, method: str = "POST") -> Iterator[Case]:
    """What is wrong with a belief, wherever one is sent."""
    for name, belief, says in (
        ("of another length", [0.5, 0.5], "3"),
        ("that sums to 0", [0.0, 0.0, 0.0], "within 1e-6 of 1"),
        ("that sums to 2", [1.0, 0.5, 0.5], "within 1e-6 of 1"),
        ("that is negative", [1.5, -0.5, 0.0], "greater than or equal to 0"),
        ("with NaN", [NAN, 0.5, 0.5], "finite"),
        ("with infinity", [INF, 0.0, 0.0], "finite"),
        ("that overflows", [1e308, 1e308, 0.0], "1000000"),
        ("with a huge integer", [HUGE, 0, 0], "belief"),
        ("of strings", ["1", "0", "0"], "number"),
        ("of booleans", [True, False, False], "number"),
        ("that is empty", [], "belief"),
        ("of more poses than allowed", [0.04] * 25, "at most 20"),
        ("that is no list", 1.0, "belief"),
    ):
        yield Case(f"{path}: a belief {name}", path, body | {"belief": belief}, says=says, method=method)
    yield Case(f"{path}: no belief", path, without(body, "belief"), says="belief", method=method)
    yield Case(f"{path}: an unknown field", path, body | {"colour": 1}, says="colour", method=method)


def stateless(path: str, body: Json) -> Iterator[Case]:
    """What is wrong with a computation for the belief in the request."""
    yield from beliefs(path, body)
    yield Case(f"{path}: an unknown scenario", path, body | {"scenario": "nothing"}, 422, UNKNOWN, "POST /v1/scenarios")
    yield Case(f"{path}: half a surrogate pair as scenario", path, body | {"scenario": "\ud800"}, says="unicode")


def rankings(path: str, body: Json) -> Iterator[Case]:
    """What is wrong with a ranking, of a session or of a belief."""
    place = {"x": 0.0, "y": 0.0, "yaw_rad": 0.0}
    for name, more, kind, says in (
        ("an empty list of sensors", {"sensors": []}, INVALID, "sensors"),
        ("an unknown sensor", {"sensors": ["Q9"]}, UNKNOWN, "'Q1', 'Q2'"),
        ("a sensor twice", {"sensors": ["Q1", "Q1"]}, INVALID, "names that differ"),
        ("a number as sensor", {"sensors": [1]}, INVALID, "sensors.0"),
        ("too many sensors", {"sensors": ["Q1"] * 11}, INVALID, "at most 10"),
        ("a sensor pose without a mesh", {"sensors": [place]}, NO_MESH, "no mesh"),
        ("a sensor pose that is NaN", {"sensors": [place | {"x": NAN}]}, INVALID, "finite"),
        ("a sensor pose of negative cost", {"sensors": [place | {"cost": -1}]}, INVALID, "cost"),
        ("an unknown field in a sensor pose", {"sensors": [place | {"z": 1}]}, INVALID, "sensors.0"),
        ("an unknown definition", {"definition": "magic"}, INVALID, "'posterior' or 'executed'"),
        ("an empty list of grasps", {"grasps": []}, INVALID, "grasps"),
        ("an unknown grasp", {"grasps": ["G9"]}, UNKNOWN, "'G1', 'G2'"),
        ("a grasp twice", {"grasps": ["G1", "G1"]}, INVALID, "'G1' twice"),
        ("a sensor belief of another length", {"sensor_belief": [1.0]}, INVALID, "sensor_belief"),
        ("a sensor belief that sums to 0", {"sensor_belief": [0, 0, 0]}, INVALID, "within 1e-6 of 1"),
        ("outcomes as string", {"outcomes": "yes"}, INVALID, "boolean"),
        ("an unknown field beside them", {"colour": 1}, INVALID, "colour"),
    ):
        yield Case(f"{path}: {name}", path, body | more, 422, kind, says)


RAW_SCAN = json.dumps(scan_of(GOOD)).encode()
JSON = {"content-type": "application/json"}
BIG = b"[" + b"0" * 3_000_001 + b"]"
SESSION = "/v1/sessions/{data_session}"

BODIES = [
    Case("a body that is not JSON", SCANS, b"ranges", 400, "malformed-json", headers=JSON),
    Case("a body that is cut off", SCANS, RAW_SCAN[:-3], 400, "malformed-json", headers=JSON),
    Case("a trailing comma", "/v1/scenarios", b'{"name": "a",}', 400, "malformed-json", headers=JSON),
    Case("JSON of 100 000 levels", SCANS, b"[" * 100_000 + b"]" * 100_000, 400, "malformed-json", headers=JSON),
    Case("a stamp of 100 000 levels", SCANS, RAW_SCAN[:-2] + b', "stamp": ' + b'{"a":' * 100_000 + b"1", 400,
         "malformed-json", headers=JSON),
    Case("an integer of 5 000 digits", SCANS, b'{"a": ' + b"1" * 5000 + b"}", 400, "malformed-json", headers=JSON),
    Case("Latin-1", SCANS, RAW_SCAN.replace(b"Q1", b"\xe9"), 400, "malformed-json", "UTF-8", headers=JSON),
    Case("half a surrogate pair in the bytes", SCANS, RAW_SCAN.replace(b"Q1", b"\xed\xa0\x80"), 400,
         "malformed-json", "UTF-8", headers=JSON),
    Case("UTF-16", SCANS, RAW_SCAN.decode().encode("utf-16"), 400, "malformed-json", "UTF-8", headers=JSON),
    Case("UTF-16 without a mark", SCANS, RAW_SCAN.decode().encode("utf-16-le"), 400, "malformed-json", "UTF-8",
         headers=JSON),
    Case("UTF-32", "/v1/scenarios", RAW_SCAN.decode().encode("utf-32"), 400, "malformed-json", "UTF-8", headers=JSON),
    Case("a character that is cut off", SCANS, b'"\xc3', 400, "malformed-json", "UTF-8", headers=JSON),
    Case("an empty body", SCANS, b"", says="body", headers=JSON),
    Case("null", SCANS, b"null", says="body", headers=JSON),
    Case("a list", SCANS, b"[]", says="body", headers=JSON),
    Case("a string", SCANS, b'"scan"', says="body", headers=JSON),
    Case("text/plain", SCANS, RAW_SCAN, 415, TYPE, "application/json", headers={"content-type": "text/plain"}),
    Case("no content type", SCANS, RAW_SCAN, 415, TYPE, "got none", headers={"content-type": ""}),
    Case("text/plain in chunks", SCANS, [RAW_SCAN[:9], RAW_SCAN[9:]], 415, TYPE, "application/json",
         headers={"content-type": "text/plain"}),
    Case("a form", SCANS, b"sensor=Q1", 415, TYPE, "application/json",
         headers={"content-type": "application/x-www-form-urlencoded"}),
    Case("another JSON", SCANS, RAW_SCAN, 415, TYPE, "application/json",
         headers={"content-type": "application/a+json"}),
    Case("text/plain where no body is expected", "/v1/robots/free/look", b"{}", 415, TYPE, "application/json",
         headers={"content-type": "text/plain"}),
    Case("a key twice", SCANS, RAW_SCAN.replace(b'{"sensor": "Q1",', b'{"sensor": "Q1", "sensor": "Q1",'),
         says="'sensor' twice", headers=JSON),
    Case("a key twice, further in", SCANS, RAW_SCAN.replace(b'"ranges"', b'"ranges": [1], "ranges"'),
         says="'ranges' twice", headers=JSON),
    Case("a key twice in what is the user's own", SCANS, RAW_SCAN[:-2] + b', "stamp": {"a": [{"b": 1, "b": 1}]}}}',
         says="'b' twice", headers=JSON),
    Case("more keys than poses", SCANS, json_of(scan_of(GOOD) | {f"k{i}": 0 for i in range(21)}),
         says="at most 20 keys", headers=JSON),
    Case("too many lists", SCANS, b"[" * 250_001, 413, "too-large", "250000 texts", headers=JSON),
    Case("too many texts", SCANS, b'""' * 250_001, 413, "too-large", "250000 texts", headers=JSON),
    Case("too many bytes, declared", SCANS, BIG, 413, "too-large", "3000000 bytes", headers=JSON),
    Case("too many bytes, in chunks", SCANS, [BIG[:1_500_000], BIG[1_500_000:]], 413, "too-large", "3000000 bytes",
         headers=JSON),
    Case("too many numbers", SCANS, b"[" + b"0," * 100_001 + b"0]", 413, "too-large", "100000 values", headers=JSON),
    Case("10^6 beams", SCANS, b'{"sensor": "Q1", "scan": {"ranges": [' + b"1," * 999_999 + b"1]}}", 413, "too-large",
         "100000 values", headers=JSON),
    Case("too many numbers, in chunks", SCANS, [b"[" + b"0," * 60_000, b"0," * 60_000 + b"0]"], 413, "too-large",
         "100000 values", headers=JSON),
]  # fmt: skip

PATHS = [
    Case("no such resource", "/v1/nothing", None, 404, "not-found", "/docs", "GET"),
    Case("no such resource to post to", "/v2/scenarios", {}, 404, "not-found", "/docs"),
    Case("an unknown object", "/v1/objects/nothing", None, 404, "not-found", "'nothing'", "GET"),
    Case("stable poses of one", "/v1/objects/nothing/stable-poses", None, 404, "not-found", "'nothing'", "GET"),
    Case("an unknown scenario", "/v1/scenarios/nothing", None, 404, "not-found", "'nothing'", "GET"),
    Case("warnings of one", "/v1/scenarios/nothing/warnings", None, 404, "not-found", "'nothing'", "GET"),
    Case("predictions of one", "/v1/scenarios/nothing/predictions", {}, 404, "not-found", "'nothing'"),
    Case("an unknown session", "/v1/sessions/nothing", None, 404, "not-found", "'nothing'", "GET"),
    Case("to delete it", "/v1/sessions/nothing", None, 404, "not-found", "'nothing'", "DELETE"),
    Case("a scan for it", "/v1/sessions/nothing/scans", scan_of(GOOD), 404, "not-found", "'nothing'"),
    Case("a ranking for it", "/v1/sessions/nothing/voa", {}, 404, "not-found", "'nothing'"),
    Case("its ranking", "/v1/sessions/nothing/voa", None, 404, "not-found", "'nothing'", "GET"),
    Case("its grasps", "/v1/sessions/nothing/grasps", None, 404, "not-found", "'nothing'", "GET"),
    Case("its history", "/v1/sessions/nothing/history", None, 404, "not-found", "'nothing'", "GET"),
    Case("its events", "/v1/sessions/nothing/events", None, 404, "not-found", "'nothing'", "GET"),
    Case("a belief for it", "/v1/sessions/nothing/belief", {"belief": None}, 404, "not-found", "'nothing'", "PUT"),
    Case(
        "an outcome for it",
        "/v1/sessions/nothing/grasp-outcomes",
        {"grasp": "G1", "success": True},
        404,
        "not-found",
        "'nothing'",
    ),
    Case("events after no version", SESSION + "/events", None, says="", method="GET", headers={"last-event-id": "abc"}),
    Case("bytes that are no text in an id", "/v1/sessions/%ed%a0%80", None, 404, "not-found", "", "GET"),
    Case("an unknown grasp in a query", SESSION + "/grasps?grasps=G9", None, 422, UNKNOWN, "'G1', 'G2'", "GET"),
    Case("a grasp twice in a query", SESSION + "/grasps?grasps=G1&grasps=G1", None, says="twice", method="GET"),
    Case("an unknown definition in a query", VOA + "?definition=magic", None, says="'executed'", method="GET"),
    Case(
        "an unknown parameter in a query",
        VOA + "?defintion=executed",
        None,
        says="one of definition, outcomes",
        method="GET",
    ),
    Case(
        "an unknown parameter beside others",
        "/v1/objects?limit=5&colour=red",
        None,
        says="one of limit, after, sha256, type, scale, up",
        method="GET",
    ),
    Case(
        "a parameter twice",
        VOA + "?outcomes=true&outcomes=true",
        None,
        says="query.outcomes: expected once, got 2",
        method="GET",
    ),
    Case(
        "a parameter twice, with different values",
        "/v1/sessions?limit=5&limit=6",
        None,
        says="query.limit",
        method="GET",
    ),
    Case("a parameter where there are none", SESSION + "?version=1", None, says="takes none", method="GET"),
    Case("a parameter of a write", SCANS + "?dry=true", scan_of(GOOD), says="query.dry"),
    Case("a parameter to delete", SESSION + "?force=1", None, says="query.force", method="DELETE"),
    Case("a parameter of no value", "/v1/lidars?verbose", None, says="query.verbose", method="GET"),
    Case("outcomes that are not yes or no", VOA + "?outcomes=perhaps", None, says="boolean", method="GET"),
    *(
        Case(f"{what}: {name}", f"/v1/{what}?{query}", None, says=says, method="GET")
        for what in ("objects", "scenarios", "sessions", "sessions/{data_session}/history")
        for name, query, says in (
            ("a cursor of another service", "after=abc", "`next` of a page"),
            ("a negative cursor", "after=-1", "`next` of a page"),
            ("an empty cursor", "after=", "`next` of a page"),
            ("a cursor beyond 64 bits", "after=" + "9" * 30, "`next` of a page"),
            ("a cursor in other digits", "after=%D9%A3", "`next` of a page"),
            ("no items", "limit=0", "greater than or equal to 1"),
            ("negative items", "limit=-1", "greater than or equal to 1"),
            ("too many items", "limit=1001", "less than or equal to 1000"),
            ("half an item", "limit=1.5", "integer"),
            ("not a number of items", "limit=nan", "integer"),
            ("an integer of 5 000 digits", "limit=" + "9" * 5000, "integer"),
        )
    ),
]

CROSS = {"sec-fetch-site": "cross-site"}
HEADERS = [
    Case("If-Match of an old version", SCANS, scan_of(GOOD), 412, "stale-version", "v0", headers={"if-match": '"v0"'}),
    Case("If-Match of a later version", SCANS, scan_of(GOOD), 412, "stale-version", "v7",
         headers={"if-match": '"v6", "v7"'}),
    Case("If-Match of somebody else", SCANS, scan_of(GOOD), 412, "stale-version", "v1", headers={"if-match": '"abc"'}),
    Case("a weak If-Match", SCANS, scan_of(GOOD), 412, "stale-version", "v1", headers={"if-match": 'W/"v1"'}),
    Case("If-Match of 30 digits", SCANS, scan_of(GOOD), 412, "stale-version", "v1",
         headers={"if-match": '"v' + "9" * 30 + '"'}),
    Case("a page of another site that deletes", SESSION, None, 403, "forbidden", "another site", "DELETE", CROSS),
    Case("a page of another site that asks for a look", "/v1/robots/free/look", None, 403, "forbidden", "another site",
         headers=CROSS),
    Case("a page of another site that reads", SESSION, None, 403, "forbidden", "another site", "GET", CROSS),
    Case("a page of another site that scans", SCANS, scan_of(GOOD), 403, "forbidden", "another site", headers=CROSS),
    Case("a name that leads here", SESSION, None, 421, "misdirected-request", "'evil.example'", "DELETE",
         {"host": "evil.example"}),
    Case("a name that leads here, to read", SESSION, None, 421, "misdirected-request", "VOA_HOSTS", "GET",
         {"host": "evil.example:8000"}),
    Case("an old If-Match to delete", SESSION, None, 412, "stale-version", "v0", "DELETE", {"if-match": '"v0"'}),
    Case("an old If-Match for a belief", SESSION + "/belief", {"belief": None}, 412, "stale-version", "v0", "PUT",
         {"if-match": '"v0"'}),
    Case("an old If-Match for an outcome", OUTCOMES, {"grasp": "G1", "success": True}, 412, "stale-version", "v0",
         headers={"if-match": '"v0"'}),
    Case("an empty Idempotency-Key", SCANS, scan_of(GOOD), says="Idempotency-Key", headers={"idempotency-key": ""}),
    Case("an Idempotency-Key of 256 characters", SCANS, scan_of(GOOD), says="at most 255",
         headers={"idempotency-key": "k" * 256}),
]  # fmt: skip

SESSIONS = [
    Case("session: no scenario", "/v1/sessions", {}, says="scenario"),
    Case("session: an unknown scenario", "/v1/sessions", {"scenario": "nothing"}, 422, UNKNOWN, "POST /v1/scenarios"),
    Case("session: half a surrogate pair", "/v1/sessions", {"scenario": "\ud800"}, says="unicode"),
    Case("session: a number", "/v1/sessions", {"scenario": 5}, says="string"),
    Case("session: an unknown field", "/v1/sessions", {"scenario": "{data}", "colour": 1}, says="colour"),
    Case("session: a prior of another length", "/v1/sessions", {"scenario": "{data}", "prior": [1.0]}, says="prior"),
    Case("session: a prior that sums to 0", "/v1/sessions", {"scenario": "{data}", "prior": [0, 0, 0]}, says="1e-6"),
    Case("session: a pose model of an unknown pose", "/v1/sessions", {"scenario": "{data}", "prior": PRIOR}, 422,
         UNKNOWN, "'P1'"),
    Case("session: a name as robots", "/v1/sessions", {"scenario": "{data}", "robots": "free"}, says="robots"),
    Case("session: an empty name of a robot", "/v1/sessions", {"scenario": "{data}", "robots": [""]}, says="robots.0"),
    Case("session: a robot twice", "/v1/sessions", {"scenario": "{data}", "robots": ["free", "free"]},
         says="'free' 2 times"),
    Case("session: an unknown robot", "/v1/sessions", {"scenario": "{data}", "robots": ["free", "nobody"]}, 422,
         UNKNOWN, "the mapped robots are 'fixed', 'free'"),
    Case("session: a robot of another scenario", "/v1/sessions", {"scenario": "{mesh}", "robots": ["free"]}, 409,
         CONFLICT, "is mapped to scenario"),
    Case("session: a robot whose mapping names a session", "/v1/sessions", {"scenario": "{data}", "robots": ["fixed"]},
         409, CONFLICT, "write `scenario` instead of `session`"),
]  # fmt: skip

CLAIM = "/v1/robots/free/session"
CLAIMS = [
    Case("claim: an unknown robot", "/v1/robots/nobody/session", {"session": "{data_session}"}, 404, "not-found",
         "'fixed', 'free'", "PUT"),
    Case("claim: nobody's, of an unknown robot", "/v1/robots/nobody/session", {"session": None}, 404, "not-found",
         "'nobody'", "PUT"),
    Case("claim: an unknown session", CLAIM, {"session": "nothing"}, 422, UNKNOWN, "POST /v1/sessions", "PUT"),
    Case("claim: a session on another scenario", CLAIM, {"session": "{mesh_session}"}, 409, CONFLICT,
         "is mapped to scenario", "PUT"),
    Case("claim: where the mapping names a session", "/v1/robots/fixed/session", {"session": "{data_session}"}, 409,
         CONFLICT, "write `scenario` instead of `session`", "PUT"),
    Case("claim: nobody's, where the mapping names a session", "/v1/robots/fixed/session", {"session": None}, 409,
         CONFLICT, "write `scenario` instead of `session`", "PUT"),
    Case("claim: no session", CLAIM, {}, says="session", method="PUT"),
    Case("claim: a number", CLAIM, {"session": 1}, says="string", method="PUT"),
    Case("claim: an empty name", CLAIM, {"session": ""}, says="session", method="PUT"),
    Case("claim: half a surrogate pair", CLAIM, {"session": "\ud800"}, says="unicode", method="PUT"),
    Case("claim: an unknown field", CLAIM, {"session": None, "robot": "free"}, says="robot", method="PUT"),
    Case("claim: no body", CLAIM, b"", says="body", method="PUT", headers=JSON),
    Case("claim: not JSON", CLAIM, b"{", 400, "malformed-json", method="PUT", headers=JSON),
    Case("claim: text/plain", CLAIM, b'{"session": null}', 415, TYPE, method="PUT",
         headers={"content-type": "text/plain"}),
]  # fmt: skip

FILE = "/v1/objects?sha256=" + "0" * 64
FILES = [
    Case("a mesh by no digest", "/v1/objects?sha256=abc&type=obj", None, says="sha256", method="GET"),
    Case("a mesh by a digest in capitals", "/v1/objects?sha256=" + "A" * 64 + "&type=obj", None, says="sha256",
         method="GET"),
    Case("a mesh by its digest alone", FILE, None, says="expected its type beside it", method="GET"),
    Case("a mesh of no type that there is", FILE + "&type=dae", None, says="'glb'", method="GET"),
    Case("a mesh by its digest, from a page on", FILE + "&type=obj&after=1", None, says="no `after`", method="GET"),
    Case("a mesh by its digest, at scale 0", FILE + "&type=obj&scale=0", None, says="scale", method="GET"),
    Case("a mesh by its digest, at no scale", FILE + "&type=obj&scale=nan", None, says="scale", method="GET"),
    Case("a mesh by its digest, with another axis up", FILE + "&type=obj&up=%2BX", None, says="'+Z'", method="GET"),
    Case("a mesh by its scale alone", "/v1/objects?scale=1", None, says="expected its sha256 beside", method="GET"),
]  # fmt: skip

CASES = [
    *SCENARIOS,
    *SESSIONS,
    *CLAIMS,
    *FILES,
    *SCAN_CASES,
    *stateless("/v1/updates", UPDATE),
    *stateless("/v1/rankings", RANK),
    *beliefs("/v1/sessions/{data_session}/belief", {"belief": [0.2, 0.3, 0.5]}, "PUT"),
    Case("outcome: an unknown grasp", OUTCOMES, {"grasp": "G9", "success": True}, 422, UNKNOWN, "'G1', 'G2'"),
    Case("outcome: half a surrogate pair as grasp", OUTCOMES, {"grasp": "\ud800", "success": True}, says="unicode"),
    Case("outcome: no grasp", OUTCOMES, {"success": True}, says="grasp"),
    Case("outcome: no success", OUTCOMES, {"grasp": "G1"}, says="success"),
    Case("outcome: a number as success", OUTCOMES, {"grasp": "G1", "success": 1}, says="boolean"),
    Case("outcome: a string as success", OUTCOMES, {"grasp": "G1", "success": "true"}, says="boolean"),
    Case("outcome: an unknown field", OUTCOMES, {"grasp": "G1", "success": True, "colour": 1}, says="colour"),
    *rankings("/v1/rankings", RANK),
    *rankings(VOA, {}),
    Case("update: an unknown sensor", "/v1/updates", UPDATE | {"sensor": "Q9"}, 422, UNKNOWN, "'Q1', 'Q2'"),
    Case("update: an empty scan", "/v1/updates", UPDATE | {"scan": {"ranges": []}}, says="ranges"),
    Case("update: both places", "/v1/updates", UPDATE | {"sensor_pose": HERE}, says="exactly one of"),
    Case("predictions: no sensors", PREDICT, {"sensors": []}, says="sensors"),
    Case("predictions: an unknown sensor", PREDICT, {"sensors": ["Q9"]}, 422, UNKNOWN, "'Q1', 'Q2'"),
    Case("predictions: a pose without a mesh", PREDICT, {"sensors": [HERE]}, 422, NO_MESH, "no mesh"),
    Case("predictions: an unknown field", PREDICT, {"poses": ["P1"]}, says="poses"),
    *BODIES,
    *PATHS,
    *HEADERS,
]


def filled(text: str, world: World) -> str:
    for name in ("data", "mesh", "object", "data_session", "mesh_session"):
        text = text.replace("{" + name + "}", getattr(world, name))
    return text


def send(world: World, case: Case) -> Any:
    http, path = world.service.http, filled(case.path, world)
    match case.body:
        case None:
            return http.request(case.method, path, headers=case.headers)
        case bytes():
            return http.request(case.method, path, content=case.body, headers=case.headers)
        case [bytes(), *_]:
            return http.request(case.method, path, content=iter(case.body), headers=case.headers)
        case _:
            body = filled(json_of(case.body).decode(), world)
            return http.request(case.method, path, content=body, headers=JSON | dict(case.headers))


def check_problem(answer: Any, status: int, kind: str, says: str) -> None:
    """The answer is the problem document that it must be."""
    assert answer.status_code == status, answer.text[:500]
    assert answer.headers["content-type"] == "application/problem+json"
    problem = answer.json()
    assert problem["type"] == f"urn:voa:problem:{kind}"
    assert problem["status"] == status
    assert problem["title"]
    assert says in problem["detail"]
    assert problem["request_id"] == answer.headers["x-request-id"]


def test_names_of_the_cases_differ() -> None:
    names = [case.name for case in CASES]
    assert sorted(set(names)) == sorted(names)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_bad_input_gets_its_problem_and_changes_nothing(world: World, case: Case) -> None:
    before = world.service.stored()
    answer = send(world, case)
    check_problem(answer, case.status, case.kind, case.says)
    assert world.service.stored() == before


def test_a_key_that_came_with_another_request_is_refused(world: World) -> None:
    path = f"/v1/sessions/{world.service.open(world.data)}/scans"
    key = {"idempotency-key": "once"}
    assert world.service.http.post(path, json=scan_of(GOOD), headers=key).status_code == 200
    before = world.service.stored()
    answer = world.service.http.post(path, json=scan_of([0.6, 0.5, None, 1.0]), headers=key)
    check_problem(answer, 422, "idempotency-key-reused", "once")
    assert world.service.stored() == before


METHODS = {
    "/v1/objects": {"GET", "POST"},
    "/v1/objects/{object}": {"GET"},
    "/v1/objects/{object}/stable-poses": {"GET"},
    "/v1/lidars": {"GET"},
    "/v1/scenarios": {"GET", "POST"},
    "/v1/scenarios/{data}": {"GET"},
    "/v1/scenarios/{data}/warnings": {"GET"},
    "/v1/scenarios/{data}/predictions": {"POST"},
    "/v1/sessions": {"GET", "POST"},
    "/v1/sessions/{data_session}": {"GET", "DELETE"},
    "/v1/sessions/{data_session}/scans": {"POST"},
    "/v1/sessions/{data_session}/belief": {"PUT"},
    "/v1/sessions/{data_session}/grasp-outcomes": {"POST"},
    "/v1/sessions/{data_session}/history": {"GET"},
    "/v1/sessions/{data_session}/events": {"GET"},
    "/v1/sessions/{data_session}/voa": {"GET", "POST"},
    "/v1/sessions/{data_session}/grasps": {"GET"},
    "/v1/updates": {"POST"},
    "/v1/rankings": {"POST"},
    "/v1/robots": {"GET"},
    "/v1/robots/nobody/look": {"POST"},
    "/v1/robots/nobody/session": {"PUT"},
    "/livez": {"GET"},
    "/readyz": {"GET"},
    "/metrics": {"GET"},
}


@pytest.mark.parametrize(
    ("path", "method"),
    [
        (path, method)
        for path, has in METHODS.items()
        for method in ("GET", "POST", "PUT", "PATCH", "DELETE")
        if method not in has
    ],
)
def test_a_method_that_a_path_does_not_have_is_405_and_all_that_it_has_are_named(
    world: World, path: str, method: str
) -> None:
    answer = world.service.http.request(method, filled(path, world))
    check_problem(answer, 405, "method-not-allowed", method)
    assert set(answer.headers["allow"].split(", ")) == METHODS[path]


def test_every_resource_is_in_the_table_of_methods(world: World) -> None:
    document = world.service.get("/openapi.json")
    assert len(document["paths"]) == len(METHODS)
    assert sum(map(len, document["paths"].values())) == sum(map(len, METHODS.values()))


@pytest.mark.parametrize("rule", ["margin", "exponential", "gaussian", "inverse_rmsd", "beam"])
@pytest.mark.parametrize("reading", [0.0, 1e-320, 1e308, 1.7e308])
def test_whatever_a_driver_sends_as_a_range_becomes_a_belief(world: World, rule: str, reading: float) -> None:
    lidar = LIDAR | {"range_max": 1e6, "range_min": 0.0}
    scenario = world.service.create(data_scenario(lidar=lidar, update={"rule": rule, "on_no_match": "nearest"}))
    answer = world.service.post("/v1/updates", UPDATE | {"scenario": scenario, "scan": {"ranges": [reading] * 4}})
    assert all(isinstance(share, float) for share in answer["belief"])
    assert sum(answer["belief"]) == pytest.approx(1.0, abs=1e-9)


def test_a_million_beams_are_refused_by_the_limits_of_a_default_service_too(service: Service, data_id: str) -> None:
    session = service.open(data_id)
    before = service.stored()
    answer = service.http.post(f"/v1/sessions/{session}/scans", json=scan_of([1.0] * 1_000_000))
    check_problem(answer, 422, INVALID, "at most 4096")
    assert service.stored() == before
