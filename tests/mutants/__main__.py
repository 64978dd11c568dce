"""Put each fault of the tables into a copy of the tree, one after another, and report which the tests notice.

    python -m tests.mutants [WORD ...]

tries those whose name or file has one of the words, all without any; and fails where one survives. It takes about a
quarter of an hour, so it is no part of `make test`.
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.mutants.access import MUTANTS as ACCESS
from tests.mutants.bus import MUTANTS as BUS
from tests.mutants.core import MUTANTS as CORE
from tests.mutants.mutant import judge, tests_fail
from tests.mutants.service import MUTANTS as SERVICE

REPOSITORY = Path(__file__).resolve().parents[2]


def copied(to: Path) -> Path:
    """The tree as it stands, without what git ignores."""
    listing = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(listing, cwd=REPOSITORY, capture_output=True, text=True, check=True).stdout
    for name in filter(None, names.split("\0")):
        if (REPOSITORY / name).is_file():
            (to / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(REPOSITORY / name, to / name)
    return to


def main(words: list[str]) -> int:
    """Print a line per mutant; the number of those that no test noticed."""
    wanted = [
        each
        for each in CORE + SERVICE + BUS + ACCESS
        if not words or any(word in each.name + each.file for word in words)
    ]
    left = 0
    with tempfile.TemporaryDirectory() as folder:
        tree = copied(Path(folder))
        sound: dict[str, bool] = {}
        for mutant in wanted:
            if mutant.tests not in sound:
                sound[mutant.tests] = not tests_fail(mutant.tests, tree)[0]
            if not sound[mutant.tests]:
                print(f"{mutant.tests} fails without any mutant: mend that first")
                left += 1
                continue
            verdict = judge(mutant, tree)
            left += verdict.outcome != "killed"
            print(" | ".join([verdict.outcome, mutant.file, mutant.name, verdict.test, verdict.how]), flush=True)
    print(f"{len(wanted) - left} of {len(wanted)} killed")
    return left


if __name__ == "__main__":
    sys.exit(1 if main(sys.argv[1:]) else 0)
