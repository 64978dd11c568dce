"""Small Python packages that provide update rules, as pip would leave them in a folder."""

from collections.abc import Mapping
from pathlib import Path


def write_package(folder: Path, name: str, source: str, rules: Mapping[str, str]) -> Path:
    """Write a package of one module, with entry points of the group `voa.rules`.

    Args:
        folder: to be put on the path of Python.
        name: of the module, and of the distribution.
        source: of the module.
        rules: names of rules with the factory of each, such as "module:factory".
    """
    (folder / f"{name}.py").write_text(source)
    facts = folder / f"{name}-1.0.dist-info"
    facts.mkdir(parents=True)
    (facts / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    lines = [f"{rule} = {factory}" for rule, factory in rules.items()]
    (facts / "entry_points.txt").write_text("\n".join(["[voa.rules]", *lines, ""]))
    return folder
