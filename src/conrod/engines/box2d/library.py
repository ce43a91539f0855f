"""The package Box2D, imported."""

from __future__ import annotations

import warnings

with warnings.catch_warnings():
    # Types made by SWIG warn that they have no module; where warnings are errors, that ends the interpreter.
    warnings.simplefilter("ignore", DeprecationWarning)
    import Box2D

__all__ = ["Box2D"]
