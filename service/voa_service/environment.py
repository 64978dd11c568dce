"""Detection of environment variables `VOA_...` that are not settings, such as misspelt names."""

import re
from collections.abc import Iterable, Iterator
from difflib import get_close_matches

from pydantic import BaseModel

from voa_service.settings import Settings

_PREFIX = "VOA_"
_READ_BY_CLIENTS = ("VOA_KEY", "VOA_KEY_FILE")
_READ_BY_TESTS = ("VOA_CASES", "VOA_LAB_HOLDER", "VOA_SCHEMATHESIS_SEED", "VOA_SCREENSHOTS", "VOA_TEST_SCALE")
"""Variables that the tests read. Clients read `VOA_LIMITS__BEAMS`, which is also a setting of the service."""
_LINKS = re.compile(r"VOA_(SERVICE_HOST|SERVICE_PORT(_\w+)?|PORT_\d+_(TCP|UDP|SCTP)(_\w+)?|NAME|ENV_\w+)")
"""Variables that Kubernetes and Docker set in every container that runs beside a service named voa."""


def known_variables(settings: type[BaseModel] = Settings) -> list[str]:
    """List the names of the variables that are read, sorted."""
    return sorted({*_names(settings, _PREFIX), *_READ_BY_CLIENTS, *_READ_BY_TESTS})


def unknown_variables(names: Iterable[str]) -> dict[str, str | None]:
    """Find the variables that begin with VOA_ and are not settings.

    Args:
        names: names of all variables of the environment.

    Returns:
        For each such variable, the setting with the most similar name, or None where none is similar.
    """
    known = known_variables()
    ours = [name for name in sorted(names) if name.upper().startswith(_PREFIX)]
    unknown = [name for name in ours if name.upper() not in known and not _LINKS.fullmatch(name)]
    bare = {name.removeprefix(_PREFIX): name for name in known}  # the prefix would make all short names similar
    similar = {name: get_close_matches(name.upper().removeprefix(_PREFIX), bare, 1) for name in unknown}
    return {name: bare[closest[0]] if closest else None for name, closest in similar.items()}


def _names(model: type[BaseModel], prefix: str) -> Iterator[str]:
    for name, field in model.model_fields.items():
        variable = prefix + name.upper()
        yield variable
        kind = field.annotation
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            yield from _names(kind, f"{variable}__")
