"""The page that the demo leaves: one HTML file with its pictures inside."""

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: #1a1a1a;
  background: #fff; }
h1 { font-size: 1.7rem; } h2 { font-size: 1.25rem; margin-top: 2.2rem; }
img { max-width: 100%; border: 1px solid #ddd; }
figure { margin: 1rem 0; } figcaption { color: #555; font-size: .9rem; }
pre { background: #f5f5f5; padding: .8rem; overflow-x: auto; font-size: .82rem; }
table { border-collapse: collapse; } th, td { border: 1px solid #ccc; padding: .3rem .7rem; text-align: left; }
"""


@dataclass(frozen=True)
class Picture:
    """A PNG file, and what to read in it."""

    file: Path
    caption: str


@dataclass(frozen=True)
class Chapter:
    """A part of the page.

    Attributes:
        title: above it.
        text: paragraphs, plain.
        lines: of the terminal, as they were printed.
        pictures: below.
        table: heading first; all cells are plain text.
    """

    title: str
    text: tuple[str, ...] = ()
    lines: tuple[str, ...] = ()
    pictures: tuple[Picture, ...] = ()
    table: tuple[tuple[str, ...], ...] = ()


def write_page(file: Path, title: str, chapters: Sequence[Chapter]) -> None:
    """Write the page; it needs no other file."""
    body = "\n".join(_chapter(chapter) for chapter in chapters)
    file.write_text(
        f'<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta name="viewport" content="width=device-width">\n<title>{escape(title)}</title>\n'
        f"<style>{_STYLE}</style>\n</head>\n<body>\n<h1>{escape(title)}</h1>\n{body}\n</body>\n</html>\n",
        encoding="utf-8",
    )


def _chapter(chapter: Chapter) -> str:
    parts = [f"<h2>{escape(chapter.title)}</h2>"]
    parts += [f"<p>{escape(paragraph)}</p>" for paragraph in chapter.text]
    if chapter.table:
        heading, *rows = chapter.table
        cells = "".join(f"<th>{escape(cell)}</th>" for cell in heading)
        parts.append(f"<table><tr>{cells}</tr>")
        parts += ["<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows]
        parts.append("</table>")
    if chapter.lines:
        parts.append(f"<pre>{escape(chr(10).join(chapter.lines))}</pre>")
    parts += [_picture(picture) for picture in chapter.pictures]
    return "\n".join(parts)


def _picture(picture: Picture) -> str:
    content = base64.b64encode(picture.file.read_bytes()).decode("ascii")
    alt = escape(picture.caption, quote=True)
    return (
        f'<figure><img src="data:image/png;base64,{content}" alt="{alt}">'
        f"<figcaption>{escape(picture.caption)}</figcaption></figure>"
    )
