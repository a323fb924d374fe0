"""The lock of an output directory: one run or sweep writes to it at a time."""

import errno
import fcntl
import os
from pathlib import Path
from typing import Self

from .errors import OutputError

LOCK = ".lock"
_HELD = (errno.EAGAIN, errno.EACCES)


class FolderLock:
    """A lock that the operating system releases when its process ends, however that ends.

    It is held on a hidden file, which is removed with it; one that a killed process left counts
    for nothing. Network file systems lock a file that is open for writing, too. A file system
    without locks gives none.

    Raises
    ------
    OutputError
        If another process holds it.
    """

    def __init__(self, path: Path) -> None:
        self._file, self._open = path / LOCK, -1
        while True:
            opened = os.open(self._file, os.O_RDWR | os.O_CREAT, 0o644)
            try:
                fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                os.close(opened)
                if error.errno not in _HELD:
                    self._file.unlink(missing_ok=True)
                    return
                raise OutputError(
                    f"{path}: another run is writing to it; wait until it ends, or choose "
                    "another directory with --out"
                ) from None
            if self._is_there(opened):
                self._open = opened
                return
            os.close(opened)  # its last owner has removed it meanwhile

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def release(self) -> None:
        """Release the lock."""
        if self._open < 0:
            return
        if self._is_there(self._open):
            self._file.unlink(missing_ok=True)
        os.close(self._open)
        self._open = -1

    def _is_there(self, opened: int) -> bool:
        """Whether an open file is the one of this name."""
        try:
            return os.path.samestat(os.fstat(opened), os.stat(self._file))
        except FileNotFoundError:
            return False
