"""What differs between operating systems: memory limits, locks, paths, folders, processes (docs/platforms.md).

Whatever only some systems have is used here alone, and looked for when it is needed: `import conrod` fails nowhere.
"""

from __future__ import annotations

import errno
import os
import re
import signal
import stat
import struct
import sys
import tempfile
from contextlib import suppress
from importlib import import_module
from pathlib import Path, PurePath
from types import ModuleType
from typing import Any

from conrod.errors import InvalidInput


def _module_if_present(name: str) -> ModuleType | Any:
    """Import a module of Python's library that Windows lacks; None there."""
    try:
        return import_module(name)
    except ImportError:
        return None


fcntl, resource = _module_if_present("fcntl"), _module_if_present("resource")

# -- users -------------------------------------------------------------------------------------------------------------

ROOT_UID = 0  # uid


def user_id() -> int:
    """Return the uid by which this process uses files; 0 on Windows, where every file has uid 0."""
    return os.geteuid() if hasattr(os, "geteuid") else ROOT_UID


def other_writer(folder: Path) -> str:
    """Say why another user may write into a folder, or one above it; empty if none may."""
    for place in (folder, *folder.parents):
        found = place.lstat()
        if found.st_uid not in (user_id(), ROOT_UID):
            return f"{place} belongs to another user (uid {found.st_uid})"
        if stat.S_ISDIR(found.st_mode) and found.st_mode & stat.S_IWOTH and not found.st_mode & stat.S_ISVTX:
            return f"all may write into {place}"
    return ""


# -- paths -------------------------------------------------------------------------------------------------------------

MAX_LINKS = 40  # in a path, as the kernel allows


def real_path(path: Path) -> Path:
    """Resolve a path, whether or not it exists; a link that leads to itself stays one."""
    # Path.resolve raises for a loop of links in Python 3.11 and 3.12.
    return Path(os.path.realpath(path))


def own_path(path: Path) -> Path:
    """Resolve a path that is to be written, by links of this user and of root alone.

    Raises:
        InvalidInput: another user's link is on the way, by which the file would get where that user wants it.
    """
    full = Path.cwd() / path
    here, left, links = Path(full.anchor), list(reversed(full.parts[1:])), 0
    while left and links < MAX_LINKS:
        part = left.pop()
        place = here.parent if part == ".." else here / part
        try:
            found = place.lstat()
        except OSError:
            found = None
        if found is None or not stat.S_ISLNK(found.st_mode):
            here = place
            continue
        if found.st_uid not in (user_id(), ROOT_UID):
            owner = f"a link of another user (uid {found.st_uid})"
            raise InvalidInput(f"cannot write {path}: {place} is {owner}; name the place that it leads to")
        links += 1
        target = PurePath(os.readlink(place))
        here = Path(target.anchor) if target.is_absolute() else here
        left += reversed(target.parts[1:] if target.is_absolute() else target.parts)
    return here if not left else real_path(path)


# -- memory ------------------------------------------------------------------------------------------------------------


def can_limit_memory() -> bool:
    """True if a process can be kept to an address space: not on Windows, and not on macOS, which refuses each limit."""
    return resource is not None and sys.platform != "darwin"


def address_space_limit() -> int | None:
    """Return the address space that this process may have [bytes]; None without a limit."""
    if resource is None:
        return None
    limit: int = resource.getrlimit(resource.RLIMIT_AS)[0]
    return None if limit == resource.RLIM_INFINITY else limit


def used_address_space() -> int:
    """Return the address space that this process uses [bytes]; 0 if the system does not say."""
    try:
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    except FileNotFoundError:
        return 0


def limit_address_space(memory: int) -> None:
    """Limit the address space [bytes] of this process, within its hard limit, where the system can."""
    if can_limit_memory():
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        soft = memory if hard == resource.RLIM_INFINITY else min(memory, hard)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


# -- locks -------------------------------------------------------------------------------------------------------------


def lock_byte(file: int, offset: int) -> None:
    """Lock a byte of an open file for this process, without waiting.

    Raises:
        BlockingIOError, PermissionError: another process has it.
        OSError: the system or the file system has no such locks.
    """
    if fcntl is None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))
    fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, offset)


def unlock_byte(file: int, offset: int) -> None:
    """Unlock a byte of an open file."""
    if fcntl is not None:
        with suppress(OSError):
            fcntl.lockf(file, fcntl.LOCK_UN, 1, offset)


# Of other machines. SQLite's shared memory does not reach them, and not on all of them do locks.
NETWORK_FILE_SYSTEMS = {
    "9p", "afs", "beegfs", "ceph", "cifs", "fuse.ceph", "fuse.glusterfs", "fuse.rclone", "fuse.sshfs",
    "gpfs", "lustre", "ncpfs", "nfs", "nfs4", "panfs", "smb3", "smbfs",
}  # fmt: skip
MOUNTS = "/proc/self/mountinfo"  # of Linux
LOCAL_LOCKS = frozenset(("nolock", "local_lock=all", "local_lock=posix"))  # options of a mount of NFS


def network_file_system(folder: Path) -> tuple[str, bool]:
    """Name the network file system that a folder is on, and say whether its locks reach other machines.

    By Linux's list of mounts; the name is empty where the folder is on none of `NETWORK_FILE_SYSTEMS`, or on an
    unknown one.
    """
    with suppress(OSError), open(MOUNTS, encoding="utf-8", errors="replace") as mounts:
        device = folder.stat().st_dev
        number = f"{os.major(device)}:{os.minor(device)}"
        for line in mounts:
            place, _, about = line.partition(" - ")
            kind, *options = re.split("[ ,]", about.strip())
            if place.split()[2] == number and kind in NETWORK_FILE_SYSTEMS:
                return kind, not LOCAL_LOCKS.intersection(options)
    return "", True


def grants_a_lock_twice(folder: Path) -> bool:
    """Try whether a file in a folder can be locked while it is locked, as where locks do nothing."""
    if not hasattr(fcntl, "F_OFD_SETLK"):
        return False
    exclusive = struct.pack("hhqqi", fcntl.F_WRLCK, os.SEEK_SET, 0, 1, 0)  # struct flock, of the first byte
    with tempfile.NamedTemporaryFile(dir=folder, prefix=".conrod-lock-") as first, open(first.name, "r+b") as second:
        try:
            for file in (first, second):  # a lock is held by an open file, not by its process
                fcntl.fcntl(file.fileno(), fcntl.F_OFD_SETLK, exclusive)
        except OSError:  # refused, or there are no locks, of which `lock_byte` tells
            return False
    return True


# -- files and folders -------------------------------------------------------------------------------------------------

# Not through a link, not into processes that start later, and without other line ends: Windows has the last alone.
PLAIN_FILE = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
_PLAIN_FOLDER = PLAIN_FILE | getattr(os, "O_DIRECTORY", 0)


class HeldFolder:
    """A folder held open by a descriptor, so that a link put there later cannot lead elsewhere.

    On Windows, where no folder can be opened, it is found by its path each time.
    """

    def __init__(self, path: Path, above: HeldFolder | None = None) -> None:
        """Open a folder.

        Args:
            path: its path; its name alone where `above`, the folder that it is in, is given.
        """
        self._path: Path = path if above is None else above._path / path
        self._at: dict[str, int] = {}
        if {os.open, os.stat, os.unlink, os.mkdir} <= os.supports_dir_fd:
            where = {} if above is None else above._at
            self._at = {"dir_fd": os.open(path, os.O_RDONLY | _PLAIN_FOLDER, **where)}

    def _place(self, name: str) -> str | Path:
        return name if self._at else self._path / name

    def open(self, name: str, flags: int) -> int:
        """Open a file in the folder, and no link; return its descriptor."""
        return os.open(self._place(name), flags | PLAIN_FILE, 0o666, **self._at)

    def stat(self, name: str) -> os.stat_result:
        """Return the facts of a file in the folder, or of a link there."""
        return os.stat(self._place(name), follow_symlinks=False, **self._at)

    def replace(self, old: str, new: str) -> None:
        """Rename a file in the folder, in place of another."""
        both = {"src_dir_fd": self._at["dir_fd"], "dst_dir_fd": self._at["dir_fd"]} if self._at else {}
        os.replace(self._place(old), self._place(new), **both)

    def unlink(self, name: str) -> None:
        """Remove a file from the folder."""
        os.unlink(self._place(name), **self._at)

    def mkdir(self, name: str) -> None:
        """Make a folder in the folder."""
        os.mkdir(self._place(name), **self._at)

    def names(self) -> list[str]:
        """Return the names of all that is in the folder."""
        return os.listdir(self._at["dir_fd"] if self._at else self._path)

    def sync(self) -> None:
        """Write the folder's names to the disk, where the file system can."""
        if self._at:
            with suppress(OSError):
                os.fsync(self._at["dir_fd"])

    def close(self) -> None:
        """Release the folder."""
        if self._at:
            os.close(self._at.pop("dir_fd"))


def set_permissions(descriptor: int, mode: int) -> None:
    """Give an open file the permission bits of a mode, where files have them."""
    if hasattr(os, "fchmod"):
        os.fchmod(descriptor, mode & 0o777)


def file_address(path: PurePath) -> str:
    """Return a path as an address with slashes: `file:///C:/models/saw.xml`, or relative as the path is."""
    from urllib.parse import quote

    return path.as_uri() if path.is_absolute() else quote(path.as_posix())


def interpreter_in(environment: Path) -> Path:
    """Return the path of the Python of a virtual environment."""
    return environment / "Scripts" / "python.exe" if sys.platform == "win32" else environment / "bin" / "python"


# -- processes ---------------------------------------------------------------------------------------------------------

WORKER_MARK = "CONROD_WORKER"  # variable that only a worker and what is started in it have, with the worker's own value
# Exit status after a signal that a kernel short of memory, a batch system or a person sends; engines do not send them.
EXTERNAL_KILLS = {-getattr(signal, "SIGKILL", 9), -signal.SIGTERM}
MAX_ROUNDS = 5  # of looking for processes to kill: one may fork while the others are looked at


def popen_arguments(connection: int) -> dict[str, Any]:
    """Return the arguments of Popen for a process that inherits a connection, in a separate session.

    The owner answers Ctrl-C at the terminal, and processes that an engine forks end with the group.
    """
    if sys.platform == "win32":
        import subprocess

        os.set_handle_inheritable(connection, True)
        return {
            "startupinfo": subprocess.STARTUPINFO(lpAttributeList={"handle_list": [connection]}),
            "creationflags": subprocess.CREATE_NEW_PROCESS_GROUP,
        }
    return {"pass_fds": [connection], "start_new_session": True}


def inherited_connection(descriptor: int, least: int) -> Any:
    """Return the connection that this process inherited, closed in processes that are started from here.

    Args:
        least: number that its file descriptor is to have at least, where it has one: an engine that writes into a
            wrong descriptor hits a lower one.
    """
    from multiprocessing import connection

    if sys.platform == "win32":
        os.set_handle_inheritable(descriptor, False)
        return connection.PipeConnection(descriptor)
    if fcntl is None:
        return connection.Connection(descriptor)
    least = min(least, resource.getrlimit(resource.RLIMIT_NOFILE)[0] // 2)
    hidden = fcntl.fcntl(descriptor, fcntl.F_DUPFD_CLOEXEC, least)
    os.close(descriptor)
    return connection.Connection(hidden)


def kill_group(process: int) -> None:
    """Kill all processes in the group of a process; Windows has no groups."""
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process, signal.SIGKILL)


def kill_marked(mark: str) -> None:
    """Kill all other processes that began with a mark, `NAME=value`, in their environment; Linux alone shows it.

    A process that an engine starts in a session of its own is in no group of a worker, but has its environment.
    """
    for _ in range(MAX_ROUNDS):
        # One that cannot be read is another user's, or has ended.
        found = [one for one in _process_ids() if one != os.getpid() and mark.encode() in _first_environment(one)]
        for process in found:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(process, signal.SIGKILL)
        if not found:
            return


def _process_ids() -> list[int]:
    """Return the numbers of all processes, where the system lists them as files."""
    with suppress(OSError):
        return [int(name) for name in os.listdir("/proc") if name.isdecimal()]
    return []


def _first_environment(process: int) -> list[bytes]:
    """Return the variables, `NAME=value`, that a process began with; none if they cannot be read."""
    with suppress(OSError):
        return Path(f"/proc/{process}/environ").read_bytes().split(b"\0")
    return []


def end_own_group() -> None:
    """End this process, and all of its group if it leads one."""
    if hasattr(os, "killpg") and os.getpgrp() == os.getpid():
        os.killpg(os.getpid(), signal.SIGKILL)
    os._exit(0)
