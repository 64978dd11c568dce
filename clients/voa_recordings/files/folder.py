"""The files of a rosbag2 folder: those that its metadata.yaml names, or, where some are missing, those that exist.

metadata.yaml is written when a recorder ends in order. It may be missing, empty or invalid, and files may have been
renamed or lost since: the files that exist are read, and the differences are reported as damage.
"""

import re
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from voa_recordings.files.db3_file import SIDECARS
from voa_recordings.files.kinds import STORAGES, is_named_so, kind_of, without_packing
from voa_recordings.files.message import UnreadableRecording

METADATA = "metadata.yaml"
_MOST_BYTES = 16 << 20
_PARTS = re.compile(r"(\d+)")


@dataclass
class Folder:
    """The files of a recording, and the damage of the folder.

    Attributes:
        files: storages, in the order of the metadata or of the numbers in their names.
        damage: differences from the metadata, as predicates of the recording ("lacks bag_1.mcap").
        messages: the count in the metadata; None: it has none.
        compression: format in which each message is compressed, by the metadata ("zstd"); "": none.
    """

    files: list[Path]
    damage: list[str] = field(default_factory=list)
    messages: int | None = None
    compression: str = ""


def storages(folder: Path) -> list[Path]:
    """Find storage files by name or content, in the order of their numbers: bag_2.mcap before bag_10.mcap.

    Raises:
        UnreadableRecording: the folder cannot be listed.
    """
    try:
        files = [path for path in folder.iterdir() if path.is_file() and not path.name.startswith(".")]
    except OSError as error:
        raise UnreadableRecording(f"{folder}: {error.strerror}") from error
    named = {path.name: path for path in files if is_named_so(path.name) or _is_storage(path)}
    once = [path for name, path in named.items() if without_packing(name) == name or without_packing(name) not in named]
    return sorted(once, key=_number)


def read_folder(path: Path) -> Folder:
    """Find the storage files of a folder, and compare them with its metadata.

    Raises:
        UnreadableRecording: the folder has no storage file.
    """
    present = storages(path)
    if not present:
        raise UnreadableRecording(f"{path} has no recording in it: expected files that end in .mcap or .db3")
    if not (path / METADATA).is_file():
        folder = Folder(present, [f"has no {METADATA}: its recorder did not end in order"])
    else:
        try:
            information = _information(path / METADATA)
        except UnreadableRecording as error:
            folder = Folder(present, [str(error)])
        else:
            folder = _named(path, information, present)
    orphans = _orphans(path)
    if orphans:
        folder.damage.append(f"has {', '.join(orphans)} without the database of that name: its messages are not read")
    return folder


def _named(path: Path, information: dict[str, Any], present: list[Path]) -> Folder:
    """Compare the files that the metadata names with those that are present."""
    names = [PurePosixPath(name).name for name in information["relative_file_paths"]]
    twins = {without_packing(file.name): file for file in present}
    named = [path / name if (path / name).is_file() else twins.get(without_packing(name)) for name in names]
    files = list(dict.fromkeys(file for file in named if file is not None))
    damage = [] if names else [f"has a {METADATA} that names no file"]
    missing = [name for name, file in zip(names, named, strict=True) if file is None]
    if missing:
        damage.append(f"lacks {', '.join(missing)}, which its {METADATA} names")
        others = [file for file in present if file not in files]
        if others:
            damage.append(f"has {', '.join(file.name for file in others)}, which its {METADATA} does not name")
        files = sorted([*files, *others], key=_number)
    count = information.get("message_count")
    by_message = str(information.get("compression_mode", "")).upper() == "MESSAGE"
    return Folder(
        files or present,
        damage,
        count if isinstance(count, int) else None,
        str(information.get("compression_format", "")) if by_message else "",
    )


def _information(path: Path) -> dict[str, Any]:
    """Read the part of metadata.yaml that names files; raises UnreadableRecording with a predicate of the recording."""
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise UnreadableRecording(
                f"has a {METADATA} of more than {_MOST_BYTES} bytes, which is too large to be read"
            )
        content = YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8"))
    except (OSError, YAMLError, ValueError, RecursionError) as error:
        why = " ".join(str(error).split())
        raise UnreadableRecording(f"has a {METADATA} that cannot be read ({why})") from error
    if content is None:
        raise UnreadableRecording(f"has an empty {METADATA}")
    information = content.get("rosbag2_bagfile_information") if isinstance(content, dict) else None
    names = information.get("relative_file_paths") if isinstance(information, dict) else None
    if (
        not isinstance(information, dict)
        or not isinstance(names, list)
        or not all(isinstance(name, str) and name for name in names)
    ):
        raise UnreadableRecording(
            f"has a {METADATA} that is not valid: expected rosbag2_bagfile_information with relative_file_paths"
        )
    return information


def _orphans(folder: Path) -> list[str]:
    """List write-ahead logs and journals whose database is missing or has another name."""
    logs = [path.name for path in folder.iterdir() if path.name.endswith(SIDECARS)]
    return sorted(name for name in logs if not (folder / name.rpartition("-")[0]).exists())


def _is_storage(path: Path) -> bool:
    try:
        return kind_of(path) in STORAGES
    except UnreadableRecording:
        return False


def _number(path: Path) -> list[int | str]:
    return [int(part) if part.isdigit() else part for part in _PARTS.split(path.name)]
