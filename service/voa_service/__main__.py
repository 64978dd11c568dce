"""Entry of `python -m voa_service`, which does the same as `voa serve`."""

import gc
import sys

if __name__ == "__main__":
    gc.disable()  # modules are no garbage: to search them for some would take a seventh of the start
    from voa_service.serve import main

    sys.exit(main())
