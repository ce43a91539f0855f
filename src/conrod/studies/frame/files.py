"""Files that are written whole or not at all, several of them together, and only where nothing else is lost."""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from conrod.errors import InvalidInput

STAGING = ".conrod-"

# -- what a user names -----------------------------------------------------------------------------------------------


def file_to_write(text: str, option: str) -> Path:
    """The file that an option names.

    Raises:
        InvalidInput: it cannot be written, or something else would be lost by it.
    """
    if text.strip() in ("", "-") or text.endswith(os.sep):
        raise InvalidInput(f"{option} {text!r}: give the name of a file")
    check_writable_file(Path(text))
    return Path(text)


def folder_to_write(text: str, option: str) -> Path:
    """The folder that an option names.

    Raises:
        InvalidInput: it can neither be made nor written in.
    """
    if text.strip() in ("", "-"):
        raise InvalidInput(f"{option} {text!r}: give the name of a folder")
    check_writable_folder(Path(text))
    return Path(text)


def check_apart(files: Mapping[str, Path]) -> None:
    """Refuse files that are one and the same: one would be lost by the other.

    Args:
        files: by what a user calls them.

    Raises:
        InvalidInput: names two of them.
    """
    seen: dict[str, Path] = {}
    for name, path in files.items():
        for other, there in seen.items():
            if _same_file(path, there):
                raise InvalidInput(f"{name} {path}: it is the same file as {other}")
        seen[name] = path


def _same_file(one: Path, other: Path) -> bool:
    # Compared without case: on some systems a.csv is A.csv. A file may have several names of its own, too.
    if str(real_path(one)).casefold() == str(real_path(other)).casefold():
        return True
    return one.exists() and other.exists() and one.samefile(other)


def check_writable_file(path: Path) -> None:
    """Refuse a path that a file cannot be written to, before any work is done; makes nothing.

    Raises:
        InvalidInput: says why.
    """
    real = real_path(path)
    if is_folder(real):
        raise InvalidInput(f"cannot write {path}: it is a folder; give the name of a file")
    if is_no_file(real):
        raise InvalidInput(f"cannot write {path}: it is not a regular file")
    if not real.parent.is_dir():
        raise InvalidInput(f"cannot write {path}: there is no folder {path.parent}")
    _try_folder(real.parent, path)


def check_writable_folder(path: Path) -> None:
    """Refuse a path that a folder cannot be made at or written in, before any work is done; makes nothing.

    Raises:
        InvalidInput: says why.
    """
    real = real_path(path)
    existing = next(p for p in (real, *real.parents) if os.path.lexists(p))
    if not existing.is_dir():
        raise InvalidInput(f"cannot write into {path}: {existing} is a file, not a folder")
    _try_folder(existing, path)


def real_path(path: Path) -> Path:
    """Resolve a path, whether or not it exists; a link that leads to itself stays one."""
    # Path.resolve raises for a loop of links in Python 3.11 and 3.12.
    return Path(os.path.realpath(path))


def is_folder(path: Path) -> bool:
    """True if this is a folder itself, not a link to one."""
    return stat.S_ISDIR(_mode(path))


def is_no_file(path: Path) -> bool:
    """True if there is something that is not a regular file: a folder, a link, a device, a pipe."""
    mode = _mode(path)
    return mode != 0 and not stat.S_ISREG(mode)


def _mode(path: Path) -> int:
    try:
        return path.lstat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return 0
    except OSError as error:
        raise InvalidInput(f"cannot write {path.name}: {error.strerror or error}") from None


def _try_folder(folder: Path, wanted: Path) -> None:
    try:
        _staging(folder).cleanup()
    except OSError as error:
        raise InvalidInput(f"cannot write {wanted}: {error.strerror or error} in {folder}") from None


# -- writing ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Batch:
    """Files of one folder, which is made if there is none.

    Attributes:
        files: content by name in the folder, in the order in which they are put in place.
        obsolete: names of files that are removed.
    """

    folder: Path
    files: Mapping[str, str | bytes]
    obsolete: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Move:
    """A file put in place, or removed where `new` is None; `old` is a copy of what was there, if there was."""

    target: Path
    new: Path | None
    old: Path

    def make(self) -> None:
        with naming(self.target):
            if self.new is None:
                self.target.unlink(missing_ok=True)
            else:
                os.replace(self.new, self.target)

    def undo(self) -> None:
        # One file that cannot be restored must not keep the others from it.
        with suppress(OSError):
            if self.old.exists():
                os.replace(self.old, self.target)
            else:
                self.target.unlink(missing_ok=True)


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file whole or not at all; a link to a file stays a link."""
    write_together([single(path, content)])


def single(path: Path, content: str | bytes) -> Batch:
    """A batch of one file."""
    real = real_path(path)
    return Batch(real.parent, {real.name: content})


def write_together(batches: Sequence[Batch]) -> None:
    """Write all files of all batches, or none: an error or an interrupt leaves what was there before.

    Raises:
        OSError: names the file that could not be written.
    """
    with ExitStack() as stack:
        moves = [move for batch in batches for move in _staged(batch, stack)]
        for move in moves:
            stack.enter_context(_folder_made(move.target.parent))
        _put_in_place(moves)


def _staged(batch: Batch, stack: ExitStack) -> list[_Move]:
    """Write a batch into a hidden folder inside its own, which is sure to be on the same device."""
    folder = real_path(batch.folder)
    stack.enter_context(_folder_made(folder))
    with naming(folder):
        waiting = Path(stack.enter_context(_staging(folder)))
    moves = []
    for k, (name, content) in enumerate(batch.files.items()):
        moves.append(_Move(folder / name, waiting / f"{k}.new", waiting / f"{k}.old"))
        with naming(batch.folder / name):
            (waiting / f"{k}.new").write_bytes(content.encode() if isinstance(content, str) else content)
    moves += [_Move(folder / name, None, waiting / f"{name.replace('/', '-')}.old") for name in batch.obsolete]
    for move in moves:
        with naming(move.target):
            if move.target.exists():
                shutil.copy2(move.target, move.old)
    return moves


def _put_in_place(moves: Sequence[_Move]) -> None:
    begun = []
    try:
        for move in moves:
            # Noted before it is made: an interrupt may come between the two.
            begun.append(move)
            move.make()
    except BaseException:
        for move in reversed(begun):
            move.undo()
        raise


def _staging(folder: Path) -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(dir=folder, prefix=STAGING, ignore_cleanup_errors=True)


@contextmanager
def _folder_made(folder: Path) -> Iterator[None]:
    """A folder with its parents; what was made of them goes again if what follows fails."""
    missing = [p for p in (folder, *folder.parents) if not p.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        for made in missing:
            with suppress(OSError):
                made.rmdir()
        raise


@contextmanager
def naming(place: Path | str) -> Iterator[None]:
    """Make an OSError name the file that a user knows: a full disk names none, a temporary file says nothing."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(place)) from error
