"""Records of closed poses: the scalar operations that compute joint coordinates, frames, equilibrium and other outputs. A record
is valid at poses that meet its guards, the conditions of its branches.

Machine code, exported C, derivatives and random samples of robots are computed from these records. Residuals are defined by
:meth:`Solver.system`; they depend on the coordinates x of the solver's tree, the platform's orientation coordinates c and the
prescribed coordinates.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from kinetostatics.buckling.estimate import estimate
from kinetostatics.engine.recorder import Structure, recorded_input, recording
from kinetostatics.engine.scalars import NotRecordedError, Number, Tape
from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.kinematics.loop_constraints import Placed
from kinetostatics.kinematics.robot_kinematics import JointCoordinates
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.math.arrays import Array, Mask, zeros_for
from kinetostatics.math.screws import move
from kinetostatics.mechanism.tree import Frames
from kinetostatics.quantities import OF_EQUILIBRIUM, QUANTITIES
from kinetostatics.statics.link_loads import AppliedLoad
from kinetostatics.statics.loaded_poses import LoadedAttachments, LoadedPoses
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.small_motions import SmallMotions
from kinetostatics.statics.solution import Solution
from kinetostatics.statics.springs import solve_with_springs

#: Load [N, N·m] and gravity [m/s²] of the example; they have no zeros, so that no term vanishes.
_EXAMPLE_LOAD = (31.0, -17.0, -53.0, 7.0, 11.0, -3.0)
_EXAMPLE_GRAVITY = (0.7, -1.3, -9.1)


class PoseModel(NamedTuple):
    """Data of a robot from which its poses are computed.

    Attributes:
        joints: the joint coordinates, with the solver of the loops.
        statics: the equilibrium.
        prescribed: prescribed coordinates, if residuals are requested.
        attachments: places of loads on links.
        members: model of small motions, if the stability is requested.
    """

    joints: JointCoordinates
    statics: RobotStatics
    prescribed: PrescribedCoordinates | None = None
    attachments: LoadedAttachments | None = None
    members: SmallMotions | None = None

    @classmethod
    def of(cls, solver: Solver, statics: RobotStatics, prescribed: PrescribedCoordinates | None = None) -> PoseModel:
        return cls(JointCoordinates(solver), statics, prescribed)

    def structure(self, tape: Tape | None = None, all_vary: bool = False) -> Structure:
        return Structure(self, tape, all_vary=all_vary)


class Pose:
    """Closed poses of a model, with quantities computed on first use.

    Args:
        x: (nq', N) solved coordinates.
        load, gravity: (6, N) [N, N·m] and (3, N) [m/s²].
        given: for residuals, orientation coordinates (3, N) and prescribed coordinates (n, N); with loads on links, wrenches
            (6 P, N) at their P places.
    """

    def __init__(self, model: PoseModel, x: Array, load: Array, gravity: Array, *given: Array) -> None:
        self.model, self.x, self.load, self.gravity, self.given = model, x, load, gravity, given
        self.solver, self.statics = model.joints.solver, model.statics

    @cached_property
    def placed(self) -> Placed:
        return self.solver.equations.place(self.x)

    @cached_property
    def frames(self) -> Frames:
        """Frames of all bodies.

        A spherical joint is modelled by three hinges, whose angles may be singular. Only the frames of the bodies between the
        hinges are computed from these angles.
        """
        frames = self.solver.equations.forward(self.x)
        inside = [joint.body for *_, joints in self.solver.equations.runs for joint in joints[:2]]
        if inside:
            other = self.placed.frames
            frames.rotation[:, :, inside], frames.position[:, inside] = other.rotation[:, :, inside], other.position[:, inside]
        return frames

    @cached_property
    def solution(self) -> Solution:
        applied: tuple[AppliedLoad, ...] = ()
        if self.model.attachments is not None:
            rows = iter(self.given[0].reshape(-1, 6, self.x.shape[1]))
            loads = self.model.attachments.loads
            applied = tuple(AppliedLoad(name, {attachment: next(rows) for attachment in where}) for name, where in loads)
        return self.under(applied)

    def under(self, applied: tuple[AppliedLoad, ...]) -> Solution:
        """Return the equilibrium under load, weights and loads on links."""
        _, o = self.statics.mechanism.platform_pose(self.frames)
        weights = self.statics.weights.wrenches_of_many(self.frames, o, self.gravity)
        return solve_with_springs(
            self.statics, LoadedPoses(self.frames, self.load, self.gravity, applied=applied, weights=weights)
        )

    @cached_property
    def system(self) -> tuple[Array, Array]:
        """Scaled residuals (m, N) and their gradients (m, n, N), see :meth:`Solver.system`."""
        c, target = self.given
        assert self.model.prescribed is not None
        return self.solver.system(self.model.prescribed, SolverState(self.x, c), target)

    @cached_property
    def closures(self) -> Array:
        """Residuals of the loops (closures, N) [m, rad]."""
        return self.solver.equations.evaluate(self.frames)[0]

    def opening(self) -> Array:
        """Return the largest gap (N,) of all loops and mimic joints [m, rad]."""
        worst = zeros_for((self.x.shape[1],), self.x)
        for metres, radians in self.solver.equations.loop_gaps(self.closures, self.x).values():
            worst = np.maximum(worst, np.maximum(metres, radians))
        return worst

    def actuators(self) -> Array:
        """Return the coordinates (n, N) of the actuators, in the order of the file."""
        coordinates = self.model.joints.at(self.placed.q, self.frames)
        rows = [coordinates[name] for name in self.statics.description.actuated]
        return np.stack(rows) if rows else zeros_for((0, self.x.shape[1]), self.x)

    def within(self) -> Mask:
        """True where all joints are within their limits (N,)."""
        within: Mask = np.ones(self.x.shape[1], dtype=bool)
        for *_, inside in self.model.joints.limited(self.placed.q, self.frames):
            within = within & inside
        return within

    def is_stable(self) -> Mask:
        """True where a sufficient condition excludes buckling (N,)."""
        assert self.model.members is not None
        stable: Mask = estimate(self.model.members, self.solution) < 1.0
        return stable

    def platform(self) -> Array:
        """Return the platform's rotation matrix, row by row, and position (12, N)."""
        R, o = self.solver.mechanism.platform_pose(self.frames)
        return np.concatenate([R.reshape(9, -1), o])


#: Outputs of a pose besides :data:`OF_EQUILIBRIUM`, each (*components, N).
OUTPUTS: Mapping[str, Callable[[Pose], Array | Mask]] = {
    "residual": lambda pose: pose.system[0],
    "gradient": lambda pose: pose.system[1],
    "worst_equation": lambda pose: np.max(np.abs(pose.closures), axis=0, initial=0.0),
    "opening": Pose.opening,
    "within": Pose.within,
    "actuators": Pose.actuators,
    "platform": Pose.platform,
    "is_stable": Pose.is_stable,
    "mass": lambda pose: pose.statics.weights.masses(pose.frames).sum(axis=0),
}


def outputs_at(pose: Pose, names: Sequence[str], tool: Array | None = None) -> dict[str, Number]:
    """Return outputs (…, N) by name.

    Twist, stiffness and compliance have the reference point ``tool`` (3,), from o in platform axes [m]; default o.
    """
    outputs: dict[str, Number] = {}
    for name in names:
        if name in OUTPUTS:
            outputs[name] = OUTPUTS[name](pose)
            continue
        outputs[name] = OF_EQUILIBRIUM[name](pose.statics, pose.solution)
        kind = QUANTITIES[name].moves_as if name in QUANTITIES else None
        if tool is not None and kind is not None and not _is_unknown(outputs[name]):
            R, _ = pose.solver.mechanism.platform_pose(pose.frames)
            axis = QUANTITIES[name].dims.index("component")
            outputs[name] = np.moveaxis(move(kind, np.moveaxis(outputs[name], axis, 0), np.einsum("ijn,j->in", R, tool)), 0, axis)
    return outputs


def _is_unknown(array: Array) -> bool:
    """Whether all entries are NaN at every pose, as for an infinite stiffness; NaN must not enter derivatives."""
    return all(isinstance(entry, float) and math.isnan(entry) for entry in np.asarray(array).ravel().tolist())


@dataclass(frozen=True)
class PoseRecord:
    """Recorded operations of some outputs of a robot.

    Attributes:
        tape: the operations; inputs are x, load, gravity and, if residuals are requested, c and the prescribed coordinates.
        rows: indices of the operations that compute the components of each output, in order.
        shapes: shape of each output.
        holds: for each output, the operation that computes whether the guards recorded up to this output are met.
    """

    tape: Tape
    rows: Mapping[str, tuple[int, ...]]
    shapes: Mapping[str, tuple[int, ...]]
    holds: Mapping[str, int]

    def all_rows(self, names: Sequence[str] | None = None) -> list[int]:
        """Return the ``rows`` of some outputs, by default of all, in one list."""
        return [row for name in (self.rows if names is None else names) for row in self.rows[name]]

    def all_hold(self) -> int:
        """Return the operation that computes whether all guards are met."""
        return list(self.holds.values())[-1]


def pose_record(
    model: PoseModel, names: Sequence[str], example: Sequence[Array], all_vary: bool = False, tool: Array | None = None
) -> PoseRecord:
    """Record some outputs.

    Args:
        example: inputs at one pose, see :class:`PoseRecord`; where the code branches, the branch at this pose is recorded.
        all_vary: whether to record 0, 1 and −1 as parameters too, see :class:`Structure`.
        tool: see :func:`outputs_at`.

    Raises:
        NotRecordedError: a function is not a sequence of operations on scalars.
    """
    tape = Tape()
    copy = model.structure(tape, all_vary).copy
    pose = Pose(copy, *(recorded_input(tape, number, array) for number, array in enumerate(example)))
    rows, shapes, holds = {}, {}, {}
    for name in names:
        with _recording_equilibrium(model.statics) if name in OF_EQUILIBRIUM else recording():
            array = outputs_at(pose, [name], tool)[name]
        rows[name] = tuple(tape.number_of(entry) for entry in np.asarray(array[..., 0], dtype=object).ravel().tolist())
        shapes[name] = tuple(array.shape[:-1])
        holds[name] = tape.number_of(tape.holds())
    return PoseRecord(tape, rows, shapes, holds)


@contextmanager
def _recording_equilibrium(robot: RobotStatics) -> Iterator[None]:
    """Context manager like :func:`recording`, whose error says what prevents the recording of the robot's equilibrium."""
    try:
        with recording():
            yield
    except NotRecordedError as error:
        solution = solve_with_springs(robot, LoadedPoses(*example_of(robot)))
        reason = str(error)
        if solution.singular[0]:
            reason = "the platform is singular at generic poses, which needs singular values"
        elif solution.indeterminate[0]:
            reason = "rigid limbs or rings overconstrain one another, so that their internal forces need singular values"
        elif isinstance(error.__cause__, IndexError):  # a recorded mask selects some of the poses
            reason = "a limb needs eigenvectors even at generic poses, for instance because its self-stress is almost rigid"
        raise NotRecordedError(reason) from error


def example_of(robot: RobotStatics, attachments: LoadedAttachments | None = None) -> tuple[Number, ...]:
    """Return inputs: frames of one generic pose, load (6, 1), gravity (3, 1), and wrenches at ``attachments`` (6 P, 1)."""
    plain = robot.example, np.array([_EXAMPLE_LOAD]).T, np.array([_EXAMPLE_GRAVITY]).T
    if attachments is None:
        return plain
    count = 6 * sum(len(where) for _, where in attachments.loads)
    return *plain, (np.resize(_EXAMPLE_LOAD, count) * (1 + 0.1 * np.arange(count)))[:, None]
