"""Objects: from meshes to messages."""

import numpy as np

from voa_core.errors import VoaError
from voa_core.objects import Object
from voa_core.stable_poses import propose_stable_poses
from voa_meshes import thinned, write_stl
from voa_msgs import objects
from voa_service.failures import InvalidMesh
from voa_service.meshes.mistakes import extent_mistakes
from voa_store.records import ListedObject, StoredObject


def object_message(stored: StoredObject) -> objects.Object:
    """Convert a stored mesh to a message."""
    mesh: Object = stored.object
    x, y, z = mesh.extents.tolist()
    return listed_object_message(
        ListedObject(
            mesh.digest, stored.name, (x, y, z), len(mesh.faces), mesh.watertight, stored.up, stored.created_at
        )
    )


def listed_object_message(stored: ListedObject) -> objects.Object:
    """Convert a mesh in a list to a message."""
    return objects.Object(
        id=stored.id,
        name=stored.name,
        extents=list(stored.extents),
        faces=stored.faces,
        watertight=stored.watertight,
        up=stored.up,
        warnings=extent_mistakes(stored.extents),
        created_at=stored.created_at,
    )


def mesh_file(mesh: Object, most_faces: int | None) -> objects.MeshFile:
    """Write a mesh as an STL file in a message.

    Args:
        mesh: the object.
        most_faces: bound on the triangles, to which the mesh is thinned; None: every triangle.
    """
    vertices, faces = mesh.vertices, mesh.faces.astype(np.int64)
    if most_faces is not None:
        vertices, faces = thinned(vertices, faces, most_faces)
    content = write_stl(vertices, faces)  # validation would take it for base64
    return objects.MeshFile.model_construct(id=mesh.digest, type="stl", faces=len(faces), file=content)


def stable_poses_message(mesh: Object) -> objects.StablePoses:
    """Compute the poses in which a mesh can rest on the table, with their probabilities, as a message.

    Raises:
        InvalidMesh: the mesh cannot rest, because it has no volume for example.
    """
    try:
        proposed = propose_stable_poses(mesh)
    except VoaError as error:
        raise InvalidMesh(str(error)) from error
    return objects.StablePoses(
        items=[
            objects.StablePose(
                position=list(pose.position),
                quaternion_wxyz=list(pose.quaternion_wxyz),
                probability=pose.probability,
            )
            for pose in proposed
        ]
    )
