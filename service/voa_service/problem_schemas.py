"""JSON schemas of problem documents, one for each kind of failure, for the OpenAPI document."""

import inspect
from typing import Any

from voa_msgs.problems import Problem
from voa_service.failures import Failure

_COMMON = ("type", "title", "status", "detail", "request_id")
_REQUIRED = ["type", "title", "status", "detail"]
_REASON = {"type": "string", "description": "Reason for which the observation was not accepted."}


def problem_schema(kind: type[Failure]) -> dict[str, Any]:
    """Return the JSON schema of the problem documents of one kind of failure, complete in itself.

    It has the members that every problem has, and the further ones of this kind, as `voa_msgs.problems.Problem`
    describes them.
    """
    properties = _properties()
    own = {name: _always(properties[name]) for name in (*_COMMON, *kind.members)}
    own["type"] = {"const": f"urn:voa:problem:{kind.kind}", "description": own["type"].get("description", "Kind.")}
    return {
        "type": "object",
        "title": kind.title,
        "description": inspect.getdoc(kind),
        "properties": own,
        "required": _REQUIRED,
    }


def _always(schema: dict[str, Any]) -> dict[str, Any]:
    """Drop from a member's description that other kinds of problems do not have it."""
    return schema | {"description": schema["description"].replace("; null for other problems", "")}


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
