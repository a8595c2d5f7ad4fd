"""Members: runs of beams that are welded in one line and buckle as one, and how the robot holds their ends.

The centre of an end stands still, and turns as its passive joints say; it is clamped to base, platform and driven joints behind
which a rigid link follows. Where elastic beams or several joints hold what it is fixed to, that may turn. Where nothing but the
member itself holds what is at its outer end, as in serial arms, that end is free and the inner end clamped. Bearings count as
rigid, and that all limbs might sway together is not looked at.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetostatics.buckling import Ends, buckling_ratio
from kinetostatics.kinematics import Frames
from kinetostatics.mechanism import Connection
from kinetostatics.rigid_pieces import Piece, PieceEdge, PieceGraph

if TYPE_CHECKING:
    from kinetostatics.robot import Robot

Array = NDArray[np.float64]

#: Beams are in one line when they are off by less than this, relative to their length.
_IN_LINE = 1e-6
#: Joints nearer to one another than this [m] turn about one point.
_SAME = 1e-6
#: Axes whose part across the member is less than this do not let it turn.
_ACROSS = 1e-6


@dataclass(frozen=True)
class MemberEnd:
    """How one end of a member is held.

    Attributes:
        words: clamped, pinned, hinged, guided or free.
        turns: axes about which it may turn, each in a body (body, (3,)); None: about all.
        slides: directions in which it may move; None: in all.
    """

    words: str
    turns: tuple[tuple[int, Array], ...] | None = ()
    slides: tuple[tuple[int, Array], ...] | None = ()


CLAMPED, PINNED, FREE = MemberEnd("clamped"), MemberEnd("pinned", None), MemberEnd("free", None, None)


@dataclass(frozen=True)
class Member:
    """A run of beams in one line.

    Attributes:
        beams: their names, from the inner to the outer end.
        forward: whether each beam runs the same way as the member.
        ends: how the inner and the outer end are held.
        stiffness: (n, 2, 2) bending stiffness of the deflections along y and z of the first beam's axes [N·m²].
    """

    beams: tuple[str, ...]
    forward: tuple[bool, ...]
    ends: tuple[MemberEnd, MemberEnd]
    stiffness: Array

    @property
    def words(self) -> str:
        """How its ends are held."""
        first, last = (end.words for end in self.ends)
        return f"{first} at both ends" if first == last else f"{first} and {last}"

    def holds(self, robot: Robot, frames: Frames, which: NDArray[np.intp]) -> Ends:
        """Return how its ends are held at some poses."""
        frames = Frames(frames.rotation[..., which], frames.position[..., which])
        model = robot.beams[self.beams[0]]
        axes = frames.orientations(np.array([model.span.carrier]), model.axes[:, :, None])[:, :, 0]
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

        return Ends(
            np.stack([projectors(end.slides) for end in self.ends]),
            np.stack([projectors(end.turns) for end in self.ends]),
        )

    def euler_ratio(self, robot: Robot, frames: Frames, axial: Mapping[str, Array], least: float = 0.0) -> Array:
        """Return the axial forces over those at which it buckles (N,), at N poses.

        Args:
            robot: the robot.
            frames: of the poses.
            axial: (3, N) axial forces at the inner and outer end of every beam [N] and its length [m], by name.
            least: smaller ratios may be returned as 0, where a simple bound of them says so.
        """
        lengths = np.stack([axial[name][2] for name in self.beams], axis=1)
        ways = zip(self.beams, self.forward, strict=True)
        forces = np.stack([axial[name][:2][:: 1 if way else -1].T for name, way in ways], axis=1)
        most = np.maximum(-forces.min(axis=(1, 2)), 0)
        if not any(end.slides for end in self.ends):
            weakest = float(np.min(np.linalg.eigvalsh(self.stiffness)))
            most = most * 4 * lengths.sum(axis=1) ** 2 / (np.pi**2 * weakest)  # clamped and free: none buckles earlier
        else:
            most = np.where(most > 0, np.inf, 0)
        looked = np.flatnonzero((most > 0) & (most >= least))
        result = np.where(np.isnan(most), np.nan, 0.0)
        if looked.size:
            result[looked] = buckling_ratio(lengths[looked], self.stiffness, forces[looked], self.holds(robot, frames, looked))
        return result


def members_of(robot: Robot) -> tuple[Member, ...]:
    """Return all members of a robot, in the order of the file."""
    return tuple(_Finder(robot).members())


class _Finder:
    def __init__(self, robot: Robot) -> None:
        self.robot, self.graph = robot, PieceGraph(robot.mechanism)
        frames = robot.zero_frames
        self.edges = {edge.beam.beam.name: edge for edge in self.graph.edges if edge.beam is not None}
        self.points: dict[str, tuple[Array, Array]] = {}
        self.direction: dict[str, Array] = {}
        for name in self.edges:
            model = robot.beams[name]
            start = frames.points(np.array([model.span.start_body]), model.span.start[:, None])[:, 0, 0]
            end = frames.points(np.array([model.span.end_body]), model.span.end[:, None])[:, 0, 0]
            self.points[name] = start, end
            self.direction[name] = frames.directions(np.array([model.span.carrier]), model.axes[:, :1])[:, 0, 0]
        self.at: dict[Piece, list[PieceEdge]] = {}
        for edge in self.graph.edges:
            for piece in (edge.inner.find(), edge.outer.find()):
                self.at.setdefault(piece, []).append(edge)

    def members(self) -> Iterator[Member]:
        following = self._following()
        done: set[str] = set()
        for name in self.robot.description.beams:
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
                piece = (edge.outer if forward else edge.inner).find()
                if piece in (self.graph.base, self.graph.platform):
                    continue
                for other, next_edge in self.edges.items():
                    for onward in (True, False):
                        begin = (next_edge.inner if onward else next_edge.outer).find()
                        if other != name and self._joined(piece, begin, name) and self._in_line(name, forward, other, onward):
                            ways.setdefault((name, forward), []).append((other, onward))
        one = {key: found[0] for key, found in ways.items() if len(found) == 1}
        back = {key: (value[0], not value[1]) for key, value in one.items()}
        return {key: value for key, value in one.items() if one.get(back[key]) == (key[0], not key[1])}

    def _joined(self, piece: Piece, begin: Piece, name: str) -> bool:
        """Whether two pieces are one, or slide along a beam against each other."""
        if piece is begin:
            return True
        frames = self.robot.zero_frames
        for edge in self.at.get(piece, []):
            joint = edge.connection
            if joint is not None and edge.other(piece) is begin and joint.kind in ("fixed", "prismatic"):
                if joint.kind == "fixed":
                    return True
                axis = frames.directions(np.array([joint.predecessor_body]), joint.axis_on(True)[:, None])[:, 0, 0]
                return bool(np.linalg.norm(np.cross(axis, self.direction[name])) < _IN_LINE)
        return False

    def _in_line(self, name: str, forward: bool, other: str, onward: bool) -> bool:
        x = self.direction[name] * (1 if forward else -1)
        y = self.direction[other] * (1 if onward else -1)
        gap = self.points[other][0 if onward else 1] - self.points[name][1 if forward else 0]
        size = float(np.linalg.norm(self.points[name][1] - self.points[name][0]))
        off = float(np.linalg.norm(np.cross(x, gap)))
        return bool(x @ y > 0 and np.linalg.norm(np.cross(x, y)) < _IN_LINE and off < _IN_LINE * max(size, 1e-3))

    def _member(self, run: Sequence[tuple[str, bool]]) -> Member:
        if len(run) > 1 and sum(forward for _, forward in run) * 2 < len(run):
            run = [(name, not forward) for name, forward in run[::-1]]
        names = tuple(name for name, _ in run)
        beams = {id(self.edges[name]) for name in names}
        (first, way), (last, last_way) = run[0], run[-1]
        inner = (self.edges[first].inner if way else self.edges[first].outer).find()
        outer = (self.edges[last].outer if last_way else self.edges[last].inner).find()
        ends = [self._end(piece, beams) for piece in (inner, outer)]
        if ends[0] is FREE and ends[1] is FREE:
            ends[1] = CLAMPED
        if ends[1] is FREE:
            ends[0] = CLAMPED
        elif ends[0] is FREE:
            ends[1] = CLAMPED
        elif ends[0].slides and ends[1].slides:
            ends[0] = MemberEnd(ends[0].words, ends[0].turns)
        frames, model = self.robot.zero_frames, self.robot.beams[first]
        axes = frames.orientations(np.array([model.span.carrier]), model.axes[:, :, None])[:, :, 0, 0]
        across = np.array([axes[:, 1], (1 if way else -1) * axes[:, 2]])
        return Member(names, tuple(forward for _, forward in run), (ends[0], ends[1]), self._stiffness(names, across))

    def _stiffness(self, names: Sequence[str], across: Array) -> Array:
        found = []
        for name in names:
            model = self.robot.beams[name]
            own = self.robot.zero_frames.orientations(np.array([model.span.carrier]), model.axes[:, :, None])[:, :, 0, 0]
            turn = across @ own[:, 1:]
            found.append(turn @ np.diag(1 / model.compliances[[5, 4]]) @ turn.T)
        return np.array(found)

    def _end(self, piece: Piece, member: set[int]) -> MemberEnd:
        """Return how the rest of the robot holds a piece at the end of a member of beams with these ids."""
        turns: list[tuple[int, Array]] | None = []
        slides: list[tuple[int, Array]] = []
        used, before = set(member), None
        while not (piece in (self.graph.base, self.graph.platform) and self._is_held(piece, used)):
            others = [edge for edge in self.at[piece] if id(edge) not in used]
            ways = [edge for edge in others if self._is_held(edge.other(piece), used | {id(edge)})]
            if not ways:
                return FREE
            joint = ways[0].connection
            if len(ways) > 1 or joint is None:
                turns = turns or None
                break
            if before is not None and not self._at_one_point(before, joint):
                break
            if not joint.driven:
                more = _turns(joint)
                turns = None if more is None or turns is None else turns + more
                slides += _slides(joint)
            used.add(id(ways[0]))
            piece, before = ways[0].other(piece), joint
        if turns is None:
            words = "pinned"
        else:
            words = {0: "clamped", 1: "hinged"}.get(len(turns), "pinned")
        if slides:
            words = "guided" if words == "clamped" else f"{words}, sliding"
        return MemberEnd(words, None if turns is None else tuple(turns), tuple(slides))

    def _at_one_point(self, *joints: Connection) -> bool:
        points = [
            self.robot.zero_frames.points(np.array([item.predecessor_body]), item.predecessor_frame[:3, 3:])[:, 0, 0]
            for item in joints
        ]
        return float(np.linalg.norm(points[1] - points[0])) < _SAME

    def _is_held(self, piece: Piece, without: set[int]) -> bool:
        """Whether a piece hangs together with the base when some edges are cut."""
        seen, queue = {piece}, [piece]
        while queue:
            here = queue.pop()
            if here is self.graph.base:
                return True
            for edge in self.at.get(here, []):
                other = edge.other(here)
                if id(edge) not in without and other not in seen:
                    seen.add(other)
                    queue.append(other)
        return False


def _turns(joint: Connection) -> list[tuple[int, Array]] | None:
    """Return the axes about which a passive joint turns; None: all."""
    if joint.kind in ("spherical", "floating"):
        return None
    first = (joint.predecessor_body, joint.axis_on(True))
    if joint.kind == "universal":
        return [first, (joint.successor_body, joint.successor_frame[:3, :3] @ joint.axis2)]
    return [first] if joint.kind in ("revolute", "continuous", "cylindrical", "planar") else []


def _slides(joint: Connection) -> list[tuple[int, Array]]:
    """Return the directions in which a passive joint slides."""
    axis = joint.axis_on(True)
    if joint.kind in ("prismatic", "cylindrical"):
        return [(joint.predecessor_body, axis)]
    if joint.kind == "planar":
        _, _, basis = np.linalg.svd(axis[None])
        return [(joint.predecessor_body, basis[1]), (joint.predecessor_body, basis[2])]
    return []
