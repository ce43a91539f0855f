"""Remove the regularisation of a compiled MuJoCo model's constraints."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import mujoco

# Less hardening leaves regularisation (1e-8: 4e-12 of the stroke in the press), more costs digits of the reaction
# forces by cancellation, about tenfold for each factor of ten.
HARDENING = 1e-9


def harden(model: mujoco.MjModel, factor: float = HARDENING) -> None:
    """Make the constraints of a compiled model hard, in place.

    MuJoCo adds to every constraint a regularisation R = (1 - d) / d x (an estimate of its inverse inertia), which
    it takes from `body_invweight0`, `dof_invweight0` and `tendon_invweight0`. MJCF bounds the impedance d by 0.9999;
    scaling the estimate has no such bound. All constraints harden, contacts and limits too; `mj_setConst` undoes it.

    Args:
        model: an `mujoco.MjModel` in double precision.
        factor: what the inverse weights are multiplied by, in (0, 1]. The default is for a driven machine that is
            solved to tolerance 0. For a free swing at MuJoCo's stock tolerance 1e-9 d / (1 - d) is best: less is lost
            in rounding (docs/hardening.md, "Which factor").

    Raises:
        ValueError: the factor is out of range.
    """
    if not 0.0 < factor <= 1.0:
        raise ValueError(f"hardening factor {factor!r} is out of range: 0 < factor <= 1")
    model.body_invweight0[:] *= factor
    model.dof_invweight0[:] *= factor
    model.tendon_invweight0[:] *= factor
