"""What is on disk of one run of a study: its folder, its lock, and the record that says it is over.

    RUN/run.json      the run, by its options
    RUN/result.json   status ended (0), early (3: before its final time) or failed, exit code, error, wall time [s];
                      written at once and last
    RUN/attempts      a line each time that it was started
    RUN/log.txt       what it printed; run.h5, events.h5, state.h5 of a fault
"""

import contextlib
import errno
import fcntl
import json
import os
import shutil

from ..errors import Error, warnings_of


def write_whole(path, content):
    """A JSON file that is whole or not there, also after a crash of the machine."""
    part = f"{path}.{os.getpid()}.part"
    with open(part, "w", encoding="utf-8") as file:
        json.dump(content, file, indent=1)
        file.write("\n")
        file.flush()
        os.fsync(file.fileno())
    os.replace(part, path)
    folder = os.open(os.path.dirname(path), os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def read(path):
    """The content of a JSON file; None: it is not there."""
    try:
        with open(path, encoding="utf-8") as file:
            return json.load(file)
    except FileNotFoundError:
        return None
    except ValueError as error:
        raise Error(f"{path}: {error}; remove it, and the run begins anew") from None


def lock(path, shared=False):
    """A descriptor that holds a file's lock, for as long as a process has it open; None: another one has it."""
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        fcntl.flock(descriptor, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except OSError as error:
        os.close(descriptor)
        if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
            return None
        raise Error(f"{path}: no lock of files here ({error.strerror}), without which two studies could write one run; "
                    "expected a folder of a file system with flock") from None
    return descriptor


class Record:
    """One run's."""

    def __init__(self, folder, planned):
        self.folder, self.planned = os.path.join(folder, planned.name), planned

    def file(self, name):
        return os.path.join(self.folder, name)

    @property
    def outcome(self):
        """The dict of result.json; None: the run is not over."""
        return read(self.file("result.json"))

    @property
    def status(self):
        found = self.outcome
        if found:
            return found["status"]
        return "begun" if os.path.exists(self.file("attempts")) else "open"

    @property
    def attempts(self):
        try:
            with open(self.file("attempts"), encoding="utf-8") as file:
                return sum(1 for _ in file)
        except FileNotFoundError:
            return 0

    @property
    def warnings(self):
        """Lines of the different warnings that its commands have printed, of faults, scripts or Python."""
        try:
            with open(self.file("log.txt"), encoding="utf-8", errors="replace") as file:
                return warnings_of(file.read())
        except FileNotFoundError:
            return []

    def finish(self, status, code, error, wall):
        write_whole(self.file("result.json"),
                    {"status": status, "code": code, "error": error, "wall_time": wall, "attempts": self.attempts})

    def forget(self):
        """A failed run begins anew; what it printed stays."""
        for name in ("result.json", "attempts"):
            with contextlib.suppress(FileNotFoundError):
                os.remove(self.file(name))
        self.clean()
        for name in os.listdir(self.folder):
            if name.startswith(("run.h5", "events.h5", "state.h5", "numbers.json")):
                os.remove(self.file(name))

    def clean(self):
        """Remove the folder of temporary files, also one that a killed driver has left."""
        with contextlib.suppress(OSError):
            shutil.rmtree(os.readlink(self.file("tmp")), ignore_errors=True)
            os.remove(self.file("tmp"))
