"""The JSON schemas of all messages, as one document.

    python -m tests.contract.snapshot       renew tests/contract/messages.json after an intended change

The file is read in review: a change in it is a change of what other people's code relies on.
"""

import importlib
import json
import pkgutil
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

import voa_msgs
from voa_msgs.base import Message

FILE = Path(__file__).with_name("messages.json")


def messages() -> dict[str, type[Message]]:
    """Every public message by its name."""
    by_name: dict[str, type[Message]] = {}
    for module in pkgutil.iter_modules(voa_msgs.__path__):
        for name, value in vars(importlib.import_module(f"voa_msgs.{module.name}")).items():
            if isinstance(value, type) and issubclass(value, Message) and not name.startswith("_"):
                assert by_name.setdefault(name, value) is value, f"two messages are called {name}"
    del by_name["Message"]
    return dict(sorted(by_name.items()))


def schemas() -> dict[str, Any]:
    """The schema of every message, shared parts once."""
    _, document = TypeAdapter.json_schemas(
        [(name, "validation", TypeAdapter(message)) for name, message in messages().items()]
    )
    return dict(sorted(document["$defs"].items()))


def text() -> str:
    """The snapshot as it stands in the file."""
    return json.dumps(schemas(), indent=1, sort_keys=True) + "\n"


if __name__ == "__main__":
    FILE.write_text(text(), encoding="utf-8")
