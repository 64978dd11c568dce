"""JSON files as messages."""

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel

from voa_msgs.reading import InvalidMessage, read_message

M = TypeVar("M", bound=BaseModel)


def read_file(kind: type[M], path: Path, wrong: Callable[[str], Exception]) -> M:
    """Read a message from a JSON file.

    Args:
        kind: of message.
        path: of the file.
        wrong: makes the error that is raised from one line: the file cannot be opened, is not JSON, or not a `kind`.
    """
    try:
        return read_message(kind, path.read_bytes())
    except OSError as error:
        raise wrong(f"{path}: {error.strerror}") from error
    except InvalidMessage as error:
        raise wrong(f"{path}: {error}") from error
