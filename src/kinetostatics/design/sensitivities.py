"""Derivatives of an analysis with respect to the arguments of the robot's file, and to numbers of its parts.

The robot's constants are the numbers that enter its equations. Finite differences yield their derivatives by the parameters; the
derivatives of results by these constants are exact (:mod:`kinetostatics.functions.derivatives`). If exact derivatives do not
exist (overconstrained rigid limbs, assembly errors, loads on links), central differences of whole analyses are used. Derivatives
with respect to the stiffness of a beam, a joint or an actuator are exact: :attr:`kinetostatics.Result.source_contributions`.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyzed
from kinetostatics.arguments import check_choice, names_in
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.exceptions import ArgumentError, RobotFileError
from kinetostatics.functions.derivatives import Derivatives, derivatives_at
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.load_case import AnalysisKeywords, LoadCase, load_case_of
from kinetostatics.math.arrays import Array, batch_first, frozen
from kinetostatics.parametric.parametric_robot import ParametricRobot, opens_loops, same_pose
from kinetostatics.parametric.robot_numbers import STEP as STEP_OF_CONSTANTS
from kinetostatics.parametric.robot_numbers import RobotNumber
from kinetostatics.results.pose_arrays import tool_on_robot
from kinetostatics.results.result import Result
from kinetostatics.results.sensitivities import QUANTITIES, Sensitivities, Sensitivity, is_location
from kinetostatics.robot import Robot, robot_of

#: Step of central differences, relative to the parameter (to 1 if it is zero; for a placement, to the characteristic length).
#: With this step, errors of truncation and of rounding are about equal, 1e-8 of the quantity.
STEP = 3e-5
#: A parameter has no influence if its change by 100 % changes a quantity, to first order, by less than this part of the quantity.
NOTHING = 1e-7
#: Quantities that do not depend on loads.
OF_POSES = {"mass", "actuators"}


def sensitivities(
    configuration: Configuration,
    by: Sequence[str] | None = None,
    outputs: Sequence[str] = QUANTITIES,
    *,
    tool: ArrayLike | None = None,
    **analysis: Unpack[AnalysisKeywords],
) -> Sensitivities:
    """Derivatives of twist, stiffness, actuator forces and mass with respect to the parameters of the robot, ranked.

    Args:
        configuration: a pose or a batch of poses. The coordinates used for assembly, of the platform or the actuators, are kept
            constant.
        by: names of parameters: xacro arguments of the file, each of which changes all numbers computed from it, or dimensions of
            parts, see :attr:`Function.parameters`: ``"rod_1.outer_diameter"``, ``"platform.mass"``,
            ``"revolute_1.placement.x"``, ``"prismatic_1.actuator_stiffness"``; ``*`` is a wildcard: ``"rod_*.density"``.
            Default: all numerical arguments with an influence; for a file without arguments, or a robot changed after reading,
            all dimensions of parts with an influence, except placements and centres of mass.
        outputs: quantities to differentiate: "twist", "stiffness", "compliance", "actuator_forces", "actuators" (their
            coordinates), "mass"; default: all of them.
        tool: (3,) reference point of twist and stiffness, from o in platform axes [m], such as a tool's tip; default: o. The
            point of application of ``load`` is ``point``.
        analysis: arguments of :func:`kinetostatics.analyze`: ``load``, ``gravity``, ``point``, ….

    Returns:
        Derivatives per unit of each parameter, and exact derivatives of the twist per relative change of the stiffness of each
        beam, elastic joint and actuator. Where :attr:`Sensitivity.exact` is False, a derivative is a difference of analyses;
        its error, times the parameter's value, is about 1e-7 of the quantity.

    Raises:
        ArgumentError: a parameter or quantity is unknown; or an argument of the file is named, but the robot was changed after
            reading; or a placement opens the loops of an overconstrained robot (:func:`kinetostatics.tolerances` computes the
            resulting self-stress); or no named parameter can be changed.
        StaticsError: see :func:`kinetostatics.analyze`, for one pose.

    Examples:
        To first order, the twist is inversely proportional to Young's modulus:

        >>> import kinetostatics as ks
        >>> pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.05, "ry": 0.0})
        >>> s = ks.sensitivities(pose, by=["youngs_modulus", "rod_diameter"])
        >>> s["rod_diameter"].unit, s["rod_diameter"].twist.shape
        ('m', (6,))
        >>> e = s["youngs_modulus"]
        >>> bool(abs(e.twist[2] * e.value / s.result.twist[2] + 1) < 1e-6)
        True

        The same for each rod:

        >>> sorted(ks.sensitivities(pose, by=["rod_*.youngs_modulus"], load=[0, 300, 0, 0, 0, 0]))
        ['rod_1.youngs_modulus', 'rod_2.youngs_modulus', 'rod_3.youngs_modulus']
    """
    case = load_case_of(sensitivities, AnalysisKeywords, analysis)
    if not isinstance(configuration, Configuration):
        raise ArgumentError(f"sensitivities needs a Configuration, got {configuration!r}; create one with robot.assemble(…)")
    if not configuration.reached.size:
        raise ArgumentError("sensitivities needs at least one pose; the batch is empty")
    robot = robot_of(configuration)
    robots = ParametricRobot(robot)
    numbers = _all_numbers(robots) if by is None else robots.select(names_in("by", by, '["rod_diameter"]'))
    asked = _quantities(outputs)
    place = tool_on_robot(tool, robot)
    result = analyzed(configuration, case, analysis.get("on_failure"))
    derivatives = derivatives_at(result, case.is_plain, place, asked)
    parameters: dict[str, Sensitivity] = {}
    skipped: dict[str, str] = {}
    lost: list[ArgumentError] = []
    for pattern, number in numbers:
        try:
            slopes, exact = slopes_by(number, result, derivatives, case, place, asked)
            if number.read is None and _loops_stay_open(slopes, result):
                raise opens_loops(number.name)
            parameters[number.name] = _sensitivity(number, slopes, exact, result, asked)
            continue
        except ArgumentError as error:
            reason = str(error)
        except RobotFileError as error:
            reason = f"{number.name}: a small change yields no robot: {error}"
        lost += [ArgumentError(reason)] if pattern == number.name else []
        skipped[number.name] = reason
    if lost and not parameters:
        raise lost[0]
    sources: dict[str, Array] = {}
    if "twist" in asked:
        sources = {name: twist for kind in result.seen_from(place).source_contributions.values() for name, twist in kind.items()}
    every = Sensitivities(result, ResultMapping(parameters), ResultMapping(sources), ResultMapping(skipped), place, asked)
    if by is None:
        whole = numbers_of(configuration, result, place, asked)
        parameters = {name: sensitivity for name, sensitivity in parameters.items() if _has_influence(sensitivity, whole)}
    order = sorted(parameters, key=every.order)
    return replace(every, parameters=ResultMapping({name: parameters[name] for name in order}))


def _quantities(outputs: Sequence[str]) -> tuple[str, ...]:
    asked = names_in("outputs", outputs, '["twist", "mass"]')
    for name in asked:
        check_choice("outputs", name, QUANTITIES)
    if not asked:
        raise ArgumentError('outputs is empty; it must name a quantity, such as ["twist", "mass"]')
    return tuple(name for name in QUANTITIES if name in asked)


def _all_numbers(robots: ParametricRobot) -> list[tuple[str, RobotNumber]]:
    """Return the arguments of a robot's file; without arguments, all dimensions of its parts except positions."""
    try:
        names = list(robots.arguments)
    except ArgumentError:  # the robot was changed after reading
        names = []
    return [("", robots.number(name)) for name in names or (name for name in robots.parts if not is_location(name))]


def slopes_by(
    number: RobotNumber,
    nominal: Result,
    derivatives: Derivatives | None,
    case: LoadCase,
    tool: Array | None,
    asked: Sequence[str],
) -> tuple[dict[str, Array], bool]:
    """Return the derivatives of quantities with respect to one number, batch axes first, and whether they are exact.

    In exact derivatives, finite differences are used for the robot's constants only. If an exact derivative does not exist at
    some pose, differences of whole analyses are used. The last axis of actuator quantities is the axis of actuators.
    """
    if derivatives is not None:
        with contextlib.suppress(ArgumentError):  # the change yields another mechanism, or none (negative mass)
            exact = {name: batch_first(array, nominal.shape) for name, array in derivatives.by_numbers([number]).items()}
            if all(np.all(np.isfinite(array)) for array in exact.values()):
                return exact, True
    step = STEP / STEP_OF_CONSTANTS * (number.step or 1.0)

    def numbers(by: float) -> dict[str, Array]:
        return quantities_of(number.changed(by), nominal, case, tool, asked)

    above = numbers(step)
    try:
        below = numbers(-step)
        return {key: np.asarray((above[key] - below[key]) / (2 * step)) for key in above}, False
    except RobotFileError:
        if number.value != 0:
            raise
        here, further = numbers(0.0), numbers(2 * step)
        return {key: np.asarray((4 * above[key] - 3 * here[key] - further[key]) / (2 * step)) for key in above}, False


def quantities_of(
    description: RobotDescription, nominal: Result, case: LoadCase, tool: Array | None, asked: Sequence[str]
) -> dict[str, Array]:
    """Return quantities of another robot at the nominal prescribed coordinates, batch axes first, actuators last."""
    pose = same_pose(nominal.configuration, Robot(description), case.loops)
    result = None if set(asked) <= OF_POSES else analyzed(pose, case, "nan")
    return numbers_of(pose, result, tool, asked)


def numbers_of(pose: Configuration, result: Result | None, tool: Array | None, asked: Sequence[str]) -> dict[str, Array]:
    quantities: dict[str, Array] = {}
    if "mass" in asked:
        quantities["mass"] = pose.robot.weights.masses(pose.frames).sum(axis=0).reshape(pose.shape)
    if "actuators" in asked and pose.actuators:
        quantities["actuators"] = np.stack(list(pose.actuators.values()), axis=-1)
    if result is not None:
        tip = result.seen_from(tool)
        quantities |= {name: getattr(tip, name) for name in ("twist", "stiffness", "compliance") if name in asked}
        if "actuator_forces" in asked and result.actuator_forces:
            quantities["actuator_forces"] = np.stack(list(result.actuator_forces.values()), axis=-1)
    return quantities


def _loops_stay_open(slopes: Mapping[str, Array], result: Result) -> bool:
    """Whether a small change of a number prevents the closure of loops."""
    arrays = [array for name, array in slopes.items() if name != "mass"]
    return bool(np.any(np.isfinite(result.twist)) and arrays and not any(np.any(np.isfinite(array)) for array in arrays))


def _sensitivity(
    number: RobotNumber, slopes: Mapping[str, Array], exact: bool, nominal: Result, asked: Sequence[str]
) -> Sensitivity:
    derivatives: dict[str, Array | Mapping[str, Array]] = {}
    for name in asked:
        if name.startswith("actuator"):
            actuated = nominal.robot.description.actuated
            derivatives[name] = ResultMapping({actuator: frozen(slopes[name][..., k]) for k, actuator in enumerate(actuated)})
        else:
            shape = nominal.shape if name == "mass" else slopes[name].shape
            derivatives[name] = frozen(np.array(np.broadcast_to(slopes[name], shape)))
    return Sensitivity(number.name, number.value, "" if number.unit == "1" else number.unit, ResultMapping(derivatives), exact)


def _has_influence(sensitivity: Sensitivity, whole: Mapping[str, Array]) -> bool:
    """Whether a parameter changes twist, actuator forces or mass (or, if none of them is requested, any quantity) noticeably."""
    part, pairs = abs(sensitivity.value) or 1.0, []
    compared = [name for name in ("twist", "actuator_forces", "mass") if name in sensitivity.derivatives]
    for name in compared or sensitivity.derivatives:
        derivative = sensitivity.derivatives[name]
        if isinstance(derivative, Mapping):
            pairs += [(array, whole[name][..., k]) for k, array in enumerate(derivative.values())]
        else:
            pairs.append((derivative, whole[name]))
    return any(_largest(part * slope) > NOTHING * _largest(size) for slope, size in pairs)


def _largest(array: Array) -> float:
    return float(np.max(np.abs(np.nan_to_num(array)), initial=0.0))
