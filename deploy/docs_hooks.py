"""Hooks of `make docs`: they add the decision records, which lie beside the pages, and make links to them work."""

from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

DECISIONS = Path(__file__).parent / "decisions"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add every decision record as a page below `decisions/`."""
    for record in sorted(DECISIONS.glob("*.md")):
        files.append(File.generated(config, f"decisions/{record.name}", abs_src_path=str(record)))
    return files


def on_page_markdown(markdown: str, /, *, page: Page, config: MkDocsConfig, files: Files) -> str:  # noqa: ARG001 - the hook's form
    """Turn links to the folder of the decision records into links within the built pages."""
    return markdown.replace("](../decisions/", "](decisions/")
