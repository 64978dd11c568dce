"""The process that reads one untrusted mesh: `python -m voa_service.meshes.worker TYPE MEBIBYTES SECONDS FACES`.

The file is read from stdin. The vertices that faces use, and the faces, are written to stdout as npz; a mesh with more
than FACES faces is refused here, since the service that reads stdout has no limit of its own. Nothing else is opened:
materials and addresses in the file are ignored.
"""

import io
import os
import resource
import sys
from contextlib import suppress

TOO_MANY_FACES = 3
"""Exit code for a file with more faces than allowed; their number is written to stdout."""

OUT_OF_MEMORY = 4
"""Exit code of a process whose address space was too small for the file."""
_MORE_SECONDS = 5


def main(mesh_type: str, mebibytes: int, seconds: int, faces: int) -> None:
    """Set limits on this process, then read the mesh on stdin; ends with a line on stderr where it cannot be read."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    _offer_to_the_kernel()
    resource.setrlimit(resource.RLIMIT_AS, (mebibytes * 2**20, mebibytes * 2**20))
    # The soft limit ends the process by SIGXCPU, so that SIGKILL can only mean that the kernel ran out of memory.
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + _MORE_SECONDS))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    try:
        import numpy as np  # noqa: PLC0415 - after the limits

        from voa_meshes import UnreadableMesh, read_mesh  # noqa: PLC0415
    except (MemoryError, ImportError, OSError):  # a library that does not fit into memory is an ImportError
        sys.exit(OUT_OF_MEMORY)
    try:
        mesh = read_mesh(sys.stdin.buffer.read(), mesh_type)
    except UnreadableMesh as error:
        sys.exit(str(error))
    except MemoryError:
        sys.exit(OUT_OF_MEMORY)
    except Exception as error:  # damage that no reader expects must not end in a traceback
        sys.exit(f"its parts contradict one another ({type(error).__name__})")
    if len(mesh.faces) > faces:
        print(len(mesh.faces))
        sys.exit(TOO_MANY_FACES)
    try:
        used, corners = np.unique(mesh.faces, return_inverse=True)
        out = io.BytesIO()
        np.savez(out, vertices=mesh.vertices[used], faces=corners.reshape(-1, 3))
        sys.stdout.buffer.write(out.getvalue())
    except MemoryError:
        sys.exit(OUT_OF_MEMORY)


def _offer_to_the_kernel() -> None:
    """Have the kernel end this process first when memory runs out, and not the service."""
    with suppress(OSError), open("/proc/self/oom_score_adj", "w", encoding="ascii") as score:
        score.write("1000")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]))
