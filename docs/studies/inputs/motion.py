"""Models that start, are driven and are acted upon otherwise than meant, and others that are as they should be."""

from __future__ import annotations

from collections.abc import Iterator

from docs.studies.inputs.edits import (
    CRANK,
    HACKSAW,
    KEYFRAME,
    PIN,
    SAW,
    SLIDE,
    SMALL,
    exported,
    hacksaw,
    replaced,
    saw,
    saw_keyframe,
    served,
    toml,
)  # fmt: skip
from docs.studies.inputs.geometry import JUDGED, MEASURED, _judged
from docs.studies.inputs.input import Input, healthy, wrong

STARTS, DRIVES, BESIDES = "starts and keyframes", "drives, speeds, actuators", "what acts besides"
IT_IS = r"It is saw-40rpm\..* Driven by conrod, its own settings are within tolerance"
DRIVEN = "check model.xml --drive crank=40rpm --tolerance position=0.1mm"
FORTY = 4.1887902047863905  # [rad/s]


def _keyed(key: str) -> str:
    return replaced(saw(), (KEYFRAME, key))


def starts() -> Iterator[Input]:
    """Starts that are open, elsewhere or said wrongly, and starts anywhere on the motion."""
    kind = STARTS
    open_ = _keyed(KEYFRAME.replace('qpos="0 0 0"', 'qpos="0.03 0 0"'))
    yield wrong(kind, "a keyframe that is open by 30 mm", *_judged(open_), r"(begins|starts?).*open", (1,))
    # The other branch of the slider-crank: the slider on the other side of the shaft.
    other = _keyed(
        f'<key name="start" qpos="-0.572364 0 {-2 * 2.836899999574396 + 3.141592653589793 + 2.836899999574396}"/>'
    )
    yield wrong(
        kind, "a keyframe on the other branch", *_judged(other), r"other (assembly )?branch|begins.*open|flipped", (1,)
    )
    fast = _keyed(saw_keyframe(0.0, 1.3))
    yield wrong(kind, "a keyframe whose rates are 30 % too fast", *_judged(fast), r"rate|speed|rpm", (1,))
    absent = _judged(saw(), "--keyframe begin")
    yield wrong(kind, "a keyframe that there is none of", *absent, r"begin.*start", (2,))
    leaning = replaced(saw(), ('euler="0 0 2.836899999574396"', 'euler="0 0 2.6"'), (KEYFRAME, ""))
    yield wrong(kind, "a reference pose that is open", {"model.xml": leaning}, DRIVEN, r"(begins|starts?|start).*open")
    zero = _judged(saw(), "--crank-zero 5deg")
    yield wrong(kind, "a crank zero said to be 5 deg elsewhere", *zero, r"crank.?zero|--crank-zero|zero", (1,))
    turn = _judged(saw(), "--rotation 3deg --crank-zero 0deg")
    yield wrong(kind, "a frame said to be turned by 3 deg", *turn, r"rotation|turned", (1,))
    plane = _judged(saw(), "--plane xz")
    yield wrong(kind, "a plane that it does not move in", *plane, r"plane")
    ranged = replaced(saw(), (SLIDE, SLIDE.replace(" />", ' range="-0.1 0.1" />')), (' armature="1e+14"', ""))
    drive = {"model.xml": ranged}, "check model.xml --drive slide=move:0m,-0.15m,1s --tolerance position=1mm"
    yield wrong(kind, "a law that leaves its joint's range", *drive, r"range|limit")
    strayed = replaced(toml("slider-crank"), ("rod = { turn = 0 }", 'rod = { turn = "110 deg" }'))
    file = {"m.toml": strayed}, "validate m.toml --engine mujoco --preset hardened --steps-per-rev 200"
    yield wrong(
        kind, "a start nearer to another assembly", *file, r"start\.rod\.turn|leads to an assembly|cannot", (2,)
    )

    for degrees in (30.0, 90.0, 135.0, 200.0):
        key = _keyed(saw_keyframe(degrees))
        yield healthy(kind, f"a keyframe at {degrees:g} deg", *_judged(key), IT_IS)
    yield healthy(kind, "no keyframe", *_judged(_keyed("")), IT_IS)
    at_rest = _keyed('<key name="start" qpos="0 0 0" />')
    # A keyframe is a start, and one at rest stands still: what only others drive starts from none.
    yield healthy(kind, "a keyframe at rest, not started from", *_judged(at_rest, "--keyframe qpos0"), IT_IS)
    two = _keyed('<key name="rest" qpos="0 0 0" />' + saw_keyframe(60.0))
    yield healthy(kind, "a second keyframe by its name", *_judged(two, "--keyframe start"), IT_IS)
    yield healthy(
        kind, "the frame said as it is", *_judged(saw(), "--plane xy --rotation 0deg --crank-zero 0deg"), IT_IS
    )
    six = _keyed(KEYFRAME.replace("-0.1317313576766063", "-0.131731").replace("-2.7251084528240996", "-2.72511"))
    yield healthy(kind, "rates in six digits", *_judged(six), IT_IS)
    drive = {"model.xml": _keyed(saw_keyframe(45.0))}, DRIVEN + " --keyframe start"
    yield healthy(kind, "driven from 45 deg", *drive, JUDGED)


def drives() -> Iterator[Input]:
    """Servos and laws that move the machine otherwise than meant, and others that do as meant."""
    kind = DRIVES
    for name, control, words in (
        ("a servo at 41 rpm", 1.03 * FORTY, r"strays.*41"),
        ("a servo that turns backwards", -FORTY, r"strays.*-4\d|backwards|opposite sense"),
        ("a servo at half its speed", 0.5 * FORTY, r"strays.*20"),
    ):
        yield wrong(kind, name, *_judged(served(saw(), control)), words, (1,))
    weak = _judged(served(saw(), FORTY, gain=0.2))
    yield wrong(kind, "a servo too weak to carry the saw", *weak, r"strays|stands? still|stall", (1,))
    stiff = served(saw(), FORTY, gain=100.0, timestep=0.0015).replace('autoreset="disable" ', "")
    yield wrong(kind, "a servo too stiff for the step", *_judged(stiff), r"reset|BADQACC|unstable|diverged", (1,))
    plain = {"model.xml": saw()}
    yield wrong(
        kind, "a hinge's law in mm/s", plain, "check model.xml --drive crank=40mm/s", r"crank=40mm/s|mm/s", (2,)
    )
    yield wrong(
        kind, "a joint that there is none of", plain, "check model.xml --drive cranc=40rpm", r"cranc.*crank", (2,)
    )
    two = "check model.xml --drive crank=40rpm --drive slide=hold"
    yield wrong(kind, "more drives than degrees of freedom", plain, two, r"degrees? of freedom|mobility|drives?", (2,))
    far = "check model.xml --drive slide=move:0m,-0.5m,1s"
    yield wrong(kind, "a stroke longer than the linkage's", plain, far, r"goes no further|dead centre|reach")
    words = f"check model.xml {SAW} {SMALL} --ctrl motor=fast"
    yield wrong(
        kind, "a control that is no number", {"model.xml": served(saw(), FORTY)}, words, r"motor=fast|fast", (2,)
    )

    keeps = r"keeps to the 40 rpm"
    loose = f"check model.xml {SAW} --tolerance position=1e-3"
    for gain in (60.0, 100.0):
        text = {"model.xml": served(saw(), FORTY, gain=gain, timestep=0.0003)}
        yield healthy(kind, f"a servo of gain {gain:g}", text, loose, keeps)
    asked = {"model.xml": served(saw(), 0.0)}, f"{loose} --ctrl motor={FORTY}"
    yield healthy(kind, "its control on the command line", *asked, keeps)
    off = {"model.xml": served(saw(), 0.0)}, f"{loose} --keyframe qpos0"
    yield healthy(kind, "a servo that is commanded nothing", *off, r"nothing drives it")
    fine = "--tolerance position=0.1mm"
    yield healthy(
        kind, "the slide driven", {"model.xml": replaced(saw(), (' armature="1e+14"', ""))},
        f"check model.xml --drive slide=move:0m,-0.1m,1s {fine}", JUDGED,
    )  # fmt: skip
    for name, command in (
        ("a speed in deg/s", f"check model.xml --drive crank=240deg/s {fine}"),
        ("a rocking crank", f"check model.xml --drive crank=sine:40deg,1Hz {fine}"),
        ("a crank that moves from place to place", f"check model.xml --drive crank=move:0deg,90deg,1s {fine}"),
    ):
        yield healthy(kind, name, plain, command, JUDGED)
    # Its keyframe turns as the law does: a file that turns the other way by itself is not what the law prescribes.
    backwards = {"model.xml": _keyed(saw_keyframe(0.0, -1.0))}
    yield healthy(kind, "backwards", backwards, f"check model.xml --drive crank=-40rpm {fine}", JUDGED)
    yield healthy(kind, "without a tolerance", plain, "check model.xml --drive crank=40rpm", r"measured, not judged")


def besides() -> Iterator[Input]:
    """What stands in the way or pushes besides, and what does not."""
    kind = BESIDES
    stop = replaced(saw(), (SLIDE, SLIDE.replace(" />", ' range="-0.1 0.1" />')))
    yield wrong(kind, "a stop in the way of the slide", *_judged(stop), r"limit|range|stop", (1,))
    quarter = replaced(saw(), (CRANK, CRANK.replace(" armature", ' range="-1.5 1.5" armature')))
    yield wrong(kind, "a stop in the way of the crank", *_judged(quarter), r"limit|range|stop", (1,))
    rope = (
        '<tendon><spatial name="rope" range="0 0.25"><site site="hook" /><site site="C" /></spatial></tendon><equality>'
    )
    roped = replaced(
        saw(), ("<worldbody>", '<worldbody><site name="hook" pos="0.2 0 0" />'), ("<equality>", rope)
    )  # fmt: skip
    yield wrong(kind, "a rope that is too short", *_judged(roped), r"rope|tendon", (1,))
    block = replaced(
        saw(),
        ('contact="disable" ', ""),
        ("<worldbody>", '<worldbody><geom name="block" type="box" pos="-0.16 0 0" size="0.02 0.05 0.02" />'),
        ('size="0.02576 0.02576 0.008585" rgba="0.6 0.6 0.6 1" contype="0" conaffinity="0"',
         'size="0.02576 0.02576 0.008585" rgba="0.6 0.6 0.6 1"'),
    )  # fmt: skip
    yield wrong(kind, "a block in the way of the slider", *_judged(block), r"contact|collid|block", (1,))
    servo = served(saw(), FORTY, gain=60.0)
    acting = {
        "dry friction in the slide": (SLIDE.replace(" />", ' frictionloss="600" />'), r"friction"),
        "a spring on the slide": (SLIDE.replace(" />", ' stiffness="4000" />'), r"spring|stiffness"),
        "a damper on the slide": (SLIDE.replace(" />", ' damping="1500" />'), r"damp"),
    }
    for name, (text, words) in acting.items():
        yield wrong(kind, name, *_judged(replaced(servo, (SLIDE, text))), words, (1,))
    spring = '<tendon><fixed name="band" stiffness="6000"><joint joint="slide" coef="1" /></fixed></tendon><equality>'
    yield wrong(
        kind, "a band on the slide", *_judged(replaced(servo, ("<equality>", spring))), r"band|tendon|spring", (1,)
    )
    push = '<actuator><motor name="push" joint="slide" gear="900" />'
    pushed = replaced(servo, ("<actuator>", push), (f'ctrl="{FORTY}"', f'ctrl="1 {FORTY}"'))
    yield wrong(kind, "a second actuator that pushes", *_judged(pushed), r"push|actuator", (1,))
    bent = '<joint name="bent" joint1="slide" joint2="crank" polycoef="0 -0.03 -0.02 0 0" /></equality>'
    curved = replaced(saw(), ("</equality>", bent), (KEYFRAME, ""))
    yield wrong(kind, "a joint equality with a quadratic term", *_judged(curved), r"bent|equality|quadratic")

    wide = replaced(saw(), (SLIDE, SLIDE.replace(" />", ' range="-0.5 0.5" />')))
    yield healthy(kind, "stops that are out of reach", *_judged(wide), IT_IS)
    long_rope = replaced(roped, ('range="0 0.25"', 'range="0 2"'))
    yield healthy(kind, "a rope that is long enough", *_judged(long_rope), IT_IS)
    aside = replaced(block, ('pos="-0.16 0 0"', 'pos="-0.5 0 0"'))
    yield healthy(kind, "a block that is not in the way", *_judged(aside), IT_IS)
    free = replaced(saw(), ('gravity="0 -9.81 0"', 'gravity="0 0 0"'))
    yield healthy(kind, "no gravity", *_judged(free), IT_IS)
    moon = replaced(saw(), ('gravity="0 -9.81 0"', 'gravity="0 -1.62 0"'))
    yield healthy(kind, "another gravity", *_judged(moon), IT_IS)
    heavy = replaced(saw(), ('mass="6" diaginertia="0.06 0.06 0.06"', 'mass="9" diaginertia="0.09 0.09 0.09"'))
    yield healthy(kind, "a heavier slider", *_judged(heavy), IT_IS)
    damped = replaced(saw(), (PIN, PIN.replace(" />", ' damping="0.02" />')))
    yield healthy(kind, "a little damping in a pin", *_judged(damped), IT_IS)
    yield healthy(kind, "stops out of reach, driven", {"model.xml": wide}, DRIVEN, JUDGED)
    mesh = replaced(hacksaw(), ('<geom name="bed"', '<geom name="post" pos="2 2 2" size="0.1 0.2" /><geom name="bed"'))
    yield healthy(kind, "a geom more on the ground", {"model.xml": mesh}, f"check model.xml {HACKSAW}", MEASURED)
    cutter = {"model.xml": exported("web-cutter")}
    fine = "check model.xml --drive crank=120rpm --tolerance position=0.1mm"
    yield healthy(kind, "weight and nothing else, driven", cutter, fine, JUDGED)
