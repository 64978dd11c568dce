"""Idempotency keys: equal for equal calls in one scope, with another digest for every other request."""

from tests.support.serving import scan_of
from voa_msgs.sessions import OutcomeRequest, ScanRequest
from voa_service.requests.idempotency import idempotency_key, scope_of, scope_of_caller, write_of
from voa_store.records import IdempotencyKey, RobotLook

REQUEST = OutcomeRequest(grasp="G1", success=True)


def digest(call: str, request: OutcomeRequest | ScanRequest | None) -> str:
    key = idempotency_key("k", scope_of("S"), call, request)
    assert key is not None
    return key.fingerprint


def test_a_call_without_a_key_has_none() -> None:
    assert idempotency_key(None, scope_of_caller("anonymous"), "outcome", REQUEST) is None


def test_a_key_names_its_scope() -> None:
    key = idempotency_key("k", scope_of("S"), "outcome", REQUEST)
    assert key == IdempotencyKey("session:S", "k", digest("outcome", REQUEST))
    assert scope_of("S") != scope_of("T")


def test_the_digest_is_that_of_the_meaning_of_a_request() -> None:
    written = (b'{"grasp": "G1", "success": true}', b'{"success":true,"grasp":"G1"}')
    assert {digest("outcome", OutcomeRequest.model_validate_json(body)) for body in written} == {
        digest("outcome", REQUEST)
    }


def test_another_call_or_another_body_has_another_digest() -> None:
    scan = ScanRequest.model_validate(scan_of([0.5]))
    digests = {
        digest("outcome", REQUEST),
        digest("outcome", OutcomeRequest(grasp="G1", success=False)),
        digest("scan", scan),
        digest("delete", None),
        digest("create session", None),
    }
    assert len(digests) == 5


def test_a_write_keeps_the_request_as_it_was_received_without_its_byte_order_mark() -> None:
    look = RobotLook("r", 1, "name")
    key = idempotency_key("k", scope_of_caller("anonymous"), "scan", None)
    write = write_of("scan", b'\xef\xbb\xbf{ "sensor" : "Q1" }', key, frozenset({3}), look)
    assert (write.request, write.kind) == ('{ "sensor" : "Q1" }', "scan")
    assert (write.key, write.if_match, write.look) == (key, frozenset({3}), look)
