"""Packs the responses to writes: the belief of a response, which the history has already, is not stored twice.

The belief of a packed response is left out, and the rest compressed by zlib with a dictionary of names that responses
have. It is read back byte for byte, and a checksum notices whatever was damaged.
"""

import base64
import json
import re
import zlib

import numpy as np

_MARK = "z1:"
"""Beginning of a packed response; others begin with a brace. Another dictionary or way to pack needs another mark."""
_BELIEF = b"\0"
"""Stands for the belief in the compressed text; JSON never has it."""
_CHECKSUM_BYTES = 4
_SMALL = re.compile(r"(?<=[\[,])(\d)\.?(\d*)e-05")
_NAMES = (
    b"there is no workspace: walls and people that the lidar sees count as the object. Give the box of the tab"
    b'le in which the object can be","poses":null,"sensors":null},{"kind":"poor-fit","detail":"even pose \'P\', '
    b"which fits best, is  mm off over the  beams that hit it;  mm are expected. Is it the object, and does it"
    b' lie at one of the poses? Does the sensor stand where the scan says?","poses":["P"],"sensors":null}],"id'
    b'":"","places":[{"sensor":null,"sensor_pose":{"x":0.0,"y":0.0,"yaw_rad":0.0,"height_m":null,"std":null},"'
    b'looks":1},{"sensor":"","sensor_pose":null,"looks":1}],"under_way":[],"created_at":"2026-11-2026-12-2027-'
    b'01-T00:00:00.000000Z","updated_at":"2027-","update":{"accepted":false,"reason":"bad_fit","no_match","not'
    b'hing_seen","accepted":true,"reason":null,"log_evidence":-,"fit_rmsd_mm":,"fit_hit_rmsd_mm":,"best_fit_po'
    b'se":"P","beams_compared":360}}{"scenario":"","version":,"poses":["P1","P2","P3"],"belief":\0,"best_grasp"'
    b':"","expected_score":0.,"entropy_nats":0.,"absent":null,"last_fit_rmsd_mm":,"warnings":[],"id":"","place'
    b's":[{"kind":"no-workspace","detail":"'
)
"""Dictionary of zlib: what stands near its end costs least to refer to."""


def pack(body: str, belief: bytes) -> str:
    """Pack the body of a response.

    Args:
        body: JSON.
        belief: of the session at the version that the response reports, as it is stored.

    Returns:
        Text of ASCII characters, which `unpack` reads; the body itself where that is shorter.
    """
    whole = body.encode("utf-8", "surrogatepass")
    packer = zlib.compressobj(zdict=_NAMES)
    packed = packer.compress(whole.replace(_numbers(belief), _BELIEF)) + packer.flush()
    checksum = zlib.crc32(whole).to_bytes(_CHECKSUM_BYTES, "big")
    text = _MARK + base64.b64encode(checksum + packed).decode("ascii")
    return text if len(text) < len(body) else body


def is_packed(stored: str) -> bool:
    """True if a stored response is packed."""
    return stored.startswith(_MARK)


def unpack(stored: str, belief: bytes) -> str:
    """Read a packed response back.

    Args:
        stored: by `pack`.
        belief: with which it was packed.

    Raises:
        ValueError: the response, or the belief, differs from what was written.
    """
    unpacker = zlib.decompressobj(zdict=_NAMES)
    try:
        packed = base64.b64decode(stored.removeprefix(_MARK), validate=True)
        whole = unpacker.decompress(packed[_CHECKSUM_BYTES:]).replace(_BELIEF, _numbers(belief))
    except zlib.error as error:
        raise ValueError(f"a stored response cannot be unpacked: {error}") from error
    if zlib.crc32(whole) != int.from_bytes(packed[:_CHECKSUM_BYTES], "big"):
        raise ValueError("a stored response, or its belief, differs from what was written")
    return whole.decode("utf-8", "surrogatepass")


def _numbers(belief: bytes) -> bytes:
    """Write the probabilities of a stored belief as responses do: in JSON, with 0.00001 and 1e-6.

    Stored responses depend on every byte of it. Where a response writes numbers otherwise, it is packed with them.
    """
    p = np.frombuffer(belief, dtype="<f8").reshape(2, -1)[0]
    numbers = json.dumps(p.tolist(), separators=(",", ":"))
    return _SMALL.sub(r"0.0000\1\2", numbers).replace("e-0", "e-").encode("ascii")
