"""Self-contained HTML pages: no script, no style sheet and no picture in another file.

A page is made of sections, and a section of blocks, which are plain data; the HTML is in `templates/`. Equal content
gives equal bytes. A page can be read on a telephone: what is wider than the screen scrolls sideways in its own box.
"""

import base64
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

from jinja2 import Environment, PackageLoader, StrictUndefined

_NUMBER = re.compile(r"-?|[<> ]*[-+]?\d[-+\d.,/%()\[\]<> ]*(?:to [-+\d.]+ ?%?)?")
"""Texts that a column of numbers may hold: figures, counts, shares, intervals, and a dash for none."""
_LONG = 40
"""Characters from which a cell is a sentence: its column is not squeezed to one word per line."""
_DETAILED_PX = 800
"""Width from which a picture's labels would be too small on a telephone, so that it scrolls instead of shrinking."""


@dataclass(frozen=True)
class Heading:
    """A heading within a section."""

    kind: ClassVar[str] = "heading"
    text: str


@dataclass(frozen=True)
class Paragraph:
    """A paragraph of plain text."""

    kind: ClassVar[str] = "paragraph"
    text: str


@dataclass(frozen=True)
class Notice:
    """A paragraph in a frame, which no reader should miss."""

    kind: ClassVar[str] = "notice"
    text: str


@dataclass(frozen=True)
class Command:
    """A command line."""

    kind: ClassVar[str] = "command"
    text: str


@dataclass(frozen=True)
class Items:
    """A list of plain texts."""

    kind: ClassVar[str] = "items"
    texts: Sequence[str]


@dataclass(frozen=True)
class Lines:
    """Lines of a terminal; those that are too long for the screen are broken."""

    kind: ClassVar[str] = "lines"
    texts: Sequence[str]


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes:
        name: its heading.
        style: `number` (aligned to the right), `long` (a column of sentences) or "".
    """

    name: str
    style: str


@dataclass(frozen=True)
class Table:
    """A table of plain texts.

    Columns of numbers are aligned to the right, all others to the left. Where a column has sentences, a small screen
    shows each row as a card, with every cell below its heading.

    Attributes:
        caption: above the table; "": none.
        header: names of the columns.
        rows: cells, one text per column.
    """

    kind: ClassVar[str] = "table"
    caption: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]

    @property
    def columns(self) -> list[Column]:
        """Columns with their styles, which follow from the cells."""
        return [Column(name, _style_of([row[index] for row in self.rows])) for index, name in enumerate(self.header)]

    @property
    def as_cards(self) -> bool:
        """True if a column has sentences."""
        return any(column.style == "long" for column in self.columns)


def _style_of(cells: Sequence[str]) -> str:
    if cells and all(_NUMBER.fullmatch(cell) for cell in cells):
        return "number"
    return "long" if max(map(len, cells), default=0) > _LONG else ""


@dataclass(frozen=True)
class ShadedCell:
    """A cell of a shaded table.

    Attributes:
        text: content of the cell.
        share: darkness of the background, 0 (none) to 1.
    """

    text: str
    share: float

    @property
    def opacity(self) -> str:
        """Opacity of the background; at most 0.65, so that black text can be read on it."""
        return f"{0.65 * min(max(self.share, 0.0), 1.0):.2f}"


@dataclass(frozen=True)
class ShadedTable:
    """A table of figures whose cells are the darker the larger the figure; the first column stays in sight.

    Attributes:
        caption: above the table; "": none.
        header: names of the columns, that of the rows' names included.
        rows: name of each row, and its cells.
    """

    kind: ClassVar[str] = "shaded"
    caption: str
    header: Sequence[str]
    rows: Sequence[tuple[str, Sequence[ShadedCell]]]


@dataclass(frozen=True)
class Picture:
    """A PNG file that is embedded in the page.

    Attributes:
        file: is read when the block is made.
        caption: below the picture, and read out where it cannot be seen.
    """

    kind: ClassVar[str] = "picture"
    file: Path
    caption: str
    _content: bytes = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_content", self.file.read_bytes())

    @property
    def width(self) -> int:
        """Width in pixels."""
        return int.from_bytes(self._content[16:20], "big")  # of PNG's IHDR

    @property
    def height(self) -> int:
        """Height in pixels."""
        return int.from_bytes(self._content[20:24], "big")

    @property
    def detailed(self) -> bool:
        """True if the picture's labels would be too small on a narrow screen."""
        return self.width > _DETAILED_PX

    @property
    def data(self) -> str:
        """Content in base64."""
        return base64.b64encode(self._content).decode("ascii")


@dataclass(frozen=True)
class Folded:
    """Blocks that are hidden until the reader clicks on their summary."""

    kind: ClassVar[str] = "folded"
    summary: str
    blocks: "Sequence[Block]"


@dataclass(frozen=True)
class Abreast:
    """Pictures beside one another where the screen is wide enough, else below one another."""

    kind: ClassVar[str] = "abreast"
    pictures: Sequence[Picture]


Block = Heading | Paragraph | Notice | Command | Items | Lines | Table | ShadedTable | Picture | Abreast | Folded


@dataclass(frozen=True)
class Section:
    """A section of a page.

    Attributes:
        anchor: its name in addresses.
        title: its heading.
        blocks: in order.
    """

    anchor: str
    title: str
    blocks: Sequence[Block]


def write_page(
    file: Path, title: str, lead: Sequence[Block], sections: Sequence[Section], *, contents: bool = False
) -> None:
    """Write a page to a file.

    Args:
        file: the HTML file.
        title: of the page.
        lead: blocks before the first section.
        sections: in order.
        contents: True if a list of the sections with links to them follows the lead.
    """
    file.write_text(page(title, lead, sections, contents=contents), encoding="utf-8")


def page(title: str, lead: Sequence[Block], sections: Sequence[Section], *, contents: bool = False) -> str:
    """Render a page as HTML; the arguments are those of `write_page`."""
    templates = Environment(
        loader=PackageLoader("voa_fleet.show"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return templates.get_template("page.html").render(title=title, lead=lead, sections=sections, contents=contents)
