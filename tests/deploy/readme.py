"""README.md in parts that can be run: its blocks of code, the commands in them, and what it says they print."""

import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]
README = (REPOSITORY / "README.md").read_text(encoding="utf-8")
_BLOCK = re.compile(r"^( *)```(\w*)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)
_IDS = re.compile(r"\b[0-9a-f]{16}\b")
ANYTHING = "..."
"""A line that stands for any number of lines that the README leaves out."""


@dataclass(frozen=True)
class Block:
    """A block of code.

    Attributes:
        language: what stands behind the three marks; may be empty.
        text: without the indentation of the list that it stands in.
        before: the text of the README up to it.
        after: the text behind it.
    """

    language: str
    text: str
    before: str
    after: str


@dataclass(frozen=True)
class Command:
    """A command line behind a `$`, and the lines that follow it: what it prints, as far as the README says."""

    line: str
    output: tuple[str, ...]

    @property
    def words(self) -> list[str]:
        """As a shell splits them, without the comment and where the output goes."""
        words = shlex.split(self.line, comments=True)
        return words[: words.index(">")] if ">" in words else words

    @property
    def is_local(self) -> bool:
        """Whether it runs on any machine: nothing in it is to be filled in, and no service, router or screen is named.

        What runs until it is ended, or for minutes, is left out too.
        """
        if self.words[:2] in (["voa", "serve"], ["voa", "evaluate"]):
            return False
        return not any(re.search(r"[A-Z]{2}|://|^--video$", word) for word in self.words)


def blocks(language: str | None = None) -> list[Block]:
    """The blocks of a language, all of them for None."""
    found = [
        Block(
            match[2],
            re.sub(rf"(?m)^{match[1]}", "", match[3]),
            README[: match.start()],
            README[match.end() :],
        )
        for match in _BLOCK.finditer(README)
    ]
    return [block for block in found if language is None or block.language == language]


def commands() -> list[Command]:
    """Every command line of every block, in order."""
    found: list[Command] = []
    for block in blocks():
        for text in re.split(r"(?m)^\$ ", block.text)[1:]:
            line, *output = text.rstrip("\n").split("\n")
            found.append(Command(line, tuple(output)))
    return found


def mentioned() -> list[Command]:
    """The commands that stand between the words."""
    return [Command(" ".join(line.split()), ()) for line in re.findall(r"(?<!`)`(voa [a-z][^`]*)`", README)]


def agrees(stated: Sequence[str], printed: str) -> bool:
    """Whether the stated lines are what was printed: all of it in order, but for ids, and for what `...` stands for.

    Spaces at the end of a line and empty lines do not count.
    """
    wanted, found = ([_plain(line) for line in lines if line.strip()] for lines in (stated, printed.splitlines()))
    pattern = "".join(r"(?:.*\n)*?" if line == ANYTHING else re.escape(line) + r"\n" for line in wanted)
    return re.fullmatch(pattern, "".join(line + "\n" for line in found)) is not None


def _plain(line: str) -> str:
    return _IDS.sub("ID", line.strip() if line.strip() == ANYTHING else line.rstrip())
