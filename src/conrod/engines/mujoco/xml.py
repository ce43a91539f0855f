"""XML elements and numbers, as MJCF wants them."""

from __future__ import annotations

import xml.etree.ElementTree as ET


def add(parent: ET.Element, tag: str, **attributes: str) -> ET.Element:
    """A new last child of an element."""
    return ET.SubElement(parent, tag, attributes)


def clean(value: float) -> float:
    """Zero for what is zero but for rounding."""
    return 0.0 if abs(value) < 1e-15 else value


def number(value: float) -> str:
    """The shortest text that reads back as the same number."""
    value = clean(float(value))
    texts = (f"{value:.6g}", f"{value:.15g}", repr(value))
    return next(text for text in texts if float(text) == value)


def numbers(values: list[float] | tuple[float, ...]) -> str:
    """Numbers separated by blanks, each exact."""
    return " ".join(number(v) for v in values)


def short(value: float) -> str:
    """Four digits: enough for what is only looked at."""
    return f"{clean(value):.4g}"
