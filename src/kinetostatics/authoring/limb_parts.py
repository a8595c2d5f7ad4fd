"""Parts of a limb: guide, points with joints, links between these points. Revolute axes are along y of the limb's frame."""

from __future__ import annotations

from dataclasses import dataclass

from kinetostatics.authoring.notation import AlikeLimbs, Architecture, JointSymbol, error_at

#: Largest number of points of a limb: at the base, at an elbow, at the platform.
MAX_POINTS = 3


@dataclass(frozen=True)
class LimbPoint:
    """A point of a limb with a rotational joint, or a rigid end.

    Attributes:
        kind: R, U, S or C; "4S" for the upper spherical joints of two rods, "" for a rigid end.
        symbol: the joint in the notation, None for a rigid end.
        axes: the two axes of a universal joint, from base to platform: "n" is along the limb's y, "x" perpendicular to it.
        letter: suffix of the joint's name if the limb has several joints of this kind; else empty.
    """

    kind: str
    symbol: JointSymbol | None
    axes: str = ""
    letter: str = ""


@dataclass(frozen=True)
class LimbSpan:
    """A link between two points of a limb.

    Attributes:
        kind: "rod", "telescope", "parallelogram" (four revolute joints) or "rods" (two rods between spherical joints).
        role: "crank" for the first of two links, else "rod"; it begins the names of link and section.
        slide: the prismatic joint of a telescope in the notation.
        turns: whether a telescope also rotates about its line, as a cylindrical joint.
    """

    kind: str
    role: str
    slide: JointSymbol | None = None
    turns: bool = False


@dataclass(frozen=True)
class Skeleton:
    """The parts of a limb.

    Attributes:
        group: the limb in the notation.
        guide: the prismatic or cylindrical joint of a carriage on the base, or None.
        guide_turns: whether the guide is a cylindrical joint.
        points: points with joints, from base to platform.
        spans: links between consecutive points.
    """

    group: AlikeLimbs
    guide: JointSymbol | None
    guide_turns: bool
    points: tuple[LimbPoint, ...]
    spans: tuple[LimbSpan, ...]

    @property
    def has_elbow(self) -> bool:
        """Whether the limb has a point between its base point and its platform point."""
        return len(self.points) == MAX_POINTS

    @property
    def roles(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(span.role for span in self.spans))


def skeleton_of(architecture: Architecture, group: AlikeLimbs) -> Skeleton:
    """Return the parts of a limb.

    Raises:
        ArgumentError: the directions of the limb's joints do not follow from the notation.
    """
    text, joints = architecture.source, list(group.joints)
    guide = joints.pop(0) if joints[0].kind == "P" or (joints[0].kind == "C" and len(joints) > 1) else None
    guide_turns = guide is not None and guide.kind == "C"
    for before, after in zip((guide, *joints), joints, strict=False):
        if before is not None and before.kind == after.kind == "P":
            raise error_at(text, after.place, "two prismatic joints in a row: their directions do not follow from the notation")
    if joints and joints[-1].kind == "C" and joints[-1].actuated:
        reason = (
            "the slide of a cylindrical joint at the platform cannot be actuated; mark another joint, or write P and R for it"
        )
        raise error_at(text, joints[-1].place, reason)
    points: list[LimbPoint] = [LimbPoint("C", guide)] if guide_turns else []
    spans: list[LimbSpan] = []
    waiting: LimbSpan | None = None
    if not guide_turns and joints and joints[0].kind in ("P", "4R", "4S"):
        points.append(LimbPoint("", None))  # fixed to the base or to the carriage
    for number, joint in enumerate(joints):
        last = number == len(joints) - 1
        slides = joint.kind == "P" or (joint.kind == "C" and points and not last)
        if slides or joint.kind == "4R":
            if waiting is not None:
                raise error_at(text, joint.place, "at most one prismatic joint or parallelogram can be between two joints")
            waiting = LimbSpan("telescope", "rod", joint, joint.kind == "C") if slides else LimbSpan("parallelogram", "rod")
        elif joint.kind == "4S":
            if waiting is not None or not last:
                reason = "the rods of (4S) end at the platform; write (4S) last, after [R] or [P]: '3-[R](4S)'"
                raise error_at(text, joint.place, reason)
            if points and points[-1].kind:
                spans.append(LimbSpan("rod", "rod"))
                points.append(LimbPoint("4S", joint))
            else:
                points[-1] = LimbPoint("4S", joint)
            waiting = LimbSpan("rods", "rod")
        else:
            if points:
                spans.append(waiting or LimbSpan("rod", "rod"))
            points.append(LimbPoint(joint.kind, joint))
            waiting = None
        if len(points) > MAX_POINTS:
            reason = (
                "the directions of their axes do not follow from the notation; write U for two axes that intersect, S for three"
            )
            raise error_at(text, joint.place, f"more than {MAX_POINTS} rotational joints: {reason}")
    if waiting is not None:
        spans.append(waiting)
        points.append(LimbPoint("4S", points[-1].symbol) if waiting.kind == "rods" else LimbPoint("", None))
    if len(points) > MAX_POINTS:
        raise error_at(text, group.joints[-1].place, f"a limb has rotational joints at {MAX_POINTS} points at most")
    if len(spans) > 1:
        spans = [LimbSpan(span.kind, "crank" if k == 0 else "rod", span.slide, span.turns) for k, span in enumerate(spans)]
    return Skeleton(group, guide, guide_turns, _with_letters(_with_axes(points)), tuple(spans))


def _with_axes(points: list[LimbPoint]) -> list[LimbPoint]:
    """Return the points with ``axes`` of their universal joints.

    If a neighbouring point is a revolute joint, the axis on the neighbour's side is along the limb's y. A telescope that is fixed
    to the platform counts as a revolute joint there. Without a revolute neighbour, the axis on the base's side is along y; for a
    joint at the platform, the axis on the platform's side.
    """
    with_axes = []
    for number, point in enumerate(points):
        if point.kind == "U":
            before = points[number - 1].kind if number else ""
            after = points[number + 1].kind if number + 1 < len(points) else ""
            if before in ("R", "C"):
                axes = "nx"
            elif after in ("R", "C") or (number + 1 < len(points) and not after):
                axes = "xn"
            else:
                axes = "xn" if number and number == len(points) - 1 else "nx"
            point = LimbPoint("U", point.symbol, axes)
        with_axes.append(point)
    return with_axes


def _with_letters(points: list[LimbPoint]) -> tuple[LimbPoint, ...]:
    """Return the points with the letters a, b, c for several joints of the same kind."""
    kinds = [point.kind for point in points]
    with_letters = []
    for number, point in enumerate(points):
        letter = "abc"[kinds[:number].count(point.kind)] if kinds.count(point.kind) > 1 else ""
        with_letters.append(LimbPoint(point.kind, point.symbol, point.axes, letter))
    return tuple(with_letters)
