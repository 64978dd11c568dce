"""What is believed before the first look."""

from typing import Annotated, Any, Literal

from annotated_types import Len
from pydantic import Discriminator, Tag

from voa_msgs.base import Distribution, Message, Name, NotNegative, Point2, Real
from voa_msgs.bounds import LimitedBy, OneMistake


class PoseCategory(Message):
    """All poses that rest like the named one: it, turned about the vertical and shifted in the plane."""

    pose: Name
    """A pose of the category; yaws are counted from it."""
    probability: NotNegative
    yaw_mean_rad: Real = 0.0
    yaw_concentration: NotNegative = 0.0
    """Of the von Mises distribution; 0: any yaw is as probable."""
    mean_xy: Point2 | None = None
    """Mean of the Gaussian over positions, metres; null: any position is as probable."""
    covariance_xy: Annotated[list[Point2], OneMistake(), Len(2, 2)] | None = None
    """Its covariance, m^2; given with `mean_xy`."""


class PoseModelPrior(Message):
    """P(category) x von Mises(yaw) x Gaussian(x, y), over the poses' own coordinates."""

    form: Literal["pose_model"]
    categories: Annotated[list[PoseCategory], Len(1), LimitedBy("poses")]


def _form(prior: Any) -> str:
    return "probabilities" if isinstance(prior, list) else "pose_model"


Prior = Annotated[
    Annotated[Distribution, Tag("probabilities")] | Annotated[PoseModelPrior, Tag("pose_model")],
    Discriminator(_form),
]
