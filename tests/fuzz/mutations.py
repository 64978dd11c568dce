"""Small damages to a mesh file, as editors, programs and transfers do them."""

import json
import random
import re
import struct
from collections.abc import Callable

Mutation = Callable[[bytes, random.Random], bytes]

_NUMBER = re.compile(rb"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.])")
_NUMBERS = b"0 -1 1 3 4 13 99 -13 0.5 1e3 -0.01 1e300 nan inf 1e400 x".split()
_WORDS = [*b"f v vn l # facet solid endsolid vertex element".split(), b"\\\n", b"\t", b"\r", b"\0"]


def change_a_byte(content: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(content))
    return content[:at] + bytes([rng.randrange(256)]) + content[at + 1 :]


def flip_a_bit(content: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(content))
    return content[:at] + bytes([content[at] ^ 1 << rng.randrange(8)]) + content[at + 1 :]


def leave_bytes_out(content: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(content))
    return content[:at] + content[at + rng.choice([1, 2, 4, 12, 13, 50]) :]


def double_bytes(content: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(content))
    return content[: at + rng.choice([1, 4, 12, 13, 50, 100])] + content[at:]


def cut_off(content: bytes, rng: random.Random) -> bytes:
    return content[: rng.randrange(len(content))]


def add_behind(content: bytes, rng: random.Random) -> bytes:
    return content + rng.choice([bytes(rng.randrange(1, 120)), rng.randbytes(rng.randrange(1, 120)), content[-50:]])


def change_a_number(content: bytes, rng: random.Random) -> bytes:
    numbers = list(_NUMBER.finditer(content))
    if not numbers:
        return change_a_byte(content, rng)
    chosen = rng.choice(numbers)
    return content[: chosen.start()] + rng.choice(_NUMBERS) + content[chosen.end() :]


def add_a_word(content: bytes, rng: random.Random) -> bytes:
    blanks = [k for k, byte in enumerate(content) if byte in b" \n"]
    at = rng.choice(blanks) if blanks else 0
    return content[:at] + b" " + rng.choice(_WORDS) + content[at:]


def _of_lines(change: Callable[[list[bytes], random.Random], None]) -> Mutation:
    def mutate(content: bytes, rng: random.Random) -> bytes:
        lines = content.split(b"\n")
        change(lines, rng)
        return b"\n".join(lines)

    mutate.__name__ = change.__name__
    return mutate


@_of_lines
def leave_a_line_out(lines: list[bytes], rng: random.Random) -> None:
    del lines[rng.randrange(len(lines))]


@_of_lines
def double_a_line(lines: list[bytes], rng: random.Random) -> None:
    lines.insert(rng.randrange(len(lines)), rng.choice(lines))


@_of_lines
def swap_lines(lines: list[bytes], rng: random.Random) -> None:
    a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
    lines[a], lines[b] = lines[b], lines[a]


@_of_lines
def join_lines(lines: list[bytes], rng: random.Random) -> None:
    at = rng.randrange(len(lines))
    lines[at : at + 2] = [b" ".join(lines[at : at + 2])]


def change_the_document(content: bytes, rng: random.Random) -> bytes:
    """Change a number in the JSON of a GLB file and keep the lengths of its chunks right."""
    (length,) = struct.unpack_from("<I", content, 12)
    text, rest = content[20 : 20 + length], content[20 + length :]
    text = change_a_number(text, rng) if rng.random() < 0.7 else _without_a_key(text, rng)
    text += b" " * (-len(text) % 4)
    whole = struct.pack("<II", len(text), 0x4E4F534A) + text + rest
    return struct.pack("<III", 0x46546C67, 2, 12 + len(whole)) + whole


def _without_a_key(text: bytes, rng: random.Random) -> bytes:
    document = json.loads(text)
    node = document
    while isinstance(node, dict | list) and node:
        key = rng.choice(sorted(node)) if isinstance(node, dict) else rng.randrange(len(node))
        if not isinstance(node[key], dict | list) or rng.random() < 0.2:
            del node[key]
            break
        node = node[key]
    return json.dumps(document).encode()


BYTES: list[Mutation] = [change_a_byte, flip_a_bit, leave_bytes_out, double_bytes, cut_off, add_behind]
TEXT: list[Mutation] = [change_a_number, change_a_number, add_a_word]
TEXT += [leave_a_line_out, double_a_line, swap_lines, join_lines]
