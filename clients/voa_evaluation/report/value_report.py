"""Report of an evaluation of values: its sections, with pictures, and the files `report.html` and `report.md`."""

from collections.abc import Sequence
from pathlib import Path

from voa_evaluation.report.markdown import markdown
from voa_evaluation.report.several_section import several_section
from voa_evaluation.report.value_answer import VALUE_LEAD, answer_section
from voa_evaluation.report.value_pictures import write_value_pictures
from voa_evaluation.report.value_rows import Shown
from voa_evaluation.report.value_sections import limits_section, promise_section, ways_section
from voa_evaluation.values.results import Values
from voa_fleet.show.page import Block, Command, Folded, Paragraph, Section, write_page

PAGE, TEXT = "report.html", "report.md"
VALUE_TITLE = "What is a look worth?"


def value_sections(folder: Path, values: Values) -> list[Section]:
    """Draw the pictures of an evaluation of values into a folder, and write its sections, the answer first."""
    shown = Shown(values)
    pictures = write_value_pictures(folder, shown)
    return [
        answer_section(shown, pictures),
        promise_section(shown),
        ways_section(shown, pictures),
        several_section(shown),
        limits_section(shown),
    ]


def paper_section(lead: Sequence[Block], parts: Sequence[Section]) -> Section:
    """Put the parts of the paper's own evaluation under one heading, each folded.

    Args:
        lead: blocks before the parts.
        parts: a section for each part.
    """
    folded = [Folded(part.title, part.blocks) for part in parts]
    return Section("paper", "The paper's own evaluation", (*lead, *folded))


def write_report(folder: Path, first: Sequence[Block], sections: Sequence[Section], command: str) -> dict[str, Path]:
    """Write the page, and the text of its sections as Markdown for the documentation; return their paths.

    Args:
        folder: of the files.
        first: blocks before all others, such as a notice.
        sections: of the page; the answer first.
        command: command line that gives the page again.
    """
    lead: list[Block] = [
        *first,
        Paragraph(VALUE_LEAD),
        Folded(
            "the command behind this page",
            [
                Paragraph(
                    "The CSV files in the same folder hold the rows behind every figure. This command on the same "
                    "machine and versions gives this page again, byte for byte:"
                ),
                Command(command),
            ],
        ),
    ]
    write_page(folder / PAGE, VALUE_TITLE, lead, sections)
    text = "\n\n".join([f"# {VALUE_TITLE}", VALUE_LEAD, markdown(sections)])
    (folder / TEXT).write_text(text, encoding="utf-8")
    return {"page": folder / PAGE, "text": folder / TEXT}
