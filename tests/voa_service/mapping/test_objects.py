"""Objects as messages: size, faces and warnings; and the poses in which one can rest."""

from datetime import UTC, datetime

import numpy as np
import pytest

from tests.voa_core.worlds import BOX_FACES
from voa_core.objects import Object
from voa_service.failures import InvalidMesh
from voa_service.mapping.objects import object_message, stable_poses_message
from voa_store.records import StoredObject

NOON = datetime(2026, 1, 2, 12, tzinfo=UTC)


def box(x: float, y: float, z: float) -> Object:
    corners = [((i - 0.5) * x, (j - 0.5) * y, k * z) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    return Object.from_arrays(corners, [list(face) for face in BOX_FACES])


def stored(mesh: Object) -> StoredObject:
    return StoredObject(mesh, "box", NOON, "+Z")


def test_an_object_has_its_digest_size_and_faces() -> None:
    mesh = box(0.04, 0.06, 0.05)
    message = object_message(stored(mesh))
    assert (message.id, message.name, message.faces, message.up) == (mesh.digest, "box", 12, "+Z")
    assert message.extents == pytest.approx([0.04, 0.06, 0.05])
    assert (message.watertight, message.warnings, message.created_at) == (True, [], NOON)


def test_an_object_of_forty_metres_is_warned_about() -> None:
    (warning,) = object_message(stored(box(40.0, 60.0, 50.0))).warnings
    assert warning.kind == "extent"


def test_a_box_rests_on_each_of_its_faces_and_most_probably_on_a_large_one() -> None:
    poses = stable_poses_message(box(0.04, 0.06, 0.05)).items
    assert len(poses) == 6
    assert sum(pose.probability for pose in poses) == pytest.approx(1.0)
    assert poses[0].position[2] == pytest.approx(0.02), "it lies 0.04 m thick, its origin in the middle of a side"
    assert [np.linalg.norm(pose.quaternion_wxyz) for pose in poses] == pytest.approx([1.0] * 6)


def test_a_sheet_without_a_volume_cannot_rest() -> None:
    with pytest.raises(InvalidMesh, match="expected a mesh with a volume"):
        stable_poses_message(box(0.04, 0.06, 0.0))
