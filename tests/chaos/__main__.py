"""Run the attacks: `python -m tests.chaos [WORD ...]`, only those whose names have one of the words."""

import argparse
import importlib
import pkgutil
import sys
import tempfile
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table

import tests.chaos
from tests.chaos.attack import Attack, Outcome


def attacks() -> list[Attack]:
    """Collect `ATTACKS` of every module of this package, by module and order."""
    names = sorted(module.name for module in pkgutil.iter_modules(tests.chaos.__path__))
    modules = [importlib.import_module(f"tests.chaos.{name}") for name in names if name != "__main__"]
    return [attack for module in modules for attack in getattr(module, "ATTACKS", [])]


def main() -> int:
    """Run, print, and return 0 where every attack was held."""
    parser = argparse.ArgumentParser(prog="python -m tests.chaos", description=__doc__)
    parser.add_argument("words", nargs="*", help="only attacks whose names have one of these words")
    words = parser.parse_args().words
    console = Console()
    table = Table("", "attack", "before", "now", "bound", "survived", title="Attacks", title_justify="left")
    failed = 0
    for attack in attacks():
        if words and not any(word in attack.name for word in words):
            continue
        began = time.monotonic()
        with tempfile.TemporaryDirectory(prefix="voa-chaos-") as folder:
            outcome = _outcome(attack, Path(folder))
        failed += not outcome.held
        print(f"{attack.name}: {outcome.figure} ({time.monotonic() - began:.1f} s)", file=sys.stderr, flush=True)
        sign = "ok" if outcome.held else "FAILED"
        table.add_row(sign, attack.name, attack.before, outcome.figure, attack.bound, outcome.survived)
    console.print(table)
    return int(failed > 0)


def _outcome(attack: Attack, folder: Path) -> Outcome:
    try:
        return attack.run(folder)
    except Exception as error:  # an attack that cannot be run has not been held
        return Outcome(f"{type(error).__name__}: {error}", "not looked at", held=False)


if __name__ == "__main__":
    sys.exit(main())
