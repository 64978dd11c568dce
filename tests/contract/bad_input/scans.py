"""Bad scans, and bad outcomes of grasps."""

from typing import Any

from tests.contract.bad_input.base import (
    GOOD,
    HERE,
    HUGE,
    INF,
    INVALID,
    NAN,
    NO_MESH,
    OUTCOMES,
    SCANS,
    UNKNOWN,
    Case,
    nested,
    without,
)
from tests.support.serving import Json, scan_of


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


OUTCOME_CASES = [
    Case("outcome: an unknown grasp", OUTCOMES, {"grasp": "G9", "success": True}, 422, UNKNOWN, "'G1', 'G2'"),
    Case("outcome: half a surrogate pair as grasp", OUTCOMES, {"grasp": "\ud800", "success": True}, says="unicode"),
    Case("outcome: no grasp", OUTCOMES, {"success": True}, says="grasp"),
    Case("outcome: no success", OUTCOMES, {"grasp": "G1"}, says="success"),
    Case(
        "outcome: a move above 1", OUTCOMES, {"grasp": "G1", "success": True, "object_moved": 1.1}, says="object_moved"
    ),
    Case("outcome: a number as success", OUTCOMES, {"grasp": "G1", "success": 1}, says="boolean"),
    Case("outcome: a string as success", OUTCOMES, {"grasp": "G1", "success": "true"}, says="boolean"),
]
