"""Markdown of a page's sections, for the documentation: without what the page folds away."""

from collections.abc import Sequence

from voa_fleet.show.page import (
    Abreast,
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
    Table,
)


def markdown(sections: Sequence[Section]) -> str:
    """Render sections as Markdown; pictures are linked by their file names.

    Folded blocks are left out, unless they are paragraphs alone.
    """
    parts = []
    for section in sections:
        parts.append(f"## {section.title}")
        for block in section.blocks:
            if not isinstance(block, Folded):
                parts.append(_block(block))
            elif all(isinstance(inner, Paragraph) for inner in block.blocks):
                parts += [_block(inner) for inner in block.blocks]
    return "\n\n".join(parts) + "\n"


def _block(block: Block) -> str:
    match block:
        case Heading(text):
            text = f"### {text}"
        case Items(texts):
            text = "\n".join(f"- {text}" for text in texts)
        case Table():
            text = _table(block)
        case Picture(file, caption):
            text = f"![{caption}]({file.name})\n\n*{caption}*"
        case Abreast(pictures):
            text = "\n\n".join(_block(picture) for picture in pictures)
        case Lines(texts):
            text = "\n".join(["```", *texts, "```"])
        case Command(text):
            text = f"`{text}`"
        case Paragraph(text) | Notice(text):
            pass
        case Folded():
            raise TypeError("expected a block that is not folded, got a folded one")
    return text


def _table(table: Table) -> str:
    lines = [f"**{table.caption}**", ""] if table.caption else []
    lines.append(_row(table.header))
    lines.append(_row(["--:" if column.style == "number" else ":--" for column in table.columns]))
    return "\n".join([*lines, *(_row(row) for row in table.rows)])


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cell.replace('|', '&#124;') for cell in cells)} |"
