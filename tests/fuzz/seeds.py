"""Whole mesh files of each type, to be damaged."""

from tests.voa_meshes.files import (
    CORNERS,
    POINTS,
    POLYGONS,
    TRIANGLES,
    Gltf,
    ascii_ply,
    ascii_stl,
    binary_ply,
    binary_stl,
    obj,
    step,
)


def _relative() -> str:
    lines = obj(TRIANGLES).splitlines()
    faces = [f"f {' '.join(f'{int(i) - 13}/{i}/-1' for i in line.split()[1:])}" for line in lines if line[0] == "f"]
    return "\n".join([line for line in lines if line[0] == "v"] + ["vt 0 0"] * 12 + ["vn 0 0 1"] + faces) + "\n"


def _of_parts() -> bytes:
    """Strips, nodes and whole numbers."""
    made = Gltf()
    made.mesh(made.triangles(faces=TRIANGLES[:8]), made.triangles(faces=TRIANGLES[8:10]))
    whole = made.accessor(POINTS * 1000, "<i2", "VEC3", 5122)
    made.mesh({"attributes": {"POSITION": whole}, "indices": made.indices(TRIANGLES[8:]), "mode": 4})
    made.mesh(made.triangles(faces=[6, 0, 7, 1, 8, 2, 9, 3], mode=5))
    nodes = [{"children": [1, 2, 3]}, {"mesh": 0, "translation": [0, 0, 0.1]}, {"mesh": 1, "scale": [0.001] * 3}]
    return made.file(nodes=[*nodes, {"mesh": 2, "matrix": [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1]}])


SEEDS: dict[str, list[bytes]] = {
    "obj": [obj(TRIANGLES).encode(), obj(POLYGONS).encode(), _relative().encode()],
    "stl": [ascii_stl().encode(), binary_stl(), (ascii_stl(CORNERS[:9]) + ascii_stl(CORNERS[9:])).encode()],
    "ply": [ascii_ply(TRIANGLES).encode(), ascii_ply(POLYGONS).encode()]
    + [binary_ply(polygons, order=order) for polygons in (TRIANGLES, POLYGONS) for order in "<>"],
    "glb": [step().file(), _of_parts()],
}
