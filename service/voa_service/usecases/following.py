"""The versions of a session for whoever follows it, a bounded piece at a time."""

from voa_service.runtime.feeds import Version
from voa_service.usecases.sessions import Sessions

_MOST_VERSIONS = 32
_MOST_BYTES = 2**18


def versions_since(sessions: Sessions, id_: str, seen: int | None) -> list[Version] | None:
    """Read the versions of a session after `seen`, the oldest first, or the newest where `seen` is None.

    At least one where there is one, and at most 32 of at most 256 kB in all; None: the session is gone.
    """
    states = sessions.states_since(id_, seen, _MOST_VERSIONS)
    if states is None:
        return None
    found: list[Version] = []
    held = 0
    for state in states:
        version = Version(state.version, sessions.message(state).model_dump_json())
        held += len(version.body)
        if found and held > _MOST_BYTES:
            break
        found.append(version)
    return found
