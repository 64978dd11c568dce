"""Variables `VOA_...` of the environment that nobody reads: a slip in a name would else go unnoticed."""

import re
from collections.abc import Iterable, Iterator
from difflib import get_close_matches

from pydantic import BaseModel

from voa_service.settings import Settings

_PREFIX = "VOA_"
_READ_BY_OTHERS = ("VOA_CASES", "VOA_LAB_HOLDER", "VOA_SCHEMATHESIS_SEED", "VOA_TEST_SCALE")
"""Variables that the tests read; the clients read `VOA_LIMITS__BEAMS`, which is the service's too."""
_LINKS = re.compile(r"VOA_(SERVICE_HOST|SERVICE_PORT(_\w+)?|PORT_\d+_(TCP|UDP|SCTP)(_\w+)?|NAME|ENV_\w+)")
"""Variables that Kubernetes and Docker set in every container beside a service that is named voa."""


def known_variables(settings: type[BaseModel] = Settings) -> list[str]:
    """List the variables that are read, by name."""
    return sorted({*_names(settings, _PREFIX), *_READ_BY_OTHERS})


def unknown_variables(names: Iterable[str]) -> dict[str, str | None]:
    """Find the variables that begin with VOA_ and that nobody reads.

    Args:
        names: of all variables of the environment.

    Returns:
        The closest name that is read of each, None where none is close; by name.
    """
    known = known_variables()
    ours = [name for name in sorted(names) if name.upper().startswith(_PREFIX)]
    unknown = [name for name in ours if name.upper() not in known and not _LINKS.fullmatch(name)]
    return {name: next(iter(get_close_matches(name.upper(), known, 1)), None) for name in unknown}


def _names(model: type[BaseModel], prefix: str) -> Iterator[str]:
    for name, field in model.model_fields.items():
        variable = prefix + name.upper()
        yield variable
        kind = field.annotation
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            yield from _names(kind, f"{variable}__")
