"""What a page in HTML consists of, read without a browser."""

from __future__ import annotations

from dataclasses import dataclass, field
from html.parser import HTMLParser


@dataclass
class Found(HTMLParser):
    """Elements of a page with their attributes, in order, and the joined text of some elements."""

    elements: list[tuple[str, dict[str, str]]] = field(default_factory=list)
    within: list[str] = field(default_factory=list)
    texts: dict[str, list[str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        super().__init__()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, {name: value or "" for name, value in attrs}))
        self.within.append(tag)

    def handle_endtag(self, tag: str) -> None:
        while self.within and self.within.pop() != tag:
            pass

    def handle_data(self, data: str) -> None:
        for tag in set(self.within[-1:]):
            self.texts.setdefault(tag, []).append(data)

    def values(self, name: str) -> list[str]:
        return [attributes[name] for _, attributes in self.elements if name in attributes]


def found_in(page: str) -> Found:
    """The elements of a page."""
    found = Found()
    found.feed(page)
    return found
