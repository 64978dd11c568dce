"""OpenAPI descriptions of failures: the problem documents that an operation may respond with, by status."""

from collections.abc import Sequence
from itertools import groupby
from typing import Any

from voa_msgs.problems import Problem
from voa_service.failures import Failure

PROBLEM_TYPE = "application/problem+json"
_COMMON = ("type", "title", "status", "detail", "request_id")
_REQUIRED = ["type", "title", "status", "detail"]
_REASON = {"type": "string", "description": "Reason for which the observation was not accepted."}


def described(*kinds: type[Failure]) -> dict[int | str, dict[str, Any]]:
    """Describe the failures of an operation, for the `responses=` of a FastAPI route.

    Args:
        kinds: classes of failures; several of them may have one status.

    Returns:
        For each status a description, and the schema of `application/problem+json`: it names the further members that
        a problem of each kind has, with their descriptions from `voa_msgs.problems.Problem`.
    """
    ordered = sorted(dict.fromkeys(kinds), key=lambda kind: kind.status)
    return {status: _response(list(group)) for status, group in groupby(ordered, key=lambda kind: kind.status)}


def problem_schema(kind: type[Failure]) -> dict[str, Any]:
    """Return the JSON schema of the problem documents of one kind of failure, complete in itself."""
    properties = _properties()
    own = {name: properties[name] for name in (*_COMMON, *kind.members)}
    own["type"] = {"const": f"urn:voa:problem:{kind.kind}", "description": own["type"].get("description", "Kind.")}
    return {"type": "object", "title": kind.title, "properties": own, "required": _REQUIRED}


def _response(kinds: Sequence[type[Failure]]) -> dict[str, Any]:
    schemas = [problem_schema(kind) for kind in kinds]
    return {
        "description": "; ".join(dict.fromkeys(f"{kind.title} (`{kind.kind}`)" for kind in kinds)),
        "content": {PROBLEM_TYPE: {"schema": schemas[0] if len(schemas) == 1 else {"oneOf": schemas}}},
    }


def _properties() -> dict[str, Any]:
    """Return the schemas of all members of problem documents, by name, without references."""
    schema = Problem.model_json_schema()
    resolved = _resolved(schema["properties"], schema.get("$defs", {}))
    return {"reason": _REASON} | dict(resolved)


def _resolved(node: Any, definitions: dict[str, Any]) -> Any:
    match node:
        case {"$ref": str(reference)}:
            return _resolved(definitions[reference.rpartition("/")[2]], definitions)
        case dict():
            return {name: _resolved(child, definitions) for name, child in node.items()}
        case list():
            return [_resolved(child, definitions) for child in node]
        case _:
            return node
