"""Scenario files: the body of POST /v1/scenarios, whose `object` may be a mesh file beside it."""

import json
from pathlib import Path

from pydantic import ValidationError

from voa_client import Client, VoaClientError
from voa_msgs.scenarios import Scenario, ScenarioRequest


class InvalidScenarioFile(VoaClientError):
    """A file is not a scenario; says what is wrong with it."""


def load_scenario(client: Client, path: Path) -> Scenario:
    """Store the scenario of a file, its mesh first if it names one.

    Raises:
        InvalidScenarioFile: the file is not there or not a scenario.
        VoaClientError: the service refuses it.
    """
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
        request = ScenarioRequest.model_validate(told)
    except OSError as error:
        raise InvalidScenarioFile(f"{path}: {error.strerror}") from error
    except ValidationError as error:
        first = error.errors()[0]
        raise InvalidScenarioFile(f"{path}: {'.'.join(map(str, first['loc']))}: {first['msg']}") from error
    except ValueError as error:
        raise InvalidScenarioFile(f"{path} is not JSON: {error}") from error
    mesh = None if request.object is None else path.parent / request.object
    if mesh is not None and mesh.is_file():
        request = request.model_copy(update={"object": client.create_object(mesh).id})
    return client.create_scenario(request)
