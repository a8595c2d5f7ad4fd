"""Tables of the elements of robot files, and functions that write parts of a description by these tables.

Rules that concern several elements are in :mod:`rules`.
"""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Iterable

from kinetostatics.arguments import Keyword
from kinetostatics.description.elements import Beam, BeamEnd, Inertia, JointStiffness, Link, Origin, Spring, check_section
from kinetostatics.description.fields import NUMBER, PAIR, POSITIVE, TEXT
from kinetostatics.description.flexible import Flexible
from kinetostatics.description.joints import NO_LIMITS, Joint, Loop
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.attributes import NEEDED, ElementTable, Row, row, written
from kinetostatics.files.xml import XmlElement
from kinetostatics.sections.kinds import Rectangle, RectangularTube, Section, Tube
from kinetostatics.sections.tapered import Station, Tapered


def _frame(part: type, name: str) -> tuple[Row, ...]:
    return row(part, "xyz", f"{name}.xyz"), row(part, "rpy", f"{name}.rpy")


def _limit(part: type, needed: bool) -> tuple[Row, ...]:
    limits = (row(part, name, kind=NUMBER, default=None) for name in ("lower", "upper"))
    return *limits, *(row(part, name, must=needed) for name in ("effort", "velocity"))


# ---- links and joints --------------------------------------------------------------------------------------------------

INERTIAL = ElementTable(
    "inertial",
    {
        "": (),
        "origin": (row(Link, "xyz", "center_of_mass"), row(Inertia, "rpy")),
        "mass": (row(Link, "value", "mass", default=NEEDED),),
    },
    open=("", "mass"),
)
SHAPE = ElementTable("visual", {"": (), "origin": (row(Origin, "xyz"), row(Origin, "rpy"))}, open=("",))
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
JOINT = ElementTable(
    "joint",
    {
        "": (row(Joint, "name"), row(Joint, "type")),
        "parent": (row(Joint, "link", "parent"),),
        "child": (row(Joint, "link", "child"),),
        "origin": _frame(Joint, "origin"),
        "axis": (row(Joint, "xyz", "axis", must=True),),
        "limit": _limit(Joint, needed=True),
        "mimic": (
            row(Joint, "joint", "mimic.joint", default=None, must=True),
            row(Joint, "multiplier", "mimic.multiplier"),
            row(Joint, "offset", "mimic.offset"),
        ),
    },
    open=("", "parent", "child", "axis", "limit"),
)
BASE = ElementTable("base", {"": (Row("link", TEXT, name="base"),)})
PLATFORM = ElementTable(
    "platform", {"": (row(RobotDescription, "link", "platform"),), "origin": _frame(RobotDescription, "platform_origin")}
)
LIMITS_OF_LOOP = _limit(Loop, needed=False)
LOOP = ElementTable(
    "loop",
    {
        "": (row(Loop, "name"), row(Loop, "type")),
        "predecessor": (row(Loop, "link", "predecessor"),),
        "predecessor/origin": _frame(Loop, "predecessor_origin"),
        "successor": (row(Loop, "link", "successor"),),
        "successor/origin": _frame(Loop, "successor_origin"),
        "axis": (row(Loop, "xyz", "axis", must=True),),
        "axis2": (row(Loop, "xyz", "axis2", must=True),),
        "limit": LIMITS_OF_LOOP,
        "cone": (
            row(Loop, "angle", "cone.angle", default=None, must=True),
            row(Loop, "predecessor_axis", "cone.predecessor_axis"),
            row(Loop, "successor_axis", "cone.successor_axis"),
        ),
    },
)


def limits(values: dict[str, Keyword]) -> None:
    """Complete ``lower`` and ``upper``: infinite if both are missing; zero for one that is missing alone, as in URDF."""
    lower, upper = values["lower"], values["upper"]
    if lower is None and upper is None:
        values["lower"], values["upper"] = NO_LIMITS
    else:
        values["lower"], values["upper"] = (0.0 if value is None else value for value in (lower, upper))


def unlimited(connection: Joint | Loop) -> dict[str, Keyword]:
    """Return values by field that omit the attributes ``lower`` and ``upper`` of a joint without limits."""
    return {"lower": None, "upper": None} if (connection.lower, connection.upper) == NO_LIMITS else {}


def write_link(link: Link, extra: Iterable[XmlElement]) -> XmlElement:
    inertial: list[XmlElement] = []
    if link.has_inertial:
        moments = written("numbers", link.inertia.moments).split()
        inertia = XmlElement("inertia", dict(zip(MOMENTS, moments, strict=True)), (), link.place)
        inertial.append(INERTIAL.write(link, given={"rpy": link.inertia.rpy}, more=[inertia]))
    return XmlElement("link", {"name": link.name}, (*inertial, *extra), link.place)


def write_joint(joint: Joint, extra: Iterable[XmlElement]) -> XmlElement:
    always = [path for path, there in (("axis", joint.of_type.has_axis), ("limit", joint.of_type.has_limits)) if there]
    return JOINT.write(joint, given=unlimited(joint), always=always, more=extra)


def write_loop(loop: Loop) -> XmlElement:
    return LOOP.write(loop, given=unlimited(loop), always=("axis",) if loop.of_type.has_axis else ())


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
            row(Beam, "name", default=None),
            row(Beam, "link"),
            Row("from", TEXT, None, "start"),
            Row("to", TEXT, None, "end"),
            row(Beam, "youngs_modulus", "material.youngs_modulus"),
            *(row(Beam, name, f"material.{name}") for name in ("poisson_ratio", "shear_modulus")),
            row(Beam, "shear_coefficient"),
            *(row(Beam, name, f"material.{name}") for name in ("density", "thermal_expansion", "yield_strength")),
            row(Beam, "y_axis"),
        )
    },
    (*SECTIONS, "station"),
)
STATION = ElementTable("station", {"": (Row("at", NUMBER), Row("offset", PAIR, (0.0, 0.0)))}, SECTIONS)


def read_section(beam: XmlElement) -> Section:
    """Return the section of a ``<beam>`` or ``<station>``."""
    sections = beam.children
    if sections and all(element.tag == "station" for element in sections):
        try:
            return Tapered.of([Station(section=read_section(element), **STATION.read(element)) for element in sections])
        except ArgumentError as error:
            raise beam.error(f"{beam.label}: {error}") from None
    if len(sections) != 1 or sections[0].tag == "station":
        allowed = ", ".join(f"<{tag}>" for tag in SECTIONS)
        reason = f"{beam.label} has {len(sections) or 'no'} sections; give one of {allowed}"
        raise (sections[1] if sections else beam).error(reason)
    kind, table = SECTIONS[sections[0].tag]
    numbers = table.read(sections[0])
    try:
        section = kind(**numbers) if kind is Section else kind.of(**numbers)  # type: ignore[attr-defined]
        check_section(section)
    except ArgumentError as error:
        raise sections[0].error(f"{sections[0].label}: {error}") from None
    return section


def write_beam(beam: Beam, joints: Collection[str]) -> XmlElement:
    """Return a ``<beam>``; ``joints`` are the names of all joints and loops."""
    ends = {"start": _end(beam.start, beam, joints), "end": _end(beam.end, beam, joints)}
    if isinstance(beam.section, Tapered):
        sections = [STATION.write(station, more=[_section(station.section)]) for station in beam.section.stations]
    else:
        sections = [_section(beam.section)]
    return BEAM.write(beam, given={**ends, "name": None if beam.name == beam.link else beam.name}, more=sections)


def _section(section: Section) -> XmlElement:
    table = dict(SECTIONS.values())[type(section)]  # of a tube <tube>
    if type(section) is Tube and not section.inner_diameter:
        table = SECTIONS["circle"][1]
    return table.write(section)


def _end(end: BeamEnd | None, beam: Beam, joints: Collection[str]) -> str | None:
    if end is None or end.side is None:
        return None if end is None else end.joint
    text = f"{end.joint}:{end.side}"
    if text in joints:
        what = f"an end of beam {beam.name!r} is the {end.side} side of {end.joint!r}"
        raise beam.place.error(f"{what}, but a joint is called {text!r} as well")
    return text


FLEXIBLE = ElementTable(
    "flexible",
    {
        "": (
            row(Flexible, "name", default=None),
            row(Flexible, "link"),
            Row("file", TEXT),
            row(Flexible, "stiffness_factor"),
        )
    },
)


def write_flexible(part: Flexible, folder: str) -> XmlElement:
    """Return a ``<flexible>`` in a robot file in a folder."""
    file = os.path.relpath(part.file, folder or ".") if part.file else f"{part.name}.npz"
    return FLEXIBLE.write(part, given={"file": file, "name": None if part.name == part.link else part.name})


# ---- springs and elastic joints ------------------------------------------------------------------------------------------

SPRING = ElementTable(
    "spring",
    {
        "": (row(Spring, "name"), row(Spring, "stiffness"), row(Spring, "free_length", default=NEEDED), row(Spring, "preload")),
        "predecessor": (row(Spring, "link", "predecessor"),),
        "predecessor/origin": (row(Spring, "xyz", "predecessor_point"),),
        "successor": (row(Spring, "link", "successor"),),
        "successor/origin": (row(Spring, "xyz", "successor_point"),),
    },
)
COUNTERWEIGHT = ElementTable(
    "counterweight",
    {
        "": (row(Link, "name"), row(Beam, "link"), row(Link, "mass", kind=POSITIVE, default=NEEDED)),
        "origin": (row(Origin, "xyz", name="point"),),
    },
)
JOINT_STIFFNESS = ElementTable(
    "joint_stiffness",
    {"": (*(row(JointStiffness, name) for name in ("joint", "linear", "angular", "drive", "matrix")), Row("file", TEXT, None))},
)


def write_stiffness(stiffness: JointStiffness) -> XmlElement:
    """Return a ``<joint_stiffness>`` with its matrix; infinite linear stiffnesses are written if it has none at all."""
    kinds = (stiffness.linear, stiffness.angular, stiffness.drive, stiffness.matrix)
    rigid = {} if any(kinds) else {"linear": (math.inf,) * 3}
    return JOINT_STIFFNESS.write(stiffness, given={"file": None, **rigid})
