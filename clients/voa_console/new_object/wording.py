"""Wording of the page for what `voa_setup` and the service say: its messages name options of a command."""

import re
from collections.abc import Mapping, Sequence

from voa_console.new_object.draft import Draft

_OPTIONS: Mapping[str, str] = {
    "--scores simulated": "simulated scores",
    "--scores FILE.csv": "voa new --scores FILE.csv",
    "--radius": "radius",
    "--height": "height",
    "--lidar": "lidar",
    "--rests": "rests",
    "--scale": "scale",
    "--gripper": "gripper",
}
_FILE = re.compile(r"[^\s.]+\.\w+\s")
_FOLDER = re.compile(r": choose another folder by -o(, or add --force to write over it)?|; choose another by -o")


def without_options(text: str) -> str:
    """Rewrite a message of the command line for a page: the names of fields instead of options."""
    text = _FOLDER.sub(": choose another folder", text)
    for option, name in _OPTIONS.items():
        text = text.replace(option, name)
    return text


def sentence(text: str) -> str:
    """Write a text as a sentence: a capital letter first, unless a file name is there; a full stop last."""
    text = without_options(text).strip()
    if not text:
        return text
    first = text[0] if _FILE.match(text) else text[0].upper()
    return f"{first}{text[1:].rstrip('.')}."


def without_path(text: str, draft: Draft) -> str:
    """Name the mesh file of a draft without its folder, which means nothing to the person who sent it."""
    return text.replace(draft.mesh, draft.mesh.rpartition("/")[2])


def counted(number: int, noun: str) -> str:
    """Write a number with its noun, such as "1 pose" or "3 poses"."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def listed(names: Sequence[str], most: int = 6) -> str:
    """List names with commas, and count those after the first few."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{', '.join(names[:most])}{more}"


def duration(seconds: float) -> str:
    """Write a duration in seconds or minutes."""
    return f"{seconds:.0f} s" if seconds < 90.0 else f"{seconds / 60.0:.0f} min"
