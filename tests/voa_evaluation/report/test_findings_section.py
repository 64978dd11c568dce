"""The section of the page with the findings."""

from dataclasses import replace

from voa_evaluation.looks.findings import Finding
from voa_evaluation.looks.outcomes import Rate
from voa_evaluation.report.findings_section import findings_section
from voa_evaluation.statistics import Interval
from voa_fleet.show.page import page


def test_negative_findings_stand_in_a_table_with_their_reason_in_a_column_of_its_own() -> None:
    interval = Interval(0.25, 0.1, 0.75, 4)
    better = Finding("uniform", "beam", "random", "better", Rate(3, 4), Rate(2, 4), interval)
    neither = replace(
        better, rule="margin", verdict="no difference shown", seen="In 1 of 4 drops.", reason="Few drops."
    )
    html = page("t", (), [findings_section([better, neither])])
    _, good, worse, equal = html.split("<h3>")
    assert "<td>beam</td><td>uniform</td><td>random</td>" in good
    assert '<td class="number">+0.250 [+0.100, +0.750]</td>' in good
    assert "reason" not in good
    assert "<p>Nowhere.</p>" in worse
    assert "<th>reason</th>" in equal
    assert ">Few drops.</td>" in equal
    assert ">In 1 of 4 drops.</td>" in equal
    assert "1 favour VOA" in html
