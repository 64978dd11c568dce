"""Damaged mesh files: read as a second reader reads them, or refused with a reason in one line.

    python -m tests.fuzz.meshes --count 10000 --seed 1

OBJ, PLY and STL are compared with the plain readers of `tests.fuzz.plain` and with trimesh, GLB with trimesh. trimesh
is wrong, or reads less, where a row of the table says so: it counts relative OBJ indices from the file's end, cuts
polygons that are not convex as fans, takes indices beyond the last vertex, and finds no facets in a binary STL with
bytes behind its data.
"""

import argparse
import contextlib
import io
import logging
import random
import re
import struct
import warnings
from collections import Counter

import numpy as np
import trimesh
from scipy.optimize import linear_sum_assignment

from tests.fuzz import plain
from tests.fuzz.mutations import BYTES, TEXT, Mutation, change_the_document
from tests.fuzz.plain import Polygons
from tests.fuzz.seeds import SEEDS
from voa_meshes import UnreadableMesh, read_mesh
from voa_meshes.triangles import Floats

_MUTATIONS: dict[str, list[Mutation]] = dict.fromkeys(("obj", "stl", "ply"), BYTES + TEXT)
_MUTATIONS["glb"] = [*BYTES, *[change_the_document] * 6]
_LONGEST_REASON = 300
_FARTHEST = 1e9  # `SubprocessMeshReader` refuses much less
_RELATIVE = re.compile(rb"[\r\n]\s*fo?\s[^\r\n]*-")


def damaged(kind: str, rng: random.Random) -> bytes:
    """A file of a type with one to three damages, most often one."""
    content = rng.choice(SEEDS[kind])
    for _ in range(rng.choice([1, 1, 1, 2, 3])):
        with contextlib.suppress(ValueError, IndexError, struct.error):  # what it would damage is gone
            content = rng.choice(_MUTATIONS[kind])(content, rng)
    return content


def outcome(kind: str, content: bytes) -> str:
    """Read a damaged file and name the outcome; raises AssertionError for an outcome that no file may have."""
    try:
        triangles = read_mesh(content, kind)
    except UnreadableMesh as error:
        reason = str(error)
        assert reason, "expected a reason"
        assert "\n" not in reason, f"expected one line, got {reason!r}"
        assert len(reason) <= _LONGEST_REASON, f"expected a short reason, got {reason!r}"
        return "refused with a reason"
    ours = triangles.vertices[triangles.faces]
    if not (np.abs(ours) < _FARTHEST).all():
        return "not finite, or far away: refused with a reason by the next step"
    return _beside_others(kind, content, ours)


def _beside_others(kind: str, content: bytes, ours: Floats) -> str:
    """How the other readers' reading compares; raises AssertionError where it should be the same."""
    if kind == "glb":
        return _beside_trimesh(kind, _without_tail(content), ours, [])
    polygons = plain.polygons(kind, content)
    assert agree(ours, polygons), f"expected the plain reader's {len(polygons)} polygons, got {len(ours)} triangles"
    return _beside_trimesh(kind, content, ours, polygons)


def _without_tail(content: bytes) -> bytes:
    """A GLB file without the bytes behind the length that it says, with which trimesh refuses it."""
    return content[: int.from_bytes(content[8:12], "little")]


def agree(ours: Floats, theirs: Polygons) -> bool:
    """True if triangles (f, 3, 3) are the given polygons: equal corners, and no area left out."""
    if all(len(polygon) == 3 for polygon in theirs):
        return _close(ours, np.array(theirs, dtype=np.float64).reshape(-1, 3, 3))
    corners = np.concatenate([np.array(polygon) for polygon in theirs])
    areas = [sum((_area(np.array(each)) for each in flat), np.zeros(3)) for flat in (theirs, ours)]
    within = 1e-9 * max(1.0, float((corners**2).max()))
    return _close(_places(ours), _places(corners)) and bool(np.allclose(areas[0], areas[1], atol=within))


def _close(ours: Floats, theirs: Floats) -> bool:
    return ours.shape == theirs.shape and bool(np.allclose(ours, theirs, rtol=1e-6, atol=1e-9))


def _places(corners: Floats) -> Floats:
    places: Floats = np.unique(corners.reshape(-1, 3), axis=0)
    return places


def _area(polygon: Floats) -> Floats:
    """The vector area of a polygon (n, 3), the same however it is cut."""
    arms = polygon - polygon[0]
    area: Floats = 0.5 * np.cross(arms[1:-1], arms[2:]).sum(axis=0)
    return area


def _same_set(ours: Floats, theirs: Floats) -> bool:
    """Whether triangles (f, 3, 3) are the same in any order, each from any corner on."""
    if len(ours) != len(theirs):
        return False
    turned = np.stack([np.roll(theirs, k, axis=1) for k in range(3)])
    apart = np.abs(ours[None, :, None] - turned[:, None]).max(axis=(3, 4)).min(axis=0)
    pairs = linear_sum_assignment(apart)
    return bool(apart[pairs].max() <= 1e-6 * max(1.0, float(np.abs(ours).max())))


def _beside_trimesh(kind: str, content: bytes, ours: Floats, polygons: Polygons) -> str:
    """How trimesh's reading compares; raises AssertionError where neither is known to be wrong."""
    try:
        with warnings.catch_warnings(action="ignore"):
            mesh = trimesh.load_mesh(io.BytesIO(content), file_type=kind, process=False)
        vertices, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces)
    except Exception:
        return "read; trimesh refuses"
    if not len(faces):
        return "read; trimesh finds nothing" if len(ours) else "read: nothing"
    if faces.max() >= len(vertices):
        return "read; trimesh takes an index beyond the end"
    theirs = vertices[faces]
    if _close(ours, theirs) or _same_set(ours, theirs):
        return "read, as trimesh"
    if kind == "obj" and _RELATIVE.search(content):
        return "read; trimesh counts relative indices from the end"
    assert any(len(polygon) > 3 for polygon in polygons), f"expected trimesh's {len(theirs)} triangles, got {len(ours)}"
    return "read; trimesh cuts every polygon as a fan"


def run(kind: str, count: int, seed: int) -> Counter[str]:
    """Read damaged files of a type, and count the results.

    Raises:
        AssertionError: a file was read as no other reader reads it, or ended in an error of another kind.
    """
    rng = random.Random(f"{kind} {seed}")  # noqa: S311 - not a secret
    seen: Counter[str] = Counter()
    for number in range(count):
        content = damaged(kind, rng)
        try:
            seen[outcome(kind, content)] += 1
        except Exception as error:
            raise AssertionError(f"{kind} file {number} of seed {seed}: {error!r}; it is {content!r}") from error
    return seen


def main() -> None:
    """Print a table."""
    logging.disable()  # trimesh tells of every file that it refuses
    given = argparse.ArgumentParser(description=__doc__)
    given.add_argument("--count", type=int, default=10_000, help="files of each type")
    given.add_argument("--seed", type=int, default=1)
    said = given.parse_args()
    for kind in SEEDS:
        for what, times in sorted(run(kind, said.count, said.seed).items()):
            print(f"{kind}  {times:7d}  {what}")


if __name__ == "__main__":
    main()
