"""One self-contained HTML page: no script, no style sheet, no picture beside it. The same content, the same bytes.

It can be read on a telephone: what is wider than the screen scrolls sideways in a box of its own.
"""

import base64
import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from string import Template

_PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>$title</title>
<style>
body { font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; background: #fff; max-width: 70rem; margin: 2rem auto;
  padding: 0 1rem; overflow-wrap: break-word; }
h1, h2, h3 { line-height: 1.2; } h2 { margin-top: 3rem; border-bottom: 2px solid #0072b2; padding-bottom: .2rem; }
p, li { max-width: 48rem; } code { background: #f2f2f2; padding: .1rem .3rem; overflow-wrap: anywhere; }
pre { background: #f2f2f2; padding: .8rem; font-size: .85rem; white-space: pre-wrap; overflow-wrap: anywhere; }
.notice { border: 2px solid #d55e00; padding: .6rem .8rem; font-weight: 600; }
.wide { overflow-x: auto; } table { border-collapse: collapse; font-size: .85rem; margin: .5rem 0 1.5rem; }
caption { text-align: left; font-weight: 600; padding: .3rem 0; }
th, td { border: 1px solid #ccc; padding: .2rem .5rem; text-align: left; vertical-align: top; }
thead th { background: #eef4f8; } .number { text-align: right; } td.number { white-space: nowrap; }
.long { min-width: 14rem; }
figure { margin: 1rem 0 2rem; } img { max-width: 100%; height: auto; }
figcaption { font-size: .9rem; color: #444; max-width: 48rem; } summary { cursor: pointer; }
@media (max-width: 48rem) {
  img.detailed { max-width: none; width: 48rem; }
  .cards thead { display: none; }
  .cards, .cards caption, .cards tbody, .cards tr, .cards td { display: block; text-align: left; white-space: normal; }
  .cards tr { margin-bottom: .8rem; border: 1px solid #ccc; } .cards td { border: 0; }
  .cards td::before { content: attr(data-head) ": "; font-weight: 600; }
}
</style>
</head>
<body>
<h1>$title</h1>
$lead
$sections
</body>
</html>
""")
_NUMBER = re.compile(r"-?|[<> ]*[-+]?\d[-+\d.,/%()\[\]<> ]*(?:to [-+\d.]+ ?%?)?")
"""Texts that a column of numbers may hold: figures, counts, shares, intervals, and a dash for none."""
_LONG = 40
"""Characters that are a sentence: a column of them is not squeezed to a word a line."""
_FIGURES, _SENTENCES = ' class="number"', ' class="long"'
_DETAILED_PX = 800
"""A picture that is wider has labels that shrinking it to a telephone's screen would make too small to read."""


@dataclass(frozen=True)
class Section:
    """A part of the page.

    Attributes:
        anchor: its name in addresses.
        blocks: HTML, in order.
    """

    anchor: str
    title: str
    blocks: tuple[str, ...]


def page(title: str, lead: Sequence[str], sections: Sequence[Section]) -> str:
    """Write the whole page; `lead` and the blocks of sections are HTML, titles are text."""
    return _PAGE.substitute(
        title=escape(title),
        lead="\n".join(lead),
        sections="\n".join(
            f'<section id="{part.anchor}">\n<h2>{escape(part.title)}</h2>\n{_joined(part.blocks)}\n</section>'
            for part in sections
        ),
    )


def _joined(blocks: Sequence[str]) -> str:
    return "\n".join(blocks)


def contents(sections: Sequence[Section]) -> str:
    """List the sections, each with a link to it."""
    links = "\n".join(f'<li><a href="#{part.anchor}">{escape(part.title)}</a></li>' for part in sections)
    return f"<nav><ul>\n{links}\n</ul></nav>"


def heading(text: str) -> str:
    """Head a part of a section."""
    return f"<h3>{escape(text)}</h3>"


def paragraph(text: str) -> str:
    """Set plain text."""
    return f"<p>{escape(text)}</p>"


def notice(text: str) -> str:
    """Set plain text that nobody may miss."""
    return f'<p class="notice">{escape(text)}</p>'


def items(texts: Sequence[str]) -> str:
    """List plain texts."""
    return "<ul>\n" + "\n".join(f"<li>{escape(text)}</li>" for text in texts) + "\n</ul>"


def command(text: str) -> str:
    """Set a command line."""
    return f"<p><code>{escape(text)}</code></p>"


def lines(texts: Sequence[str]) -> str:
    """Set lines of a terminal; those that are too long for the screen are broken."""
    return f"<pre>{escape(chr(10).join(texts))}</pre>"


def table(caption: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Set a table of plain texts: columns of numbers to the right, all others to the left.

    Where a column has sentences, a small screen shows every row as a card, each cell below the other with its heading.
    """
    classes = [_class_of([row[column] for row in rows]) for column in range(len(header))]
    cards = _SENTENCES in classes
    heads = [f' data-head="{escape(name)}"' if cards else "" for name in header]
    starts = [f"<td{kind}{name}>" for kind, name in zip(classes, heads, strict=True)]
    head = "".join(f"<th{kind}>{escape(cell)}</th>" for kind, cell in zip(classes, header, strict=True))
    body = "\n".join(
        "<tr>" + "".join(f"{start}{escape(cell)}</td>" for start, cell in zip(starts, row, strict=True)) + "</tr>"
        for row in rows
    )
    named = f"<caption>{escape(caption)}</caption>\n" if caption else ""
    kind = ' class="cards"' if cards else ""
    return (
        f'<div class="wide"><table{kind}>\n{named}<thead><tr>{head}</tr></thead>\n'
        f"<tbody>\n{body}\n</tbody>\n</table></div>"
    )


def _class_of(cells: Sequence[str]) -> str:
    """How the cells of a column stand, as an attribute."""
    if cells and all(_NUMBER.fullmatch(cell) for cell in cells):
        return _FIGURES
    return _SENTENCES if max(map(len, cells), default=0) > _LONG else ""


def folded(summary: str, block: str) -> str:
    """Hide HTML until its summary is clicked."""
    return f"<details><summary>{escape(summary)}</summary>\n{block}\n</details>"


def picture(file: Path, caption: str) -> str:
    """Embed a PNG file; the caption says what it shows and is read out where it cannot be seen."""
    content = file.read_bytes()
    width, height = (int.from_bytes(content[start : start + 4], "big") for start in (16, 20))  # PNG's IHDR
    kind = ' class="detailed"' if width > _DETAILED_PX else ""
    data = base64.b64encode(content).decode("ascii")
    text = escape(caption)
    return (
        f'<figure><div class="wide"><img{kind} alt="{text}" width="{width}" height="{height}" '
        f'src="data:image/png;base64,{data}"></div>\n<figcaption>{text}</figcaption></figure>'
    )
