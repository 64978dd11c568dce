"""The OpenAPI document describes every operation, parameter, property, problem and limit of the service."""

import json
import re
from collections.abc import Iterator
from typing import Any

import pytest

from tests.architecture.test_language import LEANING
from tests.support.serving import Json, Service, serving
from voa_service.failures import Failure
from voa_service.settings import Limits

LIMITS = Limits(beams=11, poses=12, sensors=13, grasps=14)
KINDS = {kind.kind: kind for kind in Failure.__subclasses__()}


@pytest.fixture(scope="module")
def document(tmp_path_factory: pytest.TempPathFactory) -> Json:
    with serving(tmp_path_factory.mktemp("limited"), limits=LIMITS) as service:
        document: Json = service.get("/openapi.json")
    return document


def operations(document: Json) -> Iterator[tuple[str, str, Json]]:
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            yield path, method, operation


def nodes(node: Any) -> Iterator[Json]:
    """Every object in the document."""
    if isinstance(node, dict):
        yield node
        for child in node.values():
            yield from nodes(child)
    elif isinstance(node, list):
        for child in node:
            yield from nodes(child)


def test_it_is_openapi_3_1_with_a_title_and_a_version(document: Json) -> None:
    assert document["openapi"].startswith("3.1")
    assert document["info"]["title"]
    assert re.fullmatch(r"\d+\.\d+\.\d+.*", document["info"]["version"])


def test_every_operation_has_an_id_and_a_summary_of_its_own(document: Json) -> None:
    for member in ("operationId", "summary"):
        values = [operation[member] for _, _, operation in operations(document)]
        assert sorted(set(values)) == sorted(values)


def test_summaries_are_sentences_that_a_stranger_understands(document: Json) -> None:
    for path, method, operation in operations(document):
        summary = operation["summary"]
        assert len(summary.split()) >= 4, (path, method, summary)
        assert len(summary) <= 100, (path, method, summary)
        assert not summary.endswith("."), (path, method, summary)
        assert not LEANING.match(summary), (path, method, summary)
        assert summary != operation.get("description"), (path, method, summary)


def test_every_operation_is_listed_under_exactly_one_described_tag(document: Json) -> None:
    described = {tag["name"]: tag["description"] for tag in document["tags"]}
    for path, method, operation in operations(document):
        assert len(operation["tags"]) == 1, (path, method)
    assert {operation["tags"][0] for _, _, operation in operations(document)} == set(described)
    for text in described.values():
        assert text.endswith("."), text
        assert len(text.split()) > 5, text


def test_every_parameter_and_every_success_is_described(document: Json) -> None:
    for path, method, operation in operations(document):
        for parameter in operation.get("parameters", []):
            assert parameter.get("description", "").endswith("."), (path, method, parameter["name"])
        for status, response in operation["responses"].items():
            if status < "400":
                assert response["description"] != "Successful Response", (path, method, status)
                assert response["description"].endswith("."), (path, method, status)


def properties(document: Json) -> Iterator[tuple[str, Json]]:
    for name, schema in document["components"]["schemas"].items():
        for field, described in schema.get("properties", {}).items():
            yield f"{name}.{field}", described


def test_every_schema_and_every_property_is_described(document: Json) -> None:
    assert len(list(properties(document))) > 300
    without = {"Body_create_object", "JsonValue"}  # made by FastAPI and pydantic
    bare = [name for name, schema in document["components"]["schemas"].items() if not schema.get("description")]
    assert set(bare) == without
    wrong = [
        f"{name}: {described.get('description')}"
        for name, described in properties(document)
        if not described.get("description", "").endswith(".") or LEANING.match(described["description"])
    ]
    assert not wrong, "\n".join(wrong)


UNITS = re.compile(
    r"\b(metres|radians|mm|m\^2|1/m|seconds|nats|success probability|probabilit(y|ies)|share|expected score|evidence"
    r"|concentration|quaternion|exponent|grasp scores)\b",
    re.IGNORECASE,
)
"""Units of real numbers, and the quantities that have none."""


def test_every_real_number_is_described_with_its_unit(document: Json) -> None:
    wrong = [
        f"{name}: {described['description']}"
        for name, described in properties(document)
        if any(node.get("type") == "number" for node in nodes(described)) and not UNITS.search(described["description"])
    ]
    assert not wrong, "\n".join(wrong)


def test_every_error_is_a_problem_document_whose_kinds_are_listed(document: Json) -> None:
    for path, method, operation in operations(document):
        errors = {status: response for status, response in operation["responses"].items() if status >= "400"}
        for status, response in errors.items():
            [(media_type, content)] = response["content"].items()
            assert media_type == "application/problem+json"
            for schema in content["schema"].get("oneOf", [content["schema"]]):
                described = document["components"]["schemas"][schema["$ref"].rpartition("/")[2]]
                kind = described["properties"]["type"]["const"].removeprefix("urn:voa:problem:")
                assert KINDS[kind].status == int(status), (path, method, status, kind)
                assert f"{KINDS[kind].title} (`{kind}`)" in response["description"]


def test_errors_are_named_where_they_can_happen(document: Json) -> None:
    for path, method, operation in operations(document):
        statuses = set(operation["responses"])
        if "requestBody" in operation:
            assert {"400", "413", "422"} <= statuses, (path, method)
        if "{id}" in path or "{robot}" in path:
            assert "404" in statuses, (path, method)
        if path.startswith("/v1"):
            assert "503" in statuses, (path, method)
        if any(parameter["name"] == "If-Match" for parameter in operation.get("parameters", [])):
            assert "412" in statuses, (path, method)


def test_every_write_to_a_session_takes_a_key_and_those_that_depend_on_its_version_an_if_match(document: Json) -> None:
    writes = {
        (path, method): {parameter["name"] for parameter in operation.get("parameters", [])}
        for path, method, operation in operations(document)
        if path.startswith("/v1/sessions") and method != "get" and not path.endswith("/voa")
    }
    assert len(writes) == 7
    for (path, _), names in writes.items():
        assert "Idempotency-Key" in names
        assert ("If-Match" in names) is (path != "/v1/sessions" and "/looks" not in path)


def test_references_lead_somewhere_and_parameters_stand_in_their_paths(document: Json) -> None:
    for node in nodes(document):
        reference = node.get("$ref")
        if isinstance(reference, str):
            assert reference.removeprefix("#/components/schemas/") in document["components"]["schemas"]
    for path, method, operation in operations(document):
        declared = {p["name"] for p in operation.get("parameters", []) if p["in"] == "path"}
        assert declared == set(re.findall(r"{(\w+)}", path)), (path, method)


def test_no_schema_is_left_over(document: Json) -> None:
    used = {node["$ref"].rpartition("/")[2] for node in nodes(document) if isinstance(node.get("$ref"), str)}
    assert used == set(document["components"]["schemas"])


@pytest.mark.parametrize(
    ("schema", "field", "word", "most"),
    [
        ("ScenarioRequest", "poses", "maxItems", 12),
        ("ScenarioRequest", "grasps", "maxItems", 14),
        ("ScenarioRequest", "sensors", "maxItems", 13),
        ("ScenarioRequest", "prior", "maxItems", 12),
        ("ScenarioRequest", "predictions", "maxItems", 11),
        ("Lidar", "beams", "maximum", 11),
        ("Scan", "ranges", "maxItems", 11),
        ("Scan", "no_return", "maxItems", 11),
        ("UpdateRequest", "belief", "maxItems", 12),
        ("BeliefRequest", "belief", "maxItems", 12),
        ("RankingRequest", "belief", "maxItems", 12),
        ("VoaRequest", "sensors", "maxItems", 13),
        ("VoaRequest", "grasps", "maxItems", 14),
        ("VoaRequest", "pending", "maxItems", 13),
        ("VoaRequest", "sensor_belief", "maxItems", 12),
        ("PredictionsRequest", "sensors", "maxItems", 13),
    ],
)
def test_limits_are_those_of_the_settings(document: Json, schema: str, field: str, word: str, most: int) -> None:
    limits = {
        node[word] for node in nodes(document["components"]["schemas"][schema]["properties"][field]) if word in node
    }
    assert limits == {most}


def test_no_mark_of_a_limit_is_left_in_the_document(document: Json) -> None:
    assert "x-limit" not in json.dumps(document)


def test_limits_default_to_those_of_the_contract(service: Service) -> None:
    schemas = service.get("/openapi.json")["components"]["schemas"]
    request = schemas["ScenarioRequest"]["properties"]
    assert [request[field]["maxItems"] for field in ("poses", "sensors", "grasps")] == [20_000, 4_096, 4_096]
    assert schemas["Scan"]["properties"]["ranges"]["maxItems"] == 4_096
    ranking = schemas["VoaRequest"]["properties"]
    assert [ranking[field]["anyOf"][0]["maxItems"] for field in ("sensors", "pending")] == [4_096, 64]
    assert (Limits().faces, Limits().upload_bytes) == (200_000, 20_000_000)


def test_the_document_is_the_same_each_time_and_the_docs_show_it(service: Service) -> None:
    first = service.http.get("/openapi.json")
    assert service.http.get("/openapi.json").content == first.content
    docs = service.http.get("/docs")
    assert docs.status_code == 200
    assert "/openapi.json" in docs.text
