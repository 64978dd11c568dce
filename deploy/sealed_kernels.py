"""Kernels that were compiled when the image was built, read from a folder that cannot be written.

numba takes a cache only if it can write there, and refuses to compile anything where it finds none: on a read-only root
the service would not start. The image names this locator in NUMBA_CACHE_LOCATOR_CLASSES instead of numba's own.
A kernel that is not in the cache is an error then, not a silent wait of a minute.
"""

from numba.core.caching import UserProvidedCacheLocator


class SealedCacheLocator(UserProvidedCacheLocator):
    """Return NUMBA_CACHE_DIR."""

    def ensure_cache_path(self) -> None:
        """Do nothing: the folder exists, and is only read."""
