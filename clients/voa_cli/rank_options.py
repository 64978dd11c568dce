"""Options of `voa rank`: parsing, checks, and the request that they describe."""

import argparse
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from voa_cli.picture_option import add_picture_option
from voa_msgs.rankings import MOST_SAMPLES, VoaRequest


def read_options(description: str | None, arguments: Sequence[str] | None) -> argparse.Namespace:
    """Parse and check the command line; exits with code 2 and a message where options contradict each other."""
    parser = _parser(description)
    options = parser.parse_args(arguments)
    options.local = options.local or options.cluster is not None or options.resume is not None
    if (options.scenario is None) == (options.session is None):
        parser.error("expected either a scenario file or --session ID")
    if options.session is not None and options.url is None:
        parser.error("--session needs --url, the address of the service that has the session")
    if options.session is not None and options.belief is not None:
        parser.error("--belief can be used with a scenario file only: a session has its own belief")
    if options.local and (options.session is not None or options.url is not None):
        parser.error("--local ranks a scenario file on this machine: it takes neither --session nor --url")
    if options.local and options.picture is not None:
        parser.error("--picture needs a service, which predicts what the lidar would see: leave --local out")
    if options.cost_per_m is not None and options.departure is None:
        parser.error("--cost-per-m needs --from, the place where the drive starts")
    return options


def request_of(options: argparse.Namespace) -> VoaRequest:
    """Make the request that the options describe, without the fields for which the service has defaults.

    Raises:
        ValidationError: a value of an option is not valid.
    """
    given: dict[str, Any] = {
        "grasps": options.grasps,
        "scans": options.scans,
        "samples": options.samples,
        "method": options.method,
        "definition": options.definition,
        "lookahead": options.lookahead,
        "sensor_std": options.sensor_std,
        "from": options.departure,
        "cost_per_m": options.cost_per_m,
        "pending": options.pending,
    }
    return VoaRequest.model_validate({name: value for name, value in given.items() if value is not None})


def process_options(options: argparse.Namespace) -> list[str]:
    """Return the options of the process that ranks on this machine or on a cluster."""
    given = {"--cluster": options.cluster, "--resume": options.resume}
    return [part for name, value in given.items() if value is not None for part in (name, str(value))]


def _number(text: str, least: float = -math.inf) -> float:
    """Read a finite number of at least `least`; raises ValueError."""
    number = float(text)
    if not (math.isfinite(number) and number >= least):
        raise ValueError(text)
    return number


def _cost(text: str) -> float:
    """Read a cost of at least 0; raises ArgumentTypeError."""
    try:
        return _number(text, 0.0)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"expected a number of at least 0, got {text!r}") from error


def _samples(text: str) -> int:
    """Read a number of simulated scans; raises ArgumentTypeError."""
    if not text.isdecimal() or not 1 <= int(text) <= MOST_SAMPLES:
        raise argparse.ArgumentTypeError(f"expected a whole number from 1 to {MOST_SAMPLES}, got {text!r}")
    return int(text)


def _uncertainty(text: str) -> dict[str, float]:
    """Read "0.01,1", metres and degrees, as standard deviations of a sensor pose; raises ArgumentTypeError."""
    try:
        xy_m, yaw_deg = (_number(part, 0.0) for part in text.split(","))
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"expected metres and degrees, as in 0.01,1, got {text!r}") from error
    return {"xy_m": xy_m, "yaw_rad": math.radians(yaw_deg)}


def _departure(text: str) -> str | dict[str, float]:
    """Read "0.5,-0.2" as a point in metres, and any other text as the name of a sensor configuration."""
    try:
        x, y = (_number(part) for part in text.split(","))
    except ValueError:
        return text
    return {"x": x, "y": y}


def _parser(description: str | None) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa rank", description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "scenario",
        type=Path,
        nargs="?",
        help="scenario file, or a folder with scenario.json; its `object` may name a mesh file in its folder, read "
        "with `scale` and `up`",
    )
    parser.add_argument("--session", help="id of a session, instead of a scenario file")
    parser.add_argument(
        "--belief", help="a probability for each pose, or a JSON file with them (default: the scenario's prior)"
    )
    parser.add_argument("--grasps", nargs="+", help="names of the grasps that the arm can reach (default: all)")
    value = parser.add_argument_group("value of a look")
    value.add_argument(
        "--scans",
        choices=["exact", "simulated"],
        help="predicted scans: one exact scan of each pose, or noisy scans of displaced poses (default: simulated "
        "where the scenario has a spread, or the sensor pose a standard deviation)",
    )
    value.add_argument(
        "--samples", type=_samples, help="simulated scans of each pose (default: 256 of all poses together)"
    )
    value.add_argument(
        "--method",
        choices=["exact", "sampled"],
        help="take expectations over all poses, or over samples of them (default: exact, and sampled where places and "
        "poses are very many)",
    )
    value.add_argument(
        "--definition",
        choices=["posterior", "executed"],
        help="definition of VOA (default: posterior over exact scans, executed over simulated ones)",
    )
    value.add_argument(
        "--sensor-std",
        type=_uncertainty,
        metavar="XY_M,YAW_DEG",
        help="standard deviations of the poses at which the robot arrives, metres and degrees (default: those of the "
        "session's last sensor pose)",
    )
    plan = parser.add_argument_group("plan and costs")
    plan.add_argument(
        "--lookahead",
        type=int,
        choices=[1, 2],
        help="looks that the recommendation plans: 2 (default) recommends a pair where no single look pays",
    )
    plan.add_argument(
        "--from",
        dest="departure",
        type=_departure,
        metavar="PLACE",
        help="sensor configuration, or X,Y in metres, from which the robot drives; a negative X needs --from=-0.2,0.1",
    )
    plan.add_argument(
        "--cost-per-m", type=_cost, help="cost of driving one metre, in success probability; needs --from"
    )
    plan.add_argument(
        "--pending",
        nargs="+",
        metavar="SENSOR",
        help="looks under way, whose scans are not known yet (default: those announced in the session)",
    )
    parser.add_argument("--url", help="address of a running service (default: start one for the length of the command)")
    parser.add_argument(
        "--local",
        action="store_true",
        help="rank in a process of this command, without the limits of a service on sizes, and show the progress",
    )
    parser.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="rank as with --local, on the workers of a scheduler of dask.distributed (tcp://HOST:8786), or on local:N "
        "processes of this machine",
    )
    parser.add_argument(
        "--resume",
        type=Path,
        metavar="DIR",
        help="rank as with --local, and keep finished parts in a folder of yours, from which the command goes on when "
        "it is repeated",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    add_picture_option(parser, "the object, the places and their VOA")
    return parser
