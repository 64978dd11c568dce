"""Names that people chose reach a page only as values, never as part of a text that the page parses.

NiceGUI parses the text of `.props(...)`, and a browser evaluates properties whose names begin with a colon: a name with
a quotation mark in it could add one.
"""

import ast

from tests.architecture.test_imports import PACKAGES, REPOSITORY, files_of

OF_OUR_OWN = {"checklists.py", "fields.py", "plane_section.py", "scan_panel.py", "start.py", "timeline.py"}
"""Files whose formatted properties hold numbers, and words of the console itself."""


def formatted_props(source: str) -> list[int]:
    """Lines of calls of `.props` with a text that is put together at run time."""
    return [
        node.lineno
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Attribute)
        and node.func.attr == "props"
        and not all(is_fixed(argument) for argument in node.args)
    ]


def is_fixed(node: ast.expr) -> bool:
    """True for a text of the source, a name, or a choice between such."""
    if isinstance(node, ast.IfExp):
        return is_fixed(node.body) and is_fixed(node.orelse)
    return isinstance(node, (ast.Constant, ast.Name))


def test_properties_are_set_by_value() -> None:
    folder = REPOSITORY / PACKAGES["voa_console"].folder
    formatted = {
        path.relative_to(folder).as_posix(): lines
        for path in files_of(folder)
        if path.name not in OF_OUR_OWN and (lines := formatted_props(path.read_text()))
    }
    assert not formatted


def test_the_test_sees_what_it_forbids() -> None:
    assert formatted_props('element.props(f"title={name}")') == [1]
    assert formatted_props('element.props("title=" + name)') == [1]
    assert formatted_props('element.props("dense").props["title"] = name') == []
