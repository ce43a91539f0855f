"""The figures that a scene's page can show."""

from __future__ import annotations

from conrod.errors import InvalidInput, unknown_choice

FIGURE_NAMES = ("mechanism", "motion", "error", "order")


def figures_of(text: str | None) -> tuple[str, ...]:
    """The figures that are named in a text such as `mechanism,error`, in the order of the page; all where it is None.

    Raises:
        InvalidInput: one is unknown, or none is named.
    """
    if text is None:
        return FIGURE_NAMES
    named = [name.strip() for name in text.split(",") if name.strip()]
    for name in named:
        if name not in FIGURE_NAMES:
            raise unknown_choice("figure", name, FIGURE_NAMES)
    if not named:
        raise InvalidInput(f"--figures {text!r}: name one or more of {', '.join(FIGURE_NAMES)}")
    return tuple(name for name in FIGURE_NAMES if name in named)
