"""Sections as Markdown."""

import struct
from pathlib import Path

from voa_evaluation.report.markdown import markdown
from voa_fleet.show.page import (
    Abreast,
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


def test_every_block_becomes_markdown_and_of_folded_ones_text_alone(tmp_path: Path) -> None:
    file = tmp_path / "p.png"
    file.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(8) + struct.pack(">II", 4, 3))
    blocks = (
        Paragraph("Text."),
        Heading("Part"),
        Items(["one", "two"]),
        Table("Figures", ("name", "share"), [["a|b", "0.5"]]),
        Abreast([Picture(file, "Below.")]),
        Lines(["$ voa"]),
        Command("voa"),
        Notice("Beware."),
        Folded("more", [Paragraph("Hidden."), Table("Hidden", ("name",), [["a"]])]),
        Folded("how", [Paragraph("Folded text.")]),
    )
    assert markdown([Section("s", "Title", blocks)]).split("\n\n") == [
        "## Title",
        "Text.",
        "### Part",
        "- one\n- two",
        "**Figures**",
        "| name | share |\n| :-- | --: |\n| a&#124;b | 0.5 |",
        "![Below.](p.png)",
        "*Below.*",
        "```\n$ voa\n```",
        "`voa`",
        "Beware.",
        "Folded text.\n",
    ]
