"""Scenario files: JSON with the body of POST /v1/scenarios, in which `object` may name a mesh file.

Beside `object`, the file may have the mesh file's `scale` (metres per unit of the file) and `up` ("+Z" or "+Y").
A folder with `scenario.json` stands for that file.
"""

import re
from pathlib import Path
from typing import NamedTuple

from voa_client import Client, InvalidRequestError, VoaClientError
from voa_client.message_files import read_file
from voa_msgs.base import Positive
from voa_msgs.geometry import Spread
from voa_msgs.objects import Object, UpAxis
from voa_msgs.scenarios import Scenario, ScenarioRequest
from voa_msgs.warnings import ProbableMistake

_STORED = re.compile(r"[0-9a-f]{64}")
_MESH_FIELDS = {"scale", "up"}


class InvalidScenarioFile(VoaClientError):
    """A file is not a scenario, or its mesh file is missing or not valid; the message says what is wrong."""


class ScenarioFile(ScenarioRequest):
    """Content of a scenario file: the scenario, and scale and axis of its mesh file."""

    scale: Positive | None = None
    """Metres per unit of the mesh file; null: it is in metres."""
    up: UpAxis | None = None
    """The axis of the mesh file that is up; null: +Y in a GLB file, +Z in others."""


class MeshOfFile(NamedTuple):
    """Mesh file that a scenario file names.

    Attributes:
        path: of the mesh file.
        scale: metres per unit of the file.
        up: axis of the file that is up; None: the usual one of its type.
    """

    path: Path
    scale: float
    up: UpAxis | None


def read_scenario_file(path: Path) -> tuple[ScenarioRequest, MeshOfFile | None]:
    """Read a scenario file without a service; returns the scenario, and its mesh file.

    Args:
        path: of the scenario file, or of a folder with `scenario.json`; mesh files are searched in the file's folder.

    Returns:
        The scenario with the fields that the file states, whose `object` is None beside a mesh file; and the mesh
        file. None: `object` is the id of a stored object, or missing.

    Raises:
        InvalidScenarioFile: the scenario file is not valid, or its mesh file is missing.
    """
    path = path / "scenario.json" if path.is_dir() else path
    file = read_file(ScenarioFile, path, InvalidScenarioFile)
    mesh = _mesh(file, path)
    fields = {name: getattr(file, name) for name in file.model_fields_set - _MESH_FIELDS}
    if mesh is None:
        return ScenarioRequest.model_construct(**fields), None
    del fields["object"]
    return ScenarioRequest.model_construct(**fields), MeshOfFile(mesh, _scale(file), file.up)


def load_scenario(client: Client, path: Path, *, spread: Spread | None = None, absent: float | None = None) -> Scenario:
    """Store the scenario of a file on the service, and the mesh file that it names.

    Args:
        client: of the service.
        path: of the scenario file, or of a folder with `scenario.json`; mesh files are searched in the file's folder.
        spread: of the object about each pose, which replaces the file's; None: the file's.
        absent: probability that the object lies at none of the poses, which replaces the file's; None: the file's.

    Raises:
        InvalidScenarioFile: the scenario file or its mesh file is missing or not valid.
        VoaClientError: the service cannot be reached, or refuses.
    """
    return load_with_warnings(client, path, spread=spread, absent=absent)[0]


def load_with_warnings(
    client: Client, path: Path, *, spread: Spread | None = None, absent: float | None = None
) -> tuple[Scenario, list[ProbableMistake]]:
    """Store the scenario of a file on the service, and return it with the service's warnings about its mesh.

    Args:
        client: of the service.
        path: of the scenario file, or of a folder with `scenario.json`; mesh files are searched in the file's folder.
        spread: of the object about each pose, which replaces the file's; None: the file's.
        absent: probability that the object lies at none of the poses, which replaces the file's; None: the file's.

    Raises:
        InvalidScenarioFile: the scenario file or its mesh file is missing or not valid.
        VoaClientError: the service cannot be reached, or refuses.
    """
    path = path / "scenario.json" if path.is_dir() else path
    file = read_file(ScenarioFile, path, InvalidScenarioFile)
    mesh = _mesh(file, path)
    fields = {name: getattr(file, name) for name in file.model_fields_set - _MESH_FIELDS}
    stated = {"spread": spread, "absent": absent}
    fields |= {name: value for name, value in stated.items() if value is not None}
    warnings: list[ProbableMistake] = []
    if mesh is not None:
        uploaded = _uploaded(client, file, path, mesh)
        fields["object"], warnings = uploaded.id, uploaded.warnings
    scenario = client.create_scenario(ScenarioRequest.model_construct(**fields))
    if mesh is None and scenario.object is not None:
        warnings = client.get_object(scenario.object).warnings
    return scenario, warnings


def _mesh(file: ScenarioFile, path: Path) -> Path | None:
    """Return the mesh file that `object` names; None: `object` is the id of a stored object, or missing.

    Raises:
        InvalidScenarioFile: there is no such file, or the fields `scale` or `up` are given without a mesh file.
    """
    mesh = None if file.object is None else path.parent / file.object
    if mesh is not None and mesh.is_file():
        return mesh
    if file.object is not None and not _STORED.fullmatch(file.object):
        raise InvalidScenarioFile(
            f"{path}: object: there is no mesh file {mesh}; expected its path, relative to the scenario file's "
            "folder, or the id of a stored object"
        )
    beside = sorted(_MESH_FIELDS & file.model_fields_set)
    if beside:
        raise InvalidScenarioFile(f"{path}: {beside[0]}: needs a mesh file as `object`, and this scenario has none")
    return None


def _uploaded(client: Client, file: ScenarioFile, path: Path, mesh: Path) -> Object:
    """Find the object of a mesh file on the service, or upload the file."""
    scale = _scale(file)
    try:
        return _uploaded_before(client, mesh, scale, file.up) or client.create_object(mesh, scale=scale, up=file.up)
    except OSError as error:
        raise InvalidScenarioFile(f"{path}: object: {mesh}: {error.strerror}") from error
    except InvalidRequestError as error:
        hint = f' (in {path.name}, put "scale" beside "object")' if "scale" in error.problem.detail else ""
        raise InvalidScenarioFile(f"{path}: object: {mesh}: {error.problem.detail}{hint}") from error


def _uploaded_before(client: Client, mesh: Path, scale: float, up: UpAxis | None) -> Object | None:
    """Find the object of a mesh file that was uploaded before; None: it has to be uploaded."""
    try:
        return client.find_object(mesh, scale, up)
    except InvalidRequestError:  # not a mesh file, which the upload will report; or, over Zenoh, an older service
        return None


def _scale(file: ScenarioFile) -> float:
    return 1.0 if file.scale is None else file.scale
