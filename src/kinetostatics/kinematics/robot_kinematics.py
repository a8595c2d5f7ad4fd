"""The kinematics of a robot. *At zero* all joints are at zero, loops may be open; the *zero pose* is the closed pose nearby."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.elements.beam import BeamModel, beams_of
from kinetostatics.elements.link import ElasticLink
from kinetostatics.elements.static_model import make_elastic_links
from kinetostatics.elements.weights import Weights
from kinetostatics.exceptions import AssemblyError, KinetostaticsError
from kinetostatics.kinematics import mobility, zero_pose
from kinetostatics.kinematics.coordinates import Couplings, PrescribedCoordinates
from kinetostatics.kinematics.loop_constraints import LoopEquations, world_frames
from kinetostatics.kinematics.loop_gaps import CLOSED, are_within, gaps_at, worst_gaps_text
from kinetostatics.kinematics.mobility import Mobility, MobilityAnalysis
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.kinematics.zero_pose import box_diagonal, characteristic_length
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.math.linalg import cross, dot
from kinetostatics.mechanism.limbs import Topology
from kinetostatics.mechanism.mechanism import Mechanism
from kinetostatics.mechanism.tree import Frames, TreeJoint
from kinetostatics.unit_hints import largest, length_hint, turns_hint

#: Residual of a loop [m, rad] above which a pose is corrected once more, for a robot whose loops close exactly.
_ROUGH = 1e-13


class JointCoordinates:
    """The coordinates of all joints and loops with one freedom."""

    def __init__(self, solver: Solver) -> None:
        self.solver = solver
        self._couplings = Couplings(solver.mechanism, solver.mechanism.tree)
        joints = solver.mechanism.connections.values()
        cones = {joint.name: _widened(0.0, joint.cone.angle) for joint in joints if joint.cone is not None}
        self._limits = {joint.name: _widened(joint.lower, joint.upper) for joint in joints if joint.type.is_single} | cones

    @cached_property
    def in_tree(self) -> dict[str, TreeJoint]:
        by_body = {joint.body: joint for joint in self.solver.mechanism.tree.joints}
        return {name: by_body[body] for name, body in self.solver.mechanism.body_of_joint.items() if by_body[body].nv == 1}

    def at(self, q: Array, frames: Frames) -> dict[str, Array]:
        """Return the coordinate (N,) of every one-freedom joint and loop [m, rad].

        The angle of a continuous joint that others mimic includes full turns.
        """
        result = {name: self._couplings.coordinate(joint, q) for name, joint in self.in_tree.items()}
        for number, loop in enumerate(self.solver.equations.loops):
            if loop.type.is_single:
                result[loop.name] = self.solver.loop_coordinate(number, frames)
        return result

    def limited(self, q: Array, frames: Frames) -> Iterator[tuple[str, Array, tuple[float, float], Mask]]:
        """Yield name, value (N,), limits and (N,) True where the value is admissible.

        There is one entry for each one-freedom joint or loop, and one for each cone.
        """
        coordinates = self.at(q, frames)
        for connection in self.solver.mechanism.connections.values():
            if connection.cone is not None:
                u, v = (
                    frames.direction(body, frame[:3, :3] @ np.array(axis))
                    for body, frame, axis in (
                        (connection.predecessor_body, connection.predecessor_frame, connection.cone.predecessor_axis),
                        (connection.successor_body, connection.successor_frame, connection.cone.successor_axis),
                    )
                )
                across = cross(u, v)
                value, limits = np.arctan2(np.sqrt(dot(across, across)), dot(u, v)), (0.0, connection.cone.angle)
            elif connection.name in coordinates:
                value, limits = coordinates[connection.name], (connection.lower, connection.upper)
            else:
                continue
            least, most = self._limits[connection.name]
            yield connection.name, value, limits, (value >= least) & (value <= most)


def _widened(lower: float, upper: float) -> Array:
    """Return the limits (2,) [m, rad], each moved outwards by a margin for rounding."""
    slack = 1e-9 * max([1.0, *(abs(limit) for limit in (lower, upper) if math.isfinite(limit))])
    return np.array([lower - slack, upper + slack])


class RobotKinematics:
    """The kinematics of a robot, computed on first use.

    Attributes:
        mechanism: bodies and connections.
        topology: limbs, and the bodies attached to base and platform.
    """

    def __init__(self, mechanism: Mechanism, topology: Topology) -> None:
        self.mechanism: Mechanism = mechanism
        self.topology: Topology = topology
        self.description: RobotDescription = mechanism.description
        self.name: str = mechanism.description.name
        self.equations = LoopEquations(mechanism)

    @cached_property
    def _origins(self) -> dict[PrescribedCoordinates, tuple[Array, Array]]:
        return {}

    # ---- sizes ----------------------------------------------------------------------------------------------------------

    @cached_property
    def size(self) -> float:
        """Diagonal [m] of the box around the robot with all joints at zero."""
        return box_diagonal(self.mechanism)

    @cached_property
    def length(self) -> float:
        """Characteristic length [m]: mean distance of the limbs' outer joints from o, or a quarter of the robot's size."""
        return characteristic_length(self.mechanism, self.topology, self.size)

    def _solver(self, slack: float = 1e-7) -> Solver:
        """Return a solver that takes scaled residuals up to ``slack`` as rounding of the file."""
        return Solver(self.equations, self.length, max(self.length, self.size / 4), slack)

    # ---- the zero pose ----------------------------------------------------------------------------------------------------

    @cached_property
    def _closed_zero(self) -> tuple[SolverState, float]:
        """The zero pose and its scaled residual; if the loops cannot be closed, the pose with the smallest gaps found."""
        return zero_pose.closed_zero(self._solver(), self.actuator_coordinates)

    @cached_property
    def _unclosable(self) -> AssemblyError | None:
        """The error that no pose near zero closes the loops; None if a pose does."""
        best, residual = self._closed_zero
        if residual <= zero_pose.OPEN:
            return None
        gaps = gaps_at(self.equations, best)
        closest = worst_gaps_text(self.equations, gaps)
        return AssemblyError(zero_pose.wrong_zero_text(self.mechanism, self.zero_loop_gaps, self.size, closest), gaps)

    @cached_property
    def _zero(self) -> tuple[SolverState, float]:
        """The zero pose, and its scaled residual.

        Raises:
            AssemblyError: no pose near zero closes the loops.
        """
        if self._unclosable is not None:
            raise self._unclosable
        return self._closed_zero

    @cached_property
    def zero_poses(self) -> SolverState:
        """The zero pose, where the straight lines of coordinates to other poses start by default."""
        return self._zero[0]

    @cached_property
    def zero_frames(self) -> Frames:
        """Frames of the zero pose, a batch of one."""
        return self.frames_of(self.zero_poses)

    @cached_property
    def zero_size(self) -> float:
        """Diagonal of the box around all joints and links at the zero pose [m]; NaN if the loops cannot be closed."""
        try:
            points = self.zero_frames.position[:, :, 0]
        except KinetostaticsError:
            return math.nan
        points = points[:, np.all(np.isfinite(points), axis=0)]
        return float(np.linalg.norm(points.max(axis=1) - points.min(axis=1)))

    @cached_property
    def zero_loop_gaps(self) -> dict[str, tuple[float, float]]:
        """Gap of each loop and error of each mimic joint at zero, ``{name: (m, rad)}``."""
        return gaps_at(self.equations, zero_pose.written_zero(self.equations))

    @cached_property
    def actuators_outside_limbs(self) -> tuple[str, ...]:
        """Names of the actuated joints outside the limbs; these joints move only open branches."""
        in_limbs = {edge.joint for limb in self.topology.limbs for edge in limb.edges}
        return tuple(name for name in self.description.actuated if name not in in_limbs)

    @cached_property
    def zero_is_near(self) -> bool:
        """Whether the loops are closed at zero, except for rounding."""
        return are_within(self.zero_loop_gaps, zero_pose.ROUNDING * self.size, zero_pose.ROUNDING)

    @cached_property
    def has_wrong_zero(self) -> bool:
        """Whether the gaps at zero exceed rounding because the file is wrong.

        Either no pose nearby closes the loops to six digits, or none closes them exactly but the correction of one frame would.
        """
        if self.zero_is_near:
            return False
        if self._unclosable is not None or self.closing_error > zero_pose.SIX_DIGITS:
            return True
        return self.closing_error > CLOSED and zero_pose.is_one_frame(self.mechanism, self.zero_loop_gaps, self.size)

    @cached_property
    def wrong_zero(self) -> AssemblyError | None:
        """The error to be raised if :attr:`has_wrong_zero`, else None."""
        if self._unclosable is not None or not self.has_wrong_zero:
            return self._unclosable
        text = zero_pose.wrong_zero_text(self.mechanism, self.zero_loop_gaps, self.size)
        return AssemblyError(text, self.zero_loop_gaps, self.mobility.platform)

    def accepts(self, closure_tolerance: float) -> bool:
        """Whether a closure tolerance [m, rad] is admissible.

        If :attr:`has_wrong_zero`, the loops may almost close at another pose although the file is wrong. The tolerance must then
        be at least as large as the gaps at zero, and these gaps may not exceed ``zero_pose.ACCEPTED``.
        """
        if not self.has_wrong_zero:
            return True
        most = zero_pose.ACCEPTED
        return are_within(self.zero_loop_gaps, min(closure_tolerance, most * self.size), min(closure_tolerance, most))

    # ---- generic poses, mobility, solver ----------------------------------------------------------------------------------

    @cached_property
    def _generic(self) -> tuple[SolverState, float]:
        return mobility.generic_poses(self._solver(), *self._zero)

    @property
    def generic_poses(self) -> SolverState:
        """Three closed poses without symmetry near the zero pose, at which ranks and bases are decided."""
        return self._generic[0]

    @cached_property
    def generic_frames(self) -> Frames:
        """Frames of all bodies at the generic poses."""
        return self.frames_of(self.generic_poses)

    @property
    def closing_error(self) -> float:
        """Residual of the loops at the zero and generic poses [scaled m, rad], due to rounding in computation or file."""
        return self._generic[1]

    @cached_property
    def rough_residual(self) -> float:
        """Residual of a loop [m, rad] above which a pose is corrected once more."""
        return _ROUGH + 2 * self.length * self.closing_error

    @property
    def rank_tolerance(self) -> float:
        """Relative singular value below which a direction is taken as dependent, above the rounding errors of the file."""
        return mobility.rank_tolerance(self.closing_error)

    @cached_property
    def solver(self) -> Solver:
        """The solver that closes the loops at prescribed coordinates."""
        return self._solver(slack=1e-7 + 100 * self.closing_error)

    @cached_property
    def mobility_analysis(self) -> MobilityAnalysis:
        """Mobility of the closed loops, with or without prescribed coordinates."""
        return MobilityAnalysis(self.solver, self.generic_poses, self.rank_tolerance)

    @property
    def mobility(self) -> Mobility:
        """Mobility of the platform, local freedoms and redundant constraints."""
        return self.mobility_analysis.mobility

    # ---- coordinates ------------------------------------------------------------------------------------------------------

    @cached_property
    def actuator_names(self) -> list[str]:
        """Names of the actuated joints in the order of the solver: joints of the tree, then loops."""
        loops = [loop.name for loop in self.equations.loops]
        return sorted(self.description.actuated, key=lambda name: name in loops)

    @cached_property
    def actuator_coordinates(self) -> PrescribedCoordinates:
        """The positions of the actuated joints, as prescribed coordinates of the solver."""
        loops = [loop.name for loop in self.equations.loops]
        bodies = [self.mechanism.body_of_joint[name] for name in self.description.actuated if name not in loops]
        columns = tuple(self.equations.joint_of_body[body].first_v for body in bodies)
        return PrescribedCoordinates(columns, tuple(loops.index(name) for name in self.description.actuated if name in loops))

    def unit_hints(self, given: Mapping[str, ArrayLike]) -> list[str]:
        """Return hints at coordinates of actuators or platform whose sizes suggest millimetres or degrees instead of [m, rad]."""
        hints: list[str] = []
        for name, values in given.items():
            amount = largest(values)
            joint = self.mechanism.connections.get(name) if name in self.description.actuated else None
            if name not in ("x", "y", "z") if joint is None else not joint.type.is_slide:
                usual = joint is not None and (joint.type.endless or joint.lower <= amount <= joint.upper)
                hints += turns_hint(name, amount, usual)
            elif amount:
                hints += length_hint(f"{name} = {amount:.6g} m is", amount, self.zero_size)
        return hints

    def zero_origin(self, prescribed: PrescribedCoordinates) -> tuple[Array, Array]:
        """Return the coordinates at which straight lines from the zero pose start, see :meth:`Solver.origin`."""
        if prescribed not in self._origins:
            self._origins[prescribed] = self.solver.origin(prescribed, self.zero_poses)
        return self._origins[prescribed]

    def model_q(self, poses: SolverState) -> Array:
        """Return Pinocchio's coordinates (nq, N) of solved poses."""
        return self.equations.to_model(poses.x)

    def frames_at(self, q: Array) -> Frames:
        """Return the frames of all bodies at Pinocchio's coordinates (nq, N), in world axes."""
        return world_frames(self.mechanism, self.mechanism.forward(q))

    def frames_of(self, poses: SolverState) -> Frames:
        """Return the frames of all bodies at solved poses, in world axes."""
        return self.frames_at(self.model_q(poses))

    @cached_property
    def joint_coordinates(self) -> JointCoordinates:
        """Coordinates of all joints and loops with one freedom, and their limits."""
        return JointCoordinates(self.solver)

    # ---- beams and weights ------------------------------------------------------------------------------------------------

    @cached_property
    def beams(self) -> Mapping[str, BeamModel]:
        """All beams by name."""
        return beams_of(self.elastic_links)

    @cached_property
    def elastic_links(self) -> Mapping[str, ElasticLink]:
        """Beams and other elastic links, by name."""
        return ResultMapping(make_elastic_links(self.mechanism, self.topology.spans, self.zero_frames))

    @cached_property
    def weights(self) -> Weights:
        """Weights of all links and beams."""
        return Weights(self.mechanism, self.topology, self.elastic_links)
