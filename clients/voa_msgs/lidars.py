"""Lidars: presets, and what a scenario says of its own."""

from typing import Annotated, Literal

from annotated_types import Ge, Lt

from voa_msgs.base import Message, Name, NotNegative, Positive, Real
from voa_msgs.bounds import LimitedBy

Zero = Literal["missing", "no_return"]
Beams = Annotated[int, Ge(1), LimitedBy("beams")]
Share = Annotated[float, Ge(0.0), Lt(1.0)]


class Lidar(Message):
    """A planar lidar: a preset, any of whose fields may be overridden, or (preset null) all of its fields."""

    preset: Name | None = None
    beams: Beams | None = None
    angle_min: Real | None = None
    """Angle of the first beam, radians, counter-clockwise from the sensor's +x."""
    angle_increment: Real | None = None
    """Between neighbouring beams, radians; negative for a lidar that turns clockwise."""
    range_min: NotNegative | None = None
    """Metres; a shorter measurement is missing."""
    range_max: Positive | None = None
    """Metres; beyond it there is no return."""
    height_m: Real | None = None
    """Height of the scan plane over the table; null where every sensor configuration has its own."""
    zero: Zero | None = None
    """What a measured range of exactly 0 means."""
    noise_m: Positive | None = None
    """Standard deviation of a range close by, metres."""
    noise_ratio: NotNegative | None = None
    """Standard deviation of a range far away, as a share of it."""
    dropout: Share | None = None
    """Share of beams that come back empty from a surface in range."""


class LidarPreset(Message):
    """A lidar that the service knows by name."""

    name: str
    title: str
    beams: int
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    zero: Zero
    noise_m: float
    noise_ratio: float
    dropout: float
    source: str
    """Where the figures come from."""


class LidarPresets(Message):
    """All presets."""

    items: list[LidarPreset]
