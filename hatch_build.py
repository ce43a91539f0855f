"""README.md as a package index shows it: its links lead to the repository (docs/releasing.md)."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

LABEL = "Source"  # of the repository's address in `[project.urls]`
IMAGE = re.compile(r"!\[([^\]]*)\]\(([^)\s]+)\)\n*")
LINK = re.compile(r"(?<!!)\[([^\]]+)\]\(([^)\s]+)\)")
ABSOLUTE = re.compile(r"[a-z][a-z+.-]*:|//", re.IGNORECASE)


class CustomMetadataHook(MetadataHookInterface):
    """Hook of hatchling that makes the long description of a release from README.md."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Set the field `readme`."""
        text = (Path(self.root) / "README.md").read_text(encoding="utf-8")
        source = metadata.get("urls", {}).get(LABEL, "")
        text = with_absolute_links(text, source, metadata["version"])
        metadata["readme"] = {"content-type": "text/markdown", "text": text}


def with_absolute_links(readme: str, source: str, version: str) -> str:
    """Return the README with links to the files of a release in the repository.

    Without an address, links to files are left as their words, and pictures are left out.

    Args:
        source: address of the repository on a host like GitHub or GitLab; empty if none is known.
        version: version whose tag `vVERSION` has the files.
    """
    base = source.rstrip("/") + ("/-" if "gitlab" in source else "")

    def picture(found: re.Match[str]) -> str:
        if ABSOLUTE.match(found[2]):
            return found[0]
        return found[0].replace(found[2], f"{base}/raw/v{version}/{found[2]}") if source else ""

    def link(found: re.Match[str]) -> str:
        if ABSOLUTE.match(found[2]):
            return found[0]
        place = f"#{found[2][1:]}" if found[2].startswith("#") else f"/blob/v{version}/{found[2]}"
        return f"[{found[1]}]({base}{place})" if source else found[1]

    return LINK.sub(link, IMAGE.sub(picture, readme))
