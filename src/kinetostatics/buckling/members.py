"""Members: runs of beams that are welded in one line and buckle as one, and how the robot holds their ends.

An end turns as its passive joints say; it is clamped to base, platform and rigid links. Where elastic beams or several joints
hold what it is fixed to, that may turn. It moves across the member as its joints slide, and where nothing but the member itself
holds it: in the directions in which it still moves if everything else is rigid, the actuators are locked and the member is a rod
with hinged ends. Where nothing at all holds what is at its end, as in serial arms, that end is free and the other one clamped.
Bearings count as rigid, and that several members might sway together is not looked at.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetostatics.buckling.euler_loads import Ends, buckling_ratio
from kinetostatics.buckling.sway import EdgeMotions, free_motions, sliding_axes, turning_axes
from kinetostatics.limbs.model import StaticModel
from kinetostatics.math.arrays import Array
from kinetostatics.math.graphs import reachable
from kinetostatics.math.linalg import cross
from kinetostatics.mechanism.mechanism import Connection
from kinetostatics.mechanism.rigid_bodies import BodyEdge, BodyGraph, RigidBody
from kinetostatics.mechanism.tree import Frames

#: Beams are in one line when they are off by less than this, relative to their length.
_IN_LINE = 1e-6
#: Joints nearer to one another than this [m] turn about one point.
_SAME = 1e-6
#: Free motions of unit size of which less than this is across the member do not move its end.
_MOVES = 1e-6
#: Axes whose part across the member is less than this do not let it turn.
_ACROSS = 1e-6


@dataclass(frozen=True)
class MemberEnd:
    """How one end of a member is held.

    Attributes:
        words: clamped, pinned, hinged, guided or free; sliding, where a joint lets it move; swaying, where nothing holds it.
        turns: axes about which it may turn, each in a body (body, (3,)); None: about all.
        slides: directions in which it may move; None: in all.
    """

    words: str
    turns: tuple[tuple[int, Array], ...] | None = ()
    slides: tuple[tuple[int, Array], ...] | None = ()


CLAMPED, FREE = MemberEnd("clamped"), MemberEnd("free", None, None)


@dataclass(frozen=True)
class Member:
    """A run of beams in one line.

    Attributes:
        beams: their names, from the base to the platform end.
        forward: whether each beam runs the same way as the member.
        ends: how the base and the platform end are held.
        stiffness: (n, 2, 2) bending stiffness of the deflections along y and z of the first beam's axes [N·m²].
    """

    beams: tuple[str, ...]
    forward: tuple[bool, ...]
    ends: tuple[MemberEnd, MemberEnd]
    stiffness: Array

    @cached_property
    def _weakest(self) -> float:
        """The smallest bending stiffness of all its beams [N·m²]."""
        return float(np.min(np.linalg.eigvalsh(self.stiffness)))

    @property
    def words(self) -> str:
        """How its ends are held."""
        first, last = (end.words for end in self.ends)
        return f"{first} at both ends" if first == last else f"{first} and {last}"

    def holds(self, model: StaticModel, frames: Frames, which: NDArray[np.intp]) -> Ends:
        """Return how its ends are held at some poses."""
        frames = frames.take(which)
        beam = model.beams[self.beams[0]]
        axes = frames.orientations(np.array([beam.span.carrier]), beam.axes[:, :, None])[:, :, 0]
        sign = 1.0 if self.forward[0] else -1.0
        across = np.stack([axes[:, 1], sign * axes[:, 2]])  # (2, 3, N)

        def projectors(given: tuple[tuple[int, Array], ...] | None) -> Array:
            N = axes.shape[2]
            if given is None:
                return np.broadcast_to(np.eye(2), (N, 2, 2))
            if not given:
                return np.zeros((N, 2, 2))
            bodies = np.array([body for body, _ in given])
            world = frames.directions(bodies, np.array([direction for _, direction in given]).T)  # (3, k, N)
            u, s, _ = np.linalg.svd(np.einsum("dxn,xkn->ndk", across, world), full_matrices=False)
            u = u * (s > _ACROSS)[:, None, :]
            return np.asarray(u @ np.swapaxes(u, 1, 2))

        slides, turns = (np.stack([projectors(getattr(end, name)) for end in self.ends]) for name in ("slides", "turns"))
        return Ends(slides, turns)

    def euler_ratio(self, model: StaticModel, frames: Frames, axial: Mapping[str, Array], least: float = 0.0) -> Array:
        """Return the axial forces over those at which it buckles (N,), at N poses.

        Args:
            model: the robot.
            frames: of the poses.
            axial: (3, N) axial forces at the base and platform end of every beam [N] and its length [m], by name.
            least: smaller ratios may be returned as 0, where a simple bound of them says so.
        """
        lengths = np.stack([axial[name][2] for name in self.beams], axis=1)
        ways = zip(self.beams, self.forward, strict=True)
        forces = np.stack([axial[name][:2][:: 1 if way else -1].T for name, way in ways], axis=1)
        most = np.maximum(-forces.min(axis=(1, 2)), 0)
        if not any(end.slides for end in self.ends):
            most = most * 4 * lengths.sum(axis=1) ** 2 / (np.pi**2 * self._weakest)  # clamped and free: none buckles earlier
        else:
            most = np.where(most > 0, np.inf, 0)
        looked = np.flatnonzero((most > 0) & (most >= least))
        result = np.where(np.isnan(most), np.nan, 0.0)
        if looked.size:
            result[looked] = buckling_ratio(lengths[looked], self.stiffness, forces[looked], self.holds(model, frames, looked))
        return result


def members_of(model: StaticModel, generic: Frames) -> tuple[Member, ...]:
    """Return all members of a robot, in the order of the file."""
    return tuple(_Finder(model, generic).members())


class _Finder:
    def __init__(self, model: StaticModel, generic: Frames) -> None:
        self.model, self.graph = model, BodyGraph(model.mechanism)
        frames, self.frames = model.zero_frames, generic
        poses = [generic.take(np.array([k])) for k in range(generic.position.shape[2])]
        self.motions = [EdgeMotions(pose, model.length) for pose in poses]
        self.edges = {edge.beam.beam.name: edge for edge in self.graph.edges if edge.beam is not None}
        self.points: dict[str, tuple[Array, Array]] = {}
        self.direction: dict[str, Array] = {}
        for name in self.edges:
            beam = model.beams[name]
            self.points[name] = self._point(frames, name, False), self._point(frames, name, True)
            self.direction[name] = frames.direction(beam.span.carrier, beam.axes[:, 0])[:, 0]
        self.at: dict[RigidBody, list[BodyEdge]] = {}
        for edge in self.graph.edges:
            for body in edge.ends:
                self.at.setdefault(body, []).append(edge)

    def members(self) -> Iterator[Member]:
        following = self._following()
        done: set[str] = set()
        for name in self.model.description.beams:
            if name in done or name not in self.edges:
                continue
            run = [(name, True)]
            while (after := following.get(run[-1])) is not None and after[0] not in {item for item, _ in run}:
                run.append(after)
            back = [(name, False)]
            while (after := following.get(back[-1])) is not None and after[0] not in {item for item, _ in run + back}:
                back.append(after)
            run = [(item, not forward) for item, forward in back[:0:-1]] + run
            done |= {item for item, _ in run}
            yield self._member(run)

    def _following(self) -> dict[tuple[str, bool], tuple[str, bool]]:
        """Return which beam goes on behind which, each a name and whether it is passed from its start to its end."""
        ways: dict[tuple[str, bool], list[tuple[str, bool]]] = {}
        for name, edge in self.edges.items():
            for forward in (True, False):
                body = (edge.outer if forward else edge.inner).find()
                if body in (self.graph.base, self.graph.platform):
                    continue
                for other, next_edge in self.edges.items():
                    for onward in (True, False):
                        begin = (next_edge.inner if onward else next_edge.outer).find()
                        if other != name and self._joined(body, begin, name) and self._in_line(name, forward, other, onward):
                            ways.setdefault((name, forward), []).append((other, onward))
        one = {key: found[0] for key, found in ways.items() if len(found) == 1}
        back = {key: (value[0], not value[1]) for key, value in one.items()}
        return {key: value for key, value in one.items() if one.get(back[key]) == (key[0], not key[1])}

    def _joined(self, body: RigidBody, begin: RigidBody, name: str) -> bool:
        """Whether two pieces are one, or slide along a beam against each other."""
        if body is begin:
            return True
        frames = self.model.zero_frames
        for edge in self.at.get(body, []):
            joint = edge.connection
            if joint is not None and edge.other(body) is begin and (joint.type.is_fixed or joint.type.is_slide):
                if joint.type.is_fixed:
                    return True
                axis = frames.direction(joint.predecessor_body, joint.axis_on(True))[:, 0]
                return bool(np.linalg.norm(cross(axis, self.direction[name])) < _IN_LINE)
        return False

    def _in_line(self, name: str, forward: bool, other: str, onward: bool) -> bool:
        x = self.direction[name] * (1 if forward else -1)
        y = self.direction[other] * (1 if onward else -1)
        gap = self.points[other][0 if onward else 1] - self.points[name][1 if forward else 0]
        size = float(np.linalg.norm(self.points[name][1] - self.points[name][0]))
        off = float(np.linalg.norm(cross(x, gap)))
        return bool(x @ y > 0 and np.linalg.norm(cross(x, y)) < _IN_LINE and off < _IN_LINE * max(size, 1e-3))

    def _member(self, run: Sequence[tuple[str, bool]]) -> Member:
        if len(run) > 1 and sum(forward for _, forward in run) * 2 < len(run):
            run = [(name, not forward) for name, forward in run[::-1]]
        names = tuple(name for name, _ in run)
        beams = {id(self.edges[name]) for name in names}
        (first, way), (last, last_way) = run[0], run[-1]
        inner = (self.edges[first].inner if way else self.edges[first].outer).find()
        outer = (self.edges[last].outer if last_way else self.edges[last].inner).find()
        found = [self._end(body, beams) for body in (inner, outer)]
        ends = [item[0] for item in found]
        frames, beam = self.model.zero_frames, self.model.beams[first]
        axes = frames.orientations(np.array([beam.span.carrier]), beam.axes[:, :, None])[:, :, 0, 0]
        across = np.array([axes[:, 1], (1 if way else -1) * axes[:, 2]])
        stiffness = self._stiffness(names, across)
        if FREE not in ends and not (found[0][2] and found[1][2]):
            ends[1] = self._swaying(ends, (first, way), (last, last_way), beams, (found[0][1], found[1][1]))
        member = Member(names, tuple(forward for _, forward in run), (ends[0], ends[1]), stiffness)
        if FREE in ends or self._is_loose(member):
            free_first = ends[0] is FREE and ends[1] is not FREE
            member = replace(member, ends=(FREE, CLAMPED) if free_first else (CLAMPED, FREE))
        return member

    def _is_loose(self, member: Member) -> bool:
        """Whether it could move as it is taken to be held, so that a force of nothing would buckle it."""
        frames = self.frames
        which = np.arange(frames.position.shape[2])
        lengths = np.stack([self.model.beams[name].length(frames) for name in member.beams], axis=1)
        if not np.all(lengths > 0):
            return True  # a telescope without length
        least = np.pi**2 * float(np.min(np.linalg.eigvalsh(member.stiffness))) / (2 * lengths.sum(axis=1)) ** 2
        forces = np.broadcast_to(-least[:, None, None], (*lengths.shape, 2))
        try:
            return bool(np.any(buckling_ratio(lengths, member.stiffness, forces, member.holds(self.model, frames, which)) > 2))
        except np.linalg.LinAlgError:
            return True

    def _swaying(
        self,
        ends: Sequence[MemberEnd],
        first: tuple[str, bool],
        last: tuple[str, bool],
        beams: set[int],
        holders: tuple[RigidBody, RigidBody],
    ) -> MemberEnd:
        """Return how the platform end is held if it also moves where nothing but the member holds it."""
        beam, shifts, turns = self.model.beams[first[0]], [], False
        for motions_of_edges in self.motions:
            frames = motions_of_edges.frames
            points = np.array([self._point(frames, first[0], not first[1]), self._point(frames, last[0], last[1])])
            if not np.any(points[1] - points[0]):
                continue  # a telescope without length
            x = (points[1] - points[0]) / np.linalg.norm(points[1] - points[0])
            twists = all(_passes_torque(frames, end, x) for end in ends)
            motions = free_motions(self.graph, motions_of_edges, beams, holders, points, twists)
            axes = frames.orientations(np.array([beam.span.carrier]), beam.axes[:, :, None])[:, :, 0, 0]
            u, s, _ = np.linalg.svd(axes[:, 1:].T @ motions[3:], full_matrices=False)
            shifts.append(beam.axes[:, 1:] @ u[:, s > _MOVES] @ u[:, s > _MOVES].T @ beam.axes[:, 1:].T)
            turns |= bool(np.any(np.abs(axes[:, 1:].T @ motions[:3]) > _MOVES))
        if not shifts:
            return ends[1]
        end, most = ends[1], max(shifts, key=np.trace)
        rank = round(float(np.trace(most)))
        if rank == 0:
            return end
        slides: tuple[tuple[int, Array], ...] | None = None
        if rank == 1 and all(np.abs(item - most).max() < _SAME for item in shifts):
            direction = np.linalg.svd(most)[0][:, 0]
            slides = (*(end.slides or ()), (beam.span.carrier, direction))
        words = end.words.removesuffix(", sliding").replace("guided", "clamped")
        return MemberEnd(f"{words}, swaying", None if turns else end.turns, slides)

    def _point(self, frames: Frames, name: str, at_end: bool) -> Array:
        span = self.model.beams[name].span
        body, point = (span.end_body, span.end) if at_end else (span.start_body, span.start)
        return frames.point(body, point)[:, 0]

    def _stiffness(self, names: Sequence[str], across: Array) -> Array:
        found = []
        for name in names:
            beam = self.model.beams[name]
            own = self.model.zero_frames.orientations(np.array([beam.span.carrier]), beam.axes[:, :, None])[:, :, 0, 0]
            turn = across @ own[:, 1:]
            found.append(turn @ np.diag(1 / beam.compliances[[5, 4]]) @ turn.T)
        return np.array(found)

    def _end(self, body: RigidBody, member: set[int]) -> tuple[MemberEnd, RigidBody, bool]:
        """Return how the rest of the robot holds a piece at the end of a member of beams with these ids, what holds it, and
        whether it is a joint that lets it turn about all axes across it.
        """
        turns: list[tuple[int, Array]] | None = []
        slides: list[tuple[int, Array]] = []
        used, before = set(member), None
        while not (body in (self.graph.base, self.graph.platform) and self._is_held(body, used)):
            others = [edge for edge in self.at[body] if id(edge) not in used]
            ways = [edge for edge in others if self._is_held(edge.other(body), used | {id(edge)})]
            if not ways:
                return FREE, body, False
            joint = ways[0].connection
            if len(ways) > 1 or joint is None:
                by_joint = turns is None or len(turns) > 1
                return self._joined_end(turns or None, slides), body, by_joint
            if before is not None and not self._at_one_point(before, joint):
                break
            if not joint.driven:
                more = turning_axes(joint)
                turns = None if more is None or turns is None else turns + more
                slides += sliding_axes(joint)
            used.add(id(ways[0]))
            body, before = ways[0].other(body), joint
        end = self._joined_end(turns, slides)
        return end, body, end.words == "pinned"

    @staticmethod
    def _joined_end(turns: list[tuple[int, Array]] | None, slides: list[tuple[int, Array]]) -> MemberEnd:
        words = "pinned" if turns is None else {0: "clamped", 1: "hinged"}.get(len(turns), "pinned")
        if slides:
            words = "guided" if words == "clamped" else f"{words}, sliding"
        return MemberEnd(words, None if turns is None else tuple(turns), tuple(slides))

    def _at_one_point(self, *joints: Connection) -> bool:
        points = [self.model.zero_frames.point(item.predecessor_body, item.predecessor_frame[:3, 3])[:, 0] for item in joints]
        return float(np.linalg.norm(points[1] - points[0])) < _SAME

    def _is_held(self, body: RigidBody, without: set[int]) -> bool:
        """Whether a piece hangs together with the base when some edges are cut."""
        return self.graph.base in reachable(
            [body], lambda here: (edge.other(here) for edge in self.at.get(here, ()) if id(edge) not in without)
        )


def _passes_torque(frames: Frames, end: MemberEnd, x: Array) -> bool:
    """Whether the joints of an end do not let it turn about the member, along x."""
    if end.turns is None:
        return False
    axes = np.array([frames.direction(body, axis)[:, 0] for body, axis in end.turns]).reshape(-1, 3).T
    return bool(np.linalg.norm(x - axes @ np.linalg.pinv(axes) @ x) > 1e-3)
