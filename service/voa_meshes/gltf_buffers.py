"""The numbers in a glTF file's buffers."""

import base64
import binascii
from dataclasses import dataclass
from typing import Any, TypeVar
from urllib.parse import unquote_to_bytes

import numpy as np
from numpy.typing import NDArray

from voa_meshes.gltf import MESHOPT, Accessor, Buffer, Document, named
from voa_meshes.triangles import Floats, Indices, UnreadableMesh

_COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_MOST_ELEMENTS = 2**31
_UNSIGNED = (5121, 5123, 5125)

T = TypeVar("T")
Numbers = NDArray[Any]


def item(items: list[T], index: int, noun: str) -> T:
    """Return the item at an index; raises UnreadableMesh where the list is shorter, with `noun` as the item's name."""
    if index >= len(items):
        raise UnreadableMesh(f"it refers to {noun} {index}, but has only {len(items)}")
    return items[index]


@dataclass(frozen=True, eq=False)
class Buffers:
    """The buffers of a glTF document; `binary` is the binary chunk of its GLB file, if there is one."""

    document: Document
    binary: bytes | None

    def vectors(self, index: int, type_: str) -> Floats:
        """Return the elements of an accessor as numbers (n, width); normalised integers are 0 to 1, or -1 to 1.

        Raises:
            UnreadableMesh: the accessor has another type, or its bytes are missing.
        """
        accessor = item(self.document.accessors, index, "accessor")
        if accessor.type != type_:
            raise UnreadableMesh(f"accessor {index}: expected {type_}, got {accessor.type[:20]!a}")
        elements = self._elements(index, accessor)
        values = elements.astype(np.float64)
        if not accessor.normalized:
            return values
        if elements.dtype.kind == "f" or elements.dtype.itemsize > 2:
            raise UnreadableMesh(f"accessor {index}: component type {accessor.component_type} cannot be normalised")
        return np.maximum(values / np.iinfo(elements.dtype).max, -1.0)

    def indices(self, index: int) -> Indices:
        """Return the elements of an accessor as indices (n,).

        Raises:
            UnreadableMesh: they are not unsigned whole numbers, or their bytes are missing.
        """
        accessor = item(self.document.accessors, index, "accessor")
        if accessor.type != "SCALAR" or accessor.component_type not in _UNSIGNED or accessor.normalized:
            raise UnreadableMesh(f"accessor {index}: expected unsigned whole numbers for indices")
        return self._elements(index, accessor).reshape(-1).astype(np.int64)

    def _elements(self, index: int, accessor: Accessor) -> Numbers:
        component, width = _COMPONENTS.get(accessor.component_type), _WIDTHS.get(accessor.type)
        if component is None or width is None:
            raise UnreadableMesh(
                f"accessor {index}: no glTF component type {accessor.component_type} of {accessor.type!a}"
            )
        if accessor.count > _MOST_ELEMENTS:
            raise UnreadableMesh(f"accessor {index}: expected at most {_MOST_ELEMENTS} elements, got {accessor.count}")
        dtype, shape = np.dtype(component), (accessor.count, width)
        if accessor.buffer_view is None:
            dense: Numbers = np.zeros(shape, dtype)
        else:
            dense = self._view(accessor.buffer_view, accessor.byte_offset, dtype, shape, f"accessor {index}")
        return dense if accessor.sparse is None else self._with_sparse(index, accessor, dense)

    def _with_sparse(self, index: int, accessor: Accessor, dense: Numbers) -> Numbers:
        """Replace the elements that the sparse part of an accessor lists."""
        sparse, noun = accessor.sparse, f"the sparse accessor {index}"
        assert sparse is not None  # noqa: S101 - checked by the caller
        if sparse.indices.component_type not in _UNSIGNED:
            raise UnreadableMesh(f"{noun}: expected unsigned whole numbers for indices")
        type_ = np.dtype(_COMPONENTS[sparse.indices.component_type])
        where = self._view(sparse.indices.buffer_view, sparse.indices.byte_offset, type_, (sparse.count, 1), noun)
        shape = (sparse.count, dense.shape[1])
        values = self._view(sparse.values.buffer_view, sparse.values.byte_offset, dense.dtype, shape, noun)
        places = where.reshape(-1).astype(np.int64)
        if len(places) and (places.max() >= accessor.count or (np.diff(places) <= 0).any()):
            raise UnreadableMesh(f"{noun}: expected rising indices below {accessor.count}")
        mixed = dense.copy()
        mixed[places] = values
        return mixed

    def _view(self, index: int, offset: int, dtype: np.dtype[Any], shape: tuple[int, int], noun: str) -> Numbers:
        """Return the elements (n, width) of a buffer view that begin at an offset."""
        view = item(self.document.buffer_views, index, "buffer view")
        content = self._bytes(view.buffer)
        size = dtype.itemsize * shape[1]
        stride = size if view.byte_stride is None else view.byte_stride
        ends = offset + stride * (shape[0] - 1) + size if shape[0] else offset
        compressed = next((name for name in MESHOPT if name in view.extensions), None)
        if stride < size or ends > view.byte_length or view.byte_offset + view.byte_length > len(content):
            if compressed is not None:
                raise UnreadableMesh(f"{named(compressed)} is not supported: export the mesh without it")
            raise UnreadableMesh(
                f"{noun}: expected {shape[0]} elements of {size} bytes in buffer view {index}, got fewer"
            )
        elements: Numbers = np.ndarray(
            shape, dtype, content, offset=view.byte_offset + offset, strides=(stride, dtype.itemsize)
        )
        return elements

    def _bytes(self, index: int) -> bytes:
        """Return the bytes of a buffer."""
        buffer = item(self.document.buffers, index, "buffer")
        content = self._content(index, buffer)
        if len(content) < buffer.byte_length:
            raise UnreadableMesh(
                f"buffer {index} claims {buffer.byte_length} bytes, the file has {len(content)}: export it again"
            )
        return content[: buffer.byte_length]

    def _content(self, index: int, buffer: Buffer) -> bytes:
        compressed = next((name for name in MESHOPT if name in buffer.extensions), None)
        if compressed is not None:
            raise UnreadableMesh(f"{named(compressed)} is not supported: export the mesh without it")
        if buffer.uri is None:
            if index != 0 or self.binary is None:
                raise UnreadableMesh(f"buffer {index} has no bytes in the file")
            return self.binary
        head, comma, data = buffer.uri.partition(",")
        if not head.startswith("data:") or not comma:
            raise UnreadableMesh(
                f"an external buffer is not supported, {buffer.uri[:40]!a}: export the mesh as one file"
            )
        try:
            return base64.b64decode(data, validate=True) if head.endswith(";base64") else unquote_to_bytes(data)
        except binascii.Error as error:
            raise UnreadableMesh(f"buffer {index} is marked as base64, but cannot be decoded") from error
