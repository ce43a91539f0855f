"""The driven crank as Chipmunk can turn it."""

from __future__ import annotations

from dataclasses import replace

from conrod.engines.left_out_rod import ModelForm


def shaft_centred(form: ModelForm) -> ModelForm:
    """The form with the crank's centre of gravity on its shaft.

    A kinematic body turns about its centre of gravity, and its mass acts on nothing: so where its real one lies does
    not matter, but the place about which it turns does.
    """
    mechanism = form.mechanism
    shaft = mechanism.driven_joint.point_b
    bodies = tuple(
        replace(body, centre_of_gravity=shaft) if body.name == mechanism.crank else body for body in mechanism.bodies
    )
    return replace(form, mechanism=replace(mechanism, bodies=bodies))
