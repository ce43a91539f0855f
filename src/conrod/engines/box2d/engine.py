"""Box2D, as one of conrod's engines."""

from __future__ import annotations

from conrod.engines.box2d import dynamics, model, stepping
from conrod.engines.box2d.library import Box2D
from conrod.engines.box2d.settings import PRESETS, Box2DSettings
from conrod.engines.engine import SINGLE, Engine


class Box2DEngine(Engine[Box2DSettings]):
    """Box2D by way of its `b2World`, in single precision: impulses for velocities, then an iteration of positions."""

    name = "box2d"
    version = Box2D.__version__
    presets = PRESETS
    refusal = staticmethod(model.refusal)
    run = staticmethod(dynamics.run)
    stepper = staticmethod(stepping.stepper)
    reference_loop = staticmethod(stepping.reference_loop)

    def spacing(self, settings: Box2DSettings) -> float:
        return SINGLE


ENGINE = Box2DEngine()
