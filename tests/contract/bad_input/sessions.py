"""Bad sessions, claims of robots, and lists of objects."""

from tests.contract.bad_input.base import CONFLICT, JSON, NO_MESH, TYPE, UNKNOWN, Case
from tests.contract.bad_input.scenarios import PRIOR
from tests.support.serving import Json

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

LOOKS = "/v1/sessions/{data_session}/looks"
PLACE: Json = {"x": 0.0, "y": 0.0, "yaw_rad": 0.0}
ANNOUNCEMENTS = [
    Case("look: no place", LOOKS, {}, says="exactly one of"),
    Case("look: two places", LOOKS, {"sensor": "Q1", "sensor_pose": PLACE}, says="exactly one of"),
    Case("look: an unknown sensor", LOOKS, {"sensor": "Q9"}, 422, UNKNOWN, "'Q1', 'Q2'"),
    Case("look: an empty name of a robot", LOOKS, {"sensor": "Q1", "robot": ""}, says="robot"),
    Case("look: an unknown field", LOOKS, {"sensor": "Q1", "expires_at": None}, says="expires_at"),
    Case("look: a pose without a yaw", LOOKS, {"sensor_pose": {"x": 0.0, "y": 0.0}}, says="yaw_rad"),
    Case("look: a sensor pose without a mesh", LOOKS, {"sensor_pose": PLACE}, 422, NO_MESH, "by name"),
    Case("look: a negative std", LOOKS, {"sensor_pose": PLACE | {"std": {"xy_m": -1, "yaw_rad": 0}}}, says="std"),
    Case("look: no body", LOOKS, b"", says="body", headers=JSON),
    Case("look: not JSON", LOOKS, b"{", 400, "malformed-json", headers=JSON),
    Case("look: text/plain", LOOKS, b'{"sensor": "Q1"}', 415, TYPE, headers={"content-type": "text/plain"}),
    Case("look: an unknown session", "/v1/sessions/nothing/looks", {"sensor": "Q1"}, 404, "not-found", "'nothing'"),
    Case("look: a parameter", LOOKS + "?robot=r", {"sensor": "Q1"}, says="query.robot"),
    Case("look: an Idempotency-Key of 256 characters", LOOKS, {"sensor": "Q1"}, says="at most 255",
         headers={"idempotency-key": "k" * 256}),
    Case("to end an unknown look", LOOKS + "/nothing", None, 404, "not-found", "'nothing'", "DELETE"),
    Case("to end a look of an unknown session", "/v1/sessions/nothing/looks/L", None, 404, "not-found", "'nothing'",
         "DELETE"),
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
