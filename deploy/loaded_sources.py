"""Print the source files of all modules that the named modules load, a line each: `python loaded_sources.py MODULE...`.

`deploy/Dockerfile` compiles these of the large packages, and leaves the bytecode of the others out of the images.
"""

import importlib
import sys
from collections.abc import Sequence


def main(names: Sequence[str]) -> None:
    """Import the named modules; print the paths of the sources of everything that is loaded then."""
    for name in names:
        importlib.import_module(name)
    files = {getattr(module, "__file__", None) or "" for module in list(sys.modules.values())}
    print(*sorted(file for file in files if file.endswith(".py") and "site-packages" in file), sep="\n")


if __name__ == "__main__":
    main(sys.argv[1:])
