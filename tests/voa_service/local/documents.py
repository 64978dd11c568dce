"""Documents for rankings without HTTP, and use cases on which they are ranked."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tests.support.serving import box_obj, data_scenario, mesh_scenario
from voa_service.local.ranking import local_services
from voa_service.services import Services
from voa_service.settings import Settings


def nothing() -> None:
    """Check that never ends a ranking."""


def data_document(ranking: dict[str, Any], **changes: Any) -> bytes:
    """Write a document about a scenario whose predictions are data."""
    return json.dumps({"scenario": data_scenario(**changes), "ranking": ranking}).encode()


def mesh_document(folder: Path, ranking: dict[str, Any], **changes: Any) -> bytes:
    """Write a document about a box, whose file is written into a folder."""
    path = folder / "box.obj"
    path.write_text(box_obj(), encoding="utf-8")
    scenario = mesh_scenario("box.obj", **changes) | {"object": None}
    return json.dumps({"scenario": scenario, "mesh": {"path": str(path)}, "ranking": ranking}).encode()


@contextmanager
def local(**settings: Any) -> Iterator[Services]:
    """Build the use cases of a ranking without HTTP, with two threads."""
    with local_services(Settings(workers=2, **settings)) as built:
        yield built
