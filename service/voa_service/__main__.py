"""Entry of `python -m voa_service`, which does the same as `voa serve`."""

import sys

from voa_service.serve import main

if __name__ == "__main__":
    sys.exit(main())
