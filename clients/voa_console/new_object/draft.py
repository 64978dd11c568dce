"""Draft of a new object: the choices of `voa new`, made on a page, as plain values and pure functions.

The defaults are those of the command, and `command_of` writes the command that gives the files of a draft.
"""

import math
import re
import shlex
from dataclasses import dataclass, replace
from pathlib import Path

from voa_msgs.objects import UpAxis
from voa_setup.previews.messages import MeshMeasure

ENDINGS = ("stl", "obj", "ply", "glb", "off")
"""Types of mesh files that the service reads."""
MOST_BYTES = 20_000_000
"""Largest mesh file, which is also the limit of an upload to the service."""
UNITS = {0.001: "millimetres", 0.01: "centimetres", 0.0254: "inches", 1.0: "metres"}
"""Names of the usual units of mesh files, by their length in metres."""
GRIPPERS = {"2f-85": "Robotiq 2F-85, opens 85 mm", "2fg7": "OnRobot 2FG7, opens 39 mm"}
"""Grippers that are known by name."""
SIMULATED, GEOMETRIC = "simulated", "geometric"
"""Sources of grasp scores."""
_COMPASS = ("E", "ENE", "NE", "NNE", "N", "NNW", "NW", "WNW", "W", "WSW", "SW", "SSW", "S", "SSE", "SE", "ESE")
_DIGITS = 6


@dataclass(frozen=True)
class Draft:
    """Choices about a new object.

    Attributes:
        mesh: path of the mesh file.
        scale: metres per unit of the file.
        up: axis of the file that points up.
        confirmed: True if a person has confirmed size and axis.
        rests: names of the rests to keep; None: all that are probable enough.
        yaws: number of yaws of each rest.
        xy_m, yaw_deg: spread of the object about a pose: standard deviations in metres and degrees.
        places: number of places on a ring.
        radius_m: distance of the places from the middle, metres; None: 0.45, or more for a large object.
        bearings_deg: bearings of the places from the middle, where a person has moved one; None: an even ring.
        height_m: of the scan plane; None: the suggestion.
        lidar: name of a preset.
        gripper: name of a gripper, or the opening of a parallel gripper in metres.
        grasps: most grasps to propose.
        density_kg_m3, friction: of the object.
        scores: source of the grasp scores, `simulated` or `geometric`.
        attempts: simulated attempts of each grasp at each pose.
    """

    mesh: str
    scale: float = 1.0
    up: UpAxis = "+Z"
    confirmed: bool = False
    rests: tuple[str, ...] | None = None
    yaws: int = 8
    xy_m: float = 0.005
    yaw_deg: float = 3.0
    places: int = 8
    radius_m: float | None = None
    bearings_deg: tuple[float, ...] | None = None
    height_m: float | None = None
    lidar: str = "lds-02"
    gripper: str = "2f-85"
    grasps: int = 12
    density_kg_m3: float = 500.0
    friction: float = 0.5
    scores: str = SIMULATED
    attempts: int = 15

    @property
    def name(self) -> str:
        """Name of the object."""
        return Path(self.mesh).stem


def first_draft(mesh: Path, measure: MeshMeasure) -> Draft:
    """Return the draft of a mesh that was just received: the most usual unit in which an arm could grasp it."""
    return Draft(mesh=str(mesh), scale=measure.scales[0] if measure.scales else 1.0, up=measure.up)


def file_name(text: str) -> str:
    """Return a name for a mesh file that a browser sent: of letters, digits, spaces and `_ . -`, without a folder.

    Raises:
        ValueError: the name does not end with the type of a mesh; the message says which do.
    """
    name = re.sub(r"[^A-Za-z0-9 _.-]", "_", re.split(r"[/\\]", text)[-1]).strip(" .")
    stem, _, ending = name.rpartition(".")
    if ending.lower() not in ENDINGS:
        raise ValueError(f"{text} is no mesh file: expected a name that ends with {', '.join(ENDINGS)}.")
    stem = stem.strip(" .-")[:60] or "object"
    return f"{stem}.{ending.lower()}"


def size_cm(measure: MeshMeasure, scale: float, up: UpAxis) -> tuple[float, float, float]:
    """Return width, depth and height of the object in centimetres, under a unit and an axis that points up."""
    x, y, z = (100.0 * scale * extent for extent in measure.extents)
    return (x, z, y) if up == "+Y" else (x, y, z)


def describe_size(measure: MeshMeasure, scale: float, up: UpAxis) -> str:
    """Describe the size of the object in centimetres, and say where no arm could grasp it."""
    width, depth, height = size_cm(measure, scale, up)
    text = f"{width:.3g} cm wide, {depth:.3g} cm deep, {height:.3g} cm high"
    largest = max(width, depth, height)
    if largest > 60.0:
        return f"{text}. That is too large for an arm (1 to 60 cm): choose another unit."
    if largest < 1.0:
        return f"{text}. That is too small for an arm (1 to 60 cm): choose another unit."
    return f"{text}."


def ring_bearings(count: int) -> tuple[float, ...]:
    """Return the bearings of an even ring of places, degrees counter-clockwise from +x; none stands due west."""
    first = 0.0 if count % 2 else 0.5
    return tuple(360.0 * (index + first) / count for index in range(count))


def bearings_of(draft: Draft) -> tuple[float, ...]:
    """Return the bearings of the places, degrees."""
    return ring_bearings(draft.places) if draft.bearings_deg is None else draft.bearings_deg


def with_bearing(draft: Draft, index: int, bearing_deg: float, radius_m: float) -> Draft:
    """Move a place along the circle, to a whole degree at which no other place stands.

    Args:
        draft: before the move.
        index: of the place.
        bearing_deg: to which it is moved.
        radius_m: of the circle, which the draft keeps from now on.
    """
    bearings = list(bearings_of(draft))
    others = {round(each, 6) for number, each in enumerate(bearings) if number != index}
    wanted = round(bearing_deg) % 360
    free = min(
        (each for each in range(360) if float(each) not in others),
        key=lambda each: min((each - wanted) % 360, (wanted - each) % 360),
    )
    bearings[index] = float(free)
    return replace(draft, bearings_deg=tuple(bearings), radius_m=round(radius_m, 3))


def listed_places(draft: Draft) -> list[str]:
    """Write the places that were moved as `NAME,X,Y,YAW_DEG`, each with the lidar's beam 0 towards the middle.

    Raises:
        ValueError: no place was moved, or the radius is not known.
    """
    if draft.bearings_deg is None or draft.radius_m is None:
        raise ValueError("expected places that were moved, and their distance from the middle")
    texts = []
    for bearing in draft.bearings_deg:
        angle = math.radians(bearing)
        x, y = (round(draft.radius_m * part, _DIGITS) + 0.0 for part in (math.cos(angle), math.sin(angle)))
        yaw = round(math.remainder(bearing + 180.0, 360.0), _DIGITS) + 0.0
        texts.append(f"{place_name(bearing)},{x:.9g},{y:.9g},{yaw:.9g}")
    return texts


def place_name(bearing_deg: float) -> str:
    """Name a place by a point of the compass, +x east and +y north, or by its bearing in degrees."""
    steps = bearing_deg / 22.5
    return _COMPASS[round(steps) % 16] if float(steps).is_integer() else f"at {bearing_deg:g}"


def problems_of(draft: Draft) -> list[str]:
    """Say which choices are out of their limits, a sentence each; empty: all can be used."""
    limits: list[tuple[str, float | None, float, float]] = [
        ("The scale", draft.scale, 1e-6, 1e3),
        ("The number of yaws", draft.yaws, 1, 360),
        ("The number of places", draft.places, 1, 64),
        ("The radius of the circle (m)", draft.radius_m, 0.01, 100.0),
        ("The height of the scan plane (m)", draft.height_m, 0.0005, 10.0),
        ("The number of grasps", draft.grasps, 1, 200),
        ("The number of attempts", draft.attempts, 1, 10_000),
        ("The density (kg/m³)", draft.density_kg_m3, 1.0, 30_000.0),
        ("The friction", draft.friction, 0.01, 10.0),
        ("The spread in the plane (m)", draft.xy_m, 0.0, 1.0),
        ("The spread of the yaw (degrees)", draft.yaw_deg, 0.0, 180.0),
    ]
    sentences = [
        f"{what} must lie between {low:g} and {high:g}, got {value:g}."
        for what, value, low, high in limits
        if value is not None and not low <= value <= high
    ]
    if draft.rests == ():
        sentences.append("Tick at least one rest.")
    return sentences + _gripper_problems(draft.gripper)


def _gripper_problems(gripper: str) -> list[str]:
    if gripper in GRIPPERS:
        return []
    try:
        is_usable = 0.0 < float(gripper) <= 0.2
    except ValueError:
        is_usable = False
    return [] if is_usable else ["The opening of the gripper must lie between 0 and 200 mm."]


def command_of(draft: Draft, folder: str) -> str:
    """Write the command `voa new` that gives the files of a draft, beside its mesh file; defaults are left out."""
    plain = Draft(mesh=draft.mesh)
    words = ["voa", "new", Path(draft.mesh).name, "-o", folder, "--scale", f"{draft.scale:g}", "--up", draft.up]
    words += _option("--rests", *draft.rests) if draft.rests is not None else []
    words += _option("--yaws", f"{draft.yaws}") if draft.yaws != plain.yaws else []
    if (draft.xy_m, draft.yaw_deg) != (plain.xy_m, plain.yaw_deg):
        words += _option("--spread", f"{draft.xy_m:g},{draft.yaw_deg:g}")
    if draft.bearings_deg is not None:
        words += [word for text in listed_places(draft) for word in ("--place", text)]
    else:
        words += _option("--places", f"{draft.places}") if draft.places != plain.places else []
        words += _option("--radius", f"{draft.radius_m:g}") if draft.radius_m is not None else []
    words += _option("--height", f"{draft.height_m:g}") if draft.height_m is not None else []
    numbers = {
        "--lidar": (draft.lidar, plain.lidar),
        "--gripper": (draft.gripper, plain.gripper),
        "--grasps": (draft.grasps, plain.grasps),
        "--density": (draft.density_kg_m3, plain.density_kg_m3),
        "--friction": (draft.friction, plain.friction),
        "--scores": (draft.scores, plain.scores),
    }
    for option, (value, default) in numbers.items():
        words += _option(option, value if isinstance(value, str) else f"{value:g}") if value != default else []
    if draft.scores == SIMULATED and draft.attempts != plain.attempts:
        words += _option("--attempts", f"{draft.attempts}")
    return shlex.join(words)


def _option(name: str, *values: str) -> list[str]:
    return [name, *values]


def attempts_in_all(draft: Draft, poses: int) -> int:
    """Return the number of simulated attempts, at most: each grasp at each pose."""
    return poses * draft.grasps * draft.attempts if draft.scores == SIMULATED else 0
