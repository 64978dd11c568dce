"""Parameters of remote calls that HTTP has in the path or the query of a request."""

from typing import Annotated

from annotated_types import Ge, Gt, Le

from voa_msgs.base import Id, Message, Name
from voa_msgs.bounds import LimitedBy
from voa_msgs.objects import LEAST_FACES, MeshType, Sha256, UpAxis

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


class HistoryPage(Page):
    """Parameters of a history; with `beliefs`, each version has its belief and best grasp, too."""

    beliefs: bool = False


class Thinning(Message):
    """Parameters of the mesh of an object; with `most_faces`, it has about so many triangles at most."""

    most_faces: Annotated[int, Ge(LEAST_FACES)] | None = None


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
