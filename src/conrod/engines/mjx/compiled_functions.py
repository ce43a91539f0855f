"""Functions that JAX has compiled, kept in the user's cache folder for the worker processes that follow."""

from __future__ import annotations

import hashlib
import os
import platform
import warnings
from pathlib import Path
from typing import Any

import platformdirs

from conrod.system import WORKER_MARK, other_writer, real_path

MAX_KEPT_BYTES = 1 << 26  # of all functions; one takes a quarter of a MB
CPU_FLAGS = ("flags", "Features")  # what Linux calls them on x86 and ARM


def keep_compiled_functions(config: Any) -> None:
    """Make JAX keep the functions that it compiles here, and load functions compiled by other processes.

    Compiling takes nearly all of a short run. JAX runs what it finds in the folder: nothing is kept where another user
    may write into it. The user's own processes keep what their `JAX_COMPILATION_CACHE_DIR` says, and so do workers.

    Args:
        config: `jax.config`.
    """
    if WORKER_MARK not in os.environ or config.jax_compilation_cache_dir:
        return
    folder = real_path(platformdirs.user_cache_path("conrod") / "compiled" / _processor_digest())
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if other_writer(folder):
            return
        drop_oldest_files(folder, MAX_KEPT_BYTES)
    except OSError:
        return
    config.update("jax_compilation_cache_dir", str(folder))
    config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    # A file that cannot be read or written is compiled again.
    warnings.filterwarnings("ignore", r"Error (reading|writing) persistent compilation cache")


def drop_oldest_files(folder: Path, most: int) -> None:
    """Delete all empty files of a folder, and its oldest files until the rest takes at most some bytes."""
    found = [(file, file.stat()) for file in folder.iterdir() if file.is_file()]
    kept = 0
    for file, about in sorted(found, key=lambda one: -one[1].st_mtime):
        kept += about.st_size
        if kept > most or not about.st_size:
            file.unlink(missing_ok=True)


def _processor_digest() -> str:
    """Digest of what this processor can do: compiled functions of another may need more."""
    told = [platform.machine(), platform.processor()]
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    told += [next((line for line in lines if line.startswith(CPU_FLAGS)), "")]
    return hashlib.sha256("\n".join(told).encode()).hexdigest()[:12]
