"""Messages for ROS tools as CDR, written by rosbags. Import this module only where a message is to be written."""

from functools import cache
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from voa_ros.outputs.fields import Fields
from voa_ros.outputs.types import DEFINITIONS
from voa_ros.topics import MessageType

_ZERO: dict[str, Any] = {"bool": False, "string": "", "float32": 0.0, "float64": 0.0}


class UnknownFields(ValueError):
    """Error for a message with fields that its type does not have; its text names them."""


class Encoder:
    """Writer of messages of the types that ROS tools read: those of rosbags for Jazzy, and `DEFINITIONS`.

    For use in one thread.
    """

    def __init__(self) -> None:
        self.types: Typestore = get_typestore(Stores.ROS2_JAZZY)
        for name, definition in DEFINITIONS.items():
            self.types.register(get_types_from_msg(definition, name))
        self.type = cache(self._type)
        self._built: dict[int, list[Any]] = {}
        """Sequences of messages that were built in this call, by the identity of their fields: meshes share them."""

    def _type(self, name: str) -> MessageType:
        """Return a type with its hash, by its name."""
        return MessageType(name, self.types.hash_rihs01(name))

    def encode(self, name: str, fields: Fields) -> bytes:
        """Write a message as CDR with its header of four bytes, little endian.

        Args:
            name: of its type.
            fields: by name; a field that is left out is 0, "", or empty.

        Raises:
            UnknownFields: the type has no such field.
        """
        self._built.clear()
        message = self._message(name, fields)
        self._built.clear()
        return bytes(self.types.serialize_cdr(message, name))

    def _message(self, name: str, fields: Fields) -> Any:
        _, defined = self.types.fielddefs[name]
        unknown = fields.keys() - {field for field, _ in defined}
        if unknown:
            raise UnknownFields(f"{name}: expected fields of the type, got {', '.join(sorted(unknown))} too")
        values = {field: self._value(kind, fields.get(field)) for field, kind in defined}
        return self.types.types[name](**values)

    def _value(self, kind: Any, given: Any) -> Any:
        node, about = kind
        match node:
            case Nodetype.BASE:
                return _ZERO.get(about[0], 0) if given is None else given
            case Nodetype.NAME:
                return self._message(about, {} if given is None else given)
            case _:
                item, count = about
                return self._values(item, count if node == Nodetype.ARRAY else 0, given)

    def _values(self, item: Any, count: int, given: Any) -> Any:
        """Return a sequence, or an array of `count` items; numbers as an array of numpy, as rosbags expects."""
        node, about = item
        if node == Nodetype.BASE and about[0] != "string":
            return np.array([0] * count if given is None else given, dtype=about[0])
        values = [None] * count if given is None else given
        if node != Nodetype.NAME or given is None:
            return [self._value(item, each) for each in values]
        if id(given) not in self._built:
            self._built[id(given)] = [self._value(item, each) for each in values]
        return self._built[id(given)]
