"""The option `--picture FILE`, which several commands have."""

import argparse
from pathlib import Path

ENDINGS = (".png", ".svg")
"""Endings of the files that can be written, in lower case."""


def add_picture_option(parser: argparse.ArgumentParser, content: str) -> None:
    """Add `--picture FILE` to a parser; `content` completes the help text "draw ... into FILE"."""
    parser.add_argument(
        "--picture",
        type=picture_file,
        metavar="FILE",
        help=f"draw {content} into FILE, which ends in .png or .svg",
    )


def picture_file(text: str) -> Path:
    """Read the path of a picture that is to be written; raises ArgumentTypeError for a wrong ending or folder."""
    file = Path(text)
    if file.suffix.lower() not in ENDINGS:
        raise argparse.ArgumentTypeError(f"expected a file name that ends in .png or .svg, got {text!r}")
    if not file.parent.is_dir():
        raise argparse.ArgumentTypeError(f"there is no folder {str(file.parent)!r} for the picture")
    return file
