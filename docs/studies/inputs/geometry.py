"""Models with other lengths, joints and closures than the machine's, and with others that are none."""

from __future__ import annotations

from collections.abc import Iterator

from docs.studies.inputs.edits import (
    CLOSURE,
    CRANK,
    CUTTER,
    HACKSAW,
    KEYFRAME,
    PIN,
    PRESS,
    ROD_END,
    SAW,
    SLIDE,
    SMALL,
    exported,
    hacksaw,
    multiplied,
    placed,
    replaced,
    rounded,
    saw,
    scaled,
)  # fmt: skip
from docs.studies.inputs.input import Input, healthy, wrong

LENGTHS, JOINTS, CLOSURES = "lengths of a model", "joints and axes", "closures"
JUDGED, MEASURED = "within tolerance", "measured, not judged"
RSSR = "--scene rssr --tolerance position=0.1mm"
RSSR_OWN = "--scene rssr"


def _judged(text: str, more: str = "", options: str = SAW) -> tuple[dict[str, str | bytes], str]:
    return {"model.xml": text}, f"check model.xml {options} {SMALL} {more}"


def lengths() -> Iterator[Input]:
    """Models whose lengths are others than the machine's, and models whose lengths were said to be so."""
    kind = LENGTHS
    rod = replaced(saw(), (ROD_END, 'name="slider-pin.rod" pos="0.30003 0 0"'))
    yield wrong(kind, "rod 0.01 % longer", *_judged(rod), r"rod is 0.01 % too long")
    crank = replaced(saw(), ('<body name="rod" pos="0.1 0 0"', '<body name="rod" pos="0.1002 0 0"'))
    yield wrong(kind, "crank 0.2 % longer", *_judged(crank), r"crank is 0.2 % too long")
    offset = replaced(saw(), ('<body name="slider" pos="0 0 0">', '<body name="slider" pos="0 0.001 0">'))
    yield wrong(kind, "slide 1 mm higher", *_judged(offset, "--rotation 0deg --crank-zero 0deg"), r"offset is 1\.\d* %")
    point = replaced(saw(), ('<site name="M" pos="0.15 0 0" />', '<site name="M" pos="0.151 0 0" />'))
    yield wrong(kind, "an observed point 1 mm along its link", *_judged(point), r"M is 1 mm from where it should be")
    size = r"all lengths are 1.01 times"
    yield wrong(kind, "all 1 % larger", *_judged(scaled(saw(), 1.01)), size)
    both = replaced(crank, (ROD_END, 'name="slider-pin.rod" pos="0.303 0 0"'))
    yield wrong(
        kind, "crank and rod", *_judged(both), r"crank is 0.2 % too long.*rod is 1 % too long|rod is 1 %.*crank is 0"
    )
    hung = replaced(hacksaw(), ('name="big end" pos="0.3 0 0"', 'name="big end" pos="0.31 0 0"'))
    yield wrong(kind, "rod 10 mm longer, another tree", *_judged(hung, options=HACKSAW), r"rod is 3.3 % too long")
    disc = replaced(hacksaw(), ('name="crankpin" pos="0 0 0.1"', 'name="crankpin" pos="0 0 0.098"'))
    yield wrong(kind, "crank 2 mm shorter, another tree", *_judged(disc, options=HACKSAW), r"crank is 2 % too short")
    press = exported("shear-press", rod=0.391)
    yield wrong(kind, "rod of a press 1 mm longer", *_judged(press, options=PRESS), r"rod is 0.26 % too long")
    space = replaced(exported("rssr"), ('pos="0.3 0.15 0.05"', 'pos="0.3 0.15 0.051"'))
    named = r"0\.?0*1? ?mm|1 mm|place|apart|length|rocker"
    yield wrong(kind, "pivot in space 1 mm higher", {"model.xml": space}, f"check model.xml {RSSR_OWN}", named)

    it_is = r"It is saw-40rpm\..* Driven by conrod, its own settings are within tolerance"
    for name, value in (("crank", 0.095), ("rod", 0.35), ("offset", 0.07), ("offset", 0.0)):
        text, option = exported("saw-40rpm", **{name: value}), f"--set {name}={1000 * value:g}mm"
        yield healthy(kind, f"{name} of {1000 * value:g} mm, asked for as such", *_judged(text, option), it_is)
    six = rounded(saw(), 6)
    loose = f"check model.xml {SAW} --tolerance position=1e-5"
    yield healthy(kind, "all numbers in six digits", {"model.xml": six}, loose, it_is)
    twice = {"model.xml": scaled(hacksaw(), 2.0)}, "--set crank=200mm --set rod=600mm --set offset=180mm"
    yield healthy(kind, "all twice as large, asked for so", twice[0], f"check model.xml {HACKSAW} {twice[1]}", MEASURED)
    press = exported("shear-press", crank=0.03)
    set_crank = _judged(press, "--set crank=30mm", PRESS)
    yield healthy(
        kind, "a press with another crank", *set_crank, r"It is shear-press\..* its own settings are within tolerance"
    )
    cutter = exported("web-cutter")
    yield healthy(
        kind,
        "a four-bar of the catalogue",
        *_judged(cutter, options=CUTTER),
        r"It is web-cutter\..* its own settings are within",
    )
    moved = exported("web-cutter", **{"ground.points.D.x": 0.31})
    longer = _judged(moved, "--set ground.points.D.x=310mm", CUTTER)
    yield healthy(kind, "a four-bar with another base", *longer, r"It is web-cutter\..* its own settings are within")
    nine = {"model.xml": rounded(exported("rssr"), 9)}
    in_space = f"check model.xml {RSSR_OWN}"
    yield healthy(kind, "a linkage in space in nine digits", nine, in_space, r"It is rssr|measured")


def joints() -> Iterator[Input]:
    """Models with joints of other kinds and axes, and with the same joints written otherwise."""
    kind = JOINTS
    tilted = replaced(saw(), (PIN, PIN.replace("0 0 1", "0.000872664 0 1")))
    yield wrong(
        kind, "a pin 0.05 deg out of its axis", *_judged(tilted), r"crank-pin.*(axis|tilt|parallel)|axis.*crank-pin"
    )
    leaning = replaced(saw(), (SLIDE, SLIDE.replace("1 0 0", "0.9998477 0.0174524 0")))
    fixed = _judged(leaning, "--rotation 0deg --crank-zero 0deg")
    yield wrong(kind, "a slide 1 deg out of its line", *fixed, r"slide.*(tilt|turn|lean|direction|deg)|tilt")
    out = replaced(saw(), (SLIDE, SLIDE.replace("1 0 0", "0.999994 0 0.0035")))
    yield wrong(
        kind, "a slide 0.2 deg out of the plane", *_judged(out), r"slide.*(axis|plane|across)|axis of .*slide|out of"
    )
    hinge = replaced(saw(), (SLIDE, '<joint name="slide" type="hinge" axis="0 0 1" pos="0 -1 0" />'))
    yield wrong(kind, "a hinge for the slide", *_judged(hinge), r"hinge.*slide|3 hinges|slides?\b.*the machine has")
    spare = replaced(saw(), (PIN, PIN + '<joint name="spare" type="slide" axis="1 0 0" />'))
    yield wrong(kind, "a rod that can lengthen", *_judged(spare), r"mobility 2|mobility is 2|spare")
    stuck = replaced(saw(), (PIN, ""), (KEYFRAME, ""))
    yield wrong(
        kind, "a rod that is fast on its crank", *_judged(stuck), r"mobility 0|mobility is 0|nothing moves|cannot move"
    )
    absent = f"check model.xml {SAW.replace('--crank crank', '--crank krank')} {SMALL}"
    yield wrong(kind, "a crank that there is none of", {"model.xml": saw()}, absent, r"krank.*crank", (2,))
    no_hinge = f"check model.xml {SAW.replace('--crank crank', '--crank slide')} {SMALL}"
    yield wrong(kind, "a slide for the crank", {"model.xml": saw()}, no_hinge, r"slide.*hinge", (2,))
    shifted = replaced(saw(), (CRANK, CRANK.replace("axis=", 'pos="0.001 0.002 0" axis=')))
    yield wrong(
        kind,
        "a crank that turns about another place",
        *_judged(shifted),
        r"crank is|offset|from where it should be|rod is",
    )
    other = replaced(
        exported("rssr"),
        ('name="rod_swing" type="hinge" axis="0.0 0.0 1.0"', 'name="rod_swing" type="slide" axis="0 0 1"'),
    )  # fmt: skip
    yield wrong(
        kind,
        "a slide in space for a hinge",
        {"model.xml": other},
        f"check model.xml {RSSR_OWN}",
        r"rod_swing.*slide",
    )

    it_is = r"It is saw-40rpm\..* Driven by conrod, its own settings are within tolerance"
    flipped = replaced(saw(), (PIN, PIN.replace("0 0 1", "0 0 -1")), (KEYFRAME, ""))
    yield healthy(kind, "a pin that counts the other way", *_judged(flipped), it_is)
    back = replaced(saw(), (CRANK, CRANK.replace("0 0 1", "0 0 -1")), (KEYFRAME, ""))
    yield healthy(kind, "a crank that counts the other way", *_judged(back), it_is)
    slide = replaced(saw(), (SLIDE, SLIDE.replace("1 0 0", "-1 0 0")), (KEYFRAME, ""))
    yield healthy(kind, "a slide that counts the other way", *_judged(slide), it_is)
    long = replaced(saw(), (SLIDE, SLIDE.replace("1 0 0", "17 0 0")))
    yield healthy(kind, "an axis that has not unit length", *_judged(long), it_is)
    away = placed(saw(), pos="3 -2 1")
    yield healthy(kind, "elsewhere in the world", *_judged(away), it_is)
    upright = {"model.xml": placed(saw(), euler="1.5707963267948966 0 0")}
    asked = f"check model.xml {SAW} --tolerance position=1e-4"
    yield healthy(kind, "upright in the world", upright, asked, it_is)
    turned = placed(saw(), euler="0 0 0.5235987755982988")
    yield healthy(kind, "turned by 30 deg", *_judged(turned), it_is)
    names = saw()
    for old, new in (('name="crank-pin"', 'name="Gelenk 2"'), ('name="slide"', 'name="滑动"')):
        names = replaced(names, (old, new))
    yield healthy(kind, "other names, some not Latin", *_judged(names), it_is)
    zero = replaced(saw(), (CRANK, CRANK.replace("axis=", 'ref="0.5235987755982988" axis=')), (KEYFRAME, ""))
    yield healthy(kind, "a crank counted from 30 deg", *_judged(zero), it_is)
    tree = {"model.xml": multiplied(hacksaw(), {})}
    yield healthy(kind, "the rod on the slider", tree, f"check model.xml {HACKSAW}", MEASURED)


def closures() -> Iterator[Input]:
    """Models whose loops are not closed, or otherwise, and models closed in another way."""
    kind = CLOSURES
    yield wrong(kind, "none", *_judged(replaced(saw(), (CLOSURE, ""))), r"mobility (is )?3|no closure|closures take 0")
    inactive = replaced(saw(), (CLOSURE, CLOSURE.replace("<connect", '<connect active="false"')))
    yield wrong(kind, "one that is not active", *_judged(inactive), r"slider-pin is (inactive|not active)|inactive")
    disabled = replaced(saw(), ('contact="disable"', 'contact="disable" equality="disable"'))
    yield wrong(kind, "all switched off", *_judged(disabled), r"equalit.*(disabled|off|inactive)|inactive|switched off")
    bodies = 'name="slider-pin" body1="rod" body2="slider" anchor="0.35 0 0"'
    apart = replaced(saw(), (CLOSURE, f"<connect {bodies} />"))
    yield wrong(
        kind, "an anchor 50 mm beyond the pin", *_judged(apart), r"rod is 17 % too long|apart|do not meet|anchor"
    )
    middle = replaced(saw(), (CLOSURE, CLOSURE.replace("slider-pin.rod", "M")))
    yield wrong(kind, "the pin at the middle of the rod", *_judged(middle), r"rod is 50 % (too short|shorter)")
    weld = replaced(saw(), (CLOSURE, '<weld name="slider-pin" site1="slider-pin.rod" site2="slider-pin.slider" />'))
    yield wrong(kind, "a weld for the pin", *_judged(weld), r"weld")
    locked = '<joint name="brake" joint1="slide" polycoef="0 0 0 0 0" />'
    held = replaced(saw(), (CLOSURE, CLOSURE + locked))
    yield wrong(kind, "a slide that is held", *_judged(held), r"brake|mobility (is )?0|equality")
    twice = '<connect name="second" site1="M" site2="slider-pin.slider" />'
    yield wrong(kind, "two that contradict each other", *_judged(replaced(saw(), (CLOSURE, CLOSURE + twice))),
                r"second|contradict|mobility (is )?0|do not close|cannot be closed|opens?")  # fmt: skip
    soft = replaced(saw(), (CLOSURE, '<connect name="slider-pin" site1="slider-pin.rod" site2="slider-pin.slider" />'))
    driven = "check model.xml --drive crank=40rpm --tolerance position=0.01mm"
    yield wrong(kind, "a soft one, driven", {"model.xml": soft}, driven, r"loops? open|out of tolerance.*open", (1,))
    yield wrong(kind, "a soft one, by lint", {"model.xml": soft}, "lint model.xml", r"soft-closure", (1,))

    it_is = r"It is saw-40rpm\..* Driven by conrod, its own settings are within tolerance"
    tuned = 'solref="0.012 1" solimp="0.9999 0.9999 0.001 0.5 2"'
    by_bodies = f'<connect name="slider-pin" body1="rod" body2="slider" anchor="0.3 0 0" {tuned} />'
    yield healthy(kind, "by bodies and anchor", *_judged(replaced(saw(), (CLOSURE, by_bodies))), it_is)
    other_way = CLOSURE.replace("site1", "siteX").replace("site2", "site1").replace("siteX", "site2")
    yield healthy(kind, "its sites the other way round", *_judged(replaced(saw(), (CLOSURE, other_way))), it_is)
    double = CLOSURE + CLOSURE.replace('name="slider-pin"', 'name="again"')
    yield healthy(kind, "twice the same", *_judged(replaced(saw(), (CLOSURE, double))), it_is)
    spare = CLOSURE + '<connect name="spare" active="false" site1="M" site2="C" />'
    yield healthy(
        kind, "a second one that is not active", *_judged(replaced(saw(), (CLOSURE, spare))), r"It is saw-40rpm"
    )
    nameless = replaced(saw(), (CLOSURE, CLOSURE.replace('name="slider-pin" ', "")))
    yield healthy(kind, "without a name", *_judged(nameless), it_is)
    stiff = replaced(saw(), (CLOSURE, CLOSURE.replace("0.9999 0.9999", "0.99999 0.99999")))
    yield healthy(kind, "a stiffer one", *_judged(stiff), it_is)
    welded = '<body name="foot"><freejoint /><geom size="0.1" /></body></worldbody>'
    foot = replaced(
        saw(), ("</worldbody>", welded), (CLOSURE, CLOSURE + '<weld name="fast" body1="foot" solref="0.012 1" />'),
        (KEYFRAME, ""),
    )  # fmt: skip
    yield healthy(kind, "a weld of what is not in the loop", *_judged(foot), r"It is saw-40rpm")
    stiff_enough = {"model.xml": saw()}, "check model.xml --drive crank=40rpm --tolerance position=0.1mm"
    yield healthy(kind, "stiff enough, driven", *stiff_enough, JUDGED)
    yield healthy(kind, "stiff enough, by lint", {"model.xml": saw()}, "lint model.xml", r"no findings")
    yield healthy(kind, "soft and hardened", {"model.xml": hacksaw()}, "harden model.xml --seconds 0.5", r"hardened")
