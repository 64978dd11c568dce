"""A guess at the unit in which a mesh file was drawn, from the size of the object."""

SMALL_M, LARGE_M = 3e-3, 3.0
"""Range of sizes, in metres, of most objects that an arm grasps."""
_UNITS = {"metres": 1.0, "millimetres": 1e-3, "centimetres": 1e-2}


def unit_hint(size_m: float, scale: float) -> str:
    """Suggest scales for a mesh file whose object has an unlikely size.

    Args:
        size_m: longest side of the object's bounding box in metres, with `scale` applied.
        scale: metres per unit of the file, as the caller gave it.

    Returns:
        A sentence that names the scales under which the object measures `SMALL_M` to `LARGE_M`.
    """
    drawn = size_m / scale
    units = [f"{unit} (scale={metres:g})" for unit, metres in _UNITS.items() if SMALL_M <= drawn * metres <= LARGE_M]
    if not units:
        return "is `scale` right? It is metres per unit of the file"
    return f"is `scale` right? The file may be in {' or '.join(units)}"
