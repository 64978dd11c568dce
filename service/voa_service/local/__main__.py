"""Entry of `python -m voa_service.local`."""

import sys

from voa_service.local.command import main

if __name__ == "__main__":
    sys.exit(main())
