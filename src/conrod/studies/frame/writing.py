"""Files that are written whole or not at all, those of a folder together."""

from __future__ import annotations

import fcntl
import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import msgspec

STAGING, PLANNED = ".conrod-", "planned.json"
Plan = dict[str, str | None]  # files that are there now, in the order of what is put in place: their digests


def real_path(path: Path) -> Path:
    """Resolve a path, whether or not it exists; a link that leads to itself stays one."""
    # Path.resolve raises for a loop of links in Python 3.11 and 3.12.
    return Path(os.path.realpath(path))


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
    """Write all files of all batches; an error or an interrupt before they are put in place leaves what was there.

    Of each folder a kill leaves all or nothing: from the moment at which its plan is there, the rest of its files is
    put in place when it is looked at next, see `recover`. What has the content that it is to have is left as it is.

    Raises:
        OSError: names the file that could not be written.
    """
    with ExitStack() as folders, ExitStack() as stagings:
        staged = [_staged(batch, folders, stagings) for batch in batches]
        for staging, plan in staged:
            with naming(staging.parent):
                (staging / "plan").write_bytes(msgspec.json.encode(plan))
        for staging, _ in staged:
            os.replace(staging / "plan", staging / PLANNED)


def _staged(batch: Batch, folders: ExitStack, stagings: ExitStack) -> tuple[Path, Plan]:
    """Fill a staging, a hidden folder inside the batch's, where it is sure to be on the same device.

    It has the k-th file of the plan as `k`, or nothing where that is to be removed.
    """
    folder, plan = real_path(batch.folder), Plan()
    _make_folder(folder, folders)
    with naming(folder):
        staging = stagings.enter_context(staging_in(folder))
    contents = {name: text.encode() if isinstance(text, str) else text for name, text in batch.files.items()}
    for name, content in (*contents.items(), *((name, None) for name in batch.obsolete)):
        target = folder / name
        with naming(target):
            if target.is_dir():
                raise IsADirectoryError(None, "Is a directory")
            old = target.read_bytes() if target.exists() else None
            if content == old:
                continue
            if content is not None:
                _make_folder(target.parent, folders)
                (staging / f"{len(plan)}").write_bytes(content)
        plan[name] = None if old is None else hashlib.sha256(old).hexdigest()
    return staging, plan


def _make_folder(folder: Path, undo: ExitStack) -> None:
    """Make a folder with its parents; those that were made go again in the end if they are empty."""
    for missing in reversed([p for p in (folder, *folder.parents) if not p.exists()]):
        undo.callback(_remove, missing)
    with naming(folder):
        folder.mkdir(parents=True, exist_ok=True)


def _remove(folder: Path) -> None:
    with suppress(OSError):
        folder.rmdir()


@contextmanager
def staging_in(folder: Path) -> Iterator[Path]:
    """A hidden folder inside another one, after what is there of killed processes is settled; in the end it is, too."""
    recover(folder)
    made = Path(tempfile.mkdtemp(dir=folder, prefix=STAGING))
    with ExitStack() as lock:
        # Where a file system has no locks, what is left is never cleared away.
        with suppress(OSError):
            lock.enter_context(_locked(made))
        try:
            yield made
        finally:
            try:
                _settle(made)
            except KeyboardInterrupt:
                _settle(made, found=True)
                raise


@contextmanager
def _locked(staging: Path) -> Iterator[None]:
    """Hold a lock on a folder, which ends with the process however that ends; OSError where another has it."""
    descriptor = os.open(staging, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(descriptor)


def recover(folder: Path) -> None:
    """Settle the stagings that killed processes have left in a folder."""
    for left in real_path(folder).glob(f"{STAGING}*"):
        with suppress(OSError), _locked(left):
            _settle(left, found=True)


def _settle(staging: Path, found: bool = False) -> None:
    """Put in place what is not yet there of a staging that has its plan, and remove it.

    Args:
        found: whether it was left by another process, or is said to be: then a file is touched only where it is inside
            the folder, and the very one that was there when the plan was made.
    """
    folder = staging.parent
    for k, (name, digest) in enumerate(_plan(staging).items()):
        target, new = folder / name, staging / f"{k}"
        with naming(target):
            if found and not (_digest(target) == digest and real_path(target).is_relative_to(folder)):
                continue
            if new.exists():
                os.replace(new, target)
            else:
                target.unlink(missing_ok=True)
    shutil.rmtree(staging, ignore_errors=True)


def _digest(file: Path) -> str | None:
    return hashlib.sha256(file.read_bytes()).hexdigest() if file.is_file() else None


def _plan(staging: Path) -> Plan:
    """The plan in a staging; an empty one where none can be read."""
    with suppress(OSError, msgspec.MsgspecError):
        if (staging / PLANNED).is_file():
            return msgspec.json.decode((staging / PLANNED).read_bytes(), type=Plan)
    return {}


@contextmanager
def naming(place: Path | str) -> Iterator[None]:
    """Make an OSError name the file that a user knows: a full disk names none, a temporary file says nothing."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(place)) from error
