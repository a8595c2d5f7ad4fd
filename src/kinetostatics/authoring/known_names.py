"""Common names of mechanisms: the notation of their limbs, and their arrangement."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from kinetostatics.arguments import Keyword
from kinetostatics.exceptions import ArgumentError


@dataclass(frozen=True)
class KnownName:
    """A mechanism with a common name.

    Attributes:
        architecture: its limbs in the notation.
        about: short description.
        options: arguments of ``new_robot`` that have another default.
        also: further names, which several mechanisms may share.
    """

    name: str
    architecture: str
    about: str
    options: Mapping[str, Keyword] = field(default_factory=dict)
    also: tuple[str, ...] = ()

    @property
    def arrangement(self) -> str:
        return str(self.options.get("arrangement", "symmetric"))

    @property
    def line(self) -> str:
        """Line of ``kinetostatics new --list``."""
        needs = "" if self.arrangement == "symmetric" else f" ({self.arrangement})"
        return f"{self.name:18} {self.architecture:16} {self.about}{needs}"


_PLANAR = {"arrangement": "planar", "platform_radius": 0.08}
_CARTESIAN = {"arrangement": "cartesian", "base_radius": 0.4, "platform_radius": 0.08}
_SPHERICAL = {"arrangement": "spherical", "platform_radius": 0.15}
_HANGING = {"platform_radius": 0.1, "height": -0.5}
_CROSSED = {"azimuths": (0.0, 1.5707963267948966), "platform_radius": 0.1}
#: Carriages in pairs on three parallel rails along X.
_HEXAGLIDE = tuple(
    {"base": (x, y, 0), "platform": (u, v, 0), "guide": (1, 0, 0)}
    for x, y, u, v in (
        (0.25, 0.35, 0.05, 0.19),
        (-0.25, 0.35, -0.05, 0.19),
        (0.45, 0, 0.19, -0.05),
        (-0.45, 0, -0.19, -0.05),
        (0.25, -0.35, 0.14, -0.14),
        (-0.25, -0.35, -0.14, -0.14),
    )
)

KNOWN_NAMES = (
    KnownName("3-RPS", "3-R[P]S", "telescopes on hinges: one translation, two rotations", also=("tripod",)),
    KnownName("Sprint Z3", "3-[P]RS", "carriages and rods: one translation, two rotations", also=("z3", "tripod")),
    KnownName("2-PRU+UPR", "2-[P]RU+U[P]R", "two rods on sliders and a telescope: one translation, two rotations"),
    KnownName("Exechon", "2-U[P]R+S[P]R", "three telescopes, overconstrained: one translation, two rotations", also=("tripod",)),
    KnownName("Tricept", "3-U[P]S+UP", "telescopes around a passive tube: one translation, two rotations", also=("tripod",)),
    KnownName(
        "Gough-Stewart", "6-U[P]S", "six telescopes: all six freedoms", also=("stewart", "gough", "stewart-gough", "hexapod")
    ),
    KnownName("Hexa", "6-[R]US", "cranks and rods: all six freedoms", also=("rotary hexapod",)),
    KnownName("Linapod", "6-[P]US", "rods on upright guides: all six freedoms", {"height": -0.5}),
    KnownName("Hexaglide", "6-[P]US", "rods on three parallel rails: all six freedoms", {"placements": _HEXAGLIDE}),
    KnownName("Delta", "3-[R](4S)", "cranks and pairs of rods: three translations", _HANGING, ("clavel",)),
    KnownName("linear Delta", "3-[P](4S)", "carriages and pairs of rods: three translations", _HANGING, ("keops",)),
    KnownName("3-PUU", "3-[P]UU", "carriages and single rods: three translations", _HANGING),
    KnownName("3-UPU", "3-U[P]U", "telescopes between universal joints: three translations"),
    KnownName(
        "Tripteron", "3-[P]RRR", "a limb along each of X, Y and Z: three translations", _CARTESIAN, ("isoglide", "isoglide3")
    ),
    KnownName("3-CRR", "3-[C]RR", "arms on cylindrical guides along X, Y and Z: three translations", _CARTESIAN),
    KnownName("Orthoglide", "3-[P]R(4R)R", "parallelograms on three rails: three translations", _CARTESIAN),
    KnownName("five-bar", "[R]RR+[R]R", "two arms: a point in a plane", _PLANAR, ("5r", "rrrrr", "double scara", "dextar")),
    KnownName("planar 3-RRR", "3-[R]RR", "three arms: two translations and a rotation in a plane", _PLANAR),
    KnownName("planar 3-RPR", "3-R[P]R", "three telescopes: two translations and a rotation in a plane", _PLANAR),
    KnownName("planar 3-PRR", "3-[P]RR", "three carriages: two translations and a rotation in a plane", _PLANAR),
    KnownName(
        "spherical 3-RRR", "3-[R]RR", "three rotations about a point, an Agile Eye", _SPHERICAL, ("agile eye", "spherical")
    ),
    KnownName("Sarrus", "[R]RR+RRR", "two limbs in perpendicular planes: one translation", _CROSSED),
)

_SERIAL = (
    "is a serial robot, which has no limbs in parallel; kinetostatics new --from FILE extends the URDF of a serial robot, and "
    "kinetostatics robots --copy ur10 copies an example"
)
#: Names of robots without limbs between a base and a platform, with advice.
OTHERS = {
    ("scara",): f'{_SERIAL}; for a double SCARA write kinetostatics new "five-bar"',
    ("puma", "ur", "ur3", "ur5", "ur10", "cartesian", "gantry"): _SERIAL,
    ("h4", "i4", "par4", "quattro"): (
        "has an articulated platform, which the notation of limbs does not describe; write its file by hand"
    ),
    ("cable", "cdpr", "cable driven", "cable driven parallel"): (
        "is driven by cables, which transmit tension only; limbs here transmit tension and compression"
    ),
}


def named(text: str) -> KnownName | None:
    """Return the mechanism with a name such as "Stewart platform" or "5R"; None if the name is unknown.

    Upper and lower case are the same, and words such as "robot" or "platform" are optional.

    Raises:
        ArgumentError: several mechanisms have this name, or it is the name of a robot of another kind (``OTHERS``).
    """
    name = _normalized(text)
    for names, reason in OTHERS.items():
        if name in map(_normalized, names):
            raise ArgumentError(f"{text!r} {reason}")
    matches = [mechanism for mechanism in KNOWN_NAMES if name in map(_normalized, (mechanism.name, *mechanism.also))]
    return _single(text, [mechanism for mechanism in matches if name != _normalized(mechanism.architecture)])  # 3-RPS is notation


def _single(text: str, matches: list[KnownName]) -> KnownName | None:
    """Return the only element of ``matches``, or None if it is empty. Raise an ArgumentError if it has several elements."""
    if len(matches) > 1:
        commands = " or ".join(f'kinetostatics new "{mechanism.name}" ({mechanism.about})' for mechanism in matches)
        raise ArgumentError(f"{text!r} is more than one mechanism; write {commands}")
    return matches[0] if matches else None


def options_of(text: str, architecture: str, given: Mapping[str, Keyword]) -> dict[str, Keyword]:
    """Return the default arguments of ``new_robot`` for ``text``, a common name or limbs in the notation.

    Limbs in the notation have the defaults of the named mechanism with these limbs and the given arrangement, more than three of
    them those of three if these move in the plane only; they have none if there is no such mechanism, or if placements are given.
    ``architecture``: ``text`` in the notation, each actuator in brackets.

    Raises:
        ArgumentError: several named mechanisms have these limbs, such as the planar and the spherical 3-RRR.
    """
    if (mechanism := named(text)) is None and "placements" not in given:
        without_table = [mechanism for mechanism in KNOWN_NAMES if "placements" not in mechanism.options]
        alike = [mechanism for mechanism in without_table if mechanism.architecture == architecture]
        count, _, limb = architecture.partition("-")
        of_three = [mechanism for mechanism in KNOWN_NAMES if mechanism.architecture == f"3-{limb}"]
        if not alike and count.isdigit() and int(count) > 3 and [mechanism.options for mechanism in of_three] == [_PLANAR]:
            alike = of_three  # redundantly actuated
        alike = [mechanism for mechanism in alike if given.get("arrangement", mechanism.arrangement) == mechanism.arrangement]
        mechanism = _single(text, alike)
    return {} if mechanism is None else dict(mechanism.options)


def _normalized(text: str) -> str:
    words = re.sub(r"\b(robot|platform|mechanism|manipulator|machine|linkage|wrist)\b", "", text.lower())
    return re.sub("[^a-z0-9]", "", words)
