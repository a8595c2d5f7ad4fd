"""The parametric robot: descriptions of a robot with other arguments of its file and other numbers of its parts."""

from __future__ import annotations

import fnmatch
import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.description.robot_description import RobotDescription, known_valid
from kinetostatics.elements.static_model import StaticModel, make_elastic_links
from kinetostatics.elements.weights import Weights
from kinetostatics.engine.pose_record import PoseModel
from kinetostatics.exceptions import ArgumentError, RobotFileError, near_names
from kinetostatics.files.parameter_units import parameter_unit
from kinetostatics.files.reader import parameter_values, read_robot_file
from kinetostatics.kinematics.assembly import SolverChoice, assemble
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.solver import Solver
from kinetostatics.math.arrays import Array
from kinetostatics.parametric.robot_numbers import STEP, ErrorParameter, RobotNumber, errors_of, numbers_of_parts
from kinetostatics.robot import Robot
from kinetostatics.statics.robot_statics import statics_on
from kinetostatics.units import unit

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

#: Fields of a description and its parts that affect neither statics nor mass, such as visuals, moments of inertia and limits.
IDLE = ("parameters", "file_warnings", "extra", "inertia", "lower", "upper", "cone", "effort", "velocity")


class ParametricRobot:
    """A robot as a function of its numbers: arguments of its file, and numbers of its parts.

    Args:
        links: ``platform_link`` and ``base_link`` of its file; None: the links for which the file yields this robot.
    """

    def __init__(self, robot: Robot, links: Mapping[str, str | None] | None = None) -> None:
        self.robot, self._given_links = robot, links
        self._known: dict[tuple[tuple[str, float], ...], RobotDescription] = {}

    # ---- its numbers --------------------------------------------------------------------------------------------------

    @cached_property
    def every_part(self) -> dict[str, tuple[RobotNumber, ...]]:
        """Numbers of all parts, by name; a vector or placement has all its components, even those that cannot be changed."""
        return numbers_of_parts(self.robot)

    @cached_property
    def parts(self) -> dict[str, RobotNumber]:
        """The single numbers of all parts that can be changed, by name, such as ``revolute_1.placement.x``."""
        return {number.name: number for several in self.every_part.values() for number in several if number.step is not None}

    @cached_property
    def errors(self) -> dict[str, ErrorParameter]:
        return errors_of(self.robot)

    @cached_property
    def arguments(self) -> dict[str, float]:
        """Numerical arguments of the file with their values, in the file's order.

        Raises:
            ArgumentError: the robot differs from its file.
        """
        assert self._links is not None
        description, values = self.robot.description, dict[str, float]()
        for name, text in parameter_values(description.path, description.parameters).items():
            try:
                number = float(text)
            except ValueError:
                continue
            if math.isfinite(number):
                values[name] = number
        return values

    @cached_property
    def _links(self) -> Mapping[str, str | None]:
        if self._given_links is not None:
            return self._given_links
        description = self.robot.description
        every: list[Mapping[str, str | None]] = [{}, {"platform_link": description.platform, "base_link": description.base}]
        for links in every:
            try:
                same = read_robot_file(description.path, description.parameters, **links)
            except (ArgumentError, RobotFileError):
                continue
            if same == description:
                return links
        raise ArgumentError(
            f"the robot {self.robot.name!r} differs from its file {description.path!r}: parameters belong to a file; load it "
            "from there, or save it"
        )

    def number(self, name: str) -> RobotNumber:
        """Return a number of a part, or an argument of the file."""
        if "." in name and name in self.parts:
            return self.parts[name]
        value = self.arguments[name]

        def read(other: float) -> RobotDescription:
            return self._read({name: other})

        step = STEP * (abs(value) or 1.0)
        return RobotNumber(name, parameter_unit(value, read), value, step, self.robot.description, read=read)

    def names(self, patterns: Sequence[str], what: str = "", errors: bool = False) -> dict[str, str]:
        """Return the names that match patterns, each with its pattern.

        Args:
            patterns: names of arguments of the file and of numbers of parts; ``*`` is a wildcard.
            what: name of the argument that contains the patterns, for the error if a number is named twice; empty: this is
                allowed.
            errors: whether assembly errors such as ``revolute_*.error.[xyz]`` are included.

        Raises:
            ArgumentError: a pattern has no match, or matches arguments although the robot differs from its file; or a number is
                named twice.
        """
        parameters = [*self.parts, *(self.arguments if any("." not in name for name in patterns) else ())]
        pattern_of: dict[str, str] = {}
        for pattern in patterns:
            candidates = list(self.errors) if errors and ".error." in pattern else parameters
            names = fnmatch.filter(candidates, pattern)
            if not names:
                raise ArgumentError(f"{self.robot.name!r} has no parameter {pattern!r}: {near_names(pattern, candidates)}")
            for name in names:
                if what and name in pattern_of:
                    raise ArgumentError(f"{what}: {name!r} is named twice, the second time by {pattern!r}")
                pattern_of.setdefault(name, pattern)
        return pattern_of

    def select(self, patterns: Sequence[str], what: str = "") -> list[tuple[str, RobotNumber]]:
        """Return the pattern and the number for each match of patterns, see :meth:`names`."""
        return [(pattern, self.number(name)) for name, pattern in self.names(patterns, what).items()]

    def check_units(self, typed: Mapping[str, str], what: str) -> None:
        """Check the units ``typed`` with arguments of the file, see :func:`check_unit`."""
        for name, given in typed.items():
            if name in self.arguments:
                check_unit(self.number(name), given, what)

    # ---- robots with other numbers --------------------------------------------------------------------------------------

    def _read(self, arguments: Mapping[str, float]) -> RobotDescription:
        """Return the file's description with other values of some arguments; descriptions are kept in memory.

        Raises:
            RobotFileError: the file is invalid with these values.
        """
        key = tuple(sorted((name, value) for name, value in arguments.items() if value != self.arguments[name]))
        description = self.robot.description
        if key and key not in self._known:
            self._known[key] = read_robot_file(description.path, {**description.parameters, **dict(key)}, **self._links)
        return self._known[key] if key else description

    def description(self, values: Mapping[str, float]) -> RobotDescription:
        """Return the robot's description with other values of some numbers; expressions of the file are evaluated again.

        Raises:
            RobotFileError: the robot is invalid with these values.
        """
        there = self._read({name: value for name, value in values.items() if name not in self.parts})
        changes = [(self.parts[name], value) for name, value in values.items() if name in self.parts]
        try:
            return _changed(there, [(number, value - number.of(there)) for number, value in changes])
        except ArgumentError as error:
            raise RobotFileError(str(error), self.robot.description.path) from error

    def increased(self, amounts: Mapping[str, float]) -> RobotDescription:
        """Return the description with numbers increased by ``amounts``; arguments of the file are changed before parts.

        Raises:
            RobotFileError: the file is invalid with these values.
            ArgumentError: a part cannot have one of its new numbers.
        """
        parts = self.parts
        there = self._read({name: self.arguments[name] + by for name, by in amounts.items() if name not in parts})
        return _changed(there, [(parts[name], by) for name, by in amounts.items() if name in parts])


def _changed(description: RobotDescription, changes: Sequence[tuple[RobotNumber, float]]) -> RobotDescription:
    """Return a description with each number increased by an amount, in an order in which no intermediate description is invalid.

    For example, an outer diameter is enlarged before the inner one.

    Raises:
        ArgumentError: there is no such order.
    """
    left = list(changes)
    for _ in changes:
        put_off = []
        for number, by in left:
            try:
                description = number.changed_in(description, by)
            except ArgumentError:
                put_off.append((number, by))
        left = put_off
    for number, by in left:  # raises the error
        description = number.changed_in(description, by)
    return description


def check_unit(number: RobotNumber | ErrorParameter, typed: str, what: str) -> None:
    """Check that ``typed``, the unit of a given value, has the dimension of a number's unit; an unknown unit is not checked.

    Raises:
        ArgumentError: the dimensions differ.
    """
    own, given = (text.replace(" ", "·") for text in (number.unit, typed))
    if own and given and (own == "1" or unit(own.replace("·", " ")).dimension != unit(given.replace("·", " ")).dimension):
        expected = "has no unit" if own == "1" else f"is in {own}"
        raise ArgumentError(f"{what}: {number.name} is given in {given}, but it {expected}")


def have_same_statics(first: RobotDescription, second: RobotDescription) -> bool:
    """Whether two descriptions differ at most in fields that affect neither statics nor mass."""
    for field in fields(RobotDescription):
        a, b = getattr(first, field.name), getattr(second, field.name)
        if field.name in IDLE or not field.compare or a == b:
            continue
        if not isinstance(a, Mapping) or a.keys() != b.keys() or any(_bare(a[name]) != _bare(b[name]) for name in a):
            return False
    return True


def _bare(part: DataclassInstance) -> dict[str, object]:
    return {field.name: getattr(part, field.name) for field in fields(part) if field.compare and field.name not in IDLE}


def same_pose(configuration: Configuration, robot: Robot, loops: SolverChoice) -> Configuration:
    """Return the pose of ``robot`` at the coordinates of platform or actuators from which ``configuration`` was assembled.

    The given pose, of a similar robot, is where the straight line of coordinates to the new pose starts; thus both poses have the
    same assembly mode. ``loops`` is the function that chooses the solver.
    """
    near = replace(configuration, robot=robot)
    if configuration.prescribed:
        given = {name: np.array(configuration.platform[name]) for name in configuration.prescribed}
        return assemble(robot, None, given, configuration.orientation.name, near, near.closure_tolerance, "nan", loops)
    given = {name: np.array(value) for name, value in configuration.actuators.items()}
    return assemble(robot, given, None, None, near, near.closure_tolerance, "nan", loops)


def changed_model(robot: Robot, description: RobotDescription, original: PoseModel) -> tuple[PoseModel, Array]:
    """Return the model of a slightly changed robot, and the numbers (P,) that compiled code takes from it.

    Ranks and wrench bases are taken from ``original``, the model of the original robot.

    Raises:
        KinetostaticsError: the description is invalid, or has other coordinates, loops or limbs than the original robot.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        other = Robot(_with_beam_axes(robot, description))
        if (other.equations.tree.nq, other.equations.count) == (robot.equations.tree.nq, robot.equations.count):
            zero = other.frames_at(robot.model_q(robot.zero_poses))
            links = make_elastic_links(other.mechanism, other.topology.spans, zero)
            weights = Weights(other.mechanism, other.topology, links)
            model = StaticModel(
                other.mechanism,
                other.topology,
                links,
                weights,
                zero,
                robot.length,
                robot.rank_tolerance,
                robot.closing_error,
            )
            statics = statics_on(original.statics, model)
            solver = Solver(other.equations, robot.solver.length, robot.solver.reach, robot.solver.slack)
            changed = PoseModel.of(solver, statics, original.prescribed)
            parts = changed.structure(all_vary=True)
            if parts.key == original.structure(all_vary=True).key:
                return changed, parts.values
    raise ArgumentError("the robot would become another mechanism, because concurrent axes would no longer meet")


def _with_beam_axes(robot: Robot, description: RobotDescription) -> RobotDescription:
    """Return a description whose beams have the y axes of ``robot``, because default axes could change."""
    beams = {}
    for name, beam in description.beams.items():
        rotation = robot.mechanism.body_of[beam.link][1][:3, :3]
        y_axis = tuple((rotation.T @ robot.beams[name].axes[:, 1]).tolist())
        beams[name] = beam if beam.y_axis is not None else replace(beam, y_axis=y_axis)
    changed = replace(description, beams=beams)
    return known_valid(changed) if description.is_valid else changed


def opens_loops(name: str) -> ArgumentError:
    """Return the error for a number that, slightly changed, opens the loops."""
    return ArgumentError(
        f"{name}: with a small change of it the loops do not close, or the pose is lost; for an overconstrained robot, "
        "tolerances of JOINT.error.x … rz compute the effect of such errors, and the internal forces"
    )
