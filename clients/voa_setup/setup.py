"""Steps from a mesh to a scenario, in the order of `voa new`.

Each step decides one part of the scenario, and reports what it decided as notes for a person. The folder then holds a
scenario that the service, the fleet and the evaluations can use, and a page that shows whether it is right.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from voa_client import Client
from voa_client.scenario_files import load_with_warnings
from voa_fleet.world.objects import Physics
from voa_msgs.geometry import SensorConfiguration, Spread
from voa_msgs.lidars import Lidar, LidarPreset
from voa_msgs.objects import StablePose
from voa_msgs.rankings import Ranking, RankingRequest
from voa_msgs.scenarios import ScenarioRequest, Workspace
from voa_msgs.warnings import ProbableMistake
from voa_setup.choices import Choices
from voa_setup.errors import InvalidOption
from voa_setup.grasps.proposals import ProposedGrasp, propose_grasps
from voa_setup.heights import check_height, describe_height, sights, suggested
from voa_setup.hulls import FILE as HULLS
from voa_setup.hulls import collision_solids, convex_pieces, describe_pieces, write_hulls
from voa_setup.look.page import write_look
from voa_setup.mesh import SetupMesh, read_mesh, write_mesh
from voa_setup.places import check_places, fitting_radius, footprints, ring
from voa_setup.poses import PoseSet, make_poses
from voa_setup.scoring import Stages, final_scores, first_scores, without_failures
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
    """

    folder: Path
    scenario: ScenarioRequest
    ranking: Ranking
    warnings: list[ProbableMistake]
    notes: list[str]
    page: Path


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
    stable = _stable_poses(client, mesh)
    poses = make_poses(
        mesh,
        stable,
        yaws_deg=choices.yaws_deg,
        positions=choices.positions,
        least_probability=choices.least_probability,
    )

    stages.begin("placing the lidar")
    lidar = _preset(client, choices.lidar)
    places = _places(choices, mesh, poses, lidar)
    height_m, height_notes = _height(choices, mesh, poses, places, lidar)

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
    return NewScenario(folder, scenario, ranking, warnings, notes, page)


def _stable_poses(client: Client, mesh: SetupMesh) -> list[StablePose]:
    """Stable poses of the mesh, as the service computes them."""
    with TemporaryDirectory(prefix="voa-new-") as temporary:
        file = Path(temporary) / f"{mesh.name}.obj"
        write_mesh(mesh.mesh, file)
        return list(client.stable_poses(client.create_object(file).id).items)


def _preset(client: Client, name: str) -> LidarPreset:
    """Preset of that name; raises InvalidOption with the names that exist."""
    presets = {preset.name: preset for preset in client.lidars().items}
    if name not in presets:
        raise InvalidOption(f"--lidar {name}: there is no such lidar; there are: {', '.join(sorted(presets))}")
    return presets[name]


def _places(choices: Choices, mesh: SetupMesh, poses: PoseSet, lidar: LidarPreset) -> list[SensorConfiguration]:
    """Places of the lidar, on a ring around the middle of the positions or as listed; raises InvalidOption."""
    if not isinstance(choices.places, int):
        places = list(choices.places)
        check_places(places, mesh, poses.poses, lidar)
        return places
    xs, ys = zip(*choices.positions, strict=True)
    centre = round(sum(xs) / len(xs), 6), round(sum(ys) / len(ys), 6)
    radius = fitting_radius(choices.radius_m, mesh, poses.poses, lidar, centre)
    return ring(choices.places, radius, centre)


def _height(
    choices: Choices, mesh: SetupMesh, poses: PoseSet, places: Sequence[SensorConfiguration], lidar: LidarPreset
) -> tuple[float, list[str]]:
    """Height of the scan plane, and notes about it; raises InvalidOption for a height that sees nothing."""
    candidates = sights(mesh, poses.poses, poses.prior, places, lidar)
    best = suggested(candidates)
    chosen = best
    if choices.height_m is not None:
        chosen = sights(mesh, poses.poses, poses.prior, places, lidar, [choices.height_m])[0]
    check_height(chosen, candidates)
    return chosen.height_m, [] if len(poses.poses) == 1 else [describe_height(chosen, best)]


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
