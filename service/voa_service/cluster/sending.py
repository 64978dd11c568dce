"""Functions as bytes, in which a scenario is named and not contained.

The functions that a ranking maps over its parts hold the scenario, its cache and its locks, which cannot be sent and
need not be: every worker has its own. Everything else that they hold, such as the belief, is sent with them. Nested
functions are sent as code, for which Python's version must be the same.
"""

import io
import pickle
from collections.abc import Callable, Mapping
from typing import Any

import cloudpickle

from voa_service.mapping.models import Model
from voa_service.runtime.queues import Check

_PARTS = ("poses", "table", "sensors", "predictor", "rule", "policy", "prior")
_PARTS_OF_PREDICTOR = ("data", "contours_at")


def named_parts(model: Model, check: Check) -> dict[str, Any]:
    """Return the objects that are named instead of sent, by name: a scenario, its parts, and the check of a ranking."""
    scenario = model.scenario
    parts = {f"scenario.{name}": getattr(scenario, name) for name in _PARTS}
    # A ranking over samples has a predictor of its own, which keeps no prediction, with the parts of the scenario's.
    for name in _PARTS_OF_PREDICTOR:
        part = getattr(scenario.predictor, name)
        if part is not None:
            parts[f"scenario.predictor.{name}"] = part
    return {"model": model, "scenario": scenario, "check": check} | parts


def dumped(function: Callable[..., Any], named: Mapping[str, Any]) -> bytes:
    """Write a function as bytes, in which `named` objects stand by their names."""
    names = {id(value): name for name, value in named.items()}

    class Pickler(cloudpickle.Pickler):  # type: ignore[misc] # it has no types
        """A pickler that writes names for the objects that have one."""

        def persistent_id(self, value: Any) -> str | None:
            """Return the name of an object; None: it is written in full."""
            return names.get(id(value))

    buffer = io.BytesIO()
    Pickler(buffer, protocol=pickle.HIGHEST_PROTOCOL).dump(function)
    return buffer.getvalue()


def loaded(content: bytes, named: Mapping[str, Any]) -> Callable[..., Any]:
    """Read a function from bytes of `dumped`, with `named` objects for the names in it."""

    class Unpickler(pickle.Unpickler):
        """An unpickler that puts objects in the place of their names."""

        def persistent_load(self, name: str) -> Any:
            """Return the object of a name."""
            return named[name]

    function: Callable[..., Any] = Unpickler(io.BytesIO(content)).load()
    return function
