"""The notation of parallel mechanisms: ``3-R[P]S``, ``2-[P]RU+U[P]R``, ``3-U[P]S+UP``, ``3-[R](4S)``.

A mechanism is a sum of limbs; ``3-`` denotes three equal limbs. A limb is a string of joints from base to platform:

====== ================ ========
letter joint            freedoms
====== ================ ========
R      revolute         1
P      prismatic        1
C      cylindrical      2
U      universal        2
S      spherical        3
(4S)   parallelogram of two rods with spherical joints at both ends, also written 2(SS)
(4R)   parallelogram with four revolute joints in its corners, also written Pa
====== ================ ========

Actuated joints are in brackets or underlined (U+0332 after the letter). The notation is that of J.-P. Merlet, Parallel
Robots, 2nd ed., Springer 2006, and of X. Kong, C. Gosselin, Type Synthesis of Parallel Mechanisms, Springer 2007.

>>> architecture = parse_architecture("3-U[P]S+UP")
>>> [(limb.count, limb.text, limb.freedoms) for limb in architecture.groups]
[(3, 'U[P]S', 6), (1, 'UP', 3)]
>>> parse_architecture("3-RPS").text
'3-R[P]S'
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from kinetostatics.authoring.known_names import named
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.exceptions import ArgumentError

#: Joints by letter: name and number of freedoms; (4S) without the spins of its rods.
JOINTS: dict[str, tuple[str, int]] = {
    **{
        JOINT_TYPES[name].symbol: (name, JOINT_TYPES[name].freedoms)
        for name in ("revolute", "prismatic", "cylindrical", "universal", "spherical")
    },
    "4S": ("parallelogram of rods", 5),
    "4R": ("parallelogram", 1),
}
LETTERS = "R (revolute), P (prismatic), C (cylindrical), U (universal), S (spherical), (4S) and (4R) (parallelograms)"
#: Joints that can be actuated.
DRIVABLE = ("R", "P", "C")
#: Combining characters after an underlined letter.
UNDERLINES = "\u0332\u0331"
#: Other ways to write the parallelograms.
PARALLELOGRAMS = {**dict.fromkeys(("4S", "SS", "2SS"), "4S"), **dict.fromkeys(("4R", "RR", "2RR", "Pa"), "4R")}
MAX_LIMBS, MAX_JOINTS = 12, 8

_TERM = re.compile(r"\s*(?:(\d+)\s*(?:[-–−×x*·]\s*|(?=[\[A-Za-z(])))?")
_GROUP = re.compile(r"2?-?\(\s*([0-9]?-?[A-Za-z]*)\s*\)2?|2?-?\(([^)]*)\)2?")


@dataclass(frozen=True)
class JointSymbol:
    """A joint of a limb.

    Attributes:
        kind: a key of ``JOINTS``.
        actuated: whether it is actuated; for a cylindrical joint, whether its translation is.
        place: position in the notation, from 1.
    """

    kind: str
    actuated: bool
    place: int

    @property
    def text(self) -> str:
        """The joint in the notation: "P", or "[P]" if actuated."""
        letter = self.kind if len(self.kind) == 1 else f"({self.kind})"
        return f"[{letter}]" if self.actuated else letter


@dataclass(frozen=True)
class AlikeLimbs:
    """Equal limbs: their number, the joints of one limb from base to platform, and the limbs' place in the notation, from 1."""

    count: int
    joints: tuple[JointSymbol, ...]
    place: int

    @property
    def text(self) -> str:
        """One limb in the notation, with actuated joints in brackets."""
        return "".join(joint.text for joint in self.joints)

    @property
    def kinds(self) -> tuple[str, ...]:
        return tuple(joint.kind for joint in self.joints)

    @property
    def freedoms(self) -> int:
        """Sum of the freedoms of the joints of one limb."""
        return sum(JOINTS[kind][1] for kind in self.kinds)


@dataclass(frozen=True)
class Architecture:
    """The limbs of a mechanism.

    Attributes:
        source: the given notation.
        groups: groups of equal limbs.
        actuators_chosen: whether :func:`parse_architecture` has chosen the actuated joints, because the notation marks none.
    """

    source: str
    groups: tuple[AlikeLimbs, ...]
    actuators_chosen: bool = False

    @property
    def text(self) -> str:
        """The mechanism in the notation, with actuated joints in brackets."""
        return "+".join(f"{group.count}-{group.text}" if group.count > 1 else group.text for group in self.groups)

    @property
    def limbs(self) -> tuple[AlikeLimbs, ...]:
        """One entry for each limb."""
        return tuple(group for group in self.groups for _ in range(group.count))

    @property
    def actuators(self) -> int:
        """Number of actuated joints."""
        return sum(group.count * sum(joint.actuated for joint in group.joints) for group in self.groups)

    @property
    def formula_freedoms(self) -> int:
        """Mobility by Grübler's formula: joint freedoms minus 6 for each loop. It is too small for overconstrained mechanisms."""
        return sum(limb.freedoms for limb in self.limbs) - 6 * (len(self.limbs) - 1)


def parse_architecture(text: str) -> Architecture:
    """Return a mechanism from its notation or its common name.

    If no joint is marked as actuated, the first prismatic joint of each limb is actuated, or else its first revolute or
    cylindrical joint. Limbs with fewer than six freedoms are then passive if the number of limbs with six freedoms equals the
    mobility by Grübler's formula, such as UP in 3-UPS+UP.

    Raises:
        ArgumentError: the notation is invalid.
    """
    if not isinstance(text, str) or not text.strip():
        raise ArgumentError(f"the architecture is {text!r}; write limbs as strings of joints, such as '3-R[P]S' or '6-U[P]S'")
    if len(text) > 200:
        raise ArgumentError("the architecture is longer than 200 characters; write limbs that are alike once: '6-U[P]S'")
    if mechanism := named(text):
        text = mechanism.architecture
    if _is_a_word(text):
        raise ArgumentError(
            f"no mechanism {text!r} is known; write its limbs as strings of joints, such as 3-R[P]S, or one of the names that "
            "kinetostatics new --list shows"
        )
    groups, at = [], 0
    while True:
        group, at = _group(text, at)
        groups.append(group)
        if at == len(text):
            break
        at += 1  # a plus, or another separator
    architecture = Architecture(text, tuple(groups))
    if len(architecture.limbs) > MAX_LIMBS:
        raise ArgumentError(f"the architecture {text!r} has {len(architecture.limbs)} limbs; at most {MAX_LIMBS} can be placed")
    return architecture if architecture.actuators else _with_usual_actuators(architecture)


def _is_a_word(text: str) -> bool:
    """Whether a text cannot be notation.

    It has four letters in a row, and at least two letters that denote no joint; or it is a serial robot such as 6R.
    """
    if re.fullmatch(r"\s*\dR\s*", text):
        return True
    foreign = re.sub("(?i)pa|[rpusc]|[^a-z]", "", text)
    return len(foreign) > 1 and re.search("[A-Za-z]{4,}", text) is not None


def error_at(text: str, place: int, reason: str) -> ArgumentError:
    """Return an error about the sign at ``place`` in a notation, counted from 1."""
    here = repr(text[place - 1]) if place <= len(text) else "the end"
    return ArgumentError(f"architecture {text!r}, place {place} ({here}): {reason}")


def _group(text: str, at: int) -> tuple[AlikeLimbs, int]:
    """Read the term of a sum of limbs that begins at the index ``at``. Return its limbs and the index of the next separator."""
    place = len(text) - len(text[at:].lstrip()) + 1
    head = _TERM.match(text, at)
    count = 1
    if head is not None and head[1] and not _GROUP.match(text, head.start(1)):
        count, at = int(head[1]), head.end()
        if not 1 <= count <= MAX_LIMBS:
            raise error_at(text, place, f"{count} limbs; write a number from 1 to {MAX_LIMBS}")
    joints: list[JointSymbol] = []
    while at < len(text) and text[at] not in "+-–−/&,;":
        if text[at].isspace():
            at += 1
            continue
        symbols, at = _joint(text, at)
        joints += symbols
        if len(joints) > MAX_JOINTS:
            raise error_at(text, symbols[0].place, f"a limb has at most {MAX_JOINTS} joints; write + before the next limb")
    if not joints:
        raise error_at(text, min(at, len(text)) + 1, f"a limb is missing here; write its joints from base to platform: {LETTERS}")
    if at < len(text) and not text[at + 1 :].strip():
        raise error_at(text, at + 1, "a limb is missing behind it; write its joints, or leave the sign out")
    return AlikeLimbs(count, tuple(joints), place), at


def _joint(text: str, at: int) -> tuple[list[JointSymbol], int]:
    """Read a joint, or the actuated joints in brackets, at the index ``at``. Return the joints and the next index."""
    place = at + 1
    if text[at] == "[":
        end = text.find("]", at)
        if end < 0:
            raise error_at(text, place, "this bracket is not closed; an actuated joint is written [P]")
        inside: list[JointSymbol] = []
        position = at + 1
        while position < end:
            symbols, position = _joint(text, position)
            inside += symbols
        if not inside:
            raise error_at(text, place, "the bracket is empty; an actuated joint is written [P]")
        return [_actuated(text, joint) for joint in inside], end + 1
    group = _GROUP.match(text, at)
    if group is not None:
        inner = (group[1] if group[1] is not None else group[2]).replace(" ", "").replace("-", "")
        kind = PARALLELOGRAMS.get(inner)
        if not kind:
            raise error_at(
                text, place, f"{group[0]} is no parallelogram that is known here; write (4S) or 2(SS) for two rods on spherical "
                "joints, (4R) or Pa for four revolute joints"
            )  # fmt: skip
        return [JointSymbol(kind, False, place)], group.end()
    if text.startswith("Pa", at):
        return [JointSymbol("4R", False, place)], at + 2
    letter = text[at]
    if letter == "]":
        raise error_at(text, place, "no bracket was opened before it; an actuated joint is written [P]")
    if letter.upper() not in JOINTS:
        raise error_at(
            text, place, f"no joint has this sign; joints are {LETTERS}, actuators stand in brackets, limbs are joined by +"
        )
    joint = JointSymbol(letter.upper(), False, place)
    if text[at + 1 : at + 2] and text[at + 1] in UNDERLINES:
        return [_actuated(text, joint)], at + 2
    return [joint], at + 1


def _actuated(text: str, joint: JointSymbol) -> JointSymbol:
    if joint.kind not in DRIVABLE:
        name = JOINTS[joint.kind][0]
        raise error_at(text, joint.place, f"a {name} joint cannot be actuated; mark a revolute, prismatic or cylindrical joint")
    return replace(joint, actuated=True)


def _with_usual_actuators(architecture: Architecture) -> Architecture:
    full = sum(group.count for group in architecture.groups if group.freedoms >= 6)
    only_full = 0 < full == architecture.formula_freedoms

    def actuated(group: AlikeLimbs) -> AlikeLimbs:
        number = next((k for kinds in ("P", DRIVABLE) for k, kind in enumerate(group.kinds) if kind in kinds), -1)
        joints = tuple(replace(joint, actuated=k == number) for k, joint in enumerate(group.joints))
        return group if only_full and group.freedoms < 6 else replace(group, joints=joints)

    groups = tuple(map(actuated, architecture.groups))
    chosen = replace(architecture, groups=groups, actuators_chosen=True)
    if not chosen.actuators:
        raise ArgumentError(
            f"architecture {architecture.source!r}: no limb has a joint that can be actuated, R, P or C; add one: '3-[P]US'"
        )
    return chosen
