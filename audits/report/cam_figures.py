"""Figures of document 004's audit: the series' error over the cam angle, and the pressure angles."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from audits.cam_survey import BASE_RADII, LARGEST_PRESSURE_ANGLE, cams, surveys
from audits.documents.arc_cam import ArcCam
from conrod.exact.motion import Array
from conrod.report.charts.canvas import add_legend_above, round_to_grid
from conrod.report.charts.styles import CURVE_COLOURS

UNITS = {"lift": "mm", "velocity": "mm/s", "acceleration": "mm/s²", "jerk": "mm/s³"}
BASE = 36.0  # [mm], the base of the document's extreme cam
SAMPLES = 300  # an arc


def series_error() -> Figure:
    """Series less exact over the rise, a panel a quantity, a line for each flank radius of the smallest base."""
    figure = Figure(figsize=(10.5, 7.4))
    panels = figure.subplots(2, 2, sharex=True).ravel()
    curves = [(cam, *_errors(cam)) for cam in cams() if cam.base == BASE]
    for k, (axes, (name, unit)) in enumerate(zip(panels, UNITS.items(), strict=True)):
        span = max(float(np.ptp(errors[k])) for _, _, errors in curves)
        for hue, (cam, angles, errors) in zip(CURVE_COLOURS, curves, strict=False):
            label = f"rho = {cam.flank:g} mm" + (", one circle" if cam.scene.is_one_circle else "")
            axes.plot(
                round_to_grid(angles, 180.0), round_to_grid(errors[k], span), color=hue, label=label, linewidth=1.3
            )
        axes.axhline(0.0, color="#888888", linewidth=0.7, zorder=1)
        axes.set_ylabel(f"{name}, series less exact [{unit}]")
        axes.set_xlim(0.0, 180.0)
    for axes in panels[2:]:
        axes.set_xlabel("cam angle on the rise [deg]")
    add_legend_above(figure, panels[0].get_lines()[:-1])
    return figure


def _errors(cam: ArcCam) -> tuple[Array, Array]:
    """Angles [deg] and series less exact (4, T), flank and nose one after the other."""
    parts = []
    for arc, first, last, side in (("flank", cam.joint_b, cam.joint_c, "left"), ("nose", cam.joint_c, 180.0, "right")):
        if arc == "nose" and cam.scene.is_one_circle:
            continue
        angles = np.linspace(first, last, SAMPLES)
        exact = cam.exact(angles, "left" if side == "left" else "right")
        if arc == "flank":
            exact[:, 0] = cam.exact(first, "right")[:, 0]
        parts.append((angles, cam.series(angles, arc) - exact))
    return np.concatenate([a for a, _ in parts]), np.hstack([e for _, e in parts])


def pressure_angle() -> Figure:
    """Largest pressure angle against the flank radius, a line a base radius, with the document's rule."""
    figure = Figure(figsize=(8.0, 4.6))
    axes = figure.subplots()
    found = surveys()
    for hue, base in zip(CURVE_COLOURS, BASE_RADII, strict=False):
        some = sorted((s for s in found if s.base == base), key=lambda s: s.flank)
        axes.plot(
            round_to_grid(np.array([s.flank for s in some]), 60.0),
            round_to_grid(np.array([s.pressure_angle for s in some]), 40.0),
            color=hue,
            marker="o",
            markersize=4.5,
            label=f"R = {base:g} mm",
        )
    axes.axhline(LARGEST_PRESSURE_ANGLE, color="#444444", linewidth=1.0, linestyle=(0, (4, 2)))
    axes.annotate(
        "the document's rule",
        (0.008, LARGEST_PRESSURE_ANGLE),
        xycoords=("axes fraction", "data"),
        xytext=(0, 3),
        textcoords="offset points",
        fontsize=8.5,
        color="#444444",
    )
    axes.set_xlabel("flank radius rho [mm]")
    axes.set_ylabel("largest pressure angle [deg]")
    axes.set_ylim(0.0, 45.0)
    axes.legend(loc="lower right", ncol=2)
    return figure
