"""One self-contained HTML page: no script, no style sheet, no picture beside it. The same content, the same bytes."""

import base64
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
body { font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; max-width: 70rem; margin: 2rem auto; padding: 0 1rem; }
h1, h2, h3 { line-height: 1.2; } h2 { margin-top: 3rem; border-bottom: 2px solid #0072b2; padding-bottom: .2rem; }
p, li { max-width: 48rem; } code { background: #f2f2f2; padding: .1rem .3rem; overflow-wrap: anywhere; }
.wide { overflow-x: auto; } table { border-collapse: collapse; font-size: .85rem; margin: .5rem 0 1.5rem; }
caption { text-align: left; font-weight: 600; padding: .3rem 0; }
th, td { border: 1px solid #ccc; padding: .2rem .5rem; text-align: right; } thead th { background: #eef4f8; }
th:first-child, td:first-child { text-align: left; } figure { margin: 1rem 0 2rem; } img { max-width: 100%; }
figcaption { font-size: .9rem; color: #444; max-width: 48rem; } summary { cursor: pointer; }
</style>
</head>
<body>
<h1>$title</h1>
$lead
<nav><ul>
$contents
</ul></nav>
$sections
</body>
</html>
""")


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
    """The whole page; `lead` and the blocks of sections are HTML, titles are text."""
    return _PAGE.substitute(
        title=escape(title),
        lead="\n".join(lead),
        contents="\n".join(f'<li><a href="#{part.anchor}">{escape(part.title)}</a></li>' for part in sections),
        sections="\n".join(
            f'<section id="{part.anchor}">\n<h2>{escape(part.title)}</h2>\n{_joined(part.blocks)}\n</section>'
            for part in sections
        ),
    )


def _joined(blocks: Sequence[str]) -> str:
    return "\n".join(blocks)


def heading(text: str) -> str:
    """A heading within a section."""
    return f"<h3>{escape(text)}</h3>"


def paragraph(text: str) -> str:
    """Plain text."""
    return f"<p>{escape(text)}</p>"


def items(texts: Sequence[str]) -> str:
    """A list of plain texts."""
    return "<ul>\n" + "\n".join(f"<li>{escape(text)}</li>" for text in texts) + "\n</ul>"


def command(text: str) -> str:
    """A command line."""
    return f"<p><code>{escape(text)}</code></p>"


def table(caption: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of plain texts."""
    head = "".join(f"<th>{escape(cell)}</th>" for cell in header)
    body = "\n".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return (
        f'<div class="wide"><table>\n<caption>{escape(caption)}</caption>\n<thead><tr>{head}</tr></thead>\n'
        f"<tbody>\n{body}\n</tbody>\n</table></div>"
    )


def folded(summary: str, block: str) -> str:
    """HTML that shows when its summary is clicked."""
    return f"<details><summary>{escape(summary)}</summary>\n{block}\n</details>"


def picture(file: Path, caption: str) -> str:
    """A PNG file, embedded; the caption says what it shows and is read out where it cannot be seen."""
    data = base64.b64encode(file.read_bytes()).decode("ascii")
    told = escape(caption)
    return f'<figure><img alt="{told}" src="data:image/png;base64,{data}">\n<figcaption>{told}</figcaption></figure>'
