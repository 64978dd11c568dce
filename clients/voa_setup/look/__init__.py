"""The page `look.html` of a scenario: pictures by which a person judges whether it is right.

| to                                                        | see                    |
|-----------------------------------------------------------|------------------------|
| write the page                                            | `page`                 |
| write its sections                                        | `sections`, `tables`   |
| work out what they show, and write scores as words        | `shown`, `scores`      |
| draw a rest, a grasp, the outlines, the places            | `drawings`, `panels`   |
| draw a mesh as a shaded picture                           | `shading`              |
| look at the world from the front, above or across fingers | `views`                |
| cut the object at the height of the lidar                 | `outlines`             |
| group poses that rest on the table in one way             | `groups`               |
| draw a gripper that has closed at a grasp                 | `glyphs`               |
"""

from voa_setup.look.page import LOOK, write_look

__all__ = ["LOOK", "write_look"]
