"""Priors: the belief before the first observation."""

from typing import Annotated, Any, Literal

from annotated_types import Len
from pydantic import Discriminator, Tag

from voa_msgs.base import Distribution, Message, Name, NotNegative, Point2, Real
from voa_msgs.bounds import LimitedBy, OneMistake


class PoseCategory(Message):
    """Category of poses that rest on the same side: they differ by a yaw and a shift in the plane of the table."""

    pose: Name
    """Name of a pose of the category; yaws are measured from it."""
    probability: NotNegative
    """Probability of the category; those of all categories sum to 1."""
    yaw_mean_rad: Real = 0.0
    """Mean of the von Mises distribution of the yaw, radians from that of `pose`."""
    yaw_concentration: NotNegative = 0.0
    """Concentration of the von Mises distribution of the yaw; 0: all yaws are equally probable."""
    mean_xy: Point2 | None = None
    """Mean x, y of the Gaussian over positions, metres; null: all positions are equally probable."""
    covariance_xy: Annotated[list[Point2], OneMistake(), Len(2, 2)] | None = None
    """Covariance matrix of x and y, m^2; required where `mean_xy` is given."""


class PoseModelPrior(Message):
    """Prior computed from the coordinates of the poses: P(category) x von Mises(yaw) x Gaussian(x, y)."""

    form: Literal["pose_model"]
    """Always `pose_model`."""
    categories: Annotated[list[PoseCategory], Len(1), LimitedBy("poses")]
    """Categories, such that each pose of the scenario belongs to exactly one."""


def _form(prior: Any) -> str:
    return "probabilities" if isinstance(prior, list) else "pose_model"


Prior = Annotated[
    Annotated[Distribution, Tag("probabilities")] | Annotated[PoseModelPrior, Tag("pose_model")],
    Discriminator(_form),
]
