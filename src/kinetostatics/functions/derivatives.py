"""Derivatives of what is asked of poses, through the closing of the loops by the implicit function theorem.

A result depends on the frames of all bodies, on load and gravity, and on the robot's numbers; the record of the statics has its
derivatives. The frames depend on the joints, and these on what is given, so that the loops stay closed: G dv = −dr, with the
gradients G that Newton's method has.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kinetostatics.description.robot import RobotDescription
from kinetostatics.engine.derivatives import gradients, values
from kinetostatics.engine.llvm import needed_by
from kinetostatics.engine.outputs import OutputRecord, output_record, structure_of
from kinetostatics.engine.scalars import NotRecordedError
from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.coordinate_choices import prescribed_platform
from kinetostatics.kinematics.joint_coordinates import actuator_names
from kinetostatics.kinematics.prescribed import PrescribedCoordinates
from kinetostatics.kinematics.velocities import actuator_rates, body_moves, frame_rates, freedom_rates, with_given
from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.math.linalg import cross
from kinetostatics.mechanism.tree import Frames
from kinetostatics.parametric.numbers import Number
from kinetostatics.parametric.rates import CENTRAL, Rates, bodies_inside, rates_of
from kinetostatics.parametric.robot import alike
from kinetostatics.results.result import Result
from kinetostatics.robot import Robot, robot_of
from kinetostatics.statics.model import RobotStatics, statics_on

#: What is differentiated of analyses, and arguments of an analysis with which there are derivatives.
OUTPUTS = ("twist", "stiffness", "compliance", "actuator_forces", "actuators", "mass")
PLAIN = {"load", "gravity", "engine", "on_failure"}
#: Relative singular value of the loops' gradient below which a motion is free.
_FREE = 1e-9
#: Part of the robot's length by which bodies are moved to difference masses, and a rate of motion that counts as none [m].
_SHIFT, _TINY = 1e-3, 1e-300
#: Part of a parameter's step by which the robot is changed to see whether a record holds beside it: so little that loops stay
#: closed but for rounding as bodies move to first order.
_NEAR = 1e-6


@dataclass(frozen=True)
class Gradients:
    """Derivatives (m, …, N) of m numbers of the statics, of each by everything else with that held.

    Attributes:
        rotation, position: (m, 3, 3, B, N), (m, 3, B, N) by the frames of all bodies.
        load, gravity: (m, 6, N), (m, 3, N).
        constants: (m, P, N) by the robot's numbers.
        places, shapes: of each output, which of the m are its components, and its shape.
        numbers: (P,) the robot's numbers.
        records: what was differentiated, and the poses at which each was.
    """

    rotation: Array
    position: Array
    load: Array
    gravity: Array
    constants: Array
    places: Mapping[str, slice]
    shapes: Mapping[str, tuple[int, ...]]
    numbers: Array
    records: tuple[tuple[OutputRecord, Index], ...]


class Derivatives:
    """Derivatives of some outputs at N poses.

    Args:
        pose: the poses, closed, of the batch shape (N,).
        prescribed: what was given, and ``target`` (n, N) its values.
        target: see ``prescribed``.
        load: (6, N) [N, N·m].
        gravity: (3, N) [m/s²].
        outputs: which ones; "mass" [kg] is the robot's, with the joints as they are, and by parameters alone.
        tool: (3,) a point of the platform, from o in its axes [m], that twist, stiffness and compliance are about; None: o.
    """

    def __init__(
        self,
        pose: Configuration,
        prescribed: PrescribedCoordinates,
        target: Array,
        load: Array,
        gravity: Array,
        outputs: Sequence[str],
        tool: Array | None = None,
    ) -> None:
        self.robot: Robot = robot_of(pose)
        self.pose, self.target, self.load, self.gravity = pose, target, load, gravity
        self.prescribed = self.robot.mobility_analysis.without_idle_dofs(prescribed)
        self.outputs, self.tool = tuple(outputs), tool
        self.N = load.shape[1]

    # ---- the statics ------------------------------------------------------------------------------------------------

    @property
    def record(self) -> tuple[OutputRecord, Array]:
        """What is recorded of the first pose that has one, and the robot's numbers (P,) that it takes."""
        return self._statics.records[0][0], self._statics.numbers

    @cached_property
    def _statics(self) -> Gradients:
        return self._gradients(self.robot.statics)

    def _gradients(self, decided: RobotStatics) -> Gradients:
        """Return the derivatives of all outputs, with the wrench bases that are decided about."""
        frames = self.pose.frames
        bodies, constants = frames.position.shape[1], structure_of(decided).values
        names = [name for name in self.outputs if name not in ("actuators", "mass")]
        left = np.flatnonzero(self.pose.reached & np.all(np.isfinite(frames.position), axis=(0, 1)))
        total: Array | None = None
        places: dict[str, slice] = {}
        shapes: Mapping[str, tuple[int, ...]] = {}
        records: list[tuple[OutputRecord, Index]] = []
        while left.size or total is None:
            first = np.array([left[0] if left.size else 0])
            example = frames.take(first) if left.size else decided.example
            try:
                record = output_record(decided, names, (example, self.load[:, first], self.gravity[:, first]), tool=self.tool)
            except NotRecordedError as error:
                raise ArgumentError(f"{self.robot.name!r} has no derivatives: {error}") from error
            rows = [row for name in names for row in record.rows[name]]
            if total is None:
                total = np.full((len(rows), 12 * bodies + 9 + constants.size, self.N), np.nan)
                shapes, start = record.shapes, 0
                for name in names:
                    places[name] = slice(start, start + len(record.rows[name]))
                    start += len(record.rows[name])
            if not left.size:
                break
            found, holds = _swept(record, rows, self._inputs(frames.rotation, frames.position, left), constants)
            holds[0] = True  # it was made there
            total[..., left[holds]] = found[..., holds]
            records.append((record, left[holds]))
            left = left[~holds]
        ends = np.cumsum([9 * bodies, 3 * bodies, 6, 3])
        R, p, load, gravity, rest = np.split(total, ends, axis=1)
        m = total.shape[0]
        R, p = R.reshape(m, 3, 3, bodies, self.N), p.reshape(m, 3, bodies, self.N)
        return Gradients(R, p, load, gravity, rest, places, shapes, constants, tuple(records))

    def _inputs(self, rotation: Array, position: Array, which: Index) -> list[Array]:
        """Return what a record takes of some poses, the frames' rotations and positions of all given."""
        arrays = rotation.reshape(-1, self.N), position.reshape(-1, self.N), self.load, self.gravity
        return [array[:, which] for array in arrays]

    @cached_property
    def _by_freedoms(self) -> Array:
        return self._freedoms_of(self._statics)

    def _freedoms_of(self, own: Gradients) -> Array:
        """Return the outputs' rates (m, nv, N) with each freedom of the tree: what their wrenches do on its twists."""
        frames = self.pose.frames
        force = own.position
        moment = np.stack([cross(frames.position, one) for one in own.position]) if len(force) else force
        for j in range(3):
            turned = [cross(frames.rotation[:, j], one[:, j]) for one in own.rotation]
            moment = moment + np.stack(turned) if turned else moment
        wrench = np.concatenate([force, moment], axis=1)
        carried = np.einsum("bk,mibn->mikn", self._moves, wrench, optimize=True)
        return np.asarray(np.einsum("mikn,ikn->mkn", carried, self._twists))

    @cached_property
    def _moves(self) -> Array:
        """(B, nv) how each freedom moves each body, as seen from the base."""
        return body_moves(self.robot.solver)

    @cached_property
    def _twists(self) -> Array:
        frames = self.robot.equations.forward(self.pose.poses.x)
        return self.robot.equations.tree.twists(frames)

    # ---- the closing of the loops -------------------------------------------------------------------------------------

    @cached_property
    def _closing(self) -> tuple[Array, Array, Array]:
        """Gradient (N, m, n) by scaled steps, its pseudoinverse, and the residuals' rates (m, coordinates, N)."""
        gradient, rates = self.robot.solver.rates(self.prescribed, self.pose.poses, self.target)
        turned = np.nan_to_num(np.moveaxis(gradient, 2, 0))
        inverse = np.swapaxes(turned, 1, 2)
        if turned.size:
            inverse = np.asarray(np.linalg.pinv(turned, rcond=_FREE), dtype=np.float64)
        return turned, inverse, rates

    def _velocities(self, rates: Array) -> Array:
        """Return how fast the freedoms move (nv, k, N) so that residuals with ``rates`` (m, k, N) stay zero."""
        turned, inverse, _ = self._closing
        step = np.moveaxis(-inverse @ np.moveaxis(rates, 2, 0), 0, 2)
        return freedom_rates(self.robot.solver, self.prescribed, np.moveaxis(turned, 0, 2), rates, step)

    @cached_property
    def _by_coordinates(self) -> Array:
        """(nv, coordinates, N) the freedoms' rates with each given coordinate."""
        return with_given(self.robot.solver, self.prescribed, self._velocities(self._closing[2]))

    def _of_actuators(self, v: Array, explicit: Array | None = None) -> Array:
        """Return rates (actuators, k, N) of the actuators' coordinates, in the file's order, at freedoms' rates (nv, k, N)."""
        robot = self.robot
        given = robot.actuator_coordinates
        rows = actuator_rates(robot.solver, given, self.pose.poses, v)
        if explicit is not None:
            rows[len(given.columns) :] += explicit[:, None]
        names = actuator_names(robot.mechanism, robot.equations)
        return rows[[names.index(name) for name in robot.description.driven]]

    # ---- what is asked for --------------------------------------------------------------------------------------------

    def by_coordinate(self, k: int) -> dict[str, Array]:
        """Return the derivatives (*output, N) by the k-th given coordinate."""
        v = self._by_coordinates[:, [k]]
        return self._collected(np.einsum("mvn,vkn->mkn", self._by_freedoms, v)[:, 0], self._of_actuators(v)[:, 0])

    def by_load(self) -> dict[str, Array]:
        """Return the derivatives (*output, 6, N) by the load."""
        return self._collected(self._statics.load, np.zeros((len(self.robot.description.driven), 6, self.N)))

    def by_gravity(self) -> dict[str, Array]:
        """Return the derivatives (*output, 3, N) by gravity."""
        return self._collected(self._statics.gravity, np.zeros((len(self.robot.description.driven), 3, self.N)))

    def by_numbers(self, numbers: Sequence[Number]) -> dict[str, Array]:
        """Return the derivatives (*output, N) by one number of the robot, (*output, n, N) by n components.

        NaN where the loops cannot stay closed, as those of an overconstrained robot, and by a component without derivative.

        Raises:
            ArgumentError: no component has a derivative: the robot would be another mechanism, or none at all.
        """
        columns: list[dict[str, Array]] = []
        errors: list[ArgumentError] = []
        for item in numbers:
            try:
                columns.append(self._nothing() if item.step is None else self.by_change(item.name, item.step, item.changed))
            except ArgumentError as error:
                errors.append(error)
                columns.append({name: np.full_like(part, np.nan) for name, part in self._nothing().items()})
        if len(errors) == len(columns):
            raise errors[0]
        if len(columns) == 1:
            return columns[0]
        return {name: np.stack([column[name] for column in columns], axis=-2) for name in self.outputs}

    def _nothing(self) -> dict[str, Array]:
        return self._collected(0 * self._statics.load.sum(axis=1), np.zeros((len(self.robot.description.driven), self.N)))

    def by_change(self, name: str, step: float, changed: Callable[[float], RobotDescription]) -> dict[str, Array]:
        """Return the derivatives (*output, N) by a number, by wrench bases that suit the robot a little different, too.

        Args:
            name: of the number, for messages.
            step: by how much it is changed where constants are differenced.
            changed: the robot's description in which it is larger by an amount.

        Raises:
            ArgumentError: the robot would be another mechanism, or none at all.
        """
        where, nominal = (self.prescribed, self.pose.poses, self.target), self._statics

        def found(decided: RobotStatics, own: Gradients) -> dict[str, Array] | None:
            return self._by_rates(rates_of(self.robot, changed, step, *where, decided), own, step)

        try:
            if all(alike(changed(by), self.robot.description) for by in (step, -step)):
                return self._nothing()
            with contextlib.suppress(KinetostaticsError):  # other axes may meet then than now
                if first := found(self.robot.statics, nominal):
                    return first
            decided = statics_on(Robot(changed(step)).statics, self.robot.statics)
            if second := found(decided, self._gradients(decided)):
                return second
        except KinetostaticsError as error:
            raise ArgumentError(f"there is no derivative by {name!r}: {error}") from error
        raise ArgumentError(f"there is no derivative by {name!r}: the robot's limbs become other ones")

    def _by_rates(self, rates: Rates, own: Gradients, step: float) -> dict[str, Array] | None:
        """Return the derivatives, None if the record does not hold next to the robot."""
        inside = bodies_inside(self.robot)
        rotation, position = rates.rotation, rates.position
        assert not np.any(rotation[:, :, inside])
        total = np.einsum("mpn,p->mn", own.constants, rates.constants)
        actuators, mass = np.zeros((len(self.robot.description.driven), self.N)), rates.mass
        if any(np.any(part) for part in (rates.residual, rotation, position, rates.loop_actuators)):
            total += np.einsum("mijbn,ijbn->mn", own.rotation, rotation) + np.einsum("mibn,ibn->mn", own.position, position)
            v = self._velocities(rates.residual[:, None])
            total += np.einsum("mvn,vkn->mn", self._freedoms_of(own), v)
            actuators = self._of_actuators(v, rates.loop_actuators)[:, 0]
            moved = frame_rates(self._moves, self._twists, self.pose.frames, np.nan_to_num(v[:, 0]))
            rotation, position, mass = rotation + moved[0], position + moved[1], mass + self._mass_along(*moved)
        for record, where in own.records:
            for by in (_NEAR * step, -_NEAR * step):
                moved = self.pose.frames.rotation + by * rotation, self.pose.frames.position + by * position
                inputs = self._inputs(*moved, where)
                results = values(record.tape, needed_by(record.tape, [record.holds]), inputs, own.numbers + by * rates.constants)
                if not np.all(results[record.holds]):
                    return None
        return self._collected(total, actuators, mass)

    def _mass_along(self, turning: Array, moving: Array) -> Array:
        """Return the rate (N,) of the robot's mass as all bodies move: that of telescopic beams follows their length."""
        if not any(beam.telescopic for beam in self.robot.beams.values()):
            return np.zeros(self.N)
        frames, masses = self.pose.frames, self.robot.weights.masses
        step = _SHIFT * self.robot.length / max(float(np.max(np.abs(moving), initial=0.0)), _TINY)
        total: Array = np.zeros(self.N)
        for count, weight in CENTRAL:
            for by in (step, -step):
                there = Frames(frames.rotation + count * by * turning, frames.position + count * by * moving)
                total += weight / by * masses(there).sum(axis=0)
        return total

    def _collected(self, statics: Array, actuators: Array, mass: Array | None = None) -> dict[str, Array]:
        places, shapes = self._statics.places, self._statics.shapes
        found = {}
        for name in self.outputs:
            if name == "actuators":
                found[name] = np.where(self.pose.reached, actuators, np.nan)
            elif name == "mass":
                found[name] = np.zeros(actuators.shape[1:]) if mass is None else mass
            else:
                part = statics[places[name]]
                found[name] = part.reshape(*shapes[name], *part.shape[1:])
        return found


def derivatives_at(
    result: Result,
    analysis: Mapping[str, object],
    tool: Array | None = None,
    wanted: Sequence[str] = OUTPUTS,
) -> Derivatives | None:
    """Return the derivatives at all poses, None where loads on links, assembly errors and the like are not differentiated, or
    overconstrained rigid limbs.

    Args:
        result: of the analysis of poses.
        analysis: its arguments.
        tool: (3,) a point of the platform, from o in its axes [m], that twist and stiffness are about; None: o.
        wanted: what is differentiated.
    """
    configuration = result.configuration
    more = {name for name, value in analysis.items() if value is not None and not (isinstance(value, str) and value == "world")}
    if not more <= PLAIN or result.shape != configuration.shape or not np.all(configuration.reached):
        return None
    robot, N = robot_of(configuration), len(configuration.reached)
    if configuration.prescribed:
        convention = configuration.orientation
        prescribed = prescribed_platform(configuration.prescribed, convention)
        known = convention.pose_names
        values = [configuration.platform[name] for name in known if name in configuration.prescribed]
    else:
        prescribed = robot.actuator_coordinates
        values = [configuration.actuators[name] for name in actuator_names(robot.mechanism, robot.equations)]
    target = np.array([np.ravel(value) for value in values]).reshape(len(values), N)
    load, gravity = result.load.reshape(N, 6).T, result.gravity.reshape(N, 3).T
    if not np.all(np.isfinite(load)):
        return None
    outputs = [name for name in OUTPUTS if name in wanted]
    outputs = [name for name in outputs if robot.description.driven or not name.startswith("actuator")]
    found = Derivatives(replace(configuration, shape=(N,)), prescribed, target, load, gravity, outputs, tool)
    with contextlib.suppress(ArgumentError):  # it has no record
        return found if not N or found.record else None
    return None


def _swept(record: OutputRecord, rows: Sequence[int], inputs: Sequence[Array], constants: Array) -> tuple[Array, Mask]:
    """Return the derivatives (rows, inputs and constants, N) of a record's results, and where (N,) it holds."""
    N = inputs[0].shape[1]
    starts = np.cumsum([0, *(array.shape[0] for array in inputs)])
    needed = needed_by(record.tape, (*rows, record.holds))
    places = {}
    for number, operation in enumerate(record.tape.operations):
        if operation[0] == "input":
            places[number] = int(starts[operation[1]]) + operation[2]
        elif operation[0] == "parameter":
            places[number] = int(starts[-1]) + operation[1]
    found = np.zeros((len(rows), int(starts[-1]) + constants.size, N))
    holds = np.zeros(N, dtype=bool)
    at_once = max(1, 4000 // max(len(rows), 1))
    for first in range(0, N, at_once):
        part = slice(first, min(first + at_once, N))
        count = part.stop - part.start
        results = values(record.tape, needed, [array[:, part] for array in inputs], constants)
        holds[part] = results[record.holds]
        for number, derivative in gradients(record.tape, results, rows, places, count).items():
            found[:, places[number], part] = derivative
    return found, holds
