"""Springs between points of two links: their forces at the pose, and how these follow the elastic displacements.

A spring of length l, tension F = F_0 + k (l − l_0) and direction n pulls its ends together by F n. When these move by u relative
to each other, to first order the force changes by K_t u with K_t = k n nᵀ + (F/l) (1 − n nᵀ): it gets longer, and it turns. The
second part is no correction but of the size of the first where the free length is zero: then K_t = k 1 (the method page).

The forces act like loads on links. What their changes do is found from unit changes: with the displacements u_0 of the springs'
ends without changes, and G u per unit change, t = K_t (u_0 + G t).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from kinetostatics.description.elements import Spring
from kinetostatics.exceptions import StaticsError
from kinetostatics.limbs.group import LimbGroup
from kinetostatics.math.arrays import Array, Mask, zeros_for
from kinetostatics.math.linalg import cross, solve_by_elimination
from kinetostatics.math.screws import move_twist
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.assembly_errors import AssemblyErrors
from kinetostatics.statics.deformation import Deformation, deform
from kinetostatics.statics.link_loads import AppliedLoad, places_at
from kinetostatics.statics.model import RobotStatics
from kinetostatics.statics.solution import Solution, redistributed, solve

#: Part of the robot's size below which a spring has no length and its force no direction.
_NOTHING = 1e-9


@dataclass(frozen=True)
class PlacedSpring:
    """A spring at N poses.

    Attributes:
        name: of the spring.
        points: (3, N) its two ends [m].
        places: at which place each of them is, and where (N,).
        length: (N,) [m].
        tension: (N,) [N].
        force: (3, N) its pull on the first end, towards the second [N].
        tangent: (3, 3, N) K_t [N/m].
    """

    name: str
    points: tuple[Array, Array]
    places: tuple[dict[str, Mask], dict[str, Mask]]
    length: Array
    tension: Array
    force: Array
    tangent: Array

    def pull(self, force: Array, o: Array) -> tuple[dict[str, Array], dict[str, Array]]:
        """Return a force (3, N) on the first end and its opposite on the second: wrenches about o, and points, by place."""
        wrenches: dict[str, Array] = {}
        points: dict[str, Array] = {}
        for sign, point, places in zip((1, -1), self.points, self.places, strict=True):
            wrench = sign * np.concatenate([force, cross(point - o, force)])
            for place, where in places.items():
                wrenches[place] = wrenches.get(place, 0.0) + np.where(where, wrench, 0.0)
                points.setdefault(place, point)
        return wrenches, points


def placed_springs(robot: RobotStatics, frames: Frames) -> list[PlacedSpring]:
    """Return all springs at given frames.

    Raises:
        StaticsError: one has no length, so that its force has no direction.
        ArgumentError: an end is on an elastic link, but not at the end of its beam.
    """
    return [_placed(robot, spring, frames) for spring in robot.description.springs.values()]


def _placed(robot: RobotStatics, spring: Spring, frames: Frames) -> PlacedSpring:
    points, places = [], []
    what = f"spring {spring.name!r}" if spring.place.line is None else f"{spring.place}: spring {spring.name!r}"
    for link, local in ((spring.predecessor, spring.predecessor_point), (spring.successor, spring.successor_point)):
        body, placement = robot.mechanism.body_of[link]
        points.append(frames.point(body, placement[:3, :3] @ np.array(local) + placement[:3, 3]))
        places.append(places_at(robot, what, link, frames, points[-1]))
    span = points[1] - points[0]
    length = np.sqrt(np.sum(span**2, axis=0))
    tension = spring.preload + spring.stiffness * (length - spring.free_length)
    short = length <= _NOTHING * robot.length
    if spring.free_length == spring.preload == 0:
        ratio, n = np.full_like(length, spring.stiffness), np.zeros_like(span)
    elif np.any(short):
        raise StaticsError(f"the spring {spring.name!r} has no length at this pose: its force has no direction")
    else:
        ratio, n = tension / length, span / length
    tangent = ratio * np.eye(3)[:, :, None] + (spring.stiffness - ratio) * n[:, None] * n[None]
    return PlacedSpring(spring.name, (points[0], points[1]), (places[0], places[1]), length, tension, ratio * span, tangent)


def loads_of_springs(robot: RobotStatics) -> list[tuple[str, str]]:
    """Return names and kinds of the loads that are the springs' forces and, behind them, unit changes of these."""
    names = robot.description.springs
    changes = [(f"change {axis} of spring {name}", "change") for name in names for axis in "xyz"]
    return [*((f"spring {name}", "spring") for name in names), *changes]


def sources_of(robot: RobotStatics, applied: Iterable[AppliedLoad] = ()) -> tuple[str, ...]:
    """Return the names of the contributions to a robot's twist: those that are there whatever acts on its links, and these."""
    own = ("load", "platform_weight", *(limb.name for limb in robot.topology.limbs))
    return (*own, *(item.name for item in applied), *(f"spring {name}" for name in robot.description.springs))


def solve_with_springs(
    robot: RobotStatics,
    frames: Frames,
    load: Array,
    gravity: Array,
    assembly_errors: AssemblyErrors | None = None,
    groups: tuple[LimbGroup, ...] | None = None,
    applied: tuple[AppliedLoad, ...] = (),
    weights: Array | None = None,
) -> Solution:
    """Solve Eq. (12) as :func:`kinetostatics.statics.solution.solve`, with the robot's springs."""
    if not robot.description.springs:
        return solve(robot, frames, load, gravity, assembly_errors, groups, applied, weights)
    springs, (_, o) = placed_springs(robot, frames), robot.mechanism.platform_pose(frames)
    pulls = [item.pull(item.force, o) for item in springs]
    pulls += [item.pull(np.broadcast_to(unit[:, None], o.shape), o) for item in springs for unit in np.eye(3)]
    loads = [AppliedLoad(name, *pull, kind) for (name, kind), pull in zip(loads_of_springs(robot), pulls, strict=True)]
    found = solve(robot, frames, load, gravity, assembly_errors, groups, (*applied, *loads), weights)
    first = found.sources.index(loads[len(springs)].name)
    changes = slice(first, first + 3 * len(springs))
    moved = _relative_motions(robot, found, deform(robot, found), springs)
    t, inverse = _changes(springs, moved, changes)
    # reciprocity: what a unit change moves the platform is what a unit load of the platform moves the spring's ends, reversed
    platform = found.twists[:, changes]
    compliance = found.compliance - np.einsum("ian,ajn->ijn", platform, np.einsum("abn,jbn->ajn", inverse, platform))
    mixed = redistributed(robot, found, changes, t)
    return replace(mixed, compliance=compliance, stiffness=_inverse(compliance, found.stiffness, robot.length))


def _relative_motions(
    robot: RobotStatics, solution: Solution, deformation: Deformation, springs: Iterable[PlacedSpring]
) -> Array:
    """Return how every spring's second end moves relative to its first (3 springs, S, N), for each contribution.

    What hangs on the base alone sags by its own weight, which is no contribution: that counts with the spring's own force.
    """
    rows, none = [], np.zeros_like(solution.twists[:, :1])
    for spring in springs:
        ends = []
        for point, places in zip(spring.points, spring.places, strict=True):
            twist = np.concatenate([np.zeros_like(solution.twists), none], axis=1)
            for place, where in places.items():
                motion = _motion(robot, solution, deformation, place)
                motion = motion if motion.shape[1] == twist.shape[1] else np.concatenate([motion, none], axis=1)
                twist = np.where(where, motion, twist)
            ends.append(move_twist(twist, (point - solution.o)[:, None])[:3])
        moved = ends[1] - ends[0]
        moved[:, solution.sources.index(f"spring {spring.name}")] += moved[:, -1]
        rows.append(moved[:, :-1])
    return np.concatenate(rows)


def _motion(robot: RobotStatics, solution: Solution, deformation: Deformation, place: str) -> Array:
    """Return the twists (6, S, N) of a place, about o; with a column more where it hangs on the base, by its own weight."""
    topology = robot.topology
    if place in topology.carried_by:
        return deformation.motions[topology.carried_by[place]]
    return solution.twists if place in topology.platform.places else np.zeros_like(solution.twists)


def _changes(springs: list[PlacedSpring], moved: Array, changes: slice) -> tuple[Array, Array]:
    """Return how springs' forces change for each contribution (3 springs, S, N), and (K_t⁻¹ − G)⁻¹ (3 springs, 3 springs, N)."""
    n, _, N = moved.shape
    tangent = zeros_for((n, n, N), moved)
    for k, spring in enumerate(springs):
        tangent[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = spring.tangent
    matrix = np.eye(n)[:, :, None] - np.einsum("abn,bcn->acn", tangent, moved[:, changes])
    fine = np.all(np.isfinite(matrix), axis=(0, 1)) & np.all(np.isfinite(moved), axis=(0, 1))
    matrix = np.where(fine, matrix, np.eye(n)[:, :, None])
    inverse = solve_by_elimination(matrix, np.where(fine, tangent, 0.0))
    return np.einsum("abn,bsn->asn", inverse, np.where(fine, moved, 0.0)), inverse


def _inverse(compliance: Array, rigid: Array, length: float) -> Array:
    """Return the stiffness (6, 6, N) of a compliance; NaN where there is none, or that without springs (6, 6, N) is."""
    unit = np.repeat([1.0, length], 3)
    scale = (unit[:, None] * unit)[:, :, None]
    scaled = compliance * scale
    fine = np.all(np.isfinite(scaled), axis=(0, 1)) & np.all(np.isfinite(rigid), axis=(0, 1))
    eye = np.eye(6)[:, :, None]
    found = solve_by_elimination(np.where(fine, scaled, eye), np.broadcast_to(eye, scaled.shape))
    return np.where(fine, (found + np.swapaxes(found, 0, 1)) / 2 * scale, np.nan)
