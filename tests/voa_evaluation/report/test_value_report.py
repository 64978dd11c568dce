"""The report of an evaluation of values: its sentences and tables state the figures of the rows."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from voa_evaluation.report.value_answer import answers
from voa_evaluation.report.value_report import PAGE, TEXT, paper_section, value_sections, write_report
from voa_evaluation.report.value_rows import Shown, listed, with_interval
from voa_evaluation.statistics import Interval
from voa_evaluation.values.policies import ENTROPY, RANDOM, VOA
from voa_evaluation.values.promises import SIMULATED
from voa_evaluation.values.results import Difference, Promise, Values
from voa_fleet.show.page import Notice, Paragraph, Section, page


@pytest.fixture(scope="module")
def written(values: Values, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a report."""
    folder = tmp_path_factory.mktemp("report")
    write_report(folder, [Notice("A trial.")], value_sections(folder, values), "voa evaluate voa --seed 7")
    return folder


def test_the_answer_comes_first_and_the_rest_needs_no_other_file(written: Path) -> None:
    html = (written / PAGE).read_text(encoding="utf-8")
    titles = re.findall(r"<h2>(.+?)</h2>", html)
    assert titles[0] == "The answer"
    assert titles[-1] == "Limits, and which differences are sure"
    assert html.index("A trial.") < html.index("A robot arm must grasp")
    assert "voa evaluate voa --seed 7" in html
    assert html.count("<img ") == html.count('src="data:image/png;base64,') == len(list(written.glob("*.png"))) == 5


def test_equal_results_give_equal_bytes(values: Values, written: Path, tmp_path: Path) -> None:
    write_report(tmp_path, [Notice("A trial.")], value_sections(tmp_path, values), "voa evaluate voa --seed 7")
    files = sorted(file.name for file in written.iterdir())
    assert files == sorted(file.name for file in tmp_path.iterdir())
    assert [name for name in files if (written / name).read_bytes() != (tmp_path / name).read_bytes()] == []


def test_sentences_state_the_figures_of_the_rows_with_their_counts(values: Values) -> None:
    shown = Shown(values)
    own = shown.ways()[VOA]
    worth, promise = answers(shown)[:2]
    assert f"of 100 grasps {100 * own.without:.0f} succeed without a look" in worth
    assert f"{100 * own.success:.0f} after the look that VOA chooses" in worth
    assert f"mean over {own.gain.count} beliefs about block and coupling; {own.scans} simulated scans" in worth
    row = shown.promise(SIMULATED)
    assert f"promised {100 * row.promised:+.1f} successes" in promise
    assert f"mean of {row.chosen} looks" in promise
    pair = next(each for each in values.pairs if each.recommended == "pair")
    both = next(text for text in answers(shown) if text.startswith("When one look is not enough"))
    assert f"together {round(100 * pair.pair_achieved.value):+d} ({pair.pair_achieved.count} simulated pairs)" in both


def with_error(values: Values, error: float) -> Values:
    """Replace the mean of promised less achieved value."""

    def changed(row: Promise) -> Promise:
        return replace(row, error_chosen=replace(row.error_chosen, value=error))

    return replace(values, promises=tuple(map(changed, values.promises)))


def test_a_promise_that_is_not_kept_is_called_so(values: Values) -> None:
    verdicts = {error: answers(Shown(with_error(values, error)))[1] for error in (0.0, 0.1, -0.1)}
    assert "The promise is kept (on average to 2 in 100)." in verdicts[0.0]
    assert "The promise is not kept (on average to 2 in 100): it is too high." in verdicts[0.1]
    assert "The promise is not kept (on average to 2 in 100): it is too low." in verdicts[-0.1]


def test_only_sure_differences_are_called_better_or_worse(values: Values) -> None:
    by_object = {"block": (0.1, True), "coupling": (-0.1, True)}

    def changed(row: Difference) -> Difference:
        value, sure = by_object.get(row.object, (0.0, False))
        sure = sure and row.way == RANDOM
        return replace(row, difference=Interval(value, value, value, 9), sure=sure)

    texts = answers(Shown(replace(values, differences=tuple(map(changed, values.differences)))))
    place = next(text for text in texts if text.startswith("When the place matters"))
    assert "VOA adds successes for block (+10); loses some for coupling (-10) (in 100 grasps; 9 beliefs each)" in place
    information = next(text for text in texts if text.startswith("Why not simply look"))
    assert "no difference is shown for block and coupling" in information


def test_counts_of_verdicts_add_up(values: Values, written: Path) -> None:
    shown = Shown(values)
    table = (written / TEXT).read_text(encoding="utf-8").partition("surely better, surely worse, or neither")[2]
    cells = next(line for line in table.splitlines() if line.startswith("| least entropy |")).split("|")[2:-1]
    for alone, (better, worse, unsure) in ((False, cells[:3]), (True, cells[4:7])):
        own = shown.all_differences(ENTROPY, alone=alone)
        assert [better.strip(), worse.strip(), unsure.strip()] == [
            f"{sum(row.sure and row.difference.value > 0.0 for row in own)}/{len(own)}",
            f"{sum(row.sure and row.difference.value < 0.0 for row in own)}/{len(own)}",
            f"{sum(not row.sure for row in own)}/{len(own)}",
        ]


def test_a_report_without_sessions_driving_and_drops_can_be_written(values: Values, tmp_path: Path) -> None:
    less = replace(values, several=(), next_looks=(), repetitions=(), driving=(), pairs=(), two_robots=())
    less = replace(less, confirmations=(), bins=())
    write_report(tmp_path, [], value_sections(tmp_path, less), "voa")
    assert sorted(file.name for file in tmp_path.glob("*.png")) == ["values-differences.png", "values-objects.png"]
    assert "Tried in a physics simulation" not in (tmp_path / PAGE).read_text(encoding="utf-8")


def test_parts_of_the_papers_evaluation_are_folded() -> None:
    part = Section("grasps", "Grasp scores", (Paragraph("Hidden."),))
    html = page("t", (), [paper_section([Paragraph("Three parts.")], [part])])
    assert html.index("Three parts.") < html.index("<details><summary>Grasp scores</summary>") < html.index("Hidden.")


def test_names_and_intervals_as_text() -> None:
    assert listed(["a"]) == "a"
    assert listed(["a", "b", "c"]) == "a, b and c"
    assert with_interval(None) == "-"
    assert with_interval(Interval(0.5, 0.25, 0.75, 3), signs=False) == "0.500 [0.250, 0.750]"
