"""Platform coordinates that determine the pose, local freedoms (which do not move the platform), and redundant actuators."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.math.arrays import Array
from kinetostatics.math.graphs import joined
from kinetostatics.math.linalg import canonical_basis, first_largest, null_space
from kinetostatics.math.rotations import orientation_named
from kinetostatics.math.screws import move_twist
from kinetostatics.robot import Robot

#: Magnitude below which components of unit motions and self-stresses are zero.
NOTHING = 1e-6
COORDINATES = ("x", "y", "z", "rx", "ry", "rz")
#: Order of preference of coordinates that determine the platform about equally well: z, x, y, rz, rx, ry.
_PREFERRED = (2, 0, 1, 5, 3, 4)
#: Relative difference of singular values within which sets of coordinates are equally good.
_CLEARLY = 0.5


@dataclass(frozen=True)
class LocalFreedom:
    """Freedoms of some links that do not move the platform.

    Attributes:
        links: moving links, except the massless crosses of universal and spherical joints.
        kind: ``spin`` about the line through their joints, ``turn`` about an axis, ``slide`` or ``move``.
        joint: joint along or about whose axis the links move, if any.
        actuators: actuated joints that move with the links.
    """

    links: tuple[str, ...]
    count: int
    kind: str
    joint: str | None
    actuators: tuple[str, ...]


class Motions:
    """The motions of a robot at the generic pose with the largest number of independent constraints.

    ``free`` (nv, k) are scaled velocities that keep the loops closed. The matrix ``platform`` (6, nv) maps them to the platform's
    scaled twist at o, the matrix ``actuators`` (n, nv) to the rates of the actuators.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot, solver = robot, robot.solver
        candidates = []
        for k in range(robot.generic_poses.x.shape[1]):
            pose = robot.generic_poses.take(np.array([k]))
            _, gradient = solver.system(PrescribedCoordinates(), pose, np.zeros((0, 1)))
            free, rank, _ = null_space(gradient[:, :, 0], robot.rank_tolerance)
            candidates.append((rank, pose, free))
        _, self.pose, self.free = max(candidates, key=lambda candidate: candidate[0])  # of equal ranks the first
        self.frames = robot.equations.forward(self.pose.x)
        self.twists = robot.equations.tree.twists(self.frames)[:, :, 0] * solver.column_scale
        self.o = solver.mechanism.platform_pose(self.frames)[1][:, 0]
        self.platform = self.at_o(solver.platform_signs)

    def at_o(self, signs: Array) -> Array:
        """Return the scaled map (6, nv) from velocities to the twist at o of a body relative to the base.

        ``signs`` (nv,): 1 for freedoms that move only the body, −1 for freedoms that move only the base, else 0.
        """
        return move_twist(self.twists * signs, self.o[:, None]) / np.repeat([self.robot.length, 1.0], 3)[:, None]

    @property
    def actuators(self) -> Array:
        """(n, nv) map from scaled velocities to rates of the actuated joints: joints of the tree, then loops."""
        prescribed = self.robot.actuator_coordinates
        rows = np.eye(self.twists.shape[1])[np.array(prescribed.columns, dtype=np.intp)]
        loops = PrescribedCoordinates(loops=prescribed.loops)
        _, gradient = self.robot.solver.system(loops, self.pose, np.zeros((loops.size, 1)))
        return np.concatenate([rows, gradient[gradient.shape[0] - loops.size :, :, 0]])

    @property
    def actuator_names(self) -> list[str]:
        """Names of the rows of ``actuators``."""
        loops = {loop.name for loop in self.robot.equations.loops}
        return sorted(self.robot.description.actuated, key=lambda name: name in loops)

    def rank(self, matrix: Array) -> int:
        if not matrix.size:
            return 0
        return int(np.sum(np.linalg.svd(matrix, compute_uv=False) > self.robot.rank_tolerance))

    def local(self) -> Array:
        """Return a basis (nv, l) of the scaled velocities that do not move the platform."""
        if not self.free.shape[1]:
            return self.free
        _, values, rows = np.linalg.svd(self.platform @ self.free, full_matrices=True)
        return canonical_basis(self.free @ rows[int(np.sum(values > self.robot.rank_tolerance)) :].T)


def actuators_of(motions: Motions) -> tuple[int, int]:
    """Return the number of redundant actuators, and the number of the platform's freedoms with locked actuators."""
    D = motions.actuators
    moved = D @ motions.free
    held = motions.rank(moved)
    left = motions.free
    if left.shape[1] and moved.size:
        left = left @ np.linalg.svd(moved, full_matrices=True)[2][held:].T
    return len(D) - held, motions.rank(motions.platform @ left) if left.shape[1] else 0


def coordinates_of(motions: Motions) -> tuple[str, ...]:
    """Return coordinates that determine the platform's pose, as many as its mobility; empty if there are none.

    Coordinates of o are preferred, then sets with one angle for each rotational freedom. Among these, the best conditioned set
    is chosen; among nearly equal sets, the first in the order z, x, y, rz, rx, ry.
    """
    robot = motions.robot
    count = robot.mobility.platform
    moved = motions.platform @ motions.free
    turning = motions.rank(moved[3:])
    options: dict[tuple[int, ...], tuple[int, float]] = {}
    for chosen in combinations(_PREFERRED, count) if count else ():
        size = float(np.linalg.svd(moved[list(chosen)], compute_uv=False)[count - 1])
        turns = sum(k > 2 for k in chosen)
        natural = 2 if size < 0.1 else 0 if not turns else 1 if turns == turning else 2
        if size > 1e-3:
            options[chosen] = natural, size
    while options:
        usual = min(natural for natural, _ in options.values())
        alike = [(chosen, size) for chosen, (natural, size) in options.items() if natural == usual]
        best, _ = alike[first_largest([size for _, size in alike], _CLEARLY)]
        del options[best]
        chosen = tuple(sorted(best))
        positions = tuple(k for k in chosen if k < 3)
        angles = tuple(k - 3 for k in chosen if k > 2)
        prescribed = PrescribedCoordinates(positions=positions, angles=angles, orientation=orientation_named(None))
        if robot.mobility_analysis.fixes_platform(prescribed):
            return tuple(COORDINATES[k] for k in chosen)
    return ()


# ---- local freedoms --------------------------------------------------------------------------------------------------


def local_freedoms(motions: Motions) -> list[LocalFreedom]:
    """Return the freedoms that do not move the platform; independent freedoms are separate entries."""
    local = motions.local()
    if not local.shape[1]:
        return []
    robot = motions.robot
    tree, mechanism = robot.equations.tree, robot.mechanism
    base = mechanism.base_frame
    at_rest = tree.moves[base[0]].astype(float) if base is not None else 0.0
    bodies = list(range(tree.moves.shape[0]))
    table = np.stack([motions.at_o(tree.moves[body].astype(float) - at_rest) @ local for body in bodies])
    columns = eliminated(table.reshape(-1, local.shape[1]))
    table = (table.reshape(-1, local.shape[1]) @ columns).reshape(table.shape)
    moving = np.max(np.abs(table), axis=1) > NOTHING  # bodies, columns
    rates = np.abs(motions.actuators @ local @ columns) > NOTHING
    freedoms = []
    for group in groups_of(moving.T):
        moved = [body for body in bodies if np.any(moving[body, group])]
        links = _links_of(robot, moved)
        actuators = tuple(name for name, row in zip(motions.actuator_names, rates, strict=True) if np.any(row[group]))
        kind, joint = _kind(motions, links, moved, table[:, :, group])
        freedoms.append(LocalFreedom(links, len(group), kind, joint, actuators))
    order = {link: k for k, link in enumerate(robot.description.links)}
    return sorted(freedoms, key=lambda freedom: order.get(freedom.links[0], 0) if freedom.links else 0)


def _links_of(robot: Robot, bodies: list[int]) -> tuple[str, ...]:
    """Return the links of some bodies; massless links (crosses of universal joints) only if all are massless."""
    description = robot.description
    elastic = {link.link for link in description.elastic_links.values()}
    links = [link for link in description.links if robot.mechanism.body_of[link][0] in bodies]
    heavy = tuple(link for link in links if link in elastic or description.links[link].mass > 0)
    return heavy or tuple(links)


def _kind(motions: Motions, links: tuple[str, ...], moving: list[int], table: Array) -> tuple[str, str | None]:
    """Return ``kind`` and ``joint`` of a :class:`LocalFreedom` of some links.

    ``moving``: all moving bodies, including massless ones; ``table``: (bodies, 6, columns) scaled twists of all bodies.
    """
    robot = motions.robot
    body = robot.mechanism.body_of[links[0]][0]
    alike = [other for other in moving if float(np.max(np.abs(table[other] - table[body]))) < NOTHING]
    if table.shape[2] != 1 or any(robot.mechanism.body_of[link][0] not in alike for link in links):
        return "move", None
    linear, angular = table[body, :3, 0] * robot.length, table[body, 3:, 0]
    rate = float(np.linalg.norm(angular))
    if rate * robot.length < 1e-6 * float(np.linalg.norm(linear)):
        return "slide", _joint_along(motions, links, linear / np.linalg.norm(linear), None)
    axis = angular / rate
    if abs(float(axis @ linear)) > 1e-6 * robot.length * rate:
        return "move", None
    foot = motions.o + np.cross(angular, linear) / rate**2
    hinge = _joint_along(motions, links, axis, foot)
    if hinge is not None:
        return "turn", hinge
    along = []
    for link, (body, _) in robot.mechanism.body_of.items():
        for connection in robot.mechanism.at_link[link] if body in alike else ():
            point = motions.frames.point(body, connection.centre_on(link))[:, 0]
            if float(np.linalg.norm(np.cross(point - foot, axis))) < 1e-6 * robot.length:
                along.append(float(axis @ (point - foot)))
    return "spin" if along and max(along) - min(along) > 1e-6 * robot.length else "turn", None


def _joint_along(motions: Motions, links: tuple[str, ...], axis: Array, foot: Array | None) -> str | None:
    """Return the joint of the links along ``axis`` (3,): prismatic if ``foot`` is None, else revolute and through ``foot`` (3,).

    None if there is none. Revolutes inside universal or spherical joints are excluded.
    """
    robot = motions.robot
    compounds = [compound for group in robot.statics.groups for row in group.compounds for compound in row]
    inside = {name for compound in compounds if len(compound.joints) > 1 for name in compound.joints}
    for connection in robot.mechanism.connections.values():
        if not {connection.predecessor, connection.successor} & set(links) or connection.name in inside:
            continue
        if not (connection.type.is_slide if foot is None else connection.type.is_hinge):
            continue
        direction = motions.frames.direction(connection.predecessor_body, connection.axis_on(True))[:, 0]
        point = motions.frames.point(connection.predecessor_body, connection.predecessor_frame[:3, 3])[:, 0]
        beside = 0.0 if foot is None else float(np.linalg.norm(np.cross(point - foot, axis)))
        if float(np.linalg.norm(np.cross(direction, axis))) < 1e-6 and beside < 1e-6 * robot.length:
            return connection.name
    return None


def eliminated(matrix: Array) -> Array:
    """Return coefficients (n, r) of r combinations of a matrix's columns (m, n) that form a basis of its column space.

    The matrix has entries of unit magnitude. The method is Gauss-Jordan elimination: if the column space is a direct sum of
    spaces without common rows, each combination is in one of them.
    """
    work, columns = np.array(matrix), np.eye(matrix.shape[1])
    pivots: list[int] = []
    for _ in range(matrix.shape[1]):
        free = [k for k in range(matrix.shape[1]) if k not in pivots]
        if not work.shape[0]:
            break
        row, position = np.unravel_index(first_largest(np.abs(work[:, free]).ravel()), (work.shape[0], len(free)))
        column = free[int(position)]
        if abs(work[row, column]) <= NOTHING:
            break
        factors = work[row] / work[row, column]
        factors[column] = 1 - 1 / work[row, column]  # which makes the pivot 1
        for table in (columns, work):
            table -= np.outer(table[:, column], factors)
        pivots.append(column)
    return columns[:, sorted(pivots)]


def groups_of(loaded: NDArray[np.bool_]) -> list[list[int]]:
    """Return groups of rows of a table; two rows with a common True column are in one group."""
    rows = range(len(loaded))
    groups = joined(rows, ((k, h) for k, h in combinations(rows, 2) if np.any(loaded[k] & loaded[h])))
    return [list(group) for group in sorted({tuple(sorted(group)) for group in groups.values()})]
