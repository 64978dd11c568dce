"""Scenario files: the body of POST /v1/scenarios, whose `object` may be a mesh file beside it.

A mesh file's `scale` (metres per unit of the file) and `up` ("+Z" or "+Y") may stand beside `object`.
"""

import re
from pathlib import Path

from voa_client import Client, InvalidRequestError, VoaClientError
from voa_client.message_files import read_file
from voa_msgs.base import Positive
from voa_msgs.objects import Object, UpAxis
from voa_msgs.scenarios import Scenario, ScenarioRequest
from voa_msgs.warnings import ProbableMistake

_STORED = re.compile(r"[0-9a-f]{64}")
_OF_THE_MESH = {"scale", "up"}


class InvalidScenarioFile(VoaClientError):
    """A file is not a scenario; says what is wrong with it."""


class ScenarioFile(ScenarioRequest):
    """A scenario, and how its mesh file is to be read."""

    scale: Positive | None = None
    """Metres per unit of the mesh file; null: it is in metres."""
    up: UpAxis | None = None
    """The axis of the mesh file that is up; null: +Y in a GLB file, +Z in others."""


def load_scenario(client: Client, path: Path) -> Scenario:
    """Store the scenario of a file, its mesh first if it names one; raises as `load_with_warnings`."""
    return load_with_warnings(client, path)[0]


def load_with_warnings(client: Client, path: Path) -> tuple[Scenario, list[ProbableMistake]]:
    """Store the scenario of a file, its mesh first if it names one; returns what is warned of about the mesh, too.

    Raises:
        InvalidScenarioFile: the file is not there or not a scenario, or its mesh is not there or not read.
        VoaClientError: the service refuses it.
    """
    told = read_file(ScenarioFile, path, InvalidScenarioFile)
    mesh = _mesh(told, path)
    given = {name: getattr(told, name) for name in told.model_fields_set - _OF_THE_MESH}
    warnings: list[ProbableMistake] = []
    if mesh is not None:
        uploaded = _uploaded(client, told, path, mesh)
        given["object"], warnings = uploaded.id, uploaded.warnings
    scenario = client.create_scenario(ScenarioRequest.model_construct(**given))
    if mesh is None and scenario.object is not None:
        warnings = client.get_object(scenario.object).warnings
    return scenario, warnings


def _mesh(told: ScenarioFile, path: Path) -> Path | None:
    """The file that `object` names; None: it is the id of a stored object, or there is none.

    Raises:
        InvalidScenarioFile: there is no such file, or nothing that `scale` and `up` could be about.
    """
    mesh = None if told.object is None else path.parent / told.object
    if mesh is not None and mesh.is_file():
        return mesh
    if told.object is not None and not _STORED.fullmatch(told.object):
        raise InvalidScenarioFile(
            f"{path}: object: there is no mesh file {mesh}; expected the name of one, seen from the scenario file's "
            "folder, or the id of a stored object"
        )
    beside = sorted(_OF_THE_MESH & told.model_fields_set)
    if beside:
        raise InvalidScenarioFile(f"{path}: {beside[0]}: goes with a mesh file as `object`, and this scenario has none")
    return None


def _uploaded(client: Client, told: ScenarioFile, path: Path, mesh: Path) -> Object:
    """Find the object of a mesh file on the service, or upload the file."""
    scale = 1.0 if told.scale is None else told.scale
    try:
        return _found(client, mesh, scale, told.up) or client.create_object(mesh, scale=scale, up=told.up)
    except OSError as error:
        raise InvalidScenarioFile(f"{path}: object: {mesh}: {error.strerror}") from error
    except InvalidRequestError as error:
        hint = f' (in {path.name}, "scale" stands beside "object")' if "scale" in error.problem.detail else ""
        raise InvalidScenarioFile(f"{path}: object: {mesh}: {error.problem.detail}{hint}") from error


def _found(client: Client, mesh: Path, scale: float, up: UpAxis | None) -> Object | None:
    """Find the object of a mesh file that was uploaded before; None: upload it, and hear then what is wrong with it."""
    try:
        return client.find_object(mesh, scale, up)
    except InvalidRequestError:  # no mesh file; or, over Zenoh, an older service
        return None
