"""Pedigree of a result: hashes of the files that were read, with their sources, and of the software installed."""

from __future__ import annotations

import hashlib
import json
import re
from importlib.metadata import distribution
from pathlib import Path

# A first comment of a text file, in which whoever made it says where it is from.
FIRST_COMMENT = re.compile(r"\s*(?:<!--(.*?)-->|[#%]+\s*([^\n]*))", re.DOTALL)
HEAD, LONGEST = 4096, 160  # characters of a file that are looked at, and of a source
BY_INSTALLER = re.compile(r"\.\./|.*\.dist-info/(INSTALLER|REQUESTED|direct_url\.json)")


def sha256(content: bytes) -> str:
    """In hexadecimal digits."""
    return hashlib.sha256(content).hexdigest()


def stated_source(content: bytes) -> str:
    """Text of the first comment of a file; empty where it begins otherwise."""
    found = FIRST_COMMENT.match(content[:HEAD].decode("utf-8", errors="replace"))
    said = " ".join((found[1] or found[2] or "").split()) if found else ""
    return said if len(said) <= LONGEST else said[:LONGEST].rpartition(" ")[0] + " .."


def package_hash(name: str) -> tuple[str, str, str]:
    """Version of an installed distribution, a SHA-256, and of what that is.

    It is of the wheel's RECORD, which lists the SHA-256 of each file, sorted and without what an installer adds, so
    that it is the same on every machine; of the files themselves where a source tree is installed.
    """
    found = distribution(name)
    if json.loads(found.read_text("direct_url.json") or "{}").get("dir_info", {}).get("editable"):
        root = Path(__file__).parents[1]
        files = {p.relative_to(root).as_posix(): p for p in root.rglob("*") if p.is_file() and p.suffix != ".pyc"}
        lines = [f"{path},{sha256(files[path].read_bytes())}" for path in sorted(files)]
        return found.version, sha256("\n".join(lines).encode()), "source tree"
    lines = (found.read_text("RECORD") or "").splitlines()
    lines = sorted(line for line in lines if ",sha256=" in line and not BY_INSTALLER.match(line))
    return found.version, sha256("\n".join(lines).encode()), "wheel's RECORD" if lines else "nothing: it has no RECORD"
