"""Differences between the scene that a page shows and the next one, so that only those are sent to the browser."""

from dataclasses import dataclass, replace

from voa_scene.shapes import AnyShape, Scene

Key = tuple[str, str]
"""Group and name of a shape, which identify it in every scene."""


@dataclass(frozen=True)
class Differences:
    """Differences of a scene from the one before it.

    Attributes:
        removed: keys of shapes that are gone, or whose geometry changed.
        added: new shapes, and those whose geometry changed.
        changed: shapes of which only the place, the colour or the label changed.
    """

    removed: tuple[Key, ...]
    added: tuple[AnyShape, ...]
    changed: tuple[AnyShape, ...]


def key_of(shape: AnyShape) -> Key:
    """Return the key of a shape."""
    return (shape.group, shape.name)


def differences(before: Scene, after: Scene) -> Differences:
    """Compare two scenes shape by shape; the last of several shapes with one key counts."""
    old = {key_of(shape): shape for shape in before.shapes}
    new = {key_of(shape): shape for shape in after.shapes}
    kept = {key for key in new if key in old and has_same_geometry(old[key], new[key])}
    return Differences(
        removed=tuple(key for key in old if key not in kept),
        added=tuple(shape for key, shape in new.items() if key not in kept),
        changed=tuple(shape for key, shape in new.items() if key in kept and shape != old[key]),
    )


def has_same_geometry(one: AnyShape, other: AnyShape) -> bool:
    """True if two shapes differ in their place, colour and label at most."""
    if type(one) is not type(other):
        return False
    return one == replace(other, position=one.position, rotation=one.rotation, colour=one.colour, label=one.label)
