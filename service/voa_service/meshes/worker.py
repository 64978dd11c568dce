"""The process that reads one untrusted mesh: `python -m voa_service.meshes.worker TYPE MEBIBYTES SECONDS FACES`.

The file comes on stdin; the vertices that faces use, and the faces, leave on stdout as npz: no more than so many, for
the process that waits has no limits of its own. Nothing else is opened: neither materials nor addresses in the file
lead anywhere.
"""

import io
import os
import resource
import sys
from contextlib import suppress

TOO_MANY_FACES = 3
"""Exit code of a file that has more faces than are wanted; their number is on stdout."""

OUT_OF_MEMORY = 4
"""Exit code of a process that its address space was too small for."""
_MORE_SECONDS = 5


def main(mesh_type: str, mebibytes: int, seconds: int, faces: int) -> None:
    """Limit this process, then read; a file that cannot be read ends it with one line on stderr."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    _offer_to_the_kernel()
    resource.setrlimit(resource.RLIMIT_AS, (mebibytes * 2**20, mebibytes * 2**20))
    # The soft limit ends the process by a signal of its own: SIGKILL can then only be the kernel's, out of memory.
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + _MORE_SECONDS))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    try:
        import numpy as np  # noqa: PLC0415 - after the limits

        from voa_meshes.parsing import parse  # noqa: PLC0415
        from voa_meshes.triangles import Unreadable  # noqa: PLC0415
    except (MemoryError, ImportError, OSError):  # a library that cannot be mapped is an ImportError
        sys.exit(OUT_OF_MEMORY)
    try:
        found = parse(mesh_type, sys.stdin.buffer.read())
    except Unreadable as error:
        sys.exit(str(error))
    except MemoryError:
        sys.exit(OUT_OF_MEMORY)
    except Exception as error:  # a file that nobody thought of
        sys.exit(f"its parts contradict one another ({type(error).__name__})")
    if len(found.faces) > faces:
        print(len(found.faces))
        sys.exit(TOO_MANY_FACES)
    try:
        used, corners = np.unique(found.faces, return_inverse=True)
        out = io.BytesIO()
        np.savez(out, vertices=found.vertices[used], faces=corners.reshape(-1, 3))
        sys.stdout.buffer.write(out.getvalue())
    except MemoryError:
        sys.exit(OUT_OF_MEMORY)


def _offer_to_the_kernel() -> None:
    """Be the first process that the kernel ends when memory runs out: rather this one than the service."""
    with suppress(OSError), open("/proc/self/oom_score_adj", "w", encoding="ascii") as score:
        score.write("1000")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]))
