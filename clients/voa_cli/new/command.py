"""`voa new`: make a scenario from a mesh.

voa new bottle.stl -o bottle                    metres, a 2F-85 gripper, an LDS-02, scores from simulated attempts
voa new bottle.stl -o bottle --scale 0.001      the file is in millimetres
voa new bottle.stl --gripper 0.05 --yaws 0,90   a gripper that opens by 5 cm, and every rest at two yaws
voa new bottle.stl --scores geometric           within seconds, with scores that are a first guess

The folder then holds scenario.json (poses, grasps, scores, lidar and places), the mesh in metres, what the simulation
needs (physics.json, hulls.obj), scores.csv, and look.html, a page that shows whether everything is right. Rests come
from the shape and its centre of mass, grasps from pairs of opposite surfaces, scores from attempts in a simulation.
The same options give the same files.
"""

import sys
from collections.abc import Sequence
from dataclasses import replace

from voa_cli.new.display import print_result, report_of, terminal
from voa_cli.new.options import choices_of, read_options
from voa_client import VoaClientError
from voa_client.local import service_at
from voa_fleet.errors import FleetError
from voa_setup.choices import Choices
from voa_setup.errors import InvalidOption, SetupError, UnlikelySize
from voa_setup.grasps.proposals import NoGrasp
from voa_setup.grippers import UnknownGripper
from voa_setup.mesh import read_mesh
from voa_setup.setup import new_scenario
from voa_setup.writing import PARTIAL


def main(arguments: Sequence[str] | None = None) -> int:
    """Make a scenario from a mesh, print what was decided, and return 0; 1 after an error, 2 for invalid options."""
    options = read_options(__doc__, arguments)
    try:
        choices = with_scale(choices_of(options))
        with service_at(options.url) as client, terminal() as stages:
            result = new_scenario(client, choices, options.out, stages)
    except InvalidOption as error:
        print(f"voa new: {error}", file=sys.stderr)
        return 2
    except UnknownGripper as error:
        print(f"voa new: --gripper: {error}", file=sys.stderr)
        return 2
    except (SetupError, NoGrasp, FleetError, VoaClientError) as error:
        print(f"voa new: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"voa new: {error.filename or options.out} cannot be written: {error.strerror or error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        if (options.out / PARTIAL).exists():
            print(
                "voa new: interrupted; the same command keeps the attempts that are finished, and resumes",
                file=sys.stderr,
            )
        raise
    if options.json:
        print(report_of(result).model_dump_json(indent=1, exclude_none=True))
    else:
        print_result(result, str(choices.scores))
    return 0


def with_scale(choices: Choices) -> Choices:
    """Read the mesh once, and request the unit of an object of unlikely size at a terminal.

    Raises:
        UnlikelySize: there is no terminal, or no scale would explain the size.
    """
    try:
        read_mesh(choices.mesh, scale=choices.scale, up=choices.up)
    except UnlikelySize as error:
        if not (error.scales and sys.stdin.isatty() and sys.stderr.isatty()):
            raise
        return replace(choices, scale=_requested_scale(error))
    return choices


def _requested_scale(error: UnlikelySize) -> float:
    """Request the metres per unit of the file until a number above 0 is given; Enter takes the suggestion."""
    suggestion = error.scales[0]
    print(f"{error}", file=sys.stderr)
    while True:
        print(f"metres per unit of the file [{suggestion:g}]: ", end="", file=sys.stderr, flush=True)
        line = sys.stdin.readline()
        if not line:
            raise error
        try:
            scale = float(line) if line.strip() else suggestion
        except ValueError:
            continue
        if 0.0 < scale < float("inf"):
            return scale
