"""Options of one purpose, handed to a command as one object."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

from conrod.errors import InvalidInput

Command = TypeVar("Command", bound=Callable[..., Any])


def bundled(name: str, bundle: type, options: tuple[Callable[[Any], Any], ...]) -> Callable[[Command], Command]:
    """A decorator that adds options to a command, which gets their values as one object.

    Args:
        name: of the command's argument.
        bundle: a frozen dataclass with a field for each option, each with the option's default.
        options: decorators as `click.option` gives them.
    """
    fields = [field.name for field in dataclasses.fields(bundle)]

    def decorate(command: Command) -> Command:
        @wraps(command)
        def gathered(**values: Any) -> Any:
            return command(**{name: bundle(**{field: values.pop(field) for field in fields})}, **values)

        decorated: Any = gathered
        for option in reversed(options):
            decorated = option(decorated)
        result: Command = decorated
        return result

    return decorate


def check_unused(bundle: Any, subject: str) -> None:
    """Refuse options of a purpose that what was named does not have.

    Args:
        bundle: what the options were given as.
        subject: what was named instead, for the message: "a scene".

    Raises:
        InvalidInput: names the first option that was given.
    """
    for field in dataclasses.fields(bundle):
        if getattr(bundle, field.name) != field.default:
            option = field.metadata.get("option", "--" + field.name.replace("_", "-"))
            raise InvalidInput(f"{option} does not go with {subject}")
