"""Names of the variables of the environment that settings read."""

from pydantic import BaseModel


def variables(model: type[BaseModel], prefix: str = "VOA_") -> set[str]:
    """Return the name of each variable of a model of settings, those of its parts included."""
    names = set()
    for name, field in model.model_fields.items():
        if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            names |= variables(field.annotation, f"{prefix}{name.upper()}__")
        else:
            names.add(f"{prefix}{name.upper()}")
    return names
