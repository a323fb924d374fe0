"""The lock of an output directory: one run or sweep writes to it at a time."""

import errno
import fcntl
import os
from pathlib import Path
from typing import Self

from .errors import OutputError
from .files import HISTORY

_HELD = (errno.EAGAIN, errno.EACCES)


class FolderLock:
    """A lock that the operating system releases when its process ends, however that ends.

    It is held on the directory itself, so that no file is left. Network file systems lock only
    files that are open for writing: there it is held on the history, if there is one. A file
    system without locks gives none.

    Raises
    ------
    OutputError
        If another process holds it.
    """

    def __init__(self, path: Path) -> None:
        self._path, self._open = path, -1
        for place, flags in ((path, os.O_RDONLY), (path / HISTORY, os.O_RDWR)):
            try:
                opened = os.open(place, flags)
            except OSError:
                continue
            try:
                fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                os.close(opened)
                if error.errno in _HELD:
                    raise OutputError(
                        f"{path}: another run is writing to it; wait until it ends, or choose "
                        "another directory with --out"
                    ) from None
            else:
                self._open = opened
                return

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def release(self) -> None:
        """Release the lock."""
        if self._open >= 0:
            os.close(self._open)
            self._open = -1
