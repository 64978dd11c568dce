"""The descriptions of failures in the OpenAPI document agree with the problem documents that are sent."""

import inspect
import json

import pytest

from voa_service import failures
from voa_service.failures import Failure, HttpError, document
from voa_service.problem_schemas import problem_schema

KINDS = [
    kind
    for _, kind in inspect.getmembers(failures, inspect.isclass)
    if issubclass(kind, Failure) and kind not in (Failure, HttpError)
]
VALUES: dict[str, object] = {"known": ["a"], "version": 3, "errors": [], "reason": "no_match"}


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.kind)
def test_a_problem_document_has_the_members_that_its_schema_names(kind: type[Failure]) -> None:
    schema = problem_schema(kind)
    more = {name: VALUES[name] for name in kind.members if name in VALUES}
    headers = {"Retry-After": "1"} if "retry_after_s" in kind.members else {}
    sent = json.loads(document(kind("detail", headers, **more)))
    assert set(sent) == set(schema["properties"])
    assert sent["type"] == schema["properties"]["type"]["const"]
    assert "$ref" not in json.dumps(schema)
    assert all(schema["properties"][name].get("description") for name in kind.members)
