"""Tasks of the process that does the work, each by the functions that `voa new` uses. Needs the extra `setup`."""

from pathlib import Path
from types import TracebackType
from typing import Self

from voa_client import Client
from voa_client.local import BRIEFLY
from voa_console.new_object.draft import Draft, listed_places
from voa_console.new_object.messages import Made, Task
from voa_console.new_object.wording import sentence
from voa_msgs.lidars import LidarPreset
from voa_msgs.objects import StablePose
from voa_setup.choices import Choices
from voa_setup.grippers import gripper_named
from voa_setup.mesh import SetupMesh, read_mesh
from voa_setup.places import listed_places as places_of
from voa_setup.poses import even_yaws
from voa_setup.previews.measuring import measure_mesh
from voa_setup.previews.planning import preview_outlines, preview_plan
from voa_setup.previews.rests import preview_rests
from voa_setup.scoring import Stages
from voa_setup.setup import REFUSALS, new_scenario
from voa_setup.steps import preset_named, stable_poses_of


class Tasks:
    """Work on new objects: keeps the mesh, its stable poses and the lidars between tasks.

    Args:
        url: address of the service.
    """

    refusals = REFUSALS
    """Errors that are sentences for a person."""

    def __init__(self, url: str) -> None:
        self._client = Client(url, retries=BRIEFLY)
        self._mesh: tuple[tuple[object, ...], SetupMesh, list[StablePose]] | None = None
        self._lidars: dict[str, LidarPreset] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._client.close()

    def do(self, task: Task, stages: Stages) -> str:
        """Do a task, and return its result as JSON.

        Raises:
            SetupError: a choice cannot be used, as with the other errors in `refusals`.
            VoaClientError: the service refuses, or cannot be reached.
            OSError: a file cannot be written.
        """
        draft, folder = task.draft, Path(task.folder)
        match task.step:
            case "measure":
                return measure_mesh(Path(draft.mesh)).model_dump_json()
            case "rests":
                mesh, stable = self._rests(draft)
                return preview_rests(mesh, stable, folder).model_dump_json()
            case "plan":
                mesh, stable = self._rests(draft)
                return preview_plan(choices_of(draft), mesh, stable, self._lidar(draft.lidar)).model_dump_json()
            case "outlines":
                mesh, stable = self._rests(draft)
                return preview_outlines(choices_of(draft), mesh, stable, task.height_m).model_dump_json()
            case "make":
                return self._make(task, stages).model_dump_json()

    def _rests(self, draft: Draft) -> tuple[SetupMesh, list[StablePose]]:
        """Read the mesh, and compute its stable poses by the service, once for each size and axis."""
        key = draft.mesh, draft.scale, draft.up
        if self._mesh is None or self._mesh[0] != key:
            mesh = read_mesh(Path(draft.mesh), scale=draft.scale, up=draft.up)
            self._mesh = key, mesh, stable_poses_of(self._client, mesh)
        return self._mesh[1], self._mesh[2]

    def _lidar(self, name: str) -> LidarPreset:
        if name not in self._lidars:
            self._lidars[name] = preset_named(self._client, name)
        return self._lidars[name]

    def _make(self, task: Task, stages: Stages) -> Made:
        """Make the scenario."""
        made = new_scenario(self._client, choices_of(task.draft, force=task.force), Path(task.folder), stages)
        return Made(
            folder=str(made.folder),
            scenario=made.stored,
            name=made.scenario.name,
            poses=len(made.scenario.poses),
            grasps=[grasp.name for grasp in made.scenario.grasps],
            places=len(made.scenario.sensors),
            notes=[sentence(note) for note in made.notes],
            warnings=[sentence(warning.detail) for warning in made.warnings],
            ranking=made.ranking,
        )


def choices_of(draft: Draft, *, force: bool = False) -> Choices:
    """Make the choices that a draft describes; raises UnknownGripper."""
    return Choices(
        mesh=Path(draft.mesh),
        scale=draft.scale,
        up=draft.up,
        rests=draft.rests,
        yaws_deg=even_yaws(draft.yaws),
        xy_m=draft.xy_m,
        yaw_deg=draft.yaw_deg,
        gripper=gripper_named(draft.gripper),
        grasps=draft.grasps,
        density_kg_m3=draft.density_kg_m3,
        friction=draft.friction,
        places=draft.places if draft.bearings_deg is None else places_of(listed_places(draft)),
        radius_m=draft.radius_m if draft.bearings_deg is None else None,
        lidar=draft.lidar,
        height_m=draft.height_m,
        scores=draft.scores,
        attempts=draft.attempts,
        force=force,
    )
