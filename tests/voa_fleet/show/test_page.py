"""The page: it escapes, stands alone, and is written for small screens too."""

from html import escape
from pathlib import Path

import pytest

from voa_fleet.show.figures import new_figure
from voa_fleet.show.page import (
    Block,
    Command,
    Folded,
    Heading,
    Items,
    Lines,
    Notice,
    Paragraph,
    Picture,
    Section,
    ShadedCell,
    ShadedTable,
    Table,
    page,
)


def html_of(*blocks: Block) -> str:
    return page("a < b", [Notice("beware & care")], [Section("s", "T", blocks)], contents=True)


def test_it_escapes_and_stands_alone() -> None:
    html = html_of(Paragraph("x & y"), Table("c", ("<h>",), [["1"]]), Lines(["<1>", "2"]))
    assert "<title>a &lt; b</title>" in html
    assert "<p>x &amp; y</p>" in html
    assert "&lt;h&gt;</th>" in html
    assert "<pre>&lt;1&gt;\n2</pre>" in html
    assert html.index("beware &amp; care") < html.index('href="#s"') < html.index('id="s"')
    assert "http" not in html
    assert "<script" not in html


@pytest.mark.parametrize(
    ("cells", "kind"),
    [
        (["+0.155 [+0.100, +0.200]", "-"], ' class="number"'),
        (["0 [> -0.001, < 0.001]", "-0.010 [-0.2, 0]"], ' class="number"'),
        (["3/4 (75 %)", "0/4 (0 %)"], ' class="number"'),
        (["6% to 79%", "44% to 100%"], ' class="number"'),
        (["0.1 to 0.2", ""], ' class="number"'),
        (["12", "-0.5", "1e"], ""),
        (["margin", "beam"], ""),
        (["3 of 20"], ""),
        ([], ""),
    ],
)
def test_columns_of_numbers_stand_to_the_right_and_text_to_the_left(cells: list[str], kind: str) -> None:
    html = html_of(Table("", ("name", "what"), [["row", cell] for cell in cells]))
    assert f"<tr><th>name</th><th{kind}>what</th></tr>" in html
    assert [f"<td>row</td><td{kind}>{escape(cell)}</td>" in html for cell in cells] == [True] * len(cells)
    assert 'class="cards"' not in html


def test_rows_with_sentences_are_cards_on_a_small_screen() -> None:
    html = html_of(Table("", ("na<me", "why"), [["row", "a sentence that is not to be squeezed to a word a line"]]))
    assert '<table class="cards">' in html
    assert '<td data-head="na&lt;me">row</td><td class="long" data-head="why">a sentence' in html
    assert 'content: attr(data-head) ": "' in html


def test_nothing_makes_a_small_screen_scroll_but_boxes_of_their_own(tmp_path: Path) -> None:
    small, large = tmp_path / "small.png", tmp_path / "large.png"
    for file, width in ((small, 4.0), (large, 12.0)):
        new_figure(width, 2.0).savefig(file, dpi=100)
    html = html_of(Table("c", ("h",), [["1"]]), Picture(small, "s"), Picture(large, "l"))
    assert '<meta name="viewport" content="width=device-width, initial-scale=1">' in html
    assert "img { max-width: 100%; height: auto; }" in html
    assert ".wide { overflow-x: auto; }" in html
    assert html.count("<table>") == html.count('<div class="wide"><table>')
    assert html.count("<img ") == html.count('<div class="wide"><img ') == 2
    assert 'width="400" height="200"' in html
    assert 'class="detailed" alt="l" width="1200"' in html


def test_every_kind_of_block_is_rendered() -> None:
    inner = Table("", ("n",), [["7"]])
    blocks = Heading("h & h"), Command("voa <x>"), Items(["one", "<two>"]), Folded("more & more", [inner, inner])
    html = html_of(*blocks)
    assert "<h3>h &amp; h</h3>" in html
    assert "<p><code>voa &lt;x&gt;</code></p>" in html
    assert "<li>one</li>\n<li>&lt;two&gt;</li>" in html
    details = html[html.index("<details>") : html.index("</details>")]
    assert "<summary>more &amp; more</summary>" in details
    assert details.count('<td class="number">7</td>') == 2
    assert html == html_of(
        Heading("h & h"), Command("voa <x>"), Items(["one", "<two>"]), Folded("more & more", [inner] * 2)
    )


def test_shaded_cells_are_the_darker_the_larger_and_stay_legible() -> None:
    cells = [ShadedCell("0 of 15", 0.0), ShadedCell("15 of 15", 1.0), ShadedCell("<2>", 7.0)]
    html = html_of(ShadedTable("", ("pose", "A", "B", "C"), [("upright & dry", cells)]))
    assert "<tr><th>upright &amp; dry</th>" in html
    shades = [
        f'rgba(0, 114, 178, {opacity})">{text}</td>' for opacity, text in (("0.00", "0 of 15"), ("0.65", "15 of 15"))
    ]
    assert [shade in html for shade in shades] == [True, True]
    assert '0.65)">&lt;2&gt;</td>' in html
