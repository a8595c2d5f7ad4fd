"""Functions of a robot: chosen quantities of a pose, and their derivatives, from coordinates, load and gravity."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyze
from kinetostatics.arguments import Keyword
from kinetostatics.compensation import compensate as compensated
from kinetostatics.engine.programs import compiled_loops
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.functions.c_export import CExport, export_c
from kinetostatics.functions.derivatives import Derivatives
from kinetostatics.functions.fmu import export_fmu
from kinetostatics.functions.inputs_outputs import (
    ALWAYS,
    LOADS,
    PATHS,
    TOLERANCE,
    Quantity,
    Values,
    flat_loads,
    inputs_of,
    listed,
    outputs_of,
)
from kinetostatics.functions.ros2 import export_ros2
from kinetostatics.kinematics import assembly
from kinetostatics.kinematics.alternatives import prescribed_platform
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.math.arrays import Array, batch_first, frozen
from kinetostatics.math.rotations import orientation_named
from kinetostatics.parametric.robot_numbers import RobotNumber, numbers_of_parts
from kinetostatics.quantities import stacked, value_at
from kinetostatics.results.compensation import Compensation
from kinetostatics.robot import Robot
from kinetostatics.status import WITHOUT_NUMBERS

if TYPE_CHECKING:
    from kinetostatics.functions.compiled import CompiledFunction


class Function:
    """A function of a robot, created by :func:`kinetostatics.compile`.

    Attributes:
        robot: the robot.
        orientation: convention of the angles, see :meth:`Robot.assemble`; None for actuators.
        inputs: coordinates, load and gravity, by name.
        outputs: outputs by name, always including "status" and "residual".
        by_actuators: whether the inputs are coordinates of the actuators, not of the platform.
        engine: "numpy" or "compiled".
        compensates: whether the coordinates are targets of the loaded platform, see :func:`kinetostatics.compensate`; the outputs
            are then those of the corrected pose.
        prescribed: coordinates prescribed to the solver.
        names: names of the prescribed coordinates.
    """

    def __init__(
        self,
        robot: Robot,
        names: Sequence[str],
        by_actuators: bool,
        orientation: str | None,
        outputs: Sequence[str],
        engine: str = "numpy",
        compensates: bool = False,
    ) -> None:
        self.engine, self.compensates = engine, compensates
        self.robot, self.orientation, self.by_actuators = robot, orientation, by_actuators
        convention = orientation_named(orientation)
        if by_actuators:
            if taken := {*LOADS, "near"}.intersection(names):
                raise ArgumentError(
                    f"the actuator {min(taken)!r} is named like another argument of the function: rename the joint"
                )
            self.prescribed: PrescribedCoordinates = robot.actuator_coordinates
            self.names = robot.actuator_names
        else:
            self.prescribed = prescribed_platform(names, convention)
            self.names = [name for name in convention.pose_names if name in names]
        self.inputs: Mapping[str, Quantity] = ResultMapping(inputs_of(robot, names, by_actuators, orientation))
        self.outputs: Mapping[str, Quantity] = ResultMapping(outputs_of(robot, outputs, compensates))

    @property
    def parameters(self) -> Mapping[str, Quantity]:
        """Numbers of the robot's parts by which outputs can be differentiated, by name, with shapes and units.

        Each name consists of part and number: for a beam, ``rod_1.outer_diameter`` and other numbers of its section and material;
        for a link, ``platform.mass`` and ``.center_of_mass``, in the link's frame; for an elastic joint, ``.linear_stiffness``,
        ``.angular_stiffness`` and ``.actuator_stiffness``; for a spring, ``.stiffness``, ``.free_length`` and ``.preload``. The
        ``.placement`` of a joint displaces the joint frame along its own axes and rotates it about them, with all bodies beyond
        it; a loop has ``.predecessor_placement`` and ``.successor_placement``.
        """
        units_of = {name: tuple(number.unit for number in several) for name, several in self._numbers.items()}
        return ResultMapping({name: Quantity(name, (len(units),) * (len(units) > 1), units) for name, units in units_of.items()})

    @cached_property
    def _numbers(self) -> dict[str, tuple[RobotNumber, ...]]:
        return numbers_of_parts(self.robot)

    def __repr__(self) -> str:
        return f"<Function of {self.robot.name!r}: {', '.join(self.inputs)} → {', '.join(self.outputs)}>"

    def __str__(self) -> str:
        lines = [f"Function of {self.robot.name}", "  inputs", *(f"    {quantity}" for quantity in self.inputs.values())]
        return "\n".join([*lines, "  outputs", *(f"    {quantity}" for quantity in self.outputs.values())])

    def __call__(
        self,
        *,
        load: ArrayLike = (0, 0, 0, 0, 0, 0),
        gravity: ArrayLike = (0, 0, -9.81),
        near: Configuration | Values | None = None,
        **coordinates: ArrayLike,
    ) -> Values:
        """Return the outputs, each (…, *shape); they are NaN at poses that cannot be reached, see the output "status".

        Args:
            load: (…, 6) external wrench on the platform about o, world axes [N, N·m].
            gravity: (…, 3) gravity in world axes [m/s²].
            near: start of the straight line to the new pose: a pose, or the result of a call; default: the zero pose. If the
                function compensates, this is a target pose of the loaded platform.
            coordinates: all coordinates by name [m, rad].

        Raises:
            ArgumentError: a coordinate is missing or unknown, or shapes do not fit together.
        """
        compiled = self._compiled
        if compiled is not None and (values := compiled.single(coordinates, near, load, gravity)) is not None:
            return values
        pose = self._pose(coordinates, near)
        if compiled is None:
            return Values(self._values(pose, load, gravity), lambda: pose)
        outputs = compiled.many(pose, load, gravity, self._values)
        arrays = {name: frozen(outputs[name]) for name in self.outputs}
        return Values(arrays, lambda: pose, compiled.origin(pose, coordinates))

    def jacobian(self, of: str | Sequence[str], by: str | Sequence[str]) -> Jacobian:
        """Return a function that computes the exact derivatives of outputs by inputs and parameters; the loops remain closed.

        Args:
            of: one or more outputs, except "status" and "residual".
            by: one or more inputs or :attr:`parameters`.

        Raises:
            ArgumentError: an output, input or parameter is unknown, or the function compensates.
        """
        if self.compensates:
            raise ArgumentError("a function that compensates has no derivatives: compile one without compensate=True")
        outputs, names = listed("of", of, '("twist",)'), listed("by", by, '("load",)')
        for name in outputs:
            if name in ALWAYS or name not in self.outputs:
                differentiable = [output for output in self.outputs if output not in ALWAYS]
                hint = near_names(name, differentiable)
                if name not in self.outputs and hint.startswith("known"):
                    hint += "; further outputs must be named in outputs= (--outputs)"
                raise ArgumentError(f"this function has no output {name!r} with derivatives: {hint}")
        for name in names:
            if name not in self.inputs and name not in self._numbers:
                raise ArgumentError(f"{self.robot.name!r} has no parameter {name!r}: {near_names(name, self._numbers)}")
        return Jacobian(self, outputs, names)

    def export_c(
        self,
        folder: str | os.PathLike[str],
        scalar: str = "double",
        name: str | None = None,
        near: Configuration | Values | None = None,
    ) -> CExport:
        """Write the function as C99 for a controller, with header, C++ wrapper, test program, CMakeLists.txt and README.

        The code uses no heap and no library except libm, has bounded iterations, and takes its state as an argument. It is
        generated from the same records as Python's compiled code.

        Args:
            folder: folder of the files; created if missing.
            scalar: "double" or "float", the type of arguments and results; computations are in double.
            name: prefix of all names in C; default: the name of the robot.
            near: initial pose of a state in C: a pose, or the result of a call; default: the zero pose, which may be singular.

        Returns:
            Folder, files, numbers of operations, and memory of the C code.

        Raises:
            ArgumentError: ``near`` is not one closed pose of the robot, rigid limbs overconstrain the robot, ``scalar`` is
                invalid, or the files cannot be written.
        """
        return export_c(self, folder, scalar, name, near=near)

    def export_fmu(
        self, path: str | os.PathLike[str], name: str | None = None, near: Configuration | Values | None = None, fmi: int = 3
    ) -> None:
        """Write the function as a functional mock-up unit: FMI, co-simulation, with the sources of :meth:`export_c`.

        Args:
            path: name of the file, ending in ``.fmu``; an existing file is replaced.
            name, near: see :meth:`export_c`.
            fmi: version of the standard, 3 or 2.

        Raises:
            ArgumentError: as for :meth:`export_c`, the name has another ending, or ``fmi`` is invalid.
        """
        export_fmu(self, path, name, near, fmi)

    def export_ros2(
        self, folder: str | os.PathLike[str], name: str | None = None, near: Configuration | Values | None = None
    ) -> None:
        """Write a ROS 2 package with controllers of ros2_control around the C of :meth:`export_c`, and the robot's URDF.

        One controller, chainable, commands positions and efforts of the actuators at the coordinates of the function, which needs
        the outputs "actuators" and "actuator_forces"; the other one publishes the passive joints, so that robot_state_publisher
        shows closed loops.

        Args:
            folder, name, near: see :meth:`export_c`.

        Raises:
            ArgumentError: as for :meth:`export_c`, one of the outputs is missing, or a passive joint is planar.
        """
        export_ros2(self, Function(self.robot, self.robot.description.actuated, True, None, ["actuators"]), folder, name, near)

    # ---- poses ------------------------------------------------------------------------------------------------------

    def _pose(self, coordinates: Mapping[str, ArrayLike], near: Configuration | Values | None) -> Configuration:
        coordinate_names = [name for name in self.inputs if name not in LOADS]
        for name in coordinates:
            if name not in coordinate_names:
                raise ArgumentError(f"this function has no input {name!r}: {near_names(name, self.inputs)}")
        missing = [name for name in coordinate_names if name not in coordinates]
        if missing:
            raise ArgumentError(f"the coordinates {', '.join(missing)} are missing; this function takes {', '.join(self.inputs)}")
        actuators, platform = (coordinates, None) if self.by_actuators else (None, coordinates)
        start = near.pose if isinstance(near, Values) else near
        loops = compiled_loops(self.engine)
        return assembly.assemble(self.robot, actuators, platform, self.orientation, start, TOLERANCE, "nan", loops)

    @cached_property
    def _compiled(self) -> CompiledFunction | None:
        """The compiled code; None with NumPy or compensation, or if the robot cannot be recorded."""
        if self.engine != "compiled" or self.compensates:
            return None
        from kinetostatics.engine.scalars import NotRecordedError
        from kinetostatics.functions.compiled import CompiledFunction

        given = [name for name in self.inputs if name not in LOADS]
        requested = [name for name in self.outputs if name not in ALWAYS]
        with contextlib.suppress(NotRecordedError):
            return CompiledFunction(self.robot, self.prescribed, self.orientation, self.names, given, requested)
        return None

    def __getstate__(self) -> dict[str, object]:
        """Omit the compiled code, which other processes load from disk."""
        return {name: value for name, value in vars(self).items() if name != "_compiled"}

    def _values(self, pose: Configuration, load: ArrayLike, gravity: ArrayLike) -> dict[str, Array]:
        how: dict[str, Keyword] = {"on_failure": "nan", "engine": self.engine}
        corrected: Compensation | None = None
        if not self.compensates:
            result = analyze(pose, load, gravity, **how)
        else:
            corrected = compensated(pose, load, gravity, controlled=self.names, orientation=self.orientation, **how)
            result = corrected.result
        arrays = {}
        for name, quantity in self.outputs.items():
            is_corrected = corrected is not None and name in ("status", "actuators", "residual_error")
            value = value_at(corrected, name) if is_corrected else value_at(result, PATHS[name])
            array = stacked(value, [*quantity.axes], quantity.axes)
            arrays[name] = frozen(np.array(np.broadcast_to(array, (*result.shape, *quantity.shape))))
        return arrays


@dataclass(frozen=True)
class Jacobian:
    """The derivatives of a function, created by :meth:`Function.jacobian`.

    Attributes:
        function: the function.
        of: names of the differentiated outputs.
        by: names of the inputs and parameters with respect to which they are differentiated.
    """

    function: Function
    of: tuple[str, ...]
    by: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<Jacobian of {', '.join(self.of)} by {', '.join(self.by)}>"

    def __call__(
        self,
        *,
        load: ArrayLike = (0, 0, 0, 0, 0, 0),
        gravity: ArrayLike = (0, 0, -9.81),
        near: Configuration | Values | None = None,
        **coordinates: ArrayLike,
    ) -> Mapping[str, Mapping[str, Array]]:
        """Return the derivatives of each output by each input or parameter, (…, *output's shape, *input's shape).

        They are NaN at poses without results. Derivatives by the placement of a joint are also NaN if changing the placement
        would open the loops of an overconstrained robot; :func:`kinetostatics.tolerances` computes the effect of such an error.
        Arguments: see :meth:`Function.__call__`.

        Raises:
            ArgumentError: an argument is invalid; or a change of a parameter yields another mechanism.
        """
        function = self.function
        try:
            arrays = {name: np.asarray(value, dtype=float) for name, value in coordinates.items()}
        except (TypeError, ValueError):
            raise ArgumentError("coordinates are numbers") from None
        loads, fields, shape = flat_loads(load, gravity, *(array.shape for array in arrays.values()))
        flat, N = {name: np.broadcast_to(array, shape).ravel() for name, array in arrays.items()}, loads.shape[1]
        start = near.pose if isinstance(near, Values) else near
        if start is not None and start.shape != ():
            raise ArgumentError("near= of derivatives needs a single pose")
        pose = function._pose(flat, start)
        target = np.array([flat.get(name, np.zeros(N)) for name in function.names]).reshape(len(function.names), N)
        status = analyze(pose, loads.T, fields.T, on_failure="nan", engine=function.engine).status
        valid = np.isin(status, WITHOUT_NUMBERS, invert=True)
        derivatives = Derivatives(pose, function.prescribed, target, loads, fields, self.of)
        columns: dict[str, dict[str, Array]] = {name: {} for name in self.of}
        for name in self.by:
            if name in LOADS:
                parts = derivatives.by_components(name)
            elif name in function.names:
                parts = derivatives.by_coordinate(function.names.index(name))
            else:
                parts = derivatives.by_numbers(function._numbers[name])
            for output, array in parts.items():
                columns[output][name] = batch_first(np.where(valid, array, np.nan), shape)
        return ResultMapping({output: ResultMapping(parts) for output, parts in columns.items()})

    def export_c(
        self,
        folder: str | os.PathLike[str],
        scalar: str = "double",
        name: str | None = None,
        near: Configuration | Values | None = None,
    ) -> CExport:
        """Write the function and these derivatives as C99, see :meth:`Function.export_c`.

        Raises:
            ArgumentError: as :meth:`Function.export_c`; or a derivative is with respect to a parameter, which is constant in C.
        """
        return export_c(self.function, folder, scalar, name, self, near)
