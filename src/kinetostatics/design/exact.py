"""Derivatives of poses by arguments of the file whose mathematics is exact: only the file's constants are differenced."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from kinetostatics.description.robot import RobotDescription
from kinetostatics.design.variants import Variants, alike
from kinetostatics.exceptions import RobotFileError
from kinetostatics.functions.derivatives import Derivatives
from kinetostatics.functions.parameters import Parameter
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.coordinate_choices import prescribed_platform
from kinetostatics.kinematics.joint_coordinates import actuator_names
from kinetostatics.math.arrays import Array
from kinetostatics.results.result import Result
from kinetostatics.robot import robot_of

#: What is differentiated.
OUTPUTS = ("twist", "stiffness", "compliance", "actuator_forces", "actuators", "mass")
#: Part of a parameter by which it is changed where constants are differenced, of the fourth order.
STEP = 1e-3
#: Arguments of an analysis with which there are derivatives.
PLAIN = {"load", "gravity", "engine", "on_failure"}


def derivatives_at(
    configuration: Configuration,
    result: Result,
    analysis: Mapping[str, object],
    tool: Array | None = None,
    wanted: Sequence[str] = OUTPUTS,
) -> Derivatives | None:
    """Return the derivatives at all poses, None where loads on links, assembly errors and the like are not differentiated.

    Args:
        configuration: the poses.
        result: their analysis.
        analysis: its arguments.
        tool: (3,) a point of the platform, from o in its axes [m], that twist and stiffness are about; None: o.
        wanted: what is differentiated.
    """
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
    return Derivatives(replace(configuration, shape=(N,)), prescribed, target, load, gravity, outputs, tool)


def argument(variants: Variants, name: str, description: RobotDescription) -> Parameter:
    """Return one argument of a robot's file as a parameter, by which the file is read again."""
    value = variants.numbers[name]

    def change(_: RobotDescription, k: int, by: float) -> RobotDescription:
        return variants.read({name: value + by})

    return Parameter(name, ("",), (), (STEP * (abs(value) or 1.0),), (value,), change, description)


def by_number(derivatives: Derivatives, parameter: Parameter, shape: tuple[int, ...]) -> dict[str, Array]:
    """Return the derivatives of all outputs by one argument of the file or number of a part, batch axes first.

    Raises:
        ArgumentError: the robot has none, or becomes another mechanism.
        RobotFileError: the file is wrong with the number a little changed.
    """
    step = parameter.steps[0] or 0.0
    with contextlib.suppress(RobotFileError):  # of which by_parameter complains
        if all(alike(parameter.changed(0, by), parameter.description) for by in (step, -step)):
            parameter = replace(parameter, steps=(None,))
    found = derivatives.by_parameter(parameter)
    return {output: np.moveaxis(array, -1, 0).reshape((*shape, *array.shape[:-1])) for output, array in found.items()}
