"""The tables of faults follow the code: each says a text that stands in its file once."""

import pytest

from tests.mutants.__main__ import REPOSITORY
from tests.mutants.access import MUTANTS as ACCESS
from tests.mutants.bus import MUTANTS as BUS
from tests.mutants.core import MUTANTS as CORE
from tests.mutants.mutant import Mutant
from tests.mutants.service import MUTANTS as SERVICE


@pytest.mark.parametrize("mutant", CORE + SERVICE + BUS + ACCESS, ids=lambda mutant: f"{mutant.file} {mutant.name}")
def test_the_text_that_a_fault_replaces_is_there(mutant: Mutant) -> None:
    assert (REPOSITORY / mutant.file).read_text(encoding="utf-8").count(mutant.old) == 1
    assert mutant.new != mutant.old
