"""Errors of a command line that click finds: what was given, what to give, and where the choices are listed."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise

import click

from conrod.errors import InvalidInput

NO_NUMBER = re.compile(r"'(.*)' is not a valid (integer|float)\.", re.DOTALL)
EXAMPLES = {"whole number": "1000", "number": "0.5"}  # of an option's value


def usage_error(ctx: click.Context, error: click.UsageError) -> InvalidInput | click.UsageError:
    """Return the error of a command line in conrod's words, or as click says it."""
    if isinstance(error, click.MissingParameter):
        return _missing_argument(ctx, error)
    return _unfit_number(error) if isinstance(error, click.BadParameter) else error


def _missing_argument(ctx: click.Context, error: click.MissingParameter) -> InvalidInput | click.UsageError:
    """Return the error for an argument that was left out: what to give, and where the choices are listed."""
    if not isinstance(error.param, click.Argument):
        return error
    name = error.param.make_metavar(ctx).rstrip(".")
    listed = "`conrod show` lists them" if "SCENE" in name else f"conrod {ctx.info_name} --help"
    return InvalidInput(f"{ctx.info_name}: give {'an' if name[0] in 'AEIOU' else 'a'} {name}: {listed}")


def _unfit_number(error: click.BadParameter) -> InvalidInput | click.UsageError:
    """Return the error for an option's value that is no number, worded as the errors of ranges."""
    found = NO_NUMBER.fullmatch(error.message)
    if not found or not isinstance(error.param, click.Option):
        return error
    kind = "whole number" if found[2] == "integer" else "number"
    return InvalidInput(f"{error.param.opts[-1]} = {found[1]!r} is not a {kind}; give for instance {EXAMPLES[kind]}")


def refuse_other_values(option: click.Option, typed: Sequence[str]) -> None:
    """Refuse an option that is given twice with several values; once more the same value is none.

    Args:
        typed: words of the command line behind the verb.
    """
    values = [value for name in option.opts for value in _values_of(name, typed)]
    if len(set(values)) > 1:
        both = " and ".join(map(repr, values))
        raise InvalidInput(f"{option.opts[-1]}: given twice, as {both}: give it once")


def _values_of(option: str, typed: Sequence[str]) -> list[str]:
    """Return the values that the words of a command line give to an option, in their order."""
    found = []
    for word, following in pairwise((*typed, "")):
        if word == option:
            found.append(following)
        elif word.startswith(f"{option}="):
            found.append(word.partition("=")[2])
    return found
