"""The process that reads one untrusted mesh: `python -m voa_service.meshes.worker TYPE MEBIBYTES SECONDS`.

The file comes on stdin; vertices and faces leave on stdout as npz. Nothing else is opened: the file is given to
trimesh with its type and without a resolver, so neither materials nor addresses in it lead anywhere.
"""

import io
import os
import resource
import sys


def main(mesh_type: str, mebibytes: int, seconds: int) -> None:
    """Limit this process, then read."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    resource.setrlimit(resource.RLIMIT_AS, (mebibytes * 2**20, mebibytes * 2**20))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    import numpy as np  # noqa: PLC0415 - after the limits
    import trimesh  # noqa: PLC0415

    content = io.BytesIO(sys.stdin.buffer.read())
    try:
        mesh = trimesh.load_mesh(content, file_type=mesh_type, process=False)
    except BaseException as error:
        sys.exit(f"{type(error).__name__}: {error}")
    if not isinstance(mesh, trimesh.Trimesh):
        sys.exit("the file holds no triangles")
    out = io.BytesIO()
    np.savez(out, vertices=np.asarray(mesh.vertices, dtype=np.float64), faces=np.asarray(mesh.faces, dtype=np.int64))
    sys.stdout.buffer.write(out.getvalue())


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
