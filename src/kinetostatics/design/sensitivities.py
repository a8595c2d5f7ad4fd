"""Derivatives of an analysis with respect to the arguments of the robot's file, and to numbers of its parts.

The file may compute anything from its arguments, so that its constants are differenced; the mathematics behind them is exact
(:mod:`kinetostatics.functions.derivatives`). Where such derivatives do not exist (overconstrained rigid limbs, assembly errors,
loads on links), the whole analysis is differenced centrally. Derivatives with respect to the stiffness of a beam, a joint or an
actuator are exact: :attr:`kinetostatics.Result.source_contributions`.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyze, check_keywords
from kinetostatics.argument_checks import Keyword, check_choice, names_in
from kinetostatics.description.robot_description import RobotDescription
from kinetostatics.engine.programs import loops_for
from kinetostatics.exceptions import ArgumentError, RobotFileError
from kinetostatics.functions.derivatives import Derivatives, derivatives_at
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.math.arrays import Array, batch_first, frozen
from kinetostatics.parametric.parametric_robot import ParametricRobot, opens_loops, same_pose
from kinetostatics.parametric.robot_numbers import STEP as STEP_OF_CONSTANTS
from kinetostatics.parametric.robot_numbers import RobotNumber
from kinetostatics.results.result import Result
from kinetostatics.results.sensitivities import QUANTITIES, Sensitivities, Sensitivity, is_location
from kinetostatics.results.tool_point import tool_on_robot
from kinetostatics.robot import Robot, robot_of

#: Half the distance between the two values of a parameter, as part of it; of one that is zero, of 1; of a placement, of the
#: robot's length. Truncation and rounding then leave errors of about equal size, some 1e-8 of what is differentiated.
STEP = 3e-5
#: Changes by the whole value of a parameter below this part of what is changed are rounding.
NOTHING = 1e-7
#: What no load changes.
OF_POSES = {"mass", "actuators"}


def sensitivities(
    configuration: Configuration,
    by: Sequence[str] | None = None,
    outputs: Sequence[str] = QUANTITIES,
    *,
    tool: ArrayLike | None = None,
    **analysis: Keyword,
) -> Sensitivities:
    """Derivatives of twist, stiffness, actuator forces and mass with respect to the parameters of the robot, ranked.

    Args:
        configuration: a pose or a batch of poses. While a parameter changes, the coordinates stay that the pose was assembled
            with: the platform's, or the actuators'.
        by: names, of xacro arguments of the robot's file, which change all that the file computes from them, or of numbers of one
            part, as :attr:`Function.parameters` has them: ``"rod_1.outer_diameter"``, ``"platform.mass"``,
            ``"revolute_1.placement.x"``, ``"prismatic_1.actuator_stiffness"``; ``*`` in a name stands for anything:
            ``"rod_*.density"``. Default: all arguments that are numbers and change anything; of a file without arguments, or of a
            robot that was changed since it was read, all numbers of parts that do, but for placements and centres of mass.
        outputs: quantities to differentiate: "twist", "stiffness", "compliance", "actuator_forces", "actuators" (their
            coordinates), "mass"; default: all of them. What is not asked for is not computed.
        tool: (3,) a point of the platform, from o in its axes [m], such as a tool's tip, whose twist and stiffness are
            differentiated; default: o. Where ``load`` acts is ``point``.
        analysis: whatever :func:`kinetostatics.analyze` takes: ``load``, ``gravity``, ``point``, ….

    Returns:
        Derivatives per unit of each parameter, exact but for the file's constants, which are differenced; where
        :attr:`Sensitivity.exact` is False all is (to about 1e-7 of the quantity for a change by the parameter's whole value). And
        per part of the stiffness of each beam, elastic joint and actuator, exact.

    Raises:
        ArgumentError: there is no such parameter or quantity; or an argument of the file is named, and the robot is not what its
            file says; or a placement opens the loops of an overconstrained robot: :func:`kinetostatics.tolerances` tells which
            forces that locks in; or all parameters that are named make no robot when they are changed a little.
        StaticsError: as :func:`kinetostatics.analyze`, for one pose.

    Examples:
        Half of the modulus is twice the twist, as far as the first derivative tells:

        >>> import kinetostatics as ks
        >>> pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.05, "ry": 0.0})
        >>> s = ks.sensitivities(pose, by=["youngs_modulus", "rod_diameter"])
        >>> s["rod_diameter"].unit, s["rod_diameter"].twist.shape
        ('m', (6,))
        >>> e = s["youngs_modulus"]
        >>> bool(abs(e.twist[2] * e.value / s.result.twist[2] + 1) < 1e-6)
        True

        Each rod has a part in it:

        >>> sorted(ks.sensitivities(pose, by=["rod_*.youngs_modulus"], load=[0, 300, 0, 0, 0, 0]))
        ['rod_1.youngs_modulus', 'rod_2.youngs_modulus', 'rod_3.youngs_modulus']
    """
    check_keywords(sensitivities, analysis)
    if not isinstance(configuration, Configuration):
        raise ArgumentError(f"sensitivities needs a Configuration, got {configuration!r}; create one with robot.assemble(…)")
    robot = robot_of(configuration)
    robots = ParametricRobot(robot)
    numbers = _all_numbers(robots) if by is None else robots.select(names_in("by", by, '["rod_diameter"]'))
    asked = _quantities(outputs)
    place = tool_on_robot(tool, robot)
    result = analyze(configuration, **analysis)
    derivatives = derivatives_at(result, analysis, place, asked)
    found: dict[str, Sensitivity] = {}
    skipped: dict[str, str] = {}
    lost: list[ArgumentError] = []
    for pattern, number in numbers:
        try:
            slopes, exact = slopes_by(number, result, derivatives, analysis, place, asked)
            if number.read is None and _is_lost(slopes, result):
                raise opens_loops(number.name)
            found[number.name] = _sensitivity(number, slopes, exact, result, asked)
            continue
        except ArgumentError as error:
            said = str(error)
        except RobotFileError as error:
            said = f"{number.name}: with it a little off there is no such robot: {error}"
        lost += [ArgumentError(said)] if pattern == number.name else []
        skipped[number.name] = said
    if lost and not found:
        raise lost[0]
    sources: dict[str, Array] = {}
    if "twist" in asked:
        sources = {name: twist for kind in result.seen_from(place).source_contributions.values() for name, twist in kind.items()}
    every = Sensitivities(result, ResultMapping(found), ResultMapping(sources), ResultMapping(skipped), place, asked)
    if by is None:
        whole = numbers_of(configuration, result, place, asked)
        found = {name: item for name, item in found.items() if _does_anything(item, whole)}
    order = sorted(found, key=every.order)
    return replace(every, parameters=ResultMapping({name: found[name] for name in order}))


def _quantities(outputs: Sequence[str]) -> tuple[str, ...]:
    """Return the requested quantities, in their usual order."""
    asked = names_in("outputs", outputs, '["twist", "mass"]')
    for name in asked:
        check_choice("outputs", name, QUANTITIES)
    if not asked:
        raise ArgumentError('outputs has nothing in it; it must name a quantity, such as ["twist", "mass"]')
    return tuple(name for name in QUANTITIES if name in asked)


def _all_numbers(robots: ParametricRobot) -> list[tuple[str, RobotNumber]]:
    """Return the arguments of a robot's file, or, if there are none, all numbers of its parts but for where things are."""
    try:
        names = list(robots.arguments)
    except ArgumentError:  # the robot is no longer what its file says
        names = []
    return [("", robots.number(name)) for name in names or (name for name in robots.parts if not is_location(name))]


def slopes_by(
    number: RobotNumber,
    nominal: Result,
    derivatives: Derivatives | None,
    analysis: Mapping[str, Keyword],
    tool: Array | None,
    asked: Sequence[str],
) -> tuple[dict[str, Array], bool]:
    """Return the derivatives of quantities by one number, batch axes first, and whether only constants were differenced.

    Those of actuators have these along the last axis. Where not all poses have derivatives, whole analyses are differenced.

    Raises:
        ArgumentError, RobotFileError: there is no robot with the number a little off.
    """
    if derivatives is not None:
        with contextlib.suppress(ArgumentError):  # the robot becomes another mechanism, or none: no mass is negative
            exact = {name: batch_first(array, nominal.shape) for name, array in derivatives.by_numbers([number]).items()}
            if all(np.all(np.isfinite(array)) for array in exact.values()):
                return exact, True
    step = STEP / STEP_OF_CONSTANTS * (number.step or 1.0)

    def numbers(by: float) -> dict[str, Array]:
        return quantities_of(number.changed(by), nominal, analysis, tool, asked)

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
    description: RobotDescription, nominal: Result, analysis: Mapping[str, Keyword], tool: Array | None, asked: Sequence[str]
) -> dict[str, Array]:
    """Return the requested quantities of another robot at the same pose, batch axes first, then those of actuators.

    Raises:
        KinetostaticsError: there is no such robot.
    """
    pose = same_pose(nominal.configuration, Robot(description), loops_for(analysis))
    result = None if set(asked) <= OF_POSES else analyze(pose, **{**analysis, "on_failure": "nan"})
    return numbers_of(pose, result, tool, asked)


def numbers_of(pose: Configuration, result: Result | None, tool: Array | None, asked: Sequence[str]) -> dict[str, Array]:
    """Return the differentiated numbers of a pose and of its analysis."""
    found: dict[str, Array] = {}
    if "mass" in asked:
        found["mass"] = pose.robot.weights.masses(pose.frames).sum(axis=0).reshape(pose.shape)
    if "actuators" in asked and pose.actuators:
        found["actuators"] = np.stack(list(pose.actuators.values()), axis=-1)
    if result is not None:
        tip = result.seen_from(tool)
        found |= {name: getattr(tip, name) for name in ("twist", "stiffness", "compliance") if name in asked}
        if "actuator_forces" in asked and result.actuator_forces:
            found["actuator_forces"] = np.stack(list(result.actuator_forces.values()), axis=-1)
    return found


def _is_lost(slopes: Mapping[str, Array], result: Result) -> bool:
    """Return whether no loop closes with a number a little off, though it does without."""
    arrays = [array for name, array in slopes.items() if name != "mass"]
    return bool(np.any(np.isfinite(result.twist)) and arrays and not any(np.any(np.isfinite(array)) for array in arrays))


def _sensitivity(
    number: RobotNumber, slopes: Mapping[str, Array], exact: bool, nominal: Result, asked: Sequence[str]
) -> Sensitivity:
    found: dict[str, Array | Mapping[str, Array]] = {}
    for name in asked:
        if name.startswith("actuator"):
            driven = nominal.robot.description.driven
            found[name] = ResultMapping({actuator: frozen(slopes[name][..., k]) for k, actuator in enumerate(driven)})
        else:
            shape = nominal.shape if name == "mass" else slopes[name].shape
            found[name] = frozen(np.array(np.broadcast_to(slopes[name], shape)))
    return Sensitivity(number.name, number.value, "" if number.unit == "1" else number.unit, ResultMapping(found), exact)


def _does_anything(item: Sensitivity, whole: Mapping[str, Array]) -> bool:
    """Return whether a parameter changes twist, forces, mass or requested quantities by more than rounding."""
    part, pairs = abs(item.value) or 1.0, []
    for name in [name for name in ("twist", "actuator_forces", "mass") if name in item.derivatives] or item.derivatives:
        own = item.derivatives[name]
        if isinstance(own, Mapping):
            pairs += [(array, whole[name][..., k]) for k, array in enumerate(own.values())]
        else:
            pairs.append((own, whole[name]))
    return any(_largest(part * slope) > NOTHING * _largest(size) for slope, size in pairs)


def _largest(array: Array) -> float:
    return float(np.max(np.abs(np.nan_to_num(array)), initial=0.0))
