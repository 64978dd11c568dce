"""README.md and the documentation in parts that can be run: blocks of code, commands, and what they should print."""

import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]
DOCS = REPOSITORY / "deploy/docs"
DECISIONS = REPOSITORY / "deploy/decisions"
_BLOCK = re.compile(r"^( *)```(\w*)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)
_IDS = re.compile(r"\b[0-9a-f]{16}\b")
ANYTHING = "..."
"""A line that stands for any number of lines that a page leaves out."""


@dataclass(frozen=True)
class Block:
    """A block of code.

    Attributes:
        language: the word behind the three marks; may be empty.
        text: without the indentation of the list that it stands in.
        after: the text of the page behind it.
    """

    language: str
    text: str
    after: str


@dataclass(frozen=True)
class Command:
    """A command line behind a `$`, and the lines that follow it: what it prints, as far as the page says."""

    line: str
    output: tuple[str, ...]

    @property
    def words(self) -> list[str]:
        """The words as a shell splits them, without the comment and where the output goes."""
        words = shlex.split(self.line, comments=True)
        return words[: words.index(">")] if ">" in words else words

    @property
    def is_local(self) -> bool:
        """True if it runs on any machine: nothing is to be filled in, and no service, router or screen is named.

        Commands that run until they are ended, or for minutes, and those about a file of the reader's own, are left
        out too.
        """
        if self.words[1] in ("serve", "evaluate", "record", "new", "experiment", "calibrate"):
            return False
        if self.words[1] in ("keys", "backup", "restore", "prune", "console"):  # about the reader's own database
            return False
        files = [word for word in self.words if re.fullmatch(r"[\w./-]+\.(json|toml|mcap)", word)]
        if not all((REPOSITORY / file).is_file() for file in files):
            return False
        return not any(re.search(r"[A-Z]{2}|://|^--video$", word) for word in self.words)


class Page:
    """A Markdown file of the repository.

    Args:
        path: from the root of the repository.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self.text = (REPOSITORY / path).read_text(encoding="utf-8")

    def blocks(self, language: str | None = None) -> list[Block]:
        """Blocks of code in a language, all of them for None."""
        blocks = [
            Block(match[2], re.sub(rf"(?m)^{match[1]}", "", match[3]), self.text[match.end() :])
            for match in _BLOCK.finditer(self.text)
        ]
        return [block for block in blocks if language is None or block.language == language]

    def commands(self) -> list[Command]:
        """Every command line of every block, in order."""
        commands: list[Command] = []
        for block in self.blocks():
            for text in re.split(r"(?m)^\$ ", block.text)[1:]:
                line, *output = text.rstrip("\n").split("\n")
                commands.append(Command(line, tuple(output)))
        return commands

    def mentioned(self) -> list[Command]:
        """The commands that stand between the words."""
        return [Command(" ".join(line.split()), ()) for line in re.findall(r"(?<!`)`(voa [a-z][^`]*)`", self.text)]

    def program(self, word: str) -> Block:
        """The one program of the page with a word in it."""
        (block,) = [block for block in self.blocks("python") if word in block.text]
        return block


PAGES = [
    Page("README.md"),
    *(
        Page(path.relative_to(REPOSITORY).as_posix())
        for folder in (DOCS, DECISIONS)
        for path in sorted(folder.glob("*.md"))
    ),
]
"""README.md, the pages of the documentation, and the decision records, which are built with them."""
README = PAGES[0]


def page(name: str) -> Page:
    """The page of the documentation with a name, such as "quick-start"."""
    return Page(f"deploy/docs/{name}.md")


def agrees(stated: Sequence[str], printed: str) -> bool:
    """True if the stated lines are what was printed: all of it in order, but for ids, and for what `...` stands for.

    Spaces at the end of a line and empty lines do not count.
    """
    wanted, got = ([_plain(line) for line in lines if line.strip()] for lines in (stated, printed.splitlines()))
    pattern = "".join(r"(?:.*\n)*?" if line == ANYTHING else re.escape(line) + r"\n" for line in wanted)
    return re.fullmatch(pattern, "".join(line + "\n" for line in got)) is not None


def _plain(line: str) -> str:
    return _IDS.sub("ID", line.strip() if line.strip() == ANYTHING else line.rstrip())
