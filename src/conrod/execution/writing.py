"""Writing of files, each whole or not at all, whenever the process is killed.

Contents are written beside their places under names that nobody can guess, and put in place by a rename each. What a
folder with several files says of itself meanwhile is in the file that `Batch.meanwhile` replaces first.
"""

from __future__ import annotations

import errno
import os
import re
import secrets
import stat
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path, PurePath

from conrod.errors import name_file_in_os_errors
from conrod.system import HeldFolder, own_path, set_permissions, user_id

# Temporary files; folders of this prefix, which earlier versions left, are never looked into.
TEMPORARY_PREFIX = ".conrod-"
_TEMPORARY_NAME = re.compile(re.escape(TEMPORARY_PREFIX) + "[0-9a-f]{16}")
ABANDONED_AGE = 3600.0  # [s]: no writer keeps a temporary file for so long


@dataclass(frozen=True)
class Batch:
    """Files to be written into one folder, which is created if missing.

    Attributes:
        files: content by name in the folder, in the order in which they are put in place.
        obsolete: names of files that are removed.
        meanwhile: content by name that is put in place before all others, until `files` replace it.
    """

    folder: Path
    files: Mapping[str, str | bytes]
    obsolete: tuple[str, ...] = ()
    meanwhile: Mapping[str, str | bytes] = field(default_factory=dict)


def single_file(path: Path, content: str | bytes) -> Batch:
    """Return a batch of one file."""
    real = own_path(path)
    return Batch(real.parent, {real.name: content})


def write_together(batches: Sequence[Batch]) -> None:
    """Write all files of all batches; an error or interrupt before the renames leaves the old files.

    A kill at any moment leaves each file as it was or as it is to be. What has its content already is left alone.

    Raises:
        OSError: names the file that could not be written.
        InvalidInput: a folder is behind a link of another user.
    """
    with ExitStack() as made, ExitStack() as opened:
        staged = [(opened.enter_context(_Folder(batch.folder, made)), batch) for batch in batches]
        for folder, batch in staged:
            folder.stage(batch)
        for folder, _ in staged:
            try:
                folder.put_in_place()
            except KeyboardInterrupt:
                folder.put_in_place(interrupted=True)
                raise


@dataclass(frozen=True)
class _Change:
    """A file that is to be replaced or removed.

    Attributes:
        name: name in the batch's folder, for messages.
        folder: the folder that the file is in.
        last: the file's name there.
        temporary: name of the temporary file with the new content; None if the file is to be removed.
    """

    name: str
    folder: HeldFolder
    last: str
    temporary: str | None


class _Folder:
    """A folder whose files are written together, held open with all below it."""

    def __init__(self, path: Path, made: ExitStack) -> None:
        self.path, self._made = own_path(path), made
        self._opened: dict[PurePath, HeldFolder] = {}
        self._meanwhile, self._changes = list[_Change](), list[_Change]()

    def __enter__(self) -> _Folder:
        with name_file_in_os_errors(self.path):
            for missing in reversed([p for p in (self.path, *self.path.parents) if not p.exists()]):
                self._made.callback(_remove_empty, missing)
                missing.mkdir(exist_ok=True)
            self._opened[PurePath()] = HeldFolder(self.path)
        return self

    def __exit__(self, *_: object) -> None:
        for change in (*self._meanwhile, *self._changes):
            if change.temporary is not None:
                with suppress(OSError):  # nearly always: it has been put in place
                    change.folder.unlink(change.temporary)
        for folder in self._opened.values():
            folder.close()

    def stage(self, batch: Batch) -> None:
        """Write the changed files of a batch into temporary files."""
        new = {name: _bytes(content) for name, content in batch.files.items()}
        changed = {name for name in (*batch.obsolete, *new) if self._content(name) != new.get(name)}
        if not changed:
            return
        for name, content in batch.meanwhile.items():
            self._stage(self._meanwhile, name, _bytes(content))
        for name in (*batch.obsolete, *new):
            if name in changed or name in batch.meanwhile:
                self._stage(self._changes, name, new.get(name))

    def _stage(self, changes: list[_Change], name: str, content: bytes | None) -> None:
        """Add the change of a file to a list, with its content in a temporary file; None removes the file."""
        with name_file_in_os_errors(self.path / name):
            folder, last = self._locate(name)
            changes.append(
                _Change(name, folder, last, None if content is None else TEMPORARY_PREFIX + secrets.token_hex(8))
            )
            if content is not None:
                _write_temporary(changes[-1], content)

    def _content(self, name: str) -> bytes | None:
        """Present content of a file; None if the folder has no such file."""
        with name_file_in_os_errors(self.path / name):
            return _read_content(*self._locate(name))

    def _locate(self, name: str) -> tuple[HeldFolder, str]:
        """Open a file's folder, created if missing; return it, and the file's name in it."""
        *folders, last = PurePath(name).parts
        here = PurePath()
        for part in folders:
            above, here = self._opened[here], here / part
            if here not in self._opened:
                with suppress(FileExistsError):
                    above.mkdir(part)
                    self._made.callback(_remove_empty, self.path / here)
                self._opened[here] = HeldFolder(Path(part), above)
        return self._opened[here], last

    def put_in_place(self, interrupted: bool = False) -> None:
        """Rename the temporary files to their final names, the files of `Batch.meanwhile` first.

        Args:
            interrupted: whether an earlier call was interrupted, so that some files are in place.
        """
        for changes in (self._meanwhile, self._changes):
            for change in changes:
                with name_file_in_os_errors(self.path / change.name):
                    try:
                        _rename_or_remove(change)
                    except FileNotFoundError:
                        if not interrupted:
                            raise
            for folder in self._opened.values() if changes else ():
                folder.sync()


def _bytes(content: str | bytes) -> bytes:
    # A name of a file that is no UTF-8 may stand in a text.
    return content.encode(errors="replace") if isinstance(content, str) else content


def _write_temporary(change: _Change, content: bytes) -> None:
    """Write a temporary file to the disk, with the permissions of the file that it replaces."""
    descriptor = change.folder.open(str(change.temporary), os.O_WRONLY | os.O_CREAT | os.O_EXCL)
    with os.fdopen(descriptor, "wb") as file:
        with suppress(OSError):
            before = change.folder.stat(change.last)
            if stat.S_ISREG(before.st_mode):
                set_permissions(descriptor, before.st_mode)
        file.write(content)
        file.flush()
        os.fsync(descriptor)
        _remove_abandoned(change.folder, os.fstat(descriptor).st_mtime - ABANDONED_AGE)


def _rename_or_remove(change: _Change) -> None:
    if change.temporary is not None:
        change.folder.replace(change.temporary, change.last)
        return
    with suppress(FileNotFoundError):
        change.folder.unlink(change.last)


def _read_content(folder: HeldFolder, name: str) -> bytes | None:
    """Content of a regular file; None if the file is missing."""
    try:
        descriptor = folder.open(name, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    except OSError as error:
        if error.errno in (errno.ENOENT, errno.ELOOP, errno.ENXIO):  # nothing, a link, a pipe or socket
            return None
        raise
    with os.fdopen(descriptor, "rb") as file:
        found = os.fstat(descriptor).st_mode
        if stat.S_ISDIR(found):
            raise IsADirectoryError(None, "Is a directory")
        return file.read() if stat.S_ISREG(found) else None


def _remove_abandoned(folder: HeldFolder, before: float) -> None:
    """Remove this user's temporary files older than a time [s], left by killed processes."""
    for name in folder.names():
        with suppress(OSError):
            if _TEMPORARY_NAME.fullmatch(name):
                found = folder.stat(name)
                if stat.S_ISREG(found.st_mode) and found.st_uid == user_id() and found.st_mtime < before:
                    folder.unlink(name)


def _remove_empty(folder: Path) -> None:
    with suppress(OSError):
        folder.rmdir()
