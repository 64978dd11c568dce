"""Measure the table of acceptance against a service that is started here: `python -m tests.acceptance`.

All figures come over HTTP, from a service with default settings. Objects, rooms, noise and ray casting are made here.
"""

import argparse
import sys
import time
from collections.abc import Callable

from tests.acceptance.customer import Service, service
from tests.acceptance.figures import HEADER, Figure, as_json, as_text
from tests.acceptance.rows import designed, holder, random_objects, rooms, shipped
from tests.acceptance.sizes import FULL, QUICK, SMOKE, Size

Rows = Callable[[Service, int, Size], list[Figure]]

ROWS: dict[str, Rows] = {
    "random-objects": random_objects.rows,
    "poses-against-grasps": designed.poses_against_grasps_rows,
    "worthless-nearby": designed.worthless_nearby_rows,
    "exclusive-or": designed.exclusive_or_rows,
    "random-look": shipped.random_look_rows,
    "three-looks": shipped.three_looks_rows,
    "greedy": shipped.greedy_rows,
    "rooms": rooms.rows,
    "holder": holder.rows,
}
SIZES = {"smoke": SMOKE, "quick": QUICK, "full": FULL}


def main(arguments: list[str] | None = None) -> int:
    """Measure and print the table; 1 if a figure falls short of what is demanded, else 0."""
    options = _parser().parse_args(arguments)
    chosen = options.only or list(ROWS)
    figures: list[Figure] = []
    if not options.json:
        print(f"seed {options.seed}, size {options.size}\n\n{HEADER}", flush=True)
    with service() as running:
        for name in chosen:
            began = time.monotonic()
            for figure in ROWS[name](running, options.seed, SIZES[options.size]):
                figures.append(figure)
                if not options.json:
                    print(as_text(figure), flush=True)
            print(f"{name}: {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
    if options.json:
        print(as_json(figures, {"seed": options.seed, "size": options.size, "rows": chosen}))
    return 1 if any(figure.met is False for figure in figures) else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("python -m tests.acceptance", description=main.__doc__)
    size = parser.add_mutually_exclusive_group()
    for name, text in (("quick", "under 5 minutes on two cores (default)"), ("full", "under 40 minutes on two cores")):
        size.add_argument(f"--{name}", dest="size", action="store_const", const=name, help=text)
    size.add_argument("--size", choices=list(SIZES), help="smoke: a few seconds, whose figures mean nothing")
    parser.add_argument("--seed", type=int, default=2026, help="of objects, rooms and noise (default: %(default)s)")
    parser.add_argument(
        "--only", action="append", choices=list(ROWS), metavar="ROW", help=f"of {', '.join(ROWS)}; repeatable"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document instead of the table")
    parser.set_defaults(size="quick")
    return parser


if __name__ == "__main__":
    sys.exit(main())
