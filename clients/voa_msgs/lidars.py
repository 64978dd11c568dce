"""Lidars: the presets of the service, and the lidar of a scenario."""

from typing import Annotated, Literal

from annotated_types import Ge, Lt

from voa_msgs.base import Message, Name, NotNegative, Positive, Real
from voa_msgs.bounds import LimitedBy

Zero = Literal["missing", "no_return"]
"""Meaning of a measured range of exactly 0: the beam is missing, or nothing is in range."""
Beams = Annotated[int, Ge(1), LimitedBy("beams")]
"""Number of beams of one revolution."""
Share = Annotated[float, Ge(0.0), Lt(1.0)]
"""Share from 0 to below 1."""


class Lidar(Message):
    """Planar lidar of a scenario: a preset, of which each field may be overridden, or all fields without a preset."""

    preset: Name | None = None
    """Name of a preset of `GET /v1/lidars`; null: every other field but `height_m` is required."""
    beams: Beams | None = None
    """Number of beams of one revolution; null: the preset's."""
    angle_min: Real | None = None
    """Angle of the first beam, radians, counter-clockwise from the sensor's +x; null: the preset's."""
    angle_increment: Real | None = None
    """Angle between neighbouring beams, radians; negative for a lidar that turns clockwise; null: the preset's."""
    range_min: NotNegative | None = None
    """Shortest range, metres: a beam with a shorter measurement is missing; null: the preset's."""
    range_max: Positive | None = None
    """Longest range, metres: a beam with a longer measurement is a no-return; null: the preset's."""
    height_m: Real | None = None
    """Height of the scan plane above the table, metres; null: each sensor configuration states its own."""
    zero: Zero | None = None
    """Meaning of a measured range of exactly 0: the beam is missing, or a no-return; null: the preset's."""
    noise_m: Positive | None = None
    """Standard deviation of a short range, metres; null: the preset's."""
    noise_ratio: NotNegative | None = None
    """Standard deviation of a long range, as a share of that range; null: the preset's."""
    dropout: Share | None = None
    """Share of beams, 0 to 1, that do not return from a surface within range; null: the preset's."""


class LidarPreset(Message):
    """Lidar that the service knows by name."""

    name: str
    """Name of the preset, for `lidar.preset` of a scenario."""
    title: str
    """Name of the product, for people."""
    beams: int
    """Number of beams of one revolution."""
    angle_min: float
    """Angle of the first beam, radians, counter-clockwise from the sensor's +x."""
    angle_increment: float
    """Angle between neighbouring beams, radians; negative for a lidar that turns clockwise."""
    range_min: float
    """Shortest range, metres: a beam with a shorter measurement is missing."""
    range_max: float
    """Longest range, metres: a beam with a longer measurement is a no-return."""
    zero: Zero
    """Meaning of a measured range of exactly 0: the beam is missing, or a no-return."""
    noise_m: float
    """Standard deviation of a short range, metres."""
    noise_ratio: float
    """Standard deviation of a long range, as a share of that range."""
    dropout: float
    """Share of beams, 0 to 1, that do not return from a surface within range."""
    source: str
    """Source of these figures, such as a data sheet."""


class LidarPresets(Message):
    """List of all presets of lidars."""

    items: list[LidarPreset]
    """Presets that `lidar.preset` of a scenario can name."""
