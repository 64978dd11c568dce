"""Bad headers: versions, idempotency keys, and calls from pages of other sites."""

from tests.contract.bad_input.base import GOOD, OUTCOMES, SCANS, SESSION, Case
from tests.support.serving import scan_of

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
    Case("a page of another site that requests a look", "/v1/robots/free/look", None, 403, "forbidden", "another site",
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
