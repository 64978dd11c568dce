"""Versions of a session for its followers, in bounded pieces."""

from voa_service.runtime.feeds import Version
from voa_service.usecases.sessions import Sessions

_MOST_VERSIONS = 32
_MOST_BYTES = 2**18


def versions_since(sessions: Sessions, id_: str, seen: int | None) -> list[Version] | None:
    """Read versions of a session after `seen`, the oldest first; without `seen`, the newest; None: no such session.

    At most 32 versions of together at most 256 kB, and at least one where there is one.

    Raises:
        StoreError: the store cannot be read.
    """
    states = sessions.states_since(id_, seen, _MOST_VERSIONS)
    if states is None:
        return None
    versions: list[Version] = []
    held = 0
    for state in states:
        version = Version(state.version, sessions.message(state).model_dump_json())
        held += len(version.body)
        if versions and held > _MOST_BYTES:
            break
        versions.append(version)
    return versions
