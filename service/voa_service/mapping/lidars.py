"""Lidars: from messages and presets to the lidar of the mathematics."""

from collections.abc import Mapping

from voa_core.errors import InvalidInput, UnknownName
from voa_core.lidars import BeamGrid, LidarModel
from voa_msgs import lidars
from voa_ros import grids

_REQUIRED_FIELDS = ("beams", "angle_min", "angle_increment", "range_min", "range_max", "zero")
_DEFAULT_NOISE = {"noise_m": 0.01, "noise_ratio": 0.02, "dropout": 0.05}


def filled_lidar(lidar: lidars.Lidar, presets: Mapping[str, lidars.LidarPreset]) -> lidars.Lidar:
    """Return a lidar message with every field written out: its own, its preset's, else defaults.

    Raises:
        UnknownName: there is no such preset.
        InvalidInput: the lidar names no preset, and lacks fields.
    """
    if lidar.preset is None:
        absent = [name for name in _REQUIRED_FIELDS if getattr(lidar, name) is None]
        if absent:
            raise InvalidInput(
                "lidar", f"a preset ({', '.join(sorted(presets))}) or all of its fields", f"no {', '.join(absent)}"
            )
        base = dict(_DEFAULT_NOISE)
    elif lidar.preset not in presets:
        raise UnknownName("lidar preset", lidar.preset, sorted(presets))
    else:
        base = presets[lidar.preset].model_dump(exclude={"name", "title", "source"})
    own = {name: value for name, value in lidar.model_dump().items() if value is not None}
    return lidars.Lidar.model_validate(base | own)


def lidar_model(lidar: lidars.Lidar) -> LidarModel:
    """Build the lidar of the mathematics from a filled-in message.

    Raises:
        VoaError: its values contradict each other.
    """
    values = lidar.model_dump(exclude={"preset"})
    grid = BeamGrid(values.pop("beams"), values.pop("angle_min"), values.pop("angle_increment"))
    return LidarModel(grid=grid, **values)


def beam_grid(lidar: LidarModel) -> grids.BeamGrid:
    """Return the beams of a lidar, as looks of ROS 2 robots are gathered on them."""
    return grids.BeamGrid(lidar.grid.beams, lidar.grid.angle_min, lidar.grid.angle_increment)
