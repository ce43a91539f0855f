"""Files that are written whole or not at all, several of them together."""

from __future__ import annotations

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


@dataclass(frozen=True)
class Plan:
    """Plan in a staging, a hidden folder with each file to be put in place as `0.new`, and what is there as `0.old`.

    Attributes:
        together: stagings of one write. While the first has its plan, what was put in place is put back by whoever
            looks at one; its removal is the moment at which everything is written.
        files: digest by name of each file; None for one to be removed.
    """

    together: list[str]
    files: dict[str, str | None]


def write_together(batches: Sequence[Batch]) -> None:
    """Write all files of all batches, or none: an error, an interrupt or a kill leaves what was there before.

    After a kill it is put back when one of the folders is looked at next, see `recover`. What has the content that it
    is to have is left as it is.

    Raises:
        OSError: names the file that could not be written.
    """
    with ExitStack() as folders, ExitStack() as stagings:
        staged = [_staged(batch, folders, stagings) for batch in batches]
        for staging, files in staged:
            with naming(staging.parent):
                plan = Plan([str(one) for one, _ in staged], files)
                (staging / PLANNED).write_bytes(msgspec.json.encode(plan))
        for staging, files in staged:
            for k, (name, digest) in enumerate(files.items()):
                target = staging.parent / name
                with naming(target):
                    if digest is None:
                        target.unlink()
                    else:
                        os.replace(staging / f"{k}.new", target)
        for staging, _ in staged[:1]:
            (staging / PLANNED).unlink()


def _staged(batch: Batch, folders: ExitStack, stagings: ExitStack) -> tuple[Path, dict[str, str | None]]:
    """Fill a staging, inside the batch's folder, where it is sure to be on the same device; its files as of `Plan`."""
    folder, files = real_path(batch.folder), dict[str, str | None]()
    _make_folder(folder, folders)
    with naming(folder):
        staging = stagings.enter_context(staging_in(folder))
    contents = {name: text.encode() if isinstance(text, str) else text for name, text in batch.files.items()}
    for name, content in (*contents.items(), *((name, None) for name in batch.obsolete)):
        target = folder / name
        with naming(target):
            old = target.read_bytes() if target.exists() else None
            if content == old:
                continue
            if old is not None:
                shutil.copy2(target, staging / f"{len(files)}.old")
            if content is not None:
                _make_folder(target.parent, folders)
                (staging / f"{len(files)}.new").write_bytes(content)
        files[name] = None if content is None else hashlib.sha256(content).hexdigest()
    return staging, files


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
    """A hidden folder inside another one, after what is there of killed processes is settled."""
    recover(folder)
    made = Path(tempfile.mkdtemp(dir=folder, prefix=STAGING))
    with ExitStack() as lock:
        # Where a file system or a system has no locks, what is left is never cleared away.
        with suppress(OSError, ImportError):
            lock.enter_context(_locked(made))
        try:
            yield made
        finally:
            _settle(made)


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


def recover(folder: Path) -> None:
    """Put back what killed processes have replaced in a folder, and remove their stagings."""
    for left in real_path(folder).glob(f"{STAGING}*"):
        with suppress(OSError, ImportError), ExitStack() as locks:
            together = _plan(left).together
            # Those in other folders say so themselves: what somebody put into this one reaches no further.
            others = [one for one in map(Path, together) if one != left and _plan(one).together == together]
            group = sorted([left, *others], key=lambda one: str(one) in together[:1])
            for one in group:
                locks.enter_context(_locked(one))
            for one in group:
                _settle(one)


def _plan(staging: Path) -> Plan:
    """The plan in a staging; an empty one where none can be read."""
    with suppress(OSError, msgspec.MsgspecError):
        if staging.name.startswith(STAGING) and (staging / PLANNED).is_file():
            return msgspec.json.decode((staging / PLANNED).read_bytes(), type=Plan)
    return Plan([], {})


def _settle(staging: Path) -> None:
    """Put back what was put in place of a staging, unless all was, and remove it; that with the decision comes last.

    A file is touched only where it is the very one that was put there.
    """
    plan, folder, lost = _plan(staging), staging.parent, False
    first = [staging if Path(one).name == staging.name else Path(one) for one in plan.together[:1]]
    if any((one / PLANNED).is_file() for one in first):
        for k, (name, digest) in enumerate(plan.files.items()):
            target, old = folder / name, staging / f"{k}.old"
            try:
                inside = real_path(target.parent).is_relative_to(folder)
                found = hashlib.sha256(target.read_bytes()).hexdigest() if target.is_file() else None
                if inside and found == digest and old.exists():
                    os.replace(old, target)
                elif inside and found == digest is not None:
                    target.unlink()
            except OSError:  # one file that cannot be restored must not keep the others from it
                lost = True
    if not lost:
        shutil.rmtree(staging, ignore_errors=True)


@contextmanager
def naming(place: Path | str) -> Iterator[None]:
    """Make an OSError name the file that a user knows: a full disk names none, a temporary file says nothing."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(place)) from error
