"""Places: the sensor configurations around the object, and which of them can measure it."""

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from voa_core.checks import Floats
from voa_msgs.geometry import SensorConfiguration
from voa_msgs.lidars import LidarPreset
from voa_msgs.scenarios import Pose
from voa_setup.errors import InvalidOption
from voa_setup.mesh import SetupMesh
from voa_setup.motions import matrices_of_poses

RADIUS_M = 0.45
"""Radius of the ring of places where none is stated and the object is not too large for it, metres."""
_CLEARANCE_M = 0.05  # of a lidar from the object, where its shortest range is less
_COMPASS = ("E", "ENE", "NE", "NNE", "N", "NNW", "NW", "WNW", "W", "WSW", "SW", "SSW", "S", "SSE", "SE", "ESE")
_DIGITS = 6


def ring(count: int, radius_m: float, centre: tuple[float, float] = (0.0, 0.0)) -> list[SensorConfiguration]:
    """Return places at equal distances on a circle, each with the lidar's beam 0 towards the centre.

    None stands due west, where the arm of the simulated fleet has its base: an even number of places begins half a step
    north of east, an odd one due east. Names are points of the compass, +x east and +y north, or bearings in degrees.

    Args:
        count: number of places.
        radius_m: of the circle, metres.
        centre: of the circle, x and y in metres.
    """
    first = 0.0 if count % 2 else 0.5
    bearings = [360.0 * (index + first) / count for index in range(count)]
    named = all((bearing / 22.5).is_integer() for bearing in bearings)
    places = []
    for bearing in bearings:
        angle = math.radians(bearing)
        places.append(
            SensorConfiguration(
                name=_COMPASS[round(bearing / 22.5)] if named else f"at {bearing:g}",
                x=round(centre[0] + radius_m * math.cos(angle), _DIGITS) + 0.0,
                y=round(centre[1] + radius_m * math.sin(angle), _DIGITS) + 0.0,
                yaw_rad=round(math.remainder(angle + math.pi, 2.0 * math.pi), _DIGITS) + 0.0,
            )
        )
    return places


def listed_places(texts: Sequence[str]) -> list[SensorConfiguration]:
    """Read places from texts "NAME,X,Y,YAW_DEG": metres, and degrees counter-clockwise from the world's +x.

    Raises:
        InvalidOption: a text has another form, or a name occurs twice.
    """
    places = []
    for text in texts:
        parts = [part.strip() for part in text.split(",")]
        try:
            name, x, y, yaw_deg = parts[0], *map(float, parts[1:])
            if not name or not all(map(math.isfinite, (x, y, yaw_deg))):
                raise ValueError(text)
        except ValueError:
            raise InvalidOption(
                f"expected a place as NAME,X,Y,YAW_DEG (metres and degrees), such as E,0.45,0,180, got {text!r}"
            ) from None
        yaw_rad = round(math.radians(yaw_deg), _DIGITS) + 0.0
        places.append(SensorConfiguration(name=name, x=x, y=y, yaw_rad=yaw_rad))
    names = [place.name for place in places]
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        raise InvalidOption(f"expected a different name for each place, got {repeated[0]!r} twice")
    return places


def read_places(file: Path) -> list[SensorConfiguration]:
    """Read places from a file with a line NAME,X,Y,YAW_DEG for each; skips a header, comments (#) and empty lines.

    Raises:
        InvalidOption: the file cannot be read, has no places, or a line has another form.
    """
    try:
        lines = [line.strip() for line in file.read_text(encoding="utf-8").splitlines()]
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidOption(f"{file} cannot be read as a list of places: {error}") from error
    lines = [line for line in lines if line and not line.startswith("#")]
    if lines and re.fullmatch(r"name\s*,\s*x.*", lines[0], re.IGNORECASE):
        lines = lines[1:]
    if not lines:
        raise InvalidOption(f"{file} lists no places; expected lines NAME,X,Y,YAW_DEG")
    return listed_places(lines)


def footprints(mesh: SetupMesh, poses: Sequence[Pose]) -> list[Floats]:
    """Vertices of the mesh at each pose seen from above, (v, 2) metres."""
    return [mesh.mesh.vertices @ transform[:2, :3].T + transform[:2, 3] for transform in matrices_of_poses(poses)]


def fitting_radius(
    wanted: float | None, mesh: SetupMesh, poses: Sequence[Pose], lidar: LidarPreset, centre: tuple[float, float]
) -> float:
    """Return the radius of the ring of places: the wanted one, or a suggestion; metres.

    Raises:
        InvalidOption: on that circle the lidar would stand too near to the object at some pose, or beyond its range.
    """
    reach = max(float(np.hypot(*(points - centre).T).max()) for points in footprints(mesh, poses))
    least = math.ceil(100.0 * (reach + max(lidar.range_min, _CLEARANCE_M))) / 100.0
    most = math.floor(100.0 * (lidar.range_max - reach)) / 100.0
    if wanted is None:
        return max(RADIUS_M, least + 0.01)
    if wanted < least:
        raise InvalidOption(
            f"--radius {wanted:g}: the object reaches {reach:.3f} m from the middle of the places, and {lidar.name} "
            f"measures from {lidar.range_min:g} m on: state --radius {least:g} or more"
        )
    if wanted > most:
        raise InvalidOption(
            f"--radius {wanted:g}: {lidar.name} measures up to {lidar.range_max:g} m: state at most {most:g}"
        )
    return wanted


def check_places(
    places: Sequence[SensorConfiguration], mesh: SetupMesh, poses: Sequence[Pose], lidar: LidarPreset
) -> None:
    """Check that each place stands far enough from the object at every pose; raises InvalidOption."""
    least = max(lidar.range_min, _CLEARANCE_M)
    for pose, points in zip(poses, footprints(mesh, poses), strict=True):
        for place in places:
            nearest = float(np.hypot(points[:, 0] - place.x, points[:, 1] - place.y).min())
            if nearest < least:
                raise InvalidOption(
                    f"place {place.name!r} stands {nearest:.3f} m from the object at pose {pose.name!r}; expected at "
                    f"least {least:g} m for {lidar.name}: move it {least - nearest:.2f} m away"
                )
