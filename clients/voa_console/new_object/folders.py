"""Folders and files of a scenario: where it may be written, and the archive of what was made."""

import zipfile
from io import BytesIO
from pathlib import Path

FILES = ("scenario.json", "physics.json", "hulls.obj", "scores.csv", "look.html")
"""Files of a scenario besides its mesh."""
_PARTIAL = "scores.partial"


class UnusableTarget(ValueError):
    """A scenario cannot be written into the folder that a person named; the message says why."""


def target_folder(text: str, base: Path, *, anywhere: bool) -> Path:
    """Return the folder that a person named.

    Args:
        text: its path, absolute or from `base`.
        base: folder in which the console was started.
        anywhere: True if the person may name any folder of this machine; else only folders below `base`.

    Raises:
        UnusableTarget: the path is empty, or not below `base` where it has to be.
    """
    if not text.strip():
        raise UnusableTarget("Name a folder for the files.")
    try:
        folder = (base / Path(text.strip()).expanduser()).resolve()
    except (OSError, RuntimeError, ValueError) as error:
        raise UnusableTarget(f"{text} is no path of a folder: {error}.") from error
    if not anywhere and (folder == base.resolve() or not folder.is_relative_to(base.resolve())):
        raise UnusableTarget(
            f"{text} is not below {base.resolve()}. Other machines can reach this console, so it writes into folders "
            "below its own only."
        )
    return folder


def has_scenario(folder: Path) -> bool:
    """True if a finished scenario is in the folder, which a new one would replace."""
    return (folder / "scenario.json").exists() and not (folder / _PARTIAL).exists()


def archive(folder: Path, name: str) -> bytes:
    """Return the files of a scenario as a ZIP archive, in a folder of the object's name.

    Args:
        folder: with the scenario.
        name: of the object.
    """
    content = BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as files:
        for file in (*FILES, f"{name}.obj"):
            if (folder / file).is_file():
                files.write(folder / file, f"{name}/{file}")
    return content.getvalue()
