"""Scenes of shapes as `foxglove_msgs/msg/SceneUpdate`: an entity for each group of shapes, which can be hidden alone.

Each message is a whole scene, since a viewer that jumps in time shows the last message before that time alone. An
entity replaces its predecessor, so that a group without shapes is written as an entity without primitives.
"""

from collections.abc import Mapping, Sequence
from typing import Any, get_args

import numpy as np
from rosbags.typesys.store import Typestore

from voa_recordings.files.foxglove_types import PACKAGE, SCENE
from voa_recordings.scenes.model_file import MEDIA_TYPE, IndexedMesh, model_of
from voa_ros.messages import NANOSECONDS
from voa_scene.shapes import (
    IDENTITY,
    AnyShape,
    Ball,
    Box,
    Colour,
    Cylinder,
    Group,
    MeshShape,
    Points,
    Polyline,
    Quaternion,
    Scene,
    Shape,
    Text,
    Vector,
)

WORLD = "world"
"""Name of the world frame in recordings."""
_LINE_OF_CAPITAL = 1.4
"""Height of a line of text, in heights of a capital letter."""
_ORIGIN: Vector = (0.0, 0.0, 0.0)
_WHITE = Colour(1.0, 1.0, 1.0)


class SceneMessages:
    """Writer of scenes as ROS 2 messages.

    Args:
        store: with the types of Foxglove.
    """

    def __init__(self, store: Typestore) -> None:
        self._store = store

    def scene(self, scene: Scene, meshes: Mapping[str, IndexedMesh], at_ns: int) -> bytes:
        """Write a scene as a `foxglove_msgs/msg/SceneUpdate` in CDR.

        Args:
            scene: to write.
            meshes: by the identifier of the object; shapes of an object that is not in it are left out.
            at_ns: time of the scene, nanoseconds since 1970.
        """
        entities = [self._entity(group, scene.of(group), meshes, at_ns) for group in get_args(Group)]
        message = self._of("SceneUpdate", deletions=[], entities=entities)
        return bytes(self._store.serialize_cdr(message, SCENE))

    def _entity(self, group: str, shapes: Sequence[AnyShape], meshes: Mapping[str, IndexedMesh], at_ns: int) -> Any:
        labels = [self._of("KeyValuePair", key=shape.name, value=shape.label) for shape in shapes if shape.label]
        boxes = [self._cube(shape, shape.position, shape.size) for shape in shapes if isinstance(shape, Box)]
        return self._of(
            "SceneEntity",
            timestamp=self._time("Time", at_ns),
            frame_id=WORLD,
            id=group,
            lifetime=self._time("Duration", 0),
            frame_locked=True,
            metadata=labels,
            arrows=[],
            cubes=boxes + [dot for shape in shapes if isinstance(shape, Points) for dot in self._dots(shape)],
            spheres=[self._sphere(shape) for shape in shapes if isinstance(shape, Ball)],
            cylinders=[self._cylinder(shape) for shape in shapes if isinstance(shape, Cylinder)],
            lines=[self._line(shape) for shape in shapes if isinstance(shape, Polyline)],
            triangles=[],
            texts=[self._text(shape) for shape in shapes if isinstance(shape, Text)],
            models=self._models([shape for shape in shapes if isinstance(shape, MeshShape)], meshes),
        )

    def _models(self, copies: Sequence[MeshShape], meshes: Mapping[str, IndexedMesh]) -> list[Any]:
        """Make one model for each object, whatever the number of its copies."""
        return [
            self._of(
                "ModelPrimitive",
                pose=self._pose(_ORIGIN, IDENTITY),
                scale=self._vector((1.0, 1.0, 1.0)),
                color=self._colour(_WHITE),
                override_color=False,
                url="",
                media_type=MEDIA_TYPE,
                data=np.frombuffer(
                    model_of(meshes[name], [copy for copy in copies if copy.object == name]), dtype=np.uint8
                ),
            )
            for name in sorted({copy.object for copy in copies})
            if name in meshes
        ]

    def _cube(self, shape: Shape, position: Vector, size: Vector) -> Any:
        return self._of(
            "CubePrimitive",
            pose=self._pose(position, shape.rotation),
            size=self._vector(size),
            color=self._colour(shape.colour),
        )

    def _dots(self, shape: Points) -> list[Any]:
        """Make a small cube of each point, for scenes have no points; points of shapes are never rotated."""
        size = (shape.size, shape.size, shape.size)
        x, y, z = shape.position
        return [self._cube(shape, (x + a, y + b, z + c), size) for a, b, c in shape.points]

    def _sphere(self, shape: Ball) -> Any:
        width = 2.0 * shape.radius
        return self._of(
            "SpherePrimitive",
            pose=self._pose(shape.position, shape.rotation),
            size=self._vector((width, width, width)),
            color=self._colour(shape.colour),
        )

    def _cylinder(self, shape: Cylinder) -> Any:
        width = 2.0 * shape.radius
        return self._of(
            "CylinderPrimitive",
            pose=self._pose(shape.position, shape.rotation),
            size=self._vector((width, width, shape.height)),
            bottom_scale=1.0,
            top_scale=1.0,
            color=self._colour(shape.colour),
        )

    def _line(self, shape: Polyline) -> Any:
        kinds = self._store.types[f"{PACKAGE}/LinePrimitive"]
        return self._of(
            "LinePrimitive",
            type=kinds.LINE_LOOP if shape.closed else kinds.LINE_STRIP,  # type: ignore[attr-defined]  # built at run time
            pose=self._pose(shape.position, shape.rotation),
            thickness=shape.width,
            scale_invariant=False,
            points=[self._ros("geometry_msgs/msg/Point", x=x, y=y, z=z) for x, y, z in shape.points],
            color=self._colour(shape.colour),
            colors=[],
            indices=np.zeros(0, dtype=np.uint32),
        )

    def _text(self, shape: Text) -> Any:
        return self._of(
            "TextPrimitive",
            pose=self._pose(shape.position, shape.rotation),
            billboard=True,
            font_size=_LINE_OF_CAPITAL * shape.size,
            scale_invariant=False,
            color=self._colour(shape.colour),
            text=shape.text,
        )

    def _colour(self, colour: Colour) -> Any:
        return self._of("Color", r=colour.red, g=colour.green, b=colour.blue, a=colour.opacity)

    def _pose(self, position: Vector, rotation: Quaternion) -> Any:
        (x, y, z), (w, i, j, k) = position, rotation
        return self._ros(
            "geometry_msgs/msg/Pose",
            position=self._ros("geometry_msgs/msg/Point", x=x, y=y, z=z),
            orientation=self._ros("geometry_msgs/msg/Quaternion", x=i, y=j, z=k, w=w),
        )

    def _vector(self, vector: Vector) -> Any:
        x, y, z = vector
        return self._ros("geometry_msgs/msg/Vector3", x=x, y=y, z=z)

    def _time(self, kind: str, at_ns: int) -> Any:
        seconds, nanoseconds = divmod(at_ns, NANOSECONDS)
        return self._ros(f"builtin_interfaces/msg/{kind}", sec=seconds, nanosec=nanoseconds)

    def _of(self, name: str, **fields: Any) -> Any:
        return self._ros(f"{PACKAGE}/{name}", **fields)

    def _ros(self, type_name: str, **fields: Any) -> Any:
        return self._store.types[type_name](**fields)
