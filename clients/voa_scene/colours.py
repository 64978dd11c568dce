"""Colours that people with any common form of colour blindness can distinguish: the set of Okabe and Ito (2008).

No meaning rests on a colour alone: shapes with a meaning also have a label.
"""

from voa_scene.shapes import Colour


def _colour(code: str) -> Colour:
    return Colour(*(round(int(code[start : start + 2], 16) / 255.0, 4) for start in (1, 3, 5)))


ORANGE = _colour("#e69f00")
SKY_BLUE = _colour("#56b4e9")
GREEN = _colour("#009e73")
YELLOW = _colour("#f0e442")
BLUE = _colour("#0072b2")
VERMILION = _colour("#d55e00")
PURPLE = _colour("#cc79a7")
GREY = _colour("#8c8c8c")
"""Colour of what exists without being judged, visible on light and dark backgrounds."""
TABLE = _colour("#b9b3a6")
"""Colour of the table."""
