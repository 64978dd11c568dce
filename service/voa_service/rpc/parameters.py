"""Parameters of remote calls that HTTP has in the path or the query of a request."""

from typing import Annotated

from annotated_types import Ge, Gt, Le

from voa_msgs.base import Id, Message, Name
from voa_msgs.bounds import LimitedBy
from voa_msgs.objects import MeshType, Sha256, UpAxis

_PAGE = 100


class Page(Message):
    """Parameters of a list: at most `limit` items, after the item that `after` names."""

    limit: Annotated[int, Ge(1), Le(1000)] = _PAGE
    after: str | None = None


class ObjectPage(Page):
    """Parameters of the list of objects; with `sha256` only the object that this file became, if it was uploaded."""

    sha256: Sha256 | None = None
    type: MeshType | None = None
    scale: Annotated[float, Gt(0.0)] | None = None
    up: UpAxis | None = None


class Identified(Message):
    """Id of the object or scenario that a call concerns."""

    id: Id


class InSession(Message):
    """Id of the session that a call concerns."""

    session: Id


class Announced(Message):
    """Id of the announced look that a call concerns."""

    look: Id


class Reachable(Message):
    """Names of the grasps that the arm can reach at the moment; None: all of the scenario."""

    grasps: Annotated[list[Name], LimitedBy("grasps")] | None = None


class NoParameters(Message):
    """An empty payload, and an empty response."""
