"""Files that are written whole or not at all, several of them together, and only where nothing else is lost."""

from __future__ import annotations

import hashlib
import json
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
PLANNED = "planned.json"  # in it: each file that is to be put in place, with the digest of what is, or null

# -- what a user names -----------------------------------------------------------------------------------------------


def file_to_write(text: str, option: str) -> Path:
    """The file that an option names, before any work is done; makes nothing.

    Raises:
        InvalidInput: it cannot be written, or something else would be lost by it.
    """
    if text.strip() in ("", "-") or text.endswith(os.sep):
        raise InvalidInput(f"{option} {text!r}: give the name of a file")
    path = Path(text)
    real = real_path(path)
    if is_folder(real):
        raise InvalidInput(f"cannot write {path}: it is a folder; give the name of a file")
    if is_no_file(real):
        raise InvalidInput(f"cannot write {path}: it is not a regular file")
    if not real.parent.is_dir():
        raise InvalidInput(f"cannot write {path}: there is no folder {path.parent}")
    _try_folder(real.parent, path)
    return path


def files_to_write(given: Mapping[str, str | None], beside: Mapping[str, Path] | None = None) -> dict[str, Path]:
    """The files that options name, by option.

    Args:
        given: what was typed, None where nothing was.
        beside: other files, by what a user calls them.

    Raises:
        InvalidInput: one cannot be written, or is the same as another.
    """
    files = {option: file_to_write(text, option) for option, text in given.items() if text is not None}
    check_apart({**(beside or {}), **files})
    return files


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
        with _staging(folder):
            pass
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


def single(path: Path, content: str | bytes) -> Batch:
    """A batch of one file."""
    real = real_path(path)
    return Batch(real.parent, {real.name: content})


def write_together(batches: Sequence[Batch]) -> None:
    """Write all files of all batches, or none: an error or an interrupt leaves what was there before.

    What a process that was killed in the middle has left is undone when its folder is looked at next, see `_mended`.

    Raises:
        OSError: names the file that could not be written.
    """
    with ExitStack() as folders, ExitStack() as staging, ExitStack() as undo:
        moves = [move for batch in batches for move in _staged(batch, folders, staging)]
        for target, new, old in moves:
            _make_folder(target.parent, folders)
            # Before the file is put in place: an interrupt may come between the two.
            undo.callback(_put_back, target, old)
            with naming(target):
                if new is None:
                    target.unlink(missing_ok=True)
                else:
                    os.replace(new, target)
        undo.pop_all()
        folders.pop_all()


def _staged(batch: Batch, folders: ExitStack, staging: ExitStack) -> Iterator[tuple[Path, Path | None, Path]]:
    """Write a batch into a hidden folder inside its own, which is sure to be on the same device.

    Yields:
        each target, the file to be put there, or None for none, and where a copy is of what is there, if anything is.
    """
    folder = real_path(batch.folder)
    _make_folder(folder, folders)
    with naming(folder):
        waiting = staging.enter_context(_staging(folder))
    contents = {name: text.encode() if isinstance(text, str) else text for name, text in batch.files.items()}
    planned = [(name, hashlib.sha256(content).hexdigest()) for name, content in contents.items()]
    with naming(folder):
        (waiting / PLANNED).write_text(json.dumps([*planned, *((name, None) for name in batch.obsolete)]))
    for k, name in enumerate((*batch.files, *batch.obsolete)):
        target, new, old = folder / name, waiting / f"{k}.new", waiting / f"{k}.old"
        with naming(target):
            if name in batch.files:
                new.write_bytes(contents[name])
            if target.exists():
                shutil.copy2(target, old)
        yield target, new if name in batch.files else None, old


def _put_back(target: Path, old: Path) -> None:
    # One file that cannot be restored must not keep the others from it.
    with suppress(OSError):
        if old.exists():
            os.replace(old, target)
        else:
            target.unlink(missing_ok=True)


def _make_folder(folder: Path, undo: ExitStack) -> None:
    """Make a folder with its parents; those that were made go again when it is undone, if they are empty."""
    for missing in reversed([p for p in (folder, *folder.parents) if not p.exists()]):
        undo.callback(_remove, missing)
    with naming(folder):
        folder.mkdir(parents=True, exist_ok=True)


def _remove(folder: Path) -> None:
    with suppress(OSError):
        folder.rmdir()


@contextmanager
def _staging(folder: Path) -> Iterator[Path]:
    """A hidden folder inside another one, after what is there of killed processes is cleared away."""
    for left in folder.glob(f"{STAGING}*"):
        with suppress(OSError, ImportError), _locked(left):
            _mended(folder, left)
    made = tempfile.TemporaryDirectory(dir=folder, prefix=STAGING, ignore_cleanup_errors=True)
    with made as name, ExitStack() as lock:
        # Where a file system or a system has no locks, what is left is never cleared away.
        with suppress(OSError, ImportError):
            lock.enter_context(_locked(Path(name)))
        yield Path(name)


@contextmanager
def _locked(staging: Path) -> Iterator[None]:
    """Hold a lock on a folder, which ends with the process however that ends; OSError where another has it."""
    import fcntl

    descriptor = os.open(staging, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(descriptor)


def _mended(folder: Path, left: Path) -> None:
    """Put back what a killed process has replaced in a folder, and remove its staging.

    A file is touched only where it is the very one that the process put there.
    """
    with suppress(OSError, ValueError, TypeError):
        for k, (name, digest) in enumerate(json.loads((left / PLANNED).read_text())):
            target = folder / name
            inside = real_path(target.parent).is_relative_to(folder)
            found = hashlib.sha256(target.read_bytes()).hexdigest() if target.is_file() else None
            if inside and found == digest:
                _put_back(target, left / f"{k}.old")
    shutil.rmtree(left)


@contextmanager
def naming(place: Path | str) -> Iterator[None]:
    """Make an OSError name the file that a user knows: a full disk names none, a temporary file says nothing."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(place)) from error
