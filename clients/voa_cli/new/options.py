"""Options of `voa new`, and the choices that they describe."""

import argparse
import math
import re
import sys
from collections.abc import Sequence
from pathlib import Path

from voa_msgs.geometry import SensorConfiguration
from voa_setup.choices import ATTEMPTS, GEOMETRIC, GRIPPER, SIMULATED, XY_M, YAW_DEG, Choices
from voa_setup.errors import InvalidOption
from voa_setup.grippers import GRIPPERS, gripper_named
from voa_setup.places import listed_places, read_places
from voa_setup.poses import LEAST_PROBABILITY, even_yaws

_COUNT = re.compile(r"[+-]?\d+")
_NEGATIVE = re.compile(r"-[\d.]+,")


def read_options(description: str | None, arguments: Sequence[str] | None) -> argparse.Namespace:
    """Parse the command line; exits with code 2 and a message where it is not valid."""
    words = sys.argv[1:] if arguments is None else arguments
    # A word such as -0.1,0.05 is a position, which argparse takes for an option unless a space stands before it.
    options = _parser(description).parse_args([f" {word}" if _NEGATIVE.match(word) else word for word in words])
    options.out = Path(options.mesh.stem) if options.out is None else options.out
    return options


def choices_of(options: argparse.Namespace) -> Choices:
    """Make the choices that the options describe.

    Raises:
        InvalidOption: places contradict each other or cannot be read, or a list of grasp scores does not exist.
        UnknownGripper: the gripper is neither a name nor an opening.
    """
    return Choices(
        mesh=options.mesh,
        scale=options.scale,
        up=options.up,
        yaws_deg=options.yaws,
        positions=options.positions,
        least_probability=options.least_probability,
        rests=options.rests,
        xy_m=options.spread[0],
        yaw_deg=options.spread[1],
        gripper=gripper_named(options.gripper),
        grasps=options.grasps,
        density_kg_m3=options.density,
        friction=options.friction,
        places=_places(options),
        radius_m=options.radius,
        lidar=options.lidar,
        height_m=options.height,
        scores=_scores(options.scores),
        attempts=options.attempts,
        processes=options.processes,
        seed=options.seed,
        force=options.force,
    )


def _places(options: argparse.Namespace) -> int | list[SensorConfiguration]:
    """Number of places on the ring, or the listed ones; raises InvalidOption."""
    listed = options.place or (options.places is not None and not _COUNT.fullmatch(options.places))
    if listed and options.radius is not None:
        raise InvalidOption("--radius is of the ring of places: leave it out where places are listed")
    if options.place:
        if options.places is not None:
            raise InvalidOption("state either --places or --place, not both")
        return listed_places(options.place)
    if listed:
        return read_places(Path(options.places))
    count = 8 if options.places is None else int(options.places)
    if not 1 <= count <= 360:
        raise InvalidOption(f"--places {options.places}: expected a number from 1 to 360, or a file")
    return count


def _scores(text: str) -> str | Path:
    if text in (SIMULATED, GEOMETRIC):
        return text
    if not Path(text).is_file():
        raise InvalidOption(f"--scores {text}: expected {SIMULATED}, {GEOMETRIC}, or a file with counts; no such file")
    return Path(text)


def _number(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise argparse.ArgumentTypeError(f"expected a number, got {text!r}")
    return number


def _positive(text: str) -> float:
    number = _number(text)
    if number <= 0.0:
        raise argparse.ArgumentTypeError(f"expected a number above 0, got {text!r}")
    return number


def _share(text: str) -> float:
    number = _number(text)
    if not 0.0 <= number <= 1.0:
        raise argparse.ArgumentTypeError(f"expected a probability from 0 to 1, got {text!r}")
    return number


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number of at least 1, got {text!r}")
    return int(text)


def _seed(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"expected a whole number of at least 0, got {text!r}")
    return int(text)


def _yaws(text: str) -> list[float]:
    """Read "8" as eight even yaws, and "0,90" (or "30,") as yaws in degrees; raises ArgumentTypeError."""
    if text.isdecimal() and 1 <= int(text) <= 360:
        return even_yaws(int(text))
    try:
        yaws = [_number(part) for part in text.split(",") if part.strip()]
    except ValueError:
        yaws = []
    if "," not in text or not yaws or len({yaw % 360.0 for yaw in yaws}) < len(yaws):
        raise argparse.ArgumentTypeError(
            f"expected a number from 1 to 360, or different yaws in degrees such as 0,90,180, got {text!r}"
        )
    return yaws


def _position(text: str) -> tuple[float, float]:
    try:
        x, y = (_number(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"expected a position as X,Y in metres, such as 0.05,0, got {text!r}"
        ) from None
    return x, y


def _spread(text: str) -> tuple[float, float]:
    try:
        xy_m, yaw_deg = (_number(part) for part in text.split(","))
        if min(xy_m, yaw_deg) < 0.0:
            raise ValueError(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected metres and degrees, such as 0.005,3, got {text!r}") from None
    return xy_m, yaw_deg


def _parser(description: str | None) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa new", description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("mesh", type=Path, metavar="MESH", help="mesh file of the object: STL, OBJ, PLY, GLB or OFF")
    parser.add_argument("-o", "--out", type=Path, metavar="DIR", help="folder to write (default: the mesh's name)")
    parser.add_argument("--force", action="store_true", help="write over a scenario that is in the folder")

    mesh = parser.add_argument_group("mesh")
    mesh.add_argument("--scale", type=_positive, metavar="M", help="metres per unit of the file: 0.001 for millimetres")
    mesh.add_argument(
        "--up", choices=("+Z", "+Y"), help="axis of the file that points up (default: +Y for GLB, else +Z)"
    )

    poses = parser.add_argument_group("poses")
    poses.add_argument(
        "--yaws", type=_yaws, default=even_yaws(8), metavar="N|DEGREES",
        help="number of yaws of each rest, or the yaws themselves, such as 0,90 (default 8)",
    )  # fmt: skip
    poses.add_argument(
        "--positions", type=_position, nargs="+", default=[(0.0, 0.0)], metavar="X,Y",
        help="positions of the centre of mass on the table, metres (default 0,0)",
    )  # fmt: skip
    poses.add_argument(
        "--least-probability", type=_share, default=LEAST_PROBABILITY, metavar="P",
        help=f"leave out rests in which a dropped object ends less often (default {LEAST_PROBABILITY:g})",
    )  # fmt: skip
    poses.add_argument(
        "--rests", nargs="+", metavar="NAME",
        help="rests to keep by name, such as upright 'on side A' (default: all that are probable enough)",
    )  # fmt: skip
    poses.add_argument(
        "--spread", type=_spread, default=(XY_M, YAW_DEG), metavar="M,DEG",
        help=f"standard deviations of the object about its pose (default {XY_M:g},{YAW_DEG:g})",
    )  # fmt: skip

    grasps = parser.add_argument_group("grasps")
    grasps.add_argument(
        "--gripper", default=GRIPPER, metavar="NAME|WIDTH",
        help=f"{', '.join(GRIPPERS)}, or the opening of a parallel gripper in metres (default {GRIPPER})",
    )  # fmt: skip
    grasps.add_argument("--grasps", type=_count, default=12, metavar="N", help="most grasps to propose (default 12)")
    grasps.add_argument(
        "--friction", type=_positive, default=0.5, metavar="MU", help="friction of object and fingers (default 0.5)"
    )
    grasps.add_argument(
        "--density", type=_positive, default=500.0, metavar="KG/M3", help="of the object, for simulation (default 500)"
    )

    scores = parser.add_argument_group("grasp scores")
    scores.add_argument(
        "--scores", default=SIMULATED, metavar="SOURCE",
        help=f"{SIMULATED} (minutes; resumes after Ctrl-C), {GEOMETRIC} (seconds; a first guess), or a CSV file with "
        f"the counts of your own attempts (default {SIMULATED})",
    )  # fmt: skip
    scores.add_argument(
        "--attempts", type=_count, default=ATTEMPTS, metavar="N",
        help=f"simulated attempts of each grasp at each pose (default {ATTEMPTS})",
    )  # fmt: skip
    scores.add_argument("--processes", type=_count, default=2, metavar="N", help="simulating processes (default 2)")

    places = parser.add_argument_group("lidar and places")
    places.add_argument("--lidar", default="lds-02", metavar="NAME", help="preset of the lidar (default lds-02)")
    places.add_argument(
        "--height", type=_positive, metavar="M",
        help="height of the scan plane over the table (default: where most pairs of poses can be distinguished)",
    )  # fmt: skip
    places.add_argument(
        "--places", metavar="N|FILE",
        help="number of places on a ring, or a file with lines NAME,X,Y,YAW_DEG (default 8)",
    )  # fmt: skip
    places.add_argument(
        "--radius", type=_positive, metavar="M", help="radius of the ring (default 0.45, or more for a large object)"
    )
    places.add_argument(
        "--place", action="append", metavar="NAME,X,Y,YAW_DEG", help="a place of the lidar itself; repeat for more"
    )

    parser.add_argument("--seed", type=_seed, default=0, help="equal seeds give equal files (default 0)")
    parser.add_argument("--url", help="address of a running service (default: start one for the length of the command)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
