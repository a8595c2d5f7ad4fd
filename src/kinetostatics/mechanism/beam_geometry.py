"""Start and end of every beam: positions, links and bodies, and the prismatic joints of a telescopic beam between them.

The *span* of a beam reaches from its start (towards the base) to its end; it may cross fixed and prismatic joints.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from kinetostatics.description.elements import Beam, BeamEnd
from kinetostatics.description.flexible import ElasticPart
from kinetostatics.description.joint_types import Axes
from kinetostatics.exceptions import RobotFileError
from kinetostatics.math.arrays import Array
from kinetostatics.math.graphs import reachable
from kinetostatics.mechanism.mechanism import Connection, Mechanism, meeting_points

#: Distance [m] below which two points of a link count as one.
SAME_POINT = 1e-6


@dataclass(frozen=True)
class Span:
    """A beam between two points of the robot, or an elastic link between its inner interface and another one.

    Attributes:
        name: its name; "LINK/2", … for the second and further outer interfaces of an elastic link.
        attachments: the attachments of start and end, see :class:`kinetostatics.mechanism.limbs.Topology`.
        start_body, start: body of the start, and position (3,) [m] of the start in this body.
        end_body, end: body of the end, and position (3,) [m] of the end in this body.
        carrier: body of the link to which the file assigns the beam.
        start_link, end_link: links of start and end.
        inward, outward: fixed and prismatic joints from the beam's link to the start link, and to the end link; empty if that
            link is the beam's link.
    """

    name: str
    attachments: tuple[str, str]
    part: Beam | ElasticPart
    start_body: int
    start: Array
    end_body: int
    end: Array
    carrier: int
    start_link: str
    end_link: str
    inward: tuple[Connection, ...]
    outward: tuple[Connection, ...]

    @property
    def spanned(self) -> tuple[str, ...]:
        """Names of the prismatic joints within the span, from start to end."""
        return tuple(connection.name for connection in (*self.inward[::-1], *self.outward) if connection.type.is_slide)

    @property
    def reversed(self) -> Span:
        span = replace(self, start_body=self.end_body, start=self.end, end_body=self.start_body, end=self.start)
        span = replace(span, attachments=self.attachments[::-1])
        return replace(span, start_link=self.end_link, end_link=self.start_link, inward=self.outward, outward=self.inward)


def beam_error(beam: Beam | ElasticPart, reason: str) -> RobotFileError:
    return beam.place.error(f"<{beam.KIND} {beam.name!r}>: {reason}")


def ends_nowhere(mechanism: Mechanism) -> list[tuple[str, str]]:
    """Return (link, joint) for every link, except base and platform, whose only joint is a moving one."""
    description = mechanism.description
    return [
        (link, here[0].name)
        for link, here in mechanism.at_link.items()
        if len(here) == 1 and not here[0].type.is_fixed and link not in (description.base, description.platform)
    ]


def _ends_nowhere_text(link: str, joint: str) -> str:
    return f"link {link!r} ends nowhere, as {joint!r} is its only joint: is a <parent> wrong, or a <loop> missing?"


def _may_be_spanned(connection: Connection) -> bool:
    return connection.type.is_fixed or connection.type.is_slide


def _point_on(link: str, path: Iterable[Connection], point: Array) -> Array:
    """Return a point [m] in the body of ``link``; ``point`` is given in the body at the other end of a path of fixed joints."""
    placement = np.eye(4)
    for connection in path:
        near, far = connection.predecessor_frame, connection.successor_frame
        if link != connection.predecessor:
            near, far = far, near
        placement = placement @ near @ np.linalg.inv(far)
        link = connection.other(link)
    return np.asarray(placement[:3, :3] @ point + placement[:3, 3])


def attachment_of_end(beam: str, end: int) -> str:
    """Return the name, as in the file, of a beam's start (``end`` = 0) or end (1) as an attachment for loads."""
    return f"{('start', 'end')[end]}:{beam}"


class SpanFinder:
    """Search for the start and end of every beam.

    Attributes:
        base_links, platform_links: links rigidly fixed to base and platform.
        beams_of: beams of each link that has beams.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.description = description = mechanism.description

        self.beams_of: dict[str, list[Beam | ElasticPart]] = {}
        for beam in description.elastic_links.values():
            self.beams_of.setdefault(beam.link, []).append(beam)
        self.base_links = self._rigid_with(description.base)
        self.platform_links = self._rigid_with(description.platform)
        if self.base_links & self.platform_links:
            reason = f"the platform {description.platform!r} is rigidly fixed to the base {description.base!r}"
            raise description.platform_place.error(reason)

    def spans(self) -> dict[str, Span]:
        """Return the span of each beam, by the beam's name.

        Raises:
            RobotFileError: the start or end of a beam is invalid.
        """
        return {span.name: span for beam in self.description.elastic_links.values() for span in self._spans_of(beam)}

    def _rigid_with(self, link: str) -> set[str]:
        """Return ``link`` and, if it is rigid, all links without beams that are connected to it by rigid fixed joints."""

        def fixed_to(link: str) -> Iterator[str]:
            for connection in self.mechanism.at_link[link]:
                is_weld = connection.type.is_fixed and connection.name not in self.description.joint_stiffness
                if is_weld and connection.other(link) not in self.beams_of:
                    yield connection.other(link)

        return {link} if link in self.beams_of else set(reachable([link], fixed_to))

    def _reaches(self, link: str, connection: Connection, target: set[str], barred: set[str]) -> bool:
        """Whether a path from ``link`` through ``connection`` reaches a link of ``target`` and passes no link of ``barred``."""

        def onward(here: str) -> list[str]:
            if here in barred:
                return []
            return [joint.other(here) for joint in self.mechanism.at_link[here] if joint.other(here) != link]

        reached = reachable([connection.other(link)], onward)
        return not target.isdisjoint(reached)

    def _ends(self, beam: Beam | ElasticPart) -> tuple[BeamEnd, BeamEnd]:
        """Return start and end as in the file; by default, at the two joints of the link, or towards base and platform."""
        here = self.mechanism.at_link[beam.link]
        if len(here) == 1 and (beam.start is None or beam.end is None):
            raise beam_error(
                beam,
                f"{_ends_nowhere_text(beam.link, here[0].name)} (A free tip needs a fixed joint to a link of its own.)",
            )
        if len(here) == 2 and (beam.start is None or beam.end is None):
            given = beam.start or beam.end
            if given is None:
                start, end = sorted(here, key=lambda connection: self._joints_to_base(beam.link, connection))
                return BeamEnd(start.name), BeamEnd(end.name)
            path = self._locate(beam, given)[1]
            taken = path[0].name if path else given.joint
            [other] = [BeamEnd(connection.name) for connection in here if connection.name != taken]
            return beam.start or other, beam.end or other
        return beam.start or self._default_end(beam, True), beam.end or self._default_end(beam, False)

    def _joints_to_base(self, link: str, connection: Connection) -> tuple[float, float]:
        """Return (a, b), the smallest numbers of joints from ``link`` to the base through ``connection``; ``inf`` without a path.

        ``a`` is for paths that avoid the platform, ``b`` for all paths. Passive joints that form one universal, spherical or
        cylindrical joint count as one.
        """

        def count(barred: set[str]) -> float:
            first = connection.other(link)
            counts: dict[str, float] = {link: math.inf}
            queue = deque([(first, connection, 1)])
            while queue:
                here, arrived, joints = queue.popleft()
                if here in counts:
                    continue
                counts[here] = joints
                if here in self.base_links:
                    return joints
                if here in barred:
                    continue
                for onward in self.mechanism.at_link[here]:
                    if onward is arrived:
                        continue
                    if self._are_one_joint(here, arrived, onward):
                        queue.appendleft((onward.other(here), onward, joints))
                    else:
                        queue.append((onward.other(here), onward, joints + 1))
            return math.inf

        return count(self.platform_links), count(set())

    def _are_one_joint(self, link: str, first: Connection, second: Connection) -> bool:
        """Whether two joints of a massless link belong to one universal, spherical or cylindrical joint."""
        if self.mechanism.at_link[link] not in ([first, second], [second, first]):
            return False
        if link in self.beams_of or self.description.links[link].mass or first.actuated or second.actuated:
            return False
        a, b = (connection.axis_on(link == connection.predecessor) for connection in (first, second))
        p, q = first.centre_on(link), second.centre_on(link)
        turning = first.type.is_hinge + second.type.is_hinge
        if turning == 2:
            return meeting_points(a, p, b, q) is not None
        if turning == 1 and (first.type.is_slide or second.type.is_slide):
            return max(float(np.abs(np.cross(a, b)).max()), float(np.abs(np.cross(a, q - p)).max())) < 1e-9
        return False

    def _default_end(self, beam: Beam | ElasticPart, towards_base: bool) -> BeamEnd:
        sides = (self.base_links, self.platform_links) if towards_base else (self.platform_links, self.base_links)
        leading = [joint.name for joint in self.mechanism.at_link[beam.link] if self._reaches(beam.link, joint, *sides)]
        attribute, where = ("from", "base") if towards_base else ("to", "platform")
        if len(leading) != 1:
            which = "no joint leads" if not leading else f"the joints {', '.join(leading)} lead"
            reason = f'{which} from link {beam.link!r} towards the {where}; name the joint by {attribute}="…"'
            for link, joint in ends_nowhere(self.mechanism)[:1]:
                reason = f"{_ends_nowhere_text(link, joint)} If not: {reason}"
            raise beam_error(beam, reason)
        return BeamEnd(leading[0])

    def _link_path(self, start: str, goals: Collection[str], passes: Callable[[Connection], bool]) -> list[Connection] | None:
        """Return the connections from link ``start`` to the nearest link of ``goals``; None if there is no path."""
        paths: dict[str, list[Connection]] = {start: []}
        queue = [start]
        for here in queue:
            if here in goals:
                return paths[here]
            for connection in self.mechanism.at_link[here]:
                if connection.other(here) not in paths and passes(connection):
                    paths[connection.other(here)] = [*paths[here], connection]
                    queue.append(connection.other(here))
        return None

    def _locate(self, beam: Beam | ElasticPart, end: BeamEnd) -> tuple[str, list[Connection]]:
        """Return the link to which a beam's start or end is fixed, and the connections from the beam's link to this link."""
        if end.joint not in self.mechanism.connections:  # o of base or platform
            return beam.link, []
        joint = self.mechanism.connections[end.joint]
        adjacent = beam.link in (joint.predecessor, joint.successor)
        sliding = joint.type.slides is not Axes.NONE
        if end.side is not None and (sliding or not adjacent):
            goals = [joint.predecessor if end.side == "parent" else joint.successor]
        elif adjacent:
            return beam.link, []
        else:
            goals = [joint.predecessor, joint.successor]
        path = self._link_path(beam.link, goals, _may_be_spanned)
        if path is None:
            crossing = self._link_path(beam.link, goals, lambda _: True) or []
            names = [connection.name for connection in crossing if not _may_be_spanned(connection)]
            reason = (
                f"its span to {end.joint!r} crosses the moving joint {', '.join(map(repr, names)) or '?'}; a beam may "
                "only cross prismatic joints, along whose axes it telescopes"
            )
            for only_link, only in ends_nowhere(self.mechanism)[:1]:
                reason += f"; {_ends_nowhere_text(only_link, only)}"
            raise beam_error(beam, reason)
        link = beam.link
        for connection in path:
            link = connection.other(link)
        return link, path

    def _spans_of(self, beam: Beam | ElasticPart) -> Iterator[Span]:
        """Yield the span of a beam, or those from the first interface of an elastic link to the others."""
        start, end = self._ends(beam)
        attachments = attachment_of_end(beam.name, 0), attachment_of_end(beam.name, 1)
        spans = [self._span(beam, start, end, beam.name, attachments)]
        joints = (start.joint, end.joint) if isinstance(beam, Beam) else beam.interfaces
        for number, joint in enumerate(joints[2:], 2):
            name = f"{beam.name}/{number}"
            span = self._span(beam, start, BeamEnd(joint), name, (attachments[0], attachment_of_end(name, 1)))
            for other, earlier in zip(joints[1:], spans, strict=False):
                if float(np.linalg.norm(earlier.end - span.end)) < SAME_POINT:
                    raise beam_error(beam, f"its interfaces {other!r} and {joint!r} are the same point")
            spans.append(span)
        yield from spans

    def _span(self, beam: Beam | ElasticPart, start: BeamEnd, end: BeamEnd, name: str, attachments: tuple[str, str]) -> Span:
        start_link, inward = self._locate(beam, start)
        end_link, outward = self._locate(beam, end)
        span = Span(
            name,
            attachments,
            beam,
            self.mechanism.body_of[start_link][0],
            self.mechanism.interface_on(start_link, start.joint),
            self.mechanism.body_of[end_link][0],
            self.mechanism.interface_on(end_link, end.joint),
            self.mechanism.body_of[beam.link][0],
            start_link,
            end_link,
            tuple(inward),
            tuple(outward),
        )
        if not span.spanned:
            along = _point_on(beam.link, span.outward, span.end) - _point_on(beam.link, span.inward, span.start)
            if float(np.linalg.norm(along)) < SAME_POINT:
                reason = f"its ends {start.joint!r} and {end.joint!r} are the same point: its length is zero"
                for at, name in ((start, "from"), (end, "to")):
                    if at.joint in self.mechanism.connections and self.mechanism.connections[at.joint].type.is_slide:
                        reason += f"; of a telescope that is one beam, {name}= is the joint behind {at.joint!r}"
                raise beam_error(beam, reason)
            beam.check_direction(self.mechanism.body_of[beam.link][1][:3, :3].T @ along)
        return span
