"""Bad beliefs, rankings, updates and predictions."""

from collections.abc import Iterator

from tests.contract.bad_input.base import (
    HERE,
    HUGE,
    INF,
    INVALID,
    NAN,
    NO_MESH,
    OUTCOMES,
    PREDICT,
    RANK,
    UNKNOWN,
    UPDATE,
    VOA,
    Case,
    without,
)
from tests.support.serving import Json


def beliefs(path: str, body: Json, method: str = "POST") -> Iterator[Case]:
    """Cases of bad beliefs for a path and the body around them."""
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
    """Cases of bad requests with the belief in the request."""
    yield from beliefs(path, body)
    yield Case(f"{path}: an unknown scenario", path, body | {"scenario": "nothing"}, 422, UNKNOWN, "POST /v1/scenarios")
    yield Case(f"{path}: half a surrogate pair as scenario", path, body | {"scenario": "\ud800"}, says="unicode")


def rankings(path: str, body: Json) -> Iterator[Case]:
    """Cases of bad rankings, of a session or of a belief."""
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
        ("an unknown kind of scans", {"scans": "noisy"}, INVALID, "'exact' or 'simulated'"),
        ("no samples", {"samples": 0}, INVALID, "samples"),
        ("too many samples", {"samples": 4097}, INVALID, "samples"),
        ("a std that is negative", {"sensor_std": {"xy_m": -1}}, INVALID, "sensor_std.xy_m"),
        ("a lookahead of three", {"lookahead": 3}, INVALID, "lookahead"),
        ("a cost of driving from nowhere", {"cost_per_m": 0.1}, INVALID, "from"),
        ("a cost of driving that is negative", {"from": "Q1", "cost_per_m": -0.1}, INVALID, "cost_per_m"),
        ("an unknown place to drive from", {"from": "Q9"}, UNKNOWN, "'Q1', 'Q2'"),
        ("half a point to drive from", {"from": {"x": 0.0}}, INVALID, "from"),
        ("an unknown look under way", {"pending": ["Q9"]}, UNKNOWN, "'Q1', 'Q2'"),
        ("a look under way without a mesh", {"pending": [place]}, NO_MESH, "no mesh"),
        ("too many looks under way", {"pending": ["Q1"] * 11}, INVALID, "at most 10"),
        ("outcomes as string", {"outcomes": "yes"}, INVALID, "boolean"),
        ("an unknown field beside them", {"colour": 1}, INVALID, "colour"),
    ):
        yield Case(f"{path}: {name}", path, body | more, 422, kind, says)


COMPUTATIONS = [
    *stateless("/v1/updates", UPDATE),
    *stateless("/v1/rankings", RANK),
    *beliefs("/v1/sessions/{data_session}/belief", {"belief": [0.2, 0.3, 0.5]}, "PUT"),
    Case("outcome: an unknown field", OUTCOMES, {"grasp": "G1", "success": True, "colour": 1}, says="colour"),
    *rankings("/v1/rankings", RANK),
    *rankings(VOA, {}),
    Case("update: an absence above 1", "/v1/updates", UPDATE | {"absent": 1.1}, says="absent"),
    Case("ranking: a negative absence", "/v1/rankings", RANK | {"absent": -0.1}, says="absent"),
    Case("ranking of a session: an absence", VOA, {"absent": 0.5}, says="absent"),
    Case("update: an unknown sensor", "/v1/updates", UPDATE | {"sensor": "Q9"}, 422, UNKNOWN, "'Q1', 'Q2'"),
    Case("update: an empty scan", "/v1/updates", UPDATE | {"scan": {"ranges": []}}, says="ranges"),
    Case("update: both places", "/v1/updates", UPDATE | {"sensor_pose": HERE}, says="exactly one of"),
    Case("predictions: no sensors", PREDICT, {"sensors": []}, says="sensors"),
    Case("predictions: an unknown sensor", PREDICT, {"sensors": ["Q9"]}, 422, UNKNOWN, "'Q1', 'Q2'"),
    Case("predictions: a pose without a mesh", PREDICT, {"sensors": [HERE]}, 422, NO_MESH, "no mesh"),
]
