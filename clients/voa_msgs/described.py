"""Base of models whose fields are described, in their JSON schema, by the docstrings that follow them.

Pydantic can do that too (`use_attribute_docstrings`), but it reads the sources whenever a class is made, which took a
tenth of the time of a start of the service. They are read here when a schema is made, which few processes ever do; of
classes within functions and other classes they are not.
"""

import ast
import inspect
import sys
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from typing import Any

from pydantic import BaseModel, GetJsonSchemaHandler
from pydantic_core import CoreSchema


class Described(BaseModel):
    """Model whose JSON schema has the docstring of each field as the description of its property."""

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Make the JSON schema, and describe the properties that have no description yet."""
        made = handler(schema)
        properties = handler.resolve_ref_schema(made).get("properties", {})
        for name, field in cls.model_fields.items():
            docstring = _docstring(cls, name)
            keys = (field.alias, field.validation_alias, field.serialization_alias, name)
            described = next((properties[key] for key in keys if isinstance(key, str) and key in properties), None)
            if docstring is not None and described is not None:
                described.setdefault("description", docstring)
        return made


def _docstring(model: type[BaseModel], name: str) -> str | None:
    """Return the docstring of a field, from the class that declares it last; None: there is none."""
    owner = next(each for each in model.__mro__ if name in inspect.get_annotations(each))
    return _docstrings(owner.__module__).get((owner.__qualname__, name))


@cache
def _docstrings(module: str) -> dict[tuple[str, str], str]:
    """Read the docstrings of fields in an imported module, by class and field; none where its source is not there."""
    try:
        source = inspect.getsource(sys.modules[module])
    except (KeyError, OSError, TypeError):  # no such module, no source, and a module without a file
        return {}
    return dict(_of_classes(ast.parse(source)))


def _of_classes(module: ast.Module) -> Iterator[tuple[tuple[str, str], str]]:
    """Yield class, field and docstring of each field that a text follows."""
    for class_ in module.body:
        if isinstance(class_, ast.ClassDef):
            for field, text in pairwise(class_.body):
                if (
                    isinstance(field, ast.AnnAssign)
                    and isinstance(field.target, ast.Name)
                    and isinstance(text, ast.Expr)
                    and isinstance(text.value, ast.Constant)
                    and isinstance(text.value.value, str)
                ):
                    yield (class_.name, field.target.id), inspect.cleandoc(text.value.value)
