"""One limb at many poses: constraint wrenches J_ic, attached wrenches J_ig W_ig, compliance C_ic and sag Δ_igc.

Limbs that are built alike are stacked along an axis of their own: arrays are ``(component, column, limb, pose)``.
Ranks and the list of candidates that form the readable bases are fixed once per robot, at generic poses (``method.md``
section 2); at every pose the same candidates are evaluated.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetostatics import beams as beam_formulas
from kinetostatics.exceptions import RobotFileError, StaticsError
from kinetostatics.kinematics import Frames
from kinetostatics.linalg import Cholesky, cross, dot, normalize
from kinetostatics.mechanism import ROTATING, Connection, Mechanism, meeting_points
from kinetostatics.screws import move_wrench, rotation_twist, translation_twist, wrench_of_couple, wrench_of_force
from kinetostatics.sections import beam_compliance_coefficients
from kinetostatics.topology import SAME_POINT, BeamSpan, Edge, Limb

if TYPE_CHECKING:
    from kinetostatics.robot import Robot

Array = NDArray[np.float64]
Index = NDArray[np.intp]

#: Below this pivot of the Gram matrix (the squared sine of an angle) a readable basis counts as degenerate.
DEGENERATE = 1e-10


@dataclass(frozen=True)
class Freedom:
    """One freedom of a joint: a rotation about, or a translation along, an axis fixed in a body.

    ``centre`` is a point (3,) of ``centre_body`` on the axis.
    """

    rotates: bool
    body: int
    axis: Array
    centre_body: int
    centre: Array
    sign: int
    label: str


@dataclass(frozen=True)
class Unit:
    """A joint of a limb as its statics see it: runs of revolutes that meet in a point are one universal or spherical joint.

    Attributes:
        kind: URDF or loop type, ``universal`` or ``spherical`` for runs.
        label: name for people.
        joints: names of its joints.
        passive: whether its freedoms are free (neither driven nor fixed).
        freedoms: its freedoms, base to platform.
        edge: position of its last joint in the limb's path.
    """

    kind: str
    label: str
    joints: tuple[str, ...]
    passive: bool
    freedoms: tuple[Freedom, ...]
    edge: int


@dataclass(frozen=True)
class BeamModel:
    """A beam's numbers that do not depend on the pose.

    Attributes:
        name: of the beam.
        span: where it lies.
        axes: (3, 3) beam axes x, y, z as columns, in the carrier body.
        compliances: (6,) section compliances.
        mass_per_length: [kg/m], or None when ``mass`` [kg] is spread over whatever length the beam has.
        mass: see ``mass_per_length``.
    """

    name: str
    span: BeamSpan
    axes: Array
    compliances: Array
    mass_per_length: float | None
    mass: float

    def length(self, frames: Frames) -> Array:
        """Return the length (N,) [m] at given frames."""
        start = frames.points(np.array([self.span.start_body]), self.span.start[:, None])[:, 0]
        end = frames.points(np.array([self.span.end_body]), self.span.end[:, None])[:, 0]
        along = frames.directions(np.array([self.span.carrier]), self.axes[:, :1])[:, 0]
        return dot(along, end - start)


def make_beam_models(mechanism: Mechanism, spans: dict[str, BeamSpan], zero: Frames) -> dict[str, BeamModel]:
    """Compute the beams' constants; ``zero`` holds the frames of one closed pose, which orients telescopes.

    Raises:
        RobotFileError: a telescope's prismatic joint does not lie along its beam, or y_axis is parallel to it.
    """
    models = {}
    fixed_length: dict[str, float] = {}
    for name, span in spans.items():
        carrier = np.array([span.carrier])
        start = zero.points(np.array([span.start_body]), span.start[:, None])[:, 0, 0]
        end = zero.points(np.array([span.end_body]), span.end[:, None])[:, 0, 0]
        direction = end - start
        for joint in span.spanned:
            connection = mechanism.connections[joint]
            axis = zero.directions(
                np.array([connection.predecessor_body]), (connection.predecessor_frame[:3, :3] @ connection.axis)[:, None]
            )[:, 0, 0]
            if float(np.linalg.norm(direction)) < SAME_POINT:
                direction = axis
            if float(np.linalg.norm(np.cross(axis, direction))) > 1e-5 * float(np.linalg.norm(direction)):
                place = span.beam.place
                raise RobotFileError(
                    f"<beam {name!r}>: the axis of the prismatic joint {joint!r} inside its span does not lie along the beam",
                    place.file, place.line,
                )  # fmt: skip
            direction = axis if float(axis @ direction) > 0 else -axis
        R = zero.rotation[:, :, span.carrier, 0]
        x = R.T @ (direction / np.linalg.norm(direction))
        placement = mechanism.body_of[span.beam.link][1]
        given = span.beam.y_axis
        hint = placement[:3, :3] @ (np.array(given) if given is not None else np.eye(3)[int(np.argmin(np.abs(placement[:3, :3].T @ x)))])
        y = hint - x * float(x @ hint)
        if float(np.linalg.norm(y)) < 1e-6 * float(np.linalg.norm(hint)):
            place = span.beam.place
            raise RobotFileError(f"<beam {name!r}>: its y_axis is parallel to the beam", place.file, place.line)
        y /= np.linalg.norm(y)
        del carrier
        beam = span.beam
        coefficients = beam_compliance_coefficients(
            beam.section, beam.youngs_modulus, beam.shear_modulus, beam.shear_areas
        )
        density = beam.density
        fixed_length[name] = float(np.linalg.norm(end - start))
        models[name] = BeamModel(
            name, span, np.column_stack([x, y, np.cross(x, y)]), coefficients,
            None if density is None else density * beam.section.area, 0.0,
        )  # fmt: skip
    return {name: _with_spread_mass(mechanism, model, models, fixed_length) for name, model in models.items()}


def _with_spread_mass(
    mechanism: Mechanism, model: BeamModel, models: dict[str, BeamModel], lengths: dict[str, float]
) -> BeamModel:
    """Give a beam without density its share, by length, of its link's own mass."""
    if model.mass_per_length is not None:
        return model
    link = model.span.beam.link
    siblings = [name for name, item in models.items() if item.span.beam.link == link]
    share = lengths[model.name] / max(sum(lengths[name] for name in siblings), 1e-300) if len(siblings) > 1 else 1.0
    mass = mechanism.description.links[link].mass * share
    return BeamModel(model.name, model.span, model.axes, model.compliances, None, mass)


# ---- joints as the statics see them -------------------------------------------------------------------------------------


def limb_units(mechanism: Mechanism, limb: Limb) -> tuple[Unit, ...]:
    """Return the joints of a limb's path, base to platform, with runs of revolutes joined (fixed joints are left out)."""
    steps: list[tuple[int, Edge, Connection]] = []
    units: list[Unit] = []

    def flush() -> None:
        while steps:
            for count in (3, 2, 1):
                centres = _common_centre([(edge, item) for _, edge, item in steps[:count]]) if len(steps) >= count else None
                if count == 1 or centres is not None:
                    units.append(_unit_of_run(steps[:count], centres))
                    del steps[:count]
                    break

    for position, edge in enumerate(limb.path):
        connection = mechanism.connections[edge.joint] if edge.joint else None
        if connection is not None and connection.kind in ROTATING and not connection.driven:
            steps.append((position, edge, connection))
        elif connection is None or connection.kind != "fixed":
            flush()
            if connection is not None:
                units.append(
                    Unit(connection.kind, connection.name, (connection.name,), not connection.driven,
                         _freedoms(connection, edge.sign), position)
                )  # fmt: skip
        if limb.weight_between[position]:
            flush()
    flush()
    return tuple(units)


def _sides(edge: Edge, connection: Connection) -> tuple[tuple[int, Array], tuple[int, Array]]:
    """Return body and joint frame on the inboard and on the outboard side."""
    sides = (
        (connection.predecessor_body, connection.predecessor_frame),
        (connection.successor_body, connection.successor_frame),
    )
    return sides if edge.sign > 0 else (sides[1], sides[0])


def _common_centre(run: Sequence[tuple[Edge, Connection]]) -> Array | None:
    """Return where on the first joint's axis (m from its centre) the axes of 2 or 3 revolutes meet, None if they do not."""
    if len(run) < 2:
        return None
    meetings = []
    for (edge, connection), (next_edge, following) in zip(run, run[1:], strict=False):
        body, frame = _sides(edge, connection)[1]
        next_body, next_frame = _sides(next_edge, following)[0]
        if body != next_body:
            return None
        meeting = meeting_points(
            frame[:3, :3] @ connection.axis, frame[:3, 3], next_frame[:3, :3] @ following.axis, next_frame[:3, 3]
        )
        if meeting is None:
            return None
        meetings.append(meeting)
    if len(meetings) == 2 and abs(meetings[0][1] - meetings[1][0]) > 1e-9:
        return None
    return np.array([meetings[0][0]])


def _unit_of_run(run: Sequence[tuple[int, Edge, Connection]], meeting: Array | None) -> Unit:
    names = tuple(connection.name for _, _, connection in run)
    label = names[0] if len(names) == 1 else os.path.commonprefix(names).rstrip("_-. ") or "+".join(names)
    first_edge, first = run[0][1], run[0][2]
    body, frame = _sides(first_edge, first)[0]
    shift = float(meeting[0]) if meeting is not None else 0.0
    centre = frame[:3, 3] + shift * (frame[:3, :3] @ first.axis)
    if len(run) == 3:
        spun = tuple(
            Freedom(True, body, axis, body, centre, 1, label) for axis in np.eye(3)
        )
        return Unit("spherical", label, names, True, spun, run[-1][0])
    freedoms = tuple(
        Freedom(True, connection.predecessor_body, connection.axis_on(True), body, centre, edge.sign, connection.name)
        for _, edge, connection in run
    )
    return Unit("universal" if len(run) == 2 else "revolute", label, names, True, freedoms, run[-1][0])


def _freedoms(connection: Connection, sign: int) -> tuple[Freedom, ...]:
    """Return the freedoms of one joint or loop of any kind, base to platform."""
    kind, name = connection.kind, connection.name
    here, there = connection.predecessor_body, connection.successor_body
    frame, other = connection.predecessor_frame, connection.successor_frame
    axis = connection.axis_on(True)

    def rotation(body: int, direction: Array, label: str = name) -> Freedom:
        centre_body, centre = (there, other[:3, 3]) if kind in ("planar", "floating") else (here, frame[:3, 3])
        return Freedom(True, body, direction, centre_body, centre, sign, label)

    def translation(direction: Array) -> Freedom:
        return Freedom(False, here, direction, there, other[:3, 3], sign, name)

    if kind in ROTATING:
        found = [rotation(here, axis)]
    elif kind == "prismatic":
        found = [translation(axis)]
    elif kind == "cylindrical":
        found = [translation(axis), rotation(here, axis)]
    elif kind == "universal":
        second = other[:3, :3] @ connection.axis2
        found = [rotation(here, axis, f"{name} (first axis)"), rotation(there, second, f"{name} (second axis)")]
    elif kind == "spherical":
        found = [rotation(here, column) for column in frame[:3, :3].T]
    elif kind == "planar":
        helper = np.eye(3)[int(np.argmin(np.abs(connection.axis)))]
        side = np.cross(connection.axis, helper)
        side /= np.linalg.norm(side)
        third = np.cross(connection.axis, side)
        found = [translation(frame[:3, :3] @ side), translation(frame[:3, :3] @ third), rotation(here, axis)]
    else:
        found = [translation(column) for column in frame[:3, :3].T]
        found += [rotation(here, column) for column in frame[:3, :3].T]
    return tuple(found if sign > 0 else found[::-1])


class Branch:
    """A passive joint of a dead branch: it has to be in equilibrium as it stands.

    Attributes:
        owner: the limb on which the branch hangs, or ``base`` or ``platform``.
        joint: its name.
        outboard: (W,) which weights it carries.
        scale: (k,) what makes its powers comparable: 1 for a translation, the characteristic length for a rotation.
    """

    def __init__(self, robot: Robot, owner: str, edge: Edge) -> None:
        connection = robot.mechanism.connections[str(edge.joint)]
        self.owner, self.joint = owner, connection.name
        self.outboard = np.array([name in edge.outboard for name in robot.weights.names], dtype=float)
        self._freedoms = _freedoms(connection, edge.sign)
        self.scale = np.array([robot.length if f.rotates else 1.0 for f in self._freedoms])

    def twists(self, frames: Frames, o: Array) -> Array:
        """Return the unit twists (6, k, N) of its freedoms about o."""
        columns = []
        for f in self._freedoms:
            axis = frames.directions(np.array([f.body]), f.axis[:, None])[:, 0] * f.sign
            arm = frames.points(np.array([f.centre_body]), f.centre[:, None])[:, 0] - o
            columns.append(rotation_twist(axis, arm) if f.rotates else translation_twist(axis))
        return np.stack(columns, axis=1)


def dead_joints(robot: Robot) -> tuple[Branch, ...]:
    """Return the passive joints of all dead branches."""
    topology = robot.topology
    parts = [(limb.name, limb.branches) for limb in topology.limbs]
    parts += [("base", topology.base.edges), ("platform", topology.platform.edges)]
    found = []
    for owner, edges in parts:
        for edge in edges:
            if edge.joint is not None:
                connection = robot.mechanism.connections[edge.joint]
                if connection.kind != "fixed" and not connection.driven:
                    found.append(Branch(robot, owner, edge))
    return tuple(found)


# ---- readable wrenches ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Candidate:
    """A wrench that a person can read: a unit force through a joint's centre or a unit couple, along some direction.

    Attributes:
        direction: ``("limb", k)``: the limb's axis x, y or z; ``("axis", f)``: that of its f-th freedom; ``("cross", f, h)``: across
            two of them; ``("cross_limb", f, k)``; ``("rest", s)``: no direction but the s-th seed, see ``Basis``.
        centre: the unit whose centre the force passes through, None for a couple.
        label: for people.
    """

    direction: tuple[str | int, ...]
    centre: int | None
    label: str


@dataclass(frozen=True)
class Basis:
    """The candidates of one limb, fixed once.

    Attributes:
        constraint, attached: candidates of J_ic and of J_ig.
        independent: freedoms whose twists are independent at generic poses, for the completion of J_ic.
        carried: the same among the platform joint's freedoms, for the completion of J_ig.
        gap: ratio of the smallest kept to the largest dropped singular value of the limb's twists.
    """

    constraint: tuple[Candidate, ...]
    attached: tuple[Candidate, ...]
    independent: tuple[int, ...]
    carried: tuple[int, ...]
    gap: float


@dataclass(frozen=True)
class LimbGeometry:
    """What one pose of a group of limbs looks like: all arms are from o, arrays (…, limb, pose)."""

    axes: Array  # (3, k, g, N) axes of all freedoms
    twists: Array  # (6, k, g, N) unit twists of all freedoms about o, outboard relative to inboard
    centres: Array  # (3, units, g, N) joint centres
    limb_axes: Array  # (3, 3, g, N) columns x, y, z
    beam_axes: Array  # (3, 3, beams, g, N)
    beam_lengths: Array  # (beams, g, N)
    beam_ends: Array  # (3, beams, g, N)


class LimbGroup:
    """Limbs that are built alike.

    Attributes:
        limbs: the limbs.
        numbers: their positions among the robot's limbs.
        units: of every limb, its joints.
        beams: of every limb, the beams on its path, base to platform.
        basis: the readable wrenches, alike for all but for their labels.
        labels, attached_labels: names of the columns of J_ic and J_ig, for each limb.
        passive: which freedoms are passive.
        platform_joint: which freedoms belong to the platform joint.
        freedoms_before_beam: for each beam on the path, how many freedoms lie on its base side.
    """

    def __init__(self, robot: Robot, numbers: Sequence[int], bases: Sequence[Basis] = ()) -> None:
        self.robot = robot
        self.numbers = tuple(numbers)
        self.limbs = [robot.topology.limbs[k] for k in numbers]
        self.units = [limb_units(robot.mechanism, limb) for limb in self.limbs]
        self.beams = [[robot.beams[edge.beam] for edge in limb.path if edge.beam] for limb in self.limbs]
        first = self.units[0]
        tables = [[freedom for unit in units for freedom in unit.freedoms] for units in self.units]
        self.freedoms = tables
        self.passive = np.array([unit.passive for unit in first for _ in unit.freedoms], dtype=bool)
        self.rotates = np.array([freedom.rotates for freedom in tables[0]], dtype=bool)
        self.unit_of = np.array([k for k, unit in enumerate(first) for _ in unit.freedoms], dtype=np.intp)
        g, k = len(tables), len(tables[0])
        self._axis_body = np.array([[f.body for f in table] for table in tables], dtype=np.intp).reshape(g, k).T.ravel()
        self._axis = np.array([[f.axis for f in table] for table in tables]).reshape(g, k, 3).transpose(2, 1, 0).reshape(3, -1)
        self._centre_body = np.array([[f.centre_body for f in table] for table in tables], dtype=np.intp).reshape(g, k).T.ravel()
        self._centre = np.array([[f.centre for f in table] for table in tables]).reshape(g, k, 3).transpose(2, 1, 0).reshape(3, -1)
        self._sign = np.array([[f.sign for f in table] for table in tables], dtype=float).reshape(g, k).T[None, :, :, None]
        self._rest_point = [self._outer_point(limb) for limb in self.limbs]
        b = len(self.beams[0])
        spans = [[beam.span for beam in beams] for beams in self.beams]
        self._beam_body = {
            what: np.array([[getattr(s, what) for s in row] for row in spans], dtype=np.intp).reshape(g, b).T.ravel()
            for what in ("start_body", "end_body", "carrier")
        }
        self._beam_start = np.array([[s.start for s in row] for row in spans]).reshape(g, b, 3).transpose(2, 1, 0).reshape(3, -1)
        self._beam_end = np.array([[s.end for s in row] for row in spans]).reshape(g, b, 3).transpose(2, 1, 0).reshape(3, -1)
        self._beam_axes = np.array([[m.axes for m in row] for row in self.beams]).reshape(g, b, 3, 3).transpose(2, 3, 1, 0).reshape(3, 3, -1)
        self.compliances = np.array([[m.compliances for m in row] for row in self.beams]).reshape(g, b, 6).transpose(2, 1, 0)[..., None]
        self.freedoms_before_beam = tuple(
            sum(len(unit.freedoms) for unit in first if unit.edge < position)
            for position, edge in enumerate(self.limbs[0].path)
            if edge.beam
        )
        self.platform_joint = self._platform_joint()
        self._y_choice = self._choose_y()
        self._outboard_of_freedom = self._outboard(
            [[limb.path[unit.edge] for unit in units for _ in unit.freedoms] for limb, units in zip(self.limbs, self.units, strict=True)]
        )
        self._outboard_of_beam = self._outboard([[edge for edge in limb.path if edge.beam] for limb in self.limbs])
        if bases:
            self.basis = bases[0]
            self.labels = [tuple(c.label for c in basis.constraint) for basis in bases]
            self.attached_labels = [tuple(c.label for c in basis.attached) for basis in bases]

    @property
    def is_rigid(self) -> bool:
        """Whether no beam lies on the way from base to platform."""
        return not self.beams[0]

    @property
    def signature(self) -> tuple[object, ...]:
        """What limbs must have in common to be stacked."""
        return (
            tuple((unit.kind, unit.passive, tuple(f.rotates for f in unit.freedoms)) for unit in self.units[0]),
            self.freedoms_before_beam,
            tuple(self.platform_joint.tolist()),
            self._y_choice,
        )

    def _outboard(self, edges: list[list[Edge]]) -> Array:
        """Return the table (limbs, edges, weights) of what is outboard of given edges."""
        names = self.robot.weights.names
        table = [[[name in edge.outboard for name in names] for edge in row] for row in edges]
        return np.array(table, dtype=float).reshape(len(edges), len(edges[0]), len(names))

    def _platform_joint(self) -> NDArray[np.bool_]:
        """Mark the freedoms of the outermost run of passive joints with neither beam nor weight between them."""
        limb = self.limbs[0]
        inside = np.zeros(len(self.passive), dtype=bool)
        for position in range(len(limb.path) - 1, -1, -1):
            edge = limb.path[position]
            if edge.beam or (limb.weight_between[position] and position < len(limb.path) - 1):
                break
            connection = self.robot.mechanism.connections[str(edge.joint)]
            if connection.driven:
                break
            for k, unit in enumerate(self.units[0]):
                if connection.name in unit.joints:
                    inside |= self.unit_of == k
        return inside

    def _outer_point(self, limb: Limb) -> tuple[int, Array]:
        """Return body and point of the limb's outer end: its last joint's or beam's."""
        edge = limb.path[-1]
        if edge.beam:
            span = self.robot.beams[edge.beam].span
            return span.end_body, span.end
        connection = self.robot.mechanism.connections[str(edge.joint)]
        body, frame = _sides(edge, connection)[1]
        return body, frame[:3, 3]

    def _choose_y(self) -> tuple[str, int]:
        """Choose what the limb's y axis follows: a passive revolute, else a universal's axis, else a world axis."""
        frames = self.robot.zero_frames
        z = self._limb_z(frames)[:, 0, 0]
        axes = frames.directions(self._axis_body, self._axis)[:, :: len(self.limbs), 0]
        for kinds in (("revolute", "continuous", "cylindrical"), ("universal",)):
            for k, unit in enumerate(self.units[0]):
                for f in np.flatnonzero(self.unit_of == k):
                    if unit.kind in kinds and unit.passive and self.rotates[f] and abs(float(axes[:, f] @ z)) < 0.999:
                        return "axis", int(f)
        return "world", int(np.argmin(np.abs(z)))

    def _limb_z(self, frames: Frames) -> Array:
        """Return the limbs' z axes (3, g, N)."""
        g = len(self.limbs)
        if self.beams[0]:
            return frames.directions(self._beam_body["carrier"], self._beam_axes[:, 0])[:, -g:]
        k = len(self.passive)
        outer = frames.points(np.array([b for b, _ in self._rest_point]), np.array([p for _, p in self._rest_point]).T)
        if k:
            inner = frames.points(self._centre_body[:g], self._centre[:, :g])
            axis = outer - inner
            if float(np.min(np.sqrt(dot(axis, axis)), initial=1.0)) > 1e-9:
                return normalize(axis)
        up = np.zeros_like(outer)
        up[2] = 1
        return up

    def geometry(self, frames: Frames, o: Array) -> LimbGeometry:
        """Evaluate the limbs at given frames; ``o`` (3, N) is the reference point."""
        g, k, N = len(self.limbs), len(self.passive), frames.position.shape[2]
        axes = frames.directions(self._axis_body, self._axis).reshape(3, k, g, N)
        arms = (frames.points(self._centre_body, self._centre) - o[:, None]).reshape(3, k, g, N)
        twists = np.concatenate([np.where(self.rotates[:, None, None], cross(arms, axes), axes),
                                 np.where(self.rotates[:, None, None], axes, 0.0)]) * self._sign  # fmt: skip
        firsts = [int(np.flatnonzero(self.unit_of == u)[-1]) for u in range(len(self.units[0]))]
        outer = frames.points(np.array([b for b, _ in self._rest_point]), np.array([p for _, p in self._rest_point]).T)
        centres = np.concatenate([arms[:, firsts], (outer - o[:, None])[:, None]], axis=1)
        b = len(self.beams[0])
        beam_axes = frames.orientations(self._beam_body["carrier"], self._beam_axes).reshape(3, 3, b, g, N)
        start = frames.points(self._beam_body["start_body"], self._beam_start).reshape(3, b, g, N)
        end = frames.points(self._beam_body["end_body"], self._beam_end).reshape(3, b, g, N)
        lengths = dot(beam_axes[:, 0], end - start)
        z = self._limb_z(frames)
        if self._y_choice[0] == "axis":
            follow = axes[:, self._y_choice[1]]
        else:
            follow = np.zeros_like(z)
            follow[self._y_choice[1]] = 1
        y = normalize(follow - z * dot(z, follow))
        limb_axes = np.stack([cross(y, z), y, z], axis=1)
        return LimbGeometry(axes, twists, centres, limb_axes, beam_axes, lengths, end - o[:, None, None])

    # ---- bases ------------------------------------------------------------------------------------------------------

    def wrench(self, candidate: Candidate, geometry: LimbGeometry) -> Array:
        """Return the wrenches (6, g, N) of a candidate, about o."""
        direction = candidate.direction
        if direction[0] == "limb":
            along = geometry.limb_axes[:, int(direction[1])]
        elif direction[0] == "axis":
            along = geometry.axes[:, int(direction[1])]
        elif direction[0] == "cross":
            along = normalize(cross(geometry.axes[:, int(direction[1])], geometry.axes[:, int(direction[2])]))
        else:
            along = normalize(cross(geometry.axes[:, int(direction[1])], geometry.limb_axes[:, int(direction[2])]))
        if candidate.centre is None:
            return wrench_of_couple(along)
        return wrench_of_force(along, geometry.centres[:, candidate.centre])

    def bases(self, geometry: LimbGeometry) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Return J_ic (6, n_c, g, N), J_ig (6, n_g, g, N) about o, and where (g, N) the readable bases degenerate.

        There the bases are orthonormal ones, found by singular values.
        """
        length = self.robot.length
        scale = np.array([length] * 3 + [1.0] * 3).reshape(6, 1, 1)  # wrench × scale and twist / scale: both dimensionless
        columns = self._columns(self.basis.constraint, self.basis.independent, [], geometry)
        columns += self._columns(self.basis.attached, self.basis.carried, columns, geometry)
        count = len(self.basis.constraint)
        g, N = geometry.limb_axes.shape[2:]
        J = np.stack(columns, axis=1) if columns else np.zeros((6, 0, g, N))
        bad = self._degenerate(J, count, scale[:, None], geometry)
        if np.any(bad):
            self._replace(J, count, scale, geometry, bad)
        return J[:, :count], J[:, count:], bad

    def _columns(
        self, part: Sequence[Candidate], carried: Sequence[int], known: list[Array], geometry: LimbGeometry
    ) -> list[Array]:
        """Return the wrenches (6, g, N) of candidates, completed by ones independent of those ``known``."""
        length = self.robot.length
        scale = np.array([length] * 3 + [1.0] * 3).reshape(6, 1, 1)
        found = [self.wrench(candidate, geometry) for candidate in part if candidate.direction[0] != "rest"]
        seeds = [int(c.direction[1]) for c in part if c.direction[0] == "rest"]
        if seeds:
            spanned = [geometry.twists[:, f] / scale for f in carried] + [w * scale for w in (*known, *found)]
            found += [w / scale for w in _complete(spanned, _seeds(geometry, length) * scale[:, None], seeds)]
        return found

    def _degenerate(self, J: Array, count: int, scale: Array, geometry: LimbGeometry) -> NDArray[np.bool_]:
        """Return where (g, N) the constraint wrenches are dependent, or not reciprocal to the passive joints any more."""
        bad = ~np.all(np.isfinite(J), axis=(0, 1))
        unit = normalize(np.where(bad, 1.0, J) * scale)
        for first, last in ((0, count), (0, J.shape[1])):
            if last > first:
                part = unit[:, first:last]
                bad |= ~(Cholesky(np.einsum("ki...,kj...->ij...", part, part)).smallest_pivot > DEGENERATE)
        if count and np.any(self.passive):
            power = np.einsum("ki...,kj...->ij...", geometry.twists[:, self.passive] / scale, unit[:, :count])
            bad |= np.max(np.abs(power), axis=(0, 1)) > 1e-6 + 100 * self.robot.closing_error
        return np.asarray(bad)

    def _replace(self, J: Array, count: int, scale: Array, geometry: LimbGeometry, bad: NDArray[np.bool_]) -> None:
        """Put orthonormal bases, found by singular values, where the readable ones degenerate."""
        s = scale[:, 0, 0]
        for limb, pose in np.argwhere(bad):
            twists = geometry.twists[:, :, limb, pose] / s[:, None]
            if not np.all(np.isfinite(twists)):
                continue
            reciprocal = np.linalg.svd(twists[:, self.passive], full_matrices=True)[0][:, 6 - count :]
            J[:, :count, limb, pose] = reciprocal / s[:, None]
            known = np.hstack([twists[:, self.platform_joint], reciprocal])
            rest = np.linalg.svd(known, full_matrices=True)[0][:, 6 - (J.shape[1] - count) :]
            J[:, count:, limb, pose] = rest / s[:, None]

    def choose_basis(self, frames: Frames, o: Array) -> Basis:
        """Choose ranks and readable wrenches at generic poses; for a group of one limb."""
        geometry = self.geometry(frames, o)
        length, tolerance = self.robot.length, self.robot.rank_tolerance
        scale = np.array([length] * 3 + [1.0] * 3).reshape(6, 1, 1)
        twists = geometry.twists[:, :, 0] / scale
        poses = range(twists.shape[2])
        ranks = [_rank(twists[:, self.passive, p], tolerance) for p in poses]
        rank, gap = max(ranks)
        n_c = 6 - rank
        carried_rank = max(_rank(twists[:, self.platform_joint, p], tolerance)[0] for p in poses)
        n_g = 6 - carried_rank - n_c
        labels = [f.label for f in self.freedoms[0]]
        constraint, columns = self._select(
            _constraint_candidates(self.units[0], self.unit_of, self.passive, self.rotates, labels), n_c, self.passive,
            geometry, twists, scale, [],
        )  # fmt: skip
        independent = _independent(twists, np.flatnonzero(self.passive), tolerance)
        spanned = [twists[:, f] for f in independent] + columns
        constraint += _rest(spanned, (_seeds(geometry, length) * scale[:, None])[:, :, 0], n_c - len(constraint), "complementary wrench")
        columns = [w[:, 0] * scale[:, 0] for w in self._columns(constraint, independent, [], geometry)]
        attached, columns = self._select(
            _attached_candidates(self.units[0], self.unit_of, self.passive, self.rotates, labels), n_g, self.platform_joint,
            geometry, twists, scale, columns,
        )  # fmt: skip
        carried = _independent(twists, np.flatnonzero(self.platform_joint), tolerance)
        attached += _rest([twists[:, f] for f in carried] + columns, (_seeds(geometry, length) * scale[:, None])[:, :, 0],
                          n_g - len(attached), "complementary wrench")  # fmt: skip
        return Basis(tuple(constraint), tuple(attached), tuple(independent), tuple(carried), gap)

    def _select(
        self,
        candidates: Iterator[Candidate],
        count: int,
        reciprocal_to: NDArray[np.bool_],
        geometry: LimbGeometry,
        twists: Array,
        scale: Array,
        taken: list[Array],
    ) -> tuple[list[Candidate], list[Array]]:
        """Take candidates greedily that are reciprocal to given freedoms and independent of those taken."""
        chosen: list[Candidate] = []
        taken = list(taken)
        allowed = 1e-8 + 100 * self.robot.closing_error
        with np.errstate(invalid="ignore", divide="ignore"):
            for candidate in candidates:
                if len(chosen) == count:
                    break
                column = normalize(self.wrench(candidate, geometry)[:, 0] * scale[:, 0])
                if not np.all(np.isfinite(column)):
                    continue
                power = np.einsum("kin,kn->in", twists[:, reciprocal_to], column)
                if float(np.abs(power).max(initial=0.0)) > allowed:
                    continue
                stack = np.stack([*taken, column])
                smallest = [float(np.linalg.svd(stack[:, :, p], compute_uv=False)[-1]) for p in range(stack.shape[2])]
                if min(smallest) > 1e-3:
                    chosen.append(candidate)
                    taken.append(column)
        return chosen, taken

    # ---- statics ----------------------------------------------------------------------------------------------------

    def statics(self, frames: Frames, o: Array, weights: Array, gravity: Array) -> LimbStatics:
        """Evaluate the limbs' wrenches, compliances and sag.

        Args:
            frames: of all bodies.
            o: (3, N) reference point.
            weights: (6, W, N) wrenches of all weights about o [N, N·m].
            gravity: (3, N) [m/s²].
        """
        geometry = self.geometry(frames, o)
        J_c, J_g, degenerate = self.bases(geometry)
        outboard = np.einsum("gkw,iwn->ikgn", self._outboard_of_freedom, weights)
        beyond = np.einsum("gbw,iwn->ibgn", self._outboard_of_beam, weights)
        passive = self.passive
        row_scale = np.where(self.rotates[passive], self.robot.length, 1.0)[:, None, None]
        T = geometry.twists[:, passive]
        demand = np.einsum("ik...,ik...->k...", T, outboard[:, passive]) / row_scale
        W_g = np.zeros((J_g.shape[1], *demand.shape[1:]))
        left = demand
        if J_g.shape[1]:
            A = np.einsum("ik...,ij...->kj...", T, J_g) / row_scale[:, None]
            normal = np.einsum("ki...,kj...->ij...", A, A)
            factor = Cholesky(normal)
            for _ in range(2):  # the second round removes the error of the normal equations
                right = -np.einsum("ki...,k...->i...", A, left)
                W_g = W_g + factor.solve(right[:, None])[:, 0]
                left = demand + np.einsum("ki...,i...->k...", A, W_g)
        R_g = np.einsum("ij...,j...->i...", J_g, W_g)
        load = self.beam_load(geometry, gravity)
        C, sag = self._compliance(geometry, J_c, R_g, beyond, load)
        return LimbStatics(self, geometry, J_c, J_g, W_g, R_g, C, sag, outboard, beyond, load, left, degenerate)

    def beam_load(self, geometry: LimbGeometry, gravity: Array) -> Array:
        """Return the even loads (3, beams, g, N) [N/m] of the beams' own weights, in beam axes."""
        per_length = np.array(
            [[np.nan if m.mass_per_length is None else m.mass_per_length for m in row] for row in self.beams]
        ).reshape(len(self.limbs), -1).T[..., None]  # fmt: skip
        whole = np.array([[m.mass for m in row] for row in self.beams]).reshape(len(self.limbs), -1).T[..., None]
        spread = np.where(np.isnan(per_length), whole / geometry.beam_lengths, per_length)
        return np.einsum("ik...,i...->k...", geometry.beam_axes, np.broadcast_to(gravity[:, None, None], (3, *spread.shape))) * spread

    def to_beam(self, geometry: LimbGeometry, beam: int, wrench: Array) -> Array:
        """Return wrenches (6, m, g, N) about o as wrenches about a beam's outer end, in beam axes."""
        moved = move_wrench(wrench, geometry.beam_ends[:, beam][:, None])
        axes = geometry.beam_axes[:, :, beam]
        return np.concatenate([np.einsum("ji...,jm...->im...", axes, part) for part in (moved[:3], moved[3:])])

    def _compliance(
        self, geometry: LimbGeometry, J_c: Array, R_g: Array, beyond: Array, load: Array
    ) -> tuple[Array, Array]:
        n, g, N = J_c.shape[1:]
        C, sag = np.zeros((n, n, g, N)), np.zeros((n, g, N))
        if not self.beams[0] or n == 0:
            return C, sag
        for b in range(len(self.beams[0])):
            c, L = self.compliances[:, b][:, None], geometry.beam_lengths[b]
            known = (R_g + beyond[:, b])[:, None]
            local = self.to_beam(geometry, b, np.concatenate([J_c, known], axis=1))
            moved = beam_formulas.end_displacement(c, L, local)
            moved[:, n] += beam_formulas.sag(c[:, 0], L, load[:, b])
            product = np.einsum("ki...,kj...->ij...", local[:, :n], moved)
            C += product[:, :n]
            sag += product[:, n]
        return C, sag


@dataclass(frozen=True)
class LimbStatics:
    """A group of limbs at many poses; arrays (…, limb, pose), wrenches about o.

    Attributes:
        group, geometry: the limbs and where they are.
        J_c, J_g: (6, n_c, g, N), (6, n_g, g, N) constraint and attached wrenches, Eqs. (2)–(4).
        W_g: (n_g, g, N) attached intensities, Eq. (3).
        R_g: (6, g, N) their sum J_ig W_ig.
        C: (n_c, n_c, g, N) compliance C_ic, Eq. (1).
        sag: (n_c, g, N) Δ_igc, Eqs. (16), (19), (21).
        outboard: (6, freedoms, g, N) weights outboard of each freedom's joint.
        beyond: (6, beams, g, N) weights outboard of each beam's outer end.
        load: (3, beams, g, N) the beams' own weights in beam axes [N/m].
        unbalanced: (passive freedoms, g, N) what is left of Eq. (3) [N].
        degenerate: (g, N) where the bases are not the readable ones.
    """

    group: LimbGroup
    geometry: LimbGeometry
    J_c: Array
    J_g: Array
    W_g: Array
    R_g: Array
    C: Array
    sag: Array
    outboard: Array
    beyond: Array
    load: Array
    unbalanced: Array
    degenerate: NDArray[np.bool_]


def _constraint_candidates(
    units: Sequence[Unit], unit_of: Index, passive: NDArray[np.bool_], rotates: NDArray[np.bool_], labels: list[str]
) -> Iterator[Candidate]:
    """Yield readable candidates of J_ic in the order of preference of ``method.md`` section 3."""
    outer = len(units)
    at = _platform_centre(units)
    where = [unit.label for unit in units] + ["its outer end"]
    axes = _readable_axes(units, unit_of, passive, rotates)
    centres = [at, *(k for k in range(len(units) - 1, -1, -1) if k != at), *([outer] if at != outer else [])]
    yield Candidate(("limb", 2), at, f"force along limb axis at {where[at]}")
    for centre in centres:
        for f in axes:
            yield Candidate(("axis", f), centre, f"force ∥ {labels[f]} at {where[centre]}")
    for k in (1, 0):
        yield Candidate(("limb", k), at, f"force along limb {'xyz'[k]} at {where[at]}")
    pairs = [(f, h) for i, f in enumerate(axes) for h in axes[i + 1 :]]
    for f, h in sorted(pairs, key=lambda pair: unit_of[pair[0]] != unit_of[pair[1]]):
        first, second = units[unit_of[f]], units[unit_of[h]]
        what = first.label if first is second else f"{labels[f]} and {labels[h]}"
        yield Candidate(("cross", f, h), None, f"couple ⟂ {what}")
    for k in (2, 0, 1):
        yield Candidate(("limb", k), None, f"couple along limb {'xyz'[k]}")
    for f in axes:
        yield Candidate(("cross_limb", f, 2), None, f"couple ⟂ {labels[f]} and limb axis")
        yield Candidate(("axis", f), None, f"couple ∥ {labels[f]}")
    for centre in centres:
        for f, h in pairs:
            yield Candidate(("cross", f, h), centre, f"force ⟂ {labels[f]} and {labels[h]} at {where[centre]}")
        for f in axes:
            for k in range(3):
                yield Candidate(
                    ("cross_limb", f, k), centre, f"force ⟂ {labels[f]} and limb {'xyz'[k]} at {where[centre]}"
                )
        for k in range(3):
            yield Candidate(("limb", k), centre, f"force along limb {'xyz'[k]} at {where[centre]}")


def _attached_candidates(
    units: Sequence[Unit], unit_of: Index, passive: NDArray[np.bool_], rotates: NDArray[np.bool_], labels: list[str]
) -> Iterator[Candidate]:
    """Yield readable candidates of J_ig: forces through the platform joint's centre, then couples."""
    at = _platform_centre(units)
    where = units[at].label if at < len(units) else "its outer end"
    for k in range(3):
        yield Candidate(("limb", k), at, f"force along limb {'xyz'[k]} at {where}")
    for k in range(3):
        yield Candidate(("limb", k), None, f"couple along limb {'xyz'[k]}")
    axes = _readable_axes(units, unit_of, passive, rotates)
    for i, f in enumerate(axes):
        yield Candidate(("axis", f), at, f"force ∥ {labels[f]} at {where}")
        yield Candidate(("axis", f), None, f"couple ∥ {labels[f]}")
        for h in axes[i + 1 :]:
            yield Candidate(("cross", f, h), None, f"couple ⟂ {labels[f]} and {labels[h]}")
        for k in range(3):
            yield Candidate(("cross_limb", f, k), None, f"couple ⟂ {labels[f]} and limb {'xyz'[k]}")


def _platform_centre(units: Sequence[Unit]) -> int:
    """Return the unit through whose centre forces are preferred: the outermost joint that turns, if it is passive."""
    for k in range(len(units) - 1, -1, -1):
        if not units[k].passive:
            break
        if any(freedom.rotates for freedom in units[k].freedoms):
            return k
    return len(units)


def _readable_axes(
    units: Sequence[Unit], unit_of: Index, passive: NDArray[np.bool_], rotates: NDArray[np.bool_]
) -> list[int]:
    """Return the freedoms whose axes mean something: single joints before universal ones, platform side first."""
    free = [int(f) for f in np.flatnonzero(passive)[::-1] if units[unit_of[f]].kind not in ("spherical", "floating")]
    single = [f for f in free if units[unit_of[f]].kind != "universal"]
    return [f for f in single if rotates[f]] + [f for f in free if f not in single] + [f for f in single if not rotates[f]]


def _seeds(geometry: LimbGeometry, length: float) -> Array:
    """Return six wrenches (6, 6, g, N) along the limb axes, from which complementary wrenches are made."""
    axes = geometry.limb_axes
    zero = np.zeros_like(axes)
    return np.concatenate([np.concatenate([axes, zero]), np.concatenate([zero, axes * length])], axis=1)


def _complete(spanned: list[Array], seeds: Array, chosen: Sequence[int]) -> list[Array]:
    """Return unit vectors from the chosen seeds, orthogonal to all ``spanned`` (6, …) and to one another."""
    basis: list[Array] = []

    def residue(v: Array) -> Array:
        for _ in range(2):
            for unit in basis:
                v = v - unit * dot(unit, v)
        return v

    for column in spanned:
        basis.append(normalize(residue(normalize(column))))
    found = []
    for seed in chosen:
        unit = normalize(residue(normalize(residue(normalize(seeds[:, seed])))))
        basis.append(unit)
        found.append(unit)
    return found


def _rest(spanned: list[Array], seeds: Array, count: int, label: str) -> list[Candidate]:
    """Choose ``count`` seeds whose completion of ``spanned`` is best conditioned at all generic poses."""
    chosen: list[int] = []
    for number in range(count):
        best, best_size = -1, -1.0
        for seed in range(seeds.shape[1]):
            if seed in chosen:
                continue
            basis = _complete(spanned, seeds, chosen)
            unit = normalize(seeds[:, seed])
            known = np.stack([*(normalize(s) for s in spanned), *basis, unit])
            size = min(float(np.linalg.svd(known[:, :, p], compute_uv=False)[-1]) for p in range(known.shape[2]))
            if size > best_size:
                best, best_size = seed, size
        if best < 0:
            raise StaticsError(f"no complementary wrench number {number + 1} can be found")
        chosen.append(best)
    return [Candidate(("rest", seed), None, f"{label} {k}") for k, seed in enumerate(chosen, 1)]


def _rank(matrix: Array, tolerance: float) -> tuple[int, float]:
    """Return the rank of (6, k) scaled columns, and the gap between kept and dropped singular values."""
    if matrix.shape[1] == 0:
        return 0, np.inf
    values = np.linalg.svd(matrix, compute_uv=False)
    rank = int(np.sum(values > tolerance * max(values[0], 1e-300)))
    dropped = float(values[rank]) if rank < len(values) else 0.0
    return rank, float(values[rank - 1]) / dropped if rank and dropped > 0 else np.inf


def _independent(twists: Array, among: Index, tolerance: float) -> list[int]:
    """Return a maximal set of independent freedoms, decided at all generic poses."""
    chosen: list[int] = []
    for f in among:
        trial = [*chosen, int(f)]
        if all(_rank(twists[:, trial, p], 1e3 * tolerance)[0] == len(trial) for p in range(twists.shape[2])):
            chosen = trial
    return chosen


def make_limb_groups(robot: Robot, frames: Frames) -> tuple[LimbGroup, ...]:
    """Choose every limb's basis at generic ``frames`` and stack limbs that are built alike."""
    o = robot.solver.platform_pose(frames)[1]
    members: dict[tuple[object, ...], list[tuple[int, Basis]]] = {}
    for number in range(len(robot.topology.limbs)):
        single = LimbGroup(robot, [number])
        basis = single.choose_basis(frames, o)
        key = (
            single.signature,
            tuple((c.direction, c.centre) for c in (*basis.constraint, *basis.attached)),
            len(basis.constraint), basis.independent, basis.carried,
        )  # fmt: skip
        members.setdefault(key, []).append((number, basis))
    return tuple(LimbGroup(robot, *zip(*pairs, strict=True)) for pairs in members.values())

