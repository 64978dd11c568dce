"""Messages of the previews: plain values that pass from the process that computes them to a page that shows them."""

from voa_msgs.base import Message
from voa_msgs.objects import UpAxis


class MeshMeasure(Message):
    """Size of a mesh file before its unit is known."""

    name: str
    """Name of the object: the file's name without its ending."""
    faces: int
    """Number of triangles."""
    extents: tuple[float, float, float]
    """Size along the file's own x, y and z, in the unit of the file."""
    up: UpAxis
    """Axis of the file that points up, unless a person states another."""
    scales: list[float]
    """Metres per unit under which an arm could grasp the object, the most usual first; may be empty."""


class RestPreview(Message):
    """A way of the object to rest on the table."""

    name: str
    """Name of the rest."""
    probability: float
    """Probability that the object, dropped at random, rests this way."""
    likely: bool
    """True if a scenario keeps the rest unless a person decides otherwise."""
    alike: int
    """Number of rests that look the same, for which it stands."""
    picture: str | None
    """Name of the file with the pictures of a turn, beside one another; null: none was drawn."""
    side: str | None
    """Name of the file with a picture from the front, at yaw 0; null: none was drawn."""
    side_m: tuple[float, float, float, float]
    """Left, right, lower and upper edge of that picture: x, and height over the table, metres."""


class RestsPreview(Message):
    """Rests of a mesh in metres."""

    size_m: tuple[float, float, float]
    """Size along x, y and z (up), metres."""
    watertight: bool
    """True if the faces enclose a volume without holes."""
    notes: list[str]
    """Sentences about what was changed or guessed."""
    rests: list[RestPreview]
    """The most probable first."""


class PlannedRest(Message):
    """Rest that the scenario keeps."""

    name: str
    """Name of the rest."""
    poses: list[str]
    """Names of its poses."""
    share: float
    """Probability of its poses before the first look; the shares of all rests sum to 1."""


class PlannedPlace(Message):
    """Place of the lidar."""

    name: str
    """Name of the place."""
    x: float
    """Position along x, metres."""
    y: float
    """Position along y, metres."""
    yaw_rad: float
    """Direction of the lidar's beam 0, radians."""


class PlaneSight(Message):
    """Sight of the object by the lidar at one height of its scan plane."""

    height_m: float
    """Height over the table, metres."""
    seen: float
    """Share of the poses, weighted by the prior, that some place sees."""
    pairs: float
    """Share of the pairs of poses that the scans of some place distinguish."""
    unseen: list[str]
    """Names of the poses that no place sees."""


class Plan(Message):
    """Poses, places and scan planes of a scenario under the choices so far."""

    rests: list[PlannedRest]
    """Rests that are kept, with their poses."""
    notes: list[str]
    """Sentences about poses that were merged and rests that were left out."""
    problem: str | None
    """Sentence that says which choice cannot be used, and what would work; null: all can."""
    places: list[PlannedPlace]
    """Places of the lidar; empty where they cannot be used."""
    planes: list[PlaneSight]
    """Sight at each height from the table to the top of the object; empty where the places cannot be used."""
    suggested: PlaneSight | None
    """Height at which most pairs of poses can be distinguished; null: no height sees the object."""
    chosen: PlaneSight | None
    """Sight at the chosen height, or at the suggestion where none was chosen."""
    warnings: list[str]
    """Probable mistakes, a sentence each, as the service reports them for the finished scenario."""


class RestOutline(Message):
    """Outline of the object in the scan plane, at one rest and yaw 0, seen from above."""

    rest: str
    """Name of the rest."""
    path: str
    """Path of SVG in millimetres, x to the right and y up; empty where the plane misses the object."""
    shadow: str
    """Path of SVG around the object seen from above, in millimetres."""


class Outlines(Message):
    """Outlines of the kept rests at one height of the scan plane."""

    height_m: float
    """Height of the scan plane over the table, metres."""
    rests: list[RestOutline]
    """Outline at each rest that is kept."""
