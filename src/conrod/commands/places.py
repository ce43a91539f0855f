"""Points of a user's model as they are typed: NAME=site:SITE."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.errors import InvalidInput, unknown_choice
from conrod.user_model import Place

KINDS = ("site", "body", "geom")


def places_of(texts: Sequence[str], observed: Sequence[str] = ()) -> tuple[Place, ...]:
    """Where each point is.

    Args:
        observed: names that points may have; any where there are none.

    Raises:
        InvalidInput: a point that is not written so, is unknown or given twice.
    """
    places: dict[str, Place] = {}
    for text in texts:
        name, equals, where = (part.strip() for part in text.partition("="))
        if not equals or not name or not where:
            raise InvalidInput(f"--point {text!r}: give it as {observed[0] if observed else 'NAME'}=site:SITE")
        if observed and name not in observed:
            raise unknown_choice("observed point", name, observed)
        if name in places:
            raise InvalidInput(f"--point {name}: given twice, as {str(places[name])!r} and {where!r}")
        kind, colon, element = where.partition(":")
        # A name may have a colon in it itself.
        if colon and kind in KINDS:
            places[name] = Place(name, kind, element)
        elif colon and not element:
            raise unknown_choice("kind of element", kind, KINDS)
        else:
            places[name] = Place(name, "", where)
    return tuple(places.values())
