"""Certificates that tests make: an authority, and certificates that it issues, as files."""

from pathlib import Path
from typing import NamedTuple

import trustme

HOSTS = ("127.0.0.1", "localhost")


class Certificate(NamedTuple):
    """Files of a certificate and of its private key."""

    certificate: str
    key: str


class Authority:
    """Authority of a laboratory, with its files in a folder.

    Args:
        folder: for all files; made where it does not exist.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder = folder
        self._own = trustme.CA()
        self.file = str(folder / "ca.pem")
        self._own.cert_pem.write_to_path(self.file)

    def issue(self, name: str, hosts: tuple[str, ...] = HOSTS) -> Certificate:
        """Issue a certificate with a common name, for host names and addresses."""
        issued = self._own.issue_cert(*hosts, common_name=name)
        certificate, key = self._folder / f"{name}.pem", self._folder / f"{name}.key"
        certificate.write_bytes(b"".join(blob.bytes() for blob in issued.cert_chain_pems))
        issued.private_key_pem.write_to_path(str(key))
        return Certificate(str(certificate), str(key))
