import json
import subprocess
import sys
from types import ModuleType
from typing import Any, Literal

import pytest
from pydantic import Field, create_model

from voa_msgs.described import Described
from voa_msgs.rankings import VoaRequest
from voa_msgs.sessions import ScanRequest, UpdatedSession


class Look(Described):
    """A look."""

    place: str
    """Place that it is taken from.

    Two paragraphs.
    """
    cost: float = 0.0
    stated: float = Field(default=0.0, description="A description of its own.")
    """A docstring, which counts less."""
    from_: str = Field(default="", alias="from")
    """Name that is no word of Python."""


class Better(Look):
    """A look whose place is declared again, without a docstring."""

    place: str
    cost: float = 1.0
    """Seconds of driving."""


class Shown(Described):
    """A model whose fields have other names when they are read and when they are written."""

    place: str = Field(validation_alias="read", serialization_alias="written")
    """Place that it is taken from."""
    secret: str = Field(default="", exclude=True)
    """A field that is read, and never written."""


def descriptions(model: type[Described]) -> dict[str, str | None]:
    properties: dict[str, dict[str, Any]] = model.model_json_schema()["properties"]
    return {name: each.get("description") for name, each in properties.items()}


def test_docstrings_describe_the_fields_that_they_follow() -> None:
    assert descriptions(Look) == {
        "place": "Place that it is taken from.\n\nTwo paragraphs.",
        "cost": None,
        "stated": "A description of its own.",
        "from": "Name that is no word of Python.",
    }


def test_a_field_that_is_declared_again_has_the_docstring_of_the_new_declaration() -> None:
    assert descriptions(Better)["place"] is None
    assert descriptions(Better)["cost"] == "Seconds of driving."
    assert descriptions(Better)["from"] == "Name that is no word of Python."


@pytest.mark.parametrize("mode", ["validation", "serialization"])
def test_properties_have_the_names_of_fields_or_their_aliases(mode: Literal["validation", "serialization"]) -> None:
    by_name = Look.model_json_schema(by_alias=False, mode=mode)["properties"]
    assert by_name["from_"]["description"] == "Name that is no word of Python."
    shown = Shown.model_json_schema(mode=mode)["properties"]
    assert shown["read" if mode == "validation" else "written"]["description"] == "Place that it is taken from."
    assert ("secret" in shown) == (mode == "validation")


@pytest.mark.parametrize("model", [ScanRequest, UpdatedSession, VoaRequest])
def test_every_field_of_a_message_is_described(model: type[Described]) -> None:
    assert [name for name, text in descriptions(model).items() if not text] == []


@pytest.mark.parametrize("module", [None, ModuleType("without_file")])
def test_a_model_whose_source_is_not_there_has_no_descriptions(
    module: ModuleType | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = "without_module" if module is None else module.__name__
    if module is not None:
        monkeypatch.setitem(sys.modules, name, module)
    assert descriptions(create_model("Made", __base__=Described, __module__=name, x=(int, ...))) == {"x": None}


def test_no_source_is_read_before_a_schema_is_made() -> None:
    program = (
        "import json, voa_msgs.sessions, voa_msgs.described\n"
        "before = voa_msgs.described._docstrings.cache_info().currsize\n"
        "voa_msgs.sessions.Session.model_json_schema()\n"
        "print(json.dumps([before, voa_msgs.described._docstrings.cache_info().currsize > 0]))\n"
    )
    printed = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert json.loads(printed) == [0, True]
