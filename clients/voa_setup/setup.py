"""Steps from a mesh to a scenario, in the order of `voa new`.

Each step decides one part of the scenario, and reports what it decided as notes for a person. The folder then holds a
scenario that the service, the fleet and the evaluations can use, and a page that shows whether it is right.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from voa_client import Client
from voa_client.scenario_files import load_with_warnings
from voa_fleet.errors import FleetError
from voa_fleet.world.objects import Physics
from voa_msgs.geometry import SensorConfiguration, Spread
from voa_msgs.lidars import Lidar
from voa_msgs.rankings import Ranking, RankingRequest
from voa_msgs.scenarios import ScenarioRequest, Workspace
from voa_msgs.warnings import ProbableMistake
from voa_setup.choices import Choices
from voa_setup.errors import SetupError
from voa_setup.grasps.proposals import NoGrasp, ProposedGrasp, propose_grasps
from voa_setup.grippers import UnknownGripper
from voa_setup.hulls import FILE as HULLS
from voa_setup.hulls import collision_solids, convex_pieces, describe_pieces, write_hulls
from voa_setup.look.page import write_look
from voa_setup.mesh import SetupMesh, read_mesh, write_mesh
from voa_setup.places import footprints
from voa_setup.poses import PoseSet
from voa_setup.scoring import Stages, final_scores, first_scores, without_failures
from voa_setup.steps import chosen_height, chosen_places, chosen_poses, preset_named, stable_poses_of
from voa_setup.writing import (
    begun_folder,
    check_folder,
    earlier_scenario,
    finish_folder,
    grasps_of,
    workspace_around,
    write_physics,
    write_scenario,
)

REFUSALS = (SetupError, NoGrasp, FleetError, UnknownGripper)
"""Errors of the making whose message is a sentence for the person who made the choices."""


@dataclass(frozen=True, eq=False)
class NewScenario:
    """A scenario that was made from a mesh.

    Attributes:
        folder: with its files.
        scenario: as in `scenario.json`.
        ranking: of the places under the prior.
        warnings: probable mistakes that the service reports.
        notes: what was decided, merged, left out or guessed, a sentence each.
        page: the page that shows whether it is right.
        stored: identifier of the scenario on the service.
    """

    folder: Path
    scenario: ScenarioRequest
    ranking: Ranking
    warnings: list[ProbableMistake]
    notes: list[str]
    page: Path
    stored: str


def new_scenario(client: Client, choices: Choices, folder: Path, stages: Stages) -> NewScenario:
    """Make a scenario from a mesh, and write it into a folder with all that the fleet needs.

    After an interruption the same choices may be used again: finished attempts are kept in the folder.

    Args:
        client: of a service, which proposes the rests, checks the scenario and ranks the places.
        choices: of the person.
        folder: for the files; it is made if necessary, and nothing is written before every choice has proved usable.
        stages: receives the name of each step, and the progress of the simulated attempts.

    Raises:
        SetupError: the mesh or a choice cannot be used; the message says what would work.
        NoGrasp: the gripper can hold the object at no pose.
        FleetError: the simulation refuses the object.
        VoaClientError: the service refuses, or cannot be reached.
    """
    stages.begin("reading the mesh")
    mesh = read_mesh(choices.mesh, scale=choices.scale, up=choices.up)
    check_folder(folder, choices.mesh, force=choices.force)

    stages.begin("finding its rests")
    poses = chosen_poses(choices, mesh, stable_poses_of(client, mesh))

    stages.begin("placing the lidar")
    lidar = preset_named(client, choices.lidar)
    places = chosen_places(choices, mesh, poses, lidar)
    height_m, height_notes = chosen_height(choices, mesh, poses, places, lidar)

    stages.begin("proposing grasps")
    grasps = propose_grasps(
        mesh.mesh,
        poses.poses,
        poses.prior,
        choices.gripper,
        count=choices.grasps,
        friction=choices.friction,
        seed=choices.seed,
    )
    draft = _draft(choices, mesh, poses, places, height_m, grasps)

    stages.begin("dividing the mesh into convex pieces for the simulation")
    pieces = convex_pieces(mesh.mesh)
    begun_folder(folder)  # from here on files are written: all choices have proved usable
    write_mesh(mesh.mesh, folder / f"{mesh.name}.obj")
    write_hulls(folder / HULLS, pieces)
    write_physics(_physics(choices, poses), folder)

    stages.begin("scoring the grasps")
    scores, score_note = final_scores(choices, draft, folder, stages)
    scenario, failures = without_failures(draft.model_copy(update={"scores": scores}))
    scenario_file = write_scenario(scenario, folder)

    stages.begin("checking the scenario and ranking its places")
    stored, of_mesh = load_with_warnings(client, scenario_file)
    warnings = [*of_mesh, *client.warnings(stored.id).items]
    ranking = client.rank_once(RankingRequest(scenario=stored.id, belief=None))
    notes = [
        *mesh.notes,
        *poses.merged,
        *poses.left_out,
        *height_notes,
        _sentence(describe_pieces(mesh.mesh, pieces)),
        score_note,
        *failures,
        *earlier_scenario(folder),
    ]

    stages.begin("drawing the page")
    page = write_look(
        folder,
        scenario,
        mesh.mesh,
        ranking,
        [warning.detail for warning in warnings],
        notes,
        gripper=choices.gripper,
    )
    finish_folder(folder)
    return NewScenario(folder, scenario, ranking, warnings, notes, page, stored.id)


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:].rstrip(".") + "."


def _draft(
    choices: Choices,
    mesh: SetupMesh,
    poses: PoseSet,
    places: Sequence[SensorConfiguration],
    height_m: float,
    grasps: Sequence[ProposedGrasp],
) -> ScenarioRequest:
    """The scenario with its first scores: a lab's, or those by geometry."""
    is_exact = choices.xy_m == 0.0 and choices.yaw_rad == 0.0
    return ScenarioRequest(
        name=mesh.name,
        object=f"{mesh.name}.obj",
        poses=poses.poses,
        grasps=grasps_of((grasp.name, grasp.geometry) for grasp in grasps),
        scores=first_scores(choices, mesh.mesh, poses.poses, grasps),
        sensors=list(places),
        lidar=Lidar(preset=choices.lidar, height_m=height_m),
        workspace=Workspace.model_validate(workspace_around(footprints(mesh, poses.poses), choices.xy_m)),
        spread=None if is_exact else Spread(xy_m=choices.xy_m, yaw_rad=choices.yaw_rad),
        prior=poses.prior,
    )


def _physics(choices: Choices, poses: PoseSet) -> Physics:
    """Physical properties for the fleet."""
    return Physics(
        density_kg_m3=choices.density_kg_m3,
        friction=choices.friction,
        gripper=choices.gripper,
        solids=collision_solids(),
        grasps={},
        rests=poses.rests,
    )
