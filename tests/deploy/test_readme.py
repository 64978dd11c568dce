"""What the README shows is what the programs take."""

import ast
import re
from pathlib import Path

from voa_ros.robots import load

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    """The code blocks of a language, without the indentation of the list that they stand in."""
    found = re.findall(rf"^( *)```{language}\n(.*?)^ *```$", README, re.MULTILINE | re.DOTALL)
    return [re.sub(rf"(?m)^{indentation}", "", text) for indentation, text in found]


def test_the_mapping_is_one() -> None:
    (mapping,) = blocks("toml")
    (robot,) = load(mapping)
    assert [each.topic for each in robot.subscriptions] == ["tb3_1/scan", "tb3_1/odom"]
    assert robot.look.scans == 10


def test_the_programs_import_what_exists() -> None:
    programs = blocks("python")
    assert len(programs) == 2
    for program in programs:
        imports: list[ast.stmt] = [
            node for node in ast.parse(program).body if isinstance(node, ast.Import | ast.ImportFrom)
        ]
        exec(compile(ast.Module(imports, []), "README.md", "exec"), {})  # noqa: S102 - our own text


def test_links_lead_somewhere() -> None:
    root = Path(__file__).parents[2]
    for target in re.findall(r"\]\(((?!http)[^)#]+)\)", README):
        assert (root / target).exists(), target
