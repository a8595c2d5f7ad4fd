"""Tables of the elements of robot files, and functions that write parts of a description by these tables.

Rules that concern several elements are in :mod:`rules`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable

from kinetostatics.arguments import Keyword
from kinetostatics.description.elements import Beam, BeamEnd, Joint, JointStiffness, Link, Loop, Spring
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.attributes import (
    DIRECTION,
    NAME,
    NOT_NEGATIVE,
    NUMBER,
    POINT,
    POSITIVE,
    POSITIVE_OR_INF,
    STIFFNESSES,
    TEXT,
    VECTOR,
    ElementTable,
    Row,
    written,
)
from kinetostatics.files.xml import XmlElement
from kinetostatics.sections.kinds import Rectangle, RectangularTube, Section, Tube

_X, _Y, _Z, _ZERO = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)


def _frame(name: str) -> tuple[Row, ...]:
    return Row("xyz", POINT, _ZERO, f"{name}.xyz"), Row("rpy", VECTOR, _ZERO, f"{name}.rpy")


def _limit(needed: bool) -> tuple[Row, ...]:
    dynamic = (Row(name, NOT_NEGATIVE, 0.0, must=needed) for name in ("effort", "velocity"))
    return Row("lower", NUMBER, None), Row("upper", NUMBER, None), *dynamic


# ---- links and joints --------------------------------------------------------------------------------------------------

INERTIAL = ElementTable(
    "inertial",
    {
        "": (),
        "origin": (Row("xyz", POINT, _ZERO, "center_of_mass"), Row("rpy", VECTOR, _ZERO, "rpy")),
        "mass": (Row("value", NOT_NEGATIVE, name="mass"),),
    },
    open=("", "mass"),
)
SHAPE = ElementTable("visual", {"": (), "origin": _frame("origin")}, open=("",))
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
JOINT = ElementTable(
    "joint",
    {
        "": (Row("name", NAME), Row("type", TEXT)),
        "parent": (Row("link", TEXT, name="parent"),),
        "child": (Row("link", TEXT, name="child"),),
        "origin": _frame("origin"),
        "axis": (Row("xyz", DIRECTION, _X, "axis", must=True),),
        "limit": _limit(needed=True),
        "mimic": (
            Row("joint", TEXT, None, "mimic.joint", must=True),
            Row("multiplier", NUMBER, 1.0, "mimic.multiplier"),
            Row("offset", NUMBER, 0.0, "mimic.offset"),
        ),
    },
    open=("", "parent", "child", "axis", "limit"),
)
BASE = ElementTable("base", {"": (Row("link", TEXT, name="base"),)})
PLATFORM = ElementTable("platform", {"": (Row("link", TEXT, name="platform"),), "origin": _frame("platform_origin")})
LOOP = ElementTable(
    "loop",
    {
        "": (Row("name", NAME), Row("type", TEXT)),
        "predecessor": (Row("link", TEXT, name="predecessor"),),
        "predecessor/origin": _frame("predecessor_origin"),
        "successor": (Row("link", TEXT, name="successor"),),
        "successor/origin": _frame("successor_origin"),
        "axis": (Row("xyz", DIRECTION, _X, "axis", must=True),),
        "axis2": (Row("xyz", DIRECTION, _Y, "axis2", must=True),),
        "limit": _limit(needed=False),
        "cone": (
            Row("angle", POSITIVE, None, "cone.angle", must=True),
            Row("predecessor_axis", DIRECTION, _Z, "cone.predecessor_axis"),
            Row("successor_axis", DIRECTION, _Z, "cone.successor_axis"),
        ),
    },
)


def limits(found: dict[str, Keyword], element: XmlElement) -> None:
    """Complete ``lower`` and ``upper``: infinite if both are missing; zero for one that is missing alone, as in URDF."""
    lower, upper = found["lower"], found["upper"]
    if lower is None and upper is None:
        found["lower"], found["upper"] = -math.inf, math.inf
        return
    found["lower"], found["upper"] = (0.0 if value is None else value for value in (lower, upper))
    if found["lower"] > found["upper"]:
        note = " (the one left out is 0)" if lower is None or upper is None else ""
        raise element.required_child("limit").error(f"<limit> has lower={found['lower']:g} above upper={found['upper']:g}{note}")


def _unlimited(item: Joint | Loop) -> dict[str, Keyword]:
    """Return values by field that omit the attributes ``lower`` and ``upper`` of a joint without limits."""
    return {"lower": None, "upper": None} if (item.lower, item.upper) == (-math.inf, math.inf) else {}


def write_link(link: Link, extra: Iterable[XmlElement]) -> XmlElement:
    label = f"link {link.name!r}"
    inertial: list[XmlElement] = []
    if link.has_inertial:
        try:
            moments = written("numbers", link.inertia.moments).split()
        except ArgumentError as error:
            raise link.place.error(f"inertia of {label} {error}") from None
        if len(moments) != len(MOMENTS):
            raise link.place.error(f"inertia of {label} has {len(moments)} moments; it must have six: {', '.join(MOMENTS)}")
        inertia = XmlElement("inertia", dict(zip(MOMENTS, moments, strict=True)), (), link.place, label)
        inertial.append(INERTIAL.write(link, link.place, label, given={"rpy": link.inertia.rpy}, more=[inertia]))
    return XmlElement("link", {"name": link.name}, (*inertial, *extra), link.place, label)


def write_joint(joint: Joint, extra: Iterable[XmlElement]) -> XmlElement:
    kind = JOINT_TYPES.get(joint.type)
    always = [path for path, there in (("axis", kind and kind.has_axis), ("limit", kind and kind.has_limits)) if there]
    return JOINT.write(joint, joint.place, f"joint {joint.name!r}", given=_unlimited(joint), always=always, more=extra)


def write_loop(loop: Loop) -> XmlElement:
    kind = JOINT_TYPES.get(loop.type)
    always = ("axis",) if kind is not None and kind.has_axis else ()
    return LOOP.write(loop, loop.place, f"loop {loop.name!r}", given=_unlimited(loop), always=always)


# ---- beams -------------------------------------------------------------------------------------------------------------


def _sizes(*names: str) -> tuple[Row, ...]:
    return tuple(Row(name, POSITIVE) for name in names)


#: Elements of sections by tag: the class of the section, and the table of the element.
SECTIONS: dict[str, tuple[type[Section], ElementTable]] = {
    tag: (kind, ElementTable(tag, {"": rows}))
    for tag, kind, rows in (
        ("circle", Tube, (Row("diameter", POSITIVE, name="outer_diameter"),)),
        ("tube", Tube, _sizes("outer_diameter", "inner_diameter")),
        ("rectangle", Rectangle, _sizes("width", "height")),
        ("rectangular_tube", RectangularTube, _sizes("width", "height", "thickness")),
        (
            "section",
            Section,
            (*_sizes("area", "I_y", "I_z", "J"), *(Row(name, POSITIVE, None) for name in ("shear_area_y", "shear_area_z"))),
        ),
    )
}
BEAM = ElementTable(
    "beam",
    {
        "": (
            Row("name", NAME, None),
            Row("link", TEXT),
            Row("from", TEXT, None, "start"),
            Row("to", TEXT, None, "end"),
            Row("youngs_modulus", POSITIVE, name="material.youngs_modulus"),
            Row("poisson_ratio", NUMBER, None, "material.poisson_ratio"),
            Row("shear_modulus", POSITIVE, None, "material.shear_modulus"),
            Row("shear_coefficient", POSITIVE_OR_INF, None),
            Row("density", NOT_NEGATIVE, None, "material.density"),
            Row("thermal_expansion", NUMBER, 0.0, "material.thermal_expansion"),
            Row("y_axis", DIRECTION, None),
        )
    },
    SECTIONS,
)


def read_section(beam: XmlElement) -> Section:
    found = beam.children
    if len(found) != 1:
        known = ", ".join(f"<{tag}>" for tag in SECTIONS)
        raise (found[1] if found else beam).error(f"{beam.label} has {len(found) or 'no'} sections; give one of {known}")
    kind, table = SECTIONS[found[0].tag]
    numbers = table.read(found[0])
    given = [name for name in ("shear_area_y", "shear_area_z") if numbers.get(name) is not None]
    if len(given) == 1:
        raise found[0].error(f"<section> has {given[0]} alone; give both shear_area_y and shear_area_z, or neither")
    try:
        return kind(**numbers) if kind is Section else kind.of(**numbers)  # type: ignore[attr-defined]
    except ArgumentError as error:
        raise found[0].error(f"{found[0].label}: {error}") from None


def write_beam(beam: Beam, joints: Collection[str]) -> XmlElement:
    """Return a ``<beam>``; ``joints`` are the names of all joints and loops."""
    label = f"beam {beam.name!r}"
    ends = {"start": _end(beam.start, beam, joints), "end": _end(beam.end, beam, joints)}
    name = None if beam.name == beam.link else beam.name
    return BEAM.write(beam, beam.place, label, given={**ends, "name": name}, more=[_write_section(beam, label)])


def _end(end: BeamEnd | None, beam: Beam, joints: Collection[str]) -> str | None:
    if end is None or end.side is None:
        return None if end is None else end.joint
    text = f"{end.joint}:{end.side}"
    if text in joints:
        what = f"an end of beam {beam.name!r} is the {end.side} side of {end.joint!r}"
        raise beam.place.error(f"{what}, but a joint is called {text!r} as well")
    return text


def _write_section(beam: Beam, label: str) -> XmlElement:
    section = beam.section
    table = dict(SECTIONS.values()).get(type(section))  # of a tube <tube>
    if table is None:
        raise beam.place.error(f"the section of {label} is {section!r}; take one of kinetostatics.sections")
    if type(section) is not Section:
        try:
            same = type(section).of(*(getattr(section, row.field) for row in table.rows[""])) == section  # type: ignore[attr-defined]
        except (ArithmeticError, ArgumentError):
            same = True  # the reader will reject these sizes
        if not same:
            kind = type(section).__name__
            raise beam.place.error(
                f"the numbers of the section of {label} do not agree with its sizes; make it with {kind}.of(…)"
            )
    if type(section) is Tube and not section.inner_diameter:
        table = SECTIONS["circle"][1]
    return table.write(section, beam.place, label)


# ---- springs and elastic joints ------------------------------------------------------------------------------------------

SPRING = ElementTable(
    "spring",
    {
        "": (Row("name", NAME), Row("stiffness", NOT_NEGATIVE), Row("free_length", NOT_NEGATIVE), Row("preload", NUMBER, 0.0)),
        "predecessor": (Row("link", TEXT, name="predecessor"),),
        "predecessor/origin": (Row("xyz", POINT, _ZERO, "predecessor_point"),),
        "successor": (Row("link", TEXT, name="successor"),),
        "successor/origin": (Row("xyz", POINT, _ZERO, "successor_point"),),
    },
)
COUNTERWEIGHT = ElementTable(
    "counterweight",
    {"": (Row("name", NAME), Row("link", TEXT), Row("mass", POSITIVE)), "origin": (Row("xyz", POINT, _ZERO, "point"),)},
)
JOINT_STIFFNESS = ElementTable(
    "joint_stiffness",
    {
        "": (
            Row("joint", TEXT),
            Row("linear", STIFFNESSES, None),
            Row("angular", STIFFNESSES, None),
            Row("drive", POSITIVE_OR_INF, None),
        )
    },
)


def write_spring(spring: Spring) -> XmlElement:
    return SPRING.write(spring, spring.place, f"spring {spring.name!r}")


def write_stiffness(item: JointStiffness) -> XmlElement:
    """Return a ``<joint_stiffness>``; infinite linear stiffnesses are written if the item has none at all."""
    rigid = item.linear is None and item.angular is None and item.drive is None
    given = {"linear": (math.inf,) * 3} if rigid else None
    return JOINT_STIFFNESS.write(item, item.place, f"stiffness {item.joint!r}", given=given)
