"""Unknown paths and identifiers, and bad parameters of a query."""

from tests.contract.bad_input.base import GOOD, SCANS, SESSION, UNKNOWN, VOA, Case
from tests.support.serving import scan_of

PATHS = [
    Case("no such resource", "/v1/nothing", None, 404, "not-found", "/docs", "GET"),
    Case("no such resource to post to", "/v2/scenarios", {}, 404, "not-found", "/docs"),
    Case("an unknown object", "/v1/objects/nothing", None, 404, "not-found", "'nothing'", "GET"),
    Case("mesh of one", "/v1/objects/nothing/mesh", None, 404, "not-found", "'nothing'", "GET"),
    Case("file of one", "/v1/objects/nothing/mesh.stl", None, 404, "not-found", "'nothing'", "GET"),
    Case("too thin a mesh", "/v1/objects/nothing/mesh?most_faces=3", None, 422, "invalid-request", "100", "GET"),
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
