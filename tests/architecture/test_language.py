"""The language of the code: docstrings that stand alone, and the words that the glossary retires."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.architecture.test_imports import PACKAGES, REPOSITORY, files_of

GLOSSARY = REPOSITORY / "deploy" / "docs" / "glossary.md"
NAMES_ONLY = "(only in names)"
LEANING = re.compile(
    r"^(the same|as (above|before|there|in|for|with|of|the|it|they)|likewise|ditto|see|what|whatever|which|where"
    r"|whether|how|who|why|when|one(?! of)|everything|something|anything|nothing|nobody|it|they|there|this|these|those"
    r"|in|of|for|from|at|by|beside|so|and|or|also|another)\b",
    re.IGNORECASE,
)
"""Beginnings of docstrings that need a neighbour, or that are no sentence about their own subject."""
BACKWARDS = re.compile(r"\b(as above|see above|the one above|the one below|as below)\b", re.IGNORECASE)


def retired() -> dict[str, bool]:
    """Each retired word of the glossary, and whether only names must not have it."""
    table = GLOSSARY.read_text().split("## Retired words")[1]
    rows = [
        line.strip("|").split("|") for line in table.splitlines() if line.startswith("| ") and "retired" not in line
    ]
    return {word.strip(): NAMES_ONLY in use for words, use in rows for word in words.split(",")}


def names(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Every name that a module gives, with its line."""
    for node in ast.walk(tree):
        match node:
            case ast.FunctionDef() | ast.AsyncFunctionDef() | ast.ClassDef():
                yield node.lineno, node.name
            case ast.arg():
                yield node.lineno, node.arg
            case ast.Name(ctx=ast.Store()):
                yield node.lineno, node.id
            case ast.Attribute(ctx=ast.Store()):
                yield node.lineno, node.attr


def texts(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Every string with a space in it: docstrings, messages, help."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
            yield node.lineno, node.value


def docstrings(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Docstrings of public modules, classes, functions, and attributes."""
    yield 1, ast.get_docstring(tree) or ""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and not node.name.startswith("_"):
            yield node.lineno, ast.get_docstring(node) or ""
        if isinstance(node, ast.Module | ast.ClassDef):
            for before, after in zip(node.body, node.body[1:], strict=False):
                if (
                    isinstance(before, ast.Assign | ast.AnnAssign)
                    and isinstance(after, ast.Expr)
                    and isinstance(after.value, ast.Constant)
                    and isinstance(after.value.value, str)
                ):
                    yield after.lineno, after.value.value


def parts(name: str) -> set[str]:
    """The words of a name: of snake_case and of CamelCase."""
    return {word.lower() for word in re.split(r"_|(?<=[a-z0-9])(?=[A-Z])", name) if word} | {name.lower().strip("_")}


def wrong_names(tree: ast.AST, words: dict[str, bool]) -> list[tuple[int, str]]:
    return [(line, name) for line, name in names(tree) if parts(name) & words.keys() and name not in ON_THE_WIRE]


def wrong_texts(tree: ast.AST, words: dict[str, bool]) -> list[tuple[int, str]]:
    pattern = re.compile(
        rf"\b({'|'.join(word for word, names_only in words.items() if not names_only)})\b", re.IGNORECASE
    )
    return [(line, text[:80]) for line, text in texts(tree) if pattern.search(text)]


ON_THE_WIRE = {"not_found", "NotFound", "NotFoundError"}
"""Names that HTTP gives: 404 Not Found."""
FOLDERS = {name: package.folder for name, package in PACKAGES.items()} | {
    name: name for name in ("tests", "deploy", "clients/examples")
}
"""Folders whose Python files are checked: of each package, and of programs and tests around them."""


def sources(folder: str) -> list[Path]:
    """Python files of a folder, without this one, whose examples break the rule on purpose."""
    return [path for path in files_of(REPOSITORY / folder) if path.resolve() != Path(__file__).resolve()]


@pytest.mark.parametrize("folder", FOLDERS.values(), ids=FOLDERS)
def test_no_retired_word_is_used(folder: str) -> None:
    words = retired()
    wrong = [
        f"{path.relative_to(REPOSITORY)}:{line}: {what}"
        for path in sources(folder)
        for tree in [parsed(path)]
        for line, what in [*wrong_names(tree, words), *wrong_texts(tree, words)]
    ]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("folder", FOLDERS.values(), ids=FOLDERS)
def test_docstrings_stand_alone(folder: str) -> None:
    wrong = [
        f"{path.relative_to(REPOSITORY)}:{line}: {text.splitlines()[0][:80]}"
        for path in sources(folder)
        for line, text in docstrings(parsed(path))
        if text and (LEANING.match(text) or BACKWARDS.search(text))
    ]
    assert not wrong, "\n".join(wrong)


def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


@pytest.mark.parametrize(
    ("source", "wrong"),
    [
        ("told = 1", True),
        ("def hear(): ...", True),
        ("class FoundLook: ...", True),
        ("raise ValueError('the thing is wrong')", True),
        ("raise ValueError('not found')", False),
        ("class NotFound: ...", False),
        ("received = 'the answer'", False),
    ],
)
def test_the_rule_catches_what_it_should(source: str, wrong: bool) -> None:
    tree = ast.parse(source)
    assert bool(wrong_names(tree, retired()) or wrong_texts(tree, retired())) is wrong


@pytest.mark.parametrize(
    ("text", "leans"),
    [
        ("The same for any sensor poses.", True),
        ("What a caller gets.", True),
        ("Whether a scan is a look.", True),
        ("Rank the given sensor poses by Value of Assistance.", False),
        ("One of finitely many poses.", False),
        ("A scan of one revolution.", False),
        ("Asynchronous client.", False),
    ],
)
def test_the_rule_of_docstrings_catches_what_it_should(text: str, leans: bool) -> None:
    assert bool(LEANING.match(text)) is leans
