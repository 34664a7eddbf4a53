"""A lock between processes, on an open file: the system gives it up when its process ends, however it ends."""

import errno
import sys
from typing import IO

if sys.platform == "win32":
    import msvcrt

    def lock(file: IO[str]) -> None:
        """Wait until no other process holds the file. Raises OSError where the file's disk has no locks."""
        while True:
            try:
                return msvcrt.locking(file.fileno(), msvcrt.LK_LOCK, 1)
            except OSError as error:
                if error.errno != errno.EDEADLK:  # which says that another process has held it for ten seconds
                    raise

    def unlock(file: IO[str]) -> None:
        """Let others have the file."""
        msvcrt.locking(file.fileno(), msvcrt.LK_UNLCK, 1)

else:
    import fcntl

    def lock(file: IO[str]) -> None:
        """Wait until no other process holds the file. Raises OSError where the file's disk has no locks."""
        fcntl.flock(file, fcntl.LOCK_EX)

    def unlock(file: IO[str]) -> None:
        """Let others have the file, also where a child process has been forked meanwhile and has it open."""
        fcntl.flock(file, fcntl.LOCK_UN)
