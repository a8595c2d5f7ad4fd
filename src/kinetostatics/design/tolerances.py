"""Pose errors and forces due to manufacturing tolerances: first order, ranked, and random samples.

For dimensions, materials and placements, :mod:`kinetostatics.functions.derivatives` computes the derivatives ∂f/∂p. The
equilibrium is affine in assembly errors of joints and beams: one analysis for each error is exact (method page, section 11). The
worst case is Σ |∂f/∂p| t, the standard deviation √Σ (∂f/∂p σ)²; :mod:`kinetostatics.design.monte_carlo` computes random samples.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyzed
from kinetostatics.arguments import check, check_choice, check_mapping, warn, whole_number
from kinetostatics.design.monte_carlo import WANTED, random_robots
from kinetostatics.design.sensitivities import slopes_by
from kinetostatics.exceptions import ArgumentError, StaticsError
from kinetostatics.functions.derivatives import Derivatives, derivatives_at
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.load_case import AnalysisKeywords, LoadCase, load_case_of
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.math.linalg import first_largest, ranked
from kinetostatics.parametric.parametric_robot import ParametricRobot, check_unit, opens_loops
from kinetostatics.parametric.robot_numbers import ErrorParameter, RobotNumber, as_assembly_errors
from kinetostatics.parametric.variables import typed_unit
from kinetostatics.results.pose_arrays import tool_on_robot
from kinetostatics.results.result import Result
from kinetostatics.results.tolerances import LENGTHS, Effect, PoseQuantities, Tolerance, Tolerances, quantities
from kinetostatics.robot import robot_of
from kinetostatics.unit_hints import angular_tolerance_hint, tolerance_hint
from kinetostatics.units import parse_number

#: Standard deviation of a parameter relative to its tolerance, by distribution.
DEVIATIONS = {"normal": 1 / 3, "uniform": 1 / math.sqrt(3)}
#: Default number of samples, computed in batches or analysed one by one.
SAMPLES, ONE_BY_ONE = 10_000, 300
#: Default tolerances of assembly errors, by unit.
USUAL = {"m": 1e-4, "rad": 1e-3, "K": 1.0}
RANKINGS = ("force", "displacement", "rotation")
#: Effect of an assembly error, relative to the largest effect, that counts as zero; errors along a joint's freedoms have none.
_NO_EFFECT = 1e-9


def tolerances(
    configuration: Configuration,
    tolerances: Mapping[str, object] | None = None,
    *,
    rank_by: str | None = None,
    samples: int | None = None,
    distribution: str = "normal",
    seed: int = 0,
    tool: ArrayLike | None = None,
    **analysis: Unpack[AnalysisKeywords],
) -> Tolerances:
    """Rank manufacturing errors by pose error and internal force, with worst case, standard deviation and random samples.

    All parameters are independent of one another.

    Args:
        configuration: one pose. Under changes of dimensions and placements, the coordinates used for assembly, of the platform
            or the actuators, are constant. Assembly errors displace the platform with locked actuators.
        tolerances: ± tolerances by name of a parameter: a number (SI), a number with a unit ``"0.1mm"``, or a percentage
            ``"2%"``. A parameter is an xacro argument of the file, which changes all numbers computed from it; a dimension of a
            part, see :attr:`Function.parameters`: ``"rod_1.outer_diameter"``, ``"platform.mass"``, ``"revolute_1.placement.x"``,
            ``"prismatic_1.actuator_stiffness"``; or an assembly error: of a joint ``"revolute_1.error.x"`` … ``rz``, along and
            about the axes of the joint frame on the base side, of a beam ``"rod_1.error.length"`` or
            ``"rod_1.error.temperature"`` [K]. ``*`` is a wildcard for several parameters: ``"rod_*.outer_diameter"``. None: all
            assembly errors with an effect, within 0.1 mm, 1 mrad and 1 K.
        rank_by: order of the effects: "force" (then by moment), "displacement" or "rotation"; default: force if some error
            causes self-stress, else displacement.
        samples: number of random samples; default: 10,000, or 300 if they must be analysed one by one (overconstrained rigid
            limbs, a payload, loads on links).
        distribution: "normal", not truncated, with a standard deviation of a third of the tolerance, so that 0.3 % of the samples
            exceed it; or "uniform" within the tolerance.
        seed: seed of the random numbers.
        tool: (3,) reference point of twist and stiffness, from o in platform axes [m], such as a tool's tip; default: o. The
            point of application of ``load`` is ``point``.
        analysis: arguments of :func:`kinetostatics.analyze`: ``load``, ``gravity``, ``payload``, ….

    Returns:
        Effects of the parameters, worst case, standard deviation, and the quantities of every sample.

    Raises:
        ArgumentError: ``configuration`` is not a single pose; a parameter is unknown, or cannot deviate by its tolerance; or a
            placement opens the loops of an overconstrained robot (use its assembly errors, ``revolute_1.error.x``, instead).
        StaticsError: see :func:`kinetostatics.analyze`.

    Examples:
        The assembly error with the largest self-stress in an overconstrained robot:

        >>> import kinetostatics as ks
        >>> found = ks.tolerances(ks.load_robot("2pru_upr").assemble())
        >>> name, worst = next(iter(found.effects.items()))
        >>> name, worst.at, round(worst.force)  # [N]
        ('revolute_1.error.ry', 'prismatic_1', 261)

        Independent rod diameters within 0.1 mm, and one Young's modulus for all rods within 3 %:

        >>> pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.05, "ry": 0.0})
        >>> off = {"rod_*.outer_diameter": "0.1mm", "youngs_modulus": "3%"}
        >>> found = ks.tolerances(pose, off, load=[0, 0, -500, 0, 0, 0], samples=3000)
        >>> len(found.parameters)
        4
        >>> mean, deviation, low, high = found.sampled("displacement")
        >>> bool(abs(deviation / found.standard_deviation.displacement - 1) < 0.05)
        True
        >>> max(found.parameters, key=found.share)
        'youngs_modulus'
    """
    case = _load_case(analysis)
    if not isinstance(configuration, Configuration) or configuration.shape != ():
        raise ArgumentError("tolerances needs a single pose; create one with robot.assemble(…)")
    if rank_by is not None:
        check_choice("rank_by", rank_by, RANKINGS)
    check_choice("distribution", distribution, tuple(DEVIATIONS))
    count = None if samples is None else whole_number("samples", samples, 2)
    seed = check("seed", seed)
    robot = robot_of(configuration)
    place, family = tool_on_robot(tool, robot), ParametricRobot(robot)
    numbers, errors, given = _read_tolerances(family, tolerances)
    result = analyzed(configuration, case, analysis.get("on_failure"))
    if result.shape != ():
        raise ArgumentError("tolerances needs a single pose and a single load")
    derivatives = derivatives_at(result, case.is_plain, place, WANTED) if numbers else None
    effects = {number.name: _by_number(number, given[number.name], result, derivatives, case, place) for number in numbers}
    effects |= _by_errors(errors, [given[error.name] for error in errors], result, case, place, tolerances is None)
    errors = [error for error in errors if error.name in effects]
    if not effects:
        raise ArgumentError(f"no error of a joint or beam of {robot.name!r} has an effect")
    every: list[RobotNumber | ErrorParameter] = [*numbers, *errors]
    ratio = DEVIATIONS[distribution]
    parameters = {
        parameter.name: Tolerance(
            parameter.name, parameter.value, parameter.unit, given[parameter.name], ratio * given[parameter.name]
        )
        for parameter in every
    }
    at_once = derivatives is not None or not numbers
    count = count or (SAMPLES if at_once else ONE_BY_ONE)
    rng = np.random.default_rng(seed)
    shape = len(every), count
    units = rng.standard_normal(shape) if distribution == "normal" else rng.uniform(-math.sqrt(3), math.sqrt(3), shape)
    values = units * np.array([[tolerance.standard_deviation] for tolerance in parameters.values()])
    worst, deviation = _worst(list(effects.values())), _deviation(list(effects.values()), ratio)
    slopes = [{name: _array(effects[error.name], name) / given[error.name] for name in WANTED} for error in errors]
    linear = {name: np.stack([slope[name] for slope in slopes]) for name in WANTED if slopes}
    made, difference = random_robots(
        result, derivatives, family, numbers, errors, linear, values, case, float(deviation.displacement), place
    )
    self_stress = any(effect.force > 0 or effect.moment > 0 for effect in effects.values())
    ranked_by = rank_by or ("force" if self_stress else "displacement")
    return Tolerances(
        result,
        ResultMapping(parameters),
        ResultMapping(_ordered(effects, ranked_by)),
        ranked_by,
        worst,
        deviation,
        _sampled(made, result, place),
        ResultMapping({parameter.name: frozen(row + parameter.value) for parameter, row in zip(every, values, strict=True)}),
        distribution,
        seed,
        at_once,
        difference,
        place,
    )


def _load_case(analysis: AnalysisKeywords) -> LoadCase:
    return load_case_of(tolerances, AnalysisKeywords, analysis)


def _read_tolerances(
    family: ParametricRobot, tolerances: Mapping[str, object] | None
) -> tuple[list[RobotNumber], list[ErrorParameter], dict[str, float]]:
    """Return the varied numbers, arguments of the file first; the varied assembly errors; the tolerances by name."""
    if tolerances is None:
        errors = list(family.errors.values())
        return [], errors, {error.name: USUAL[error.unit] for error in errors}
    check_mapping("tolerances", tolerances, '{"rod_*.outer_diameter": "0.1mm"}')
    if not tolerances:
        raise ArgumentError('tolerances is empty; it must be a mapping such as {"rod_*.outer_diameter": "0.1mm"}')
    named = family.names(list(tolerances), "tolerances", errors=True)
    errors = [family.errors[name] for name, pattern in named.items() if ".error." in pattern]
    numbers = [family.number(name) for name, pattern in named.items() if ".error." not in pattern]
    numbers.sort(key=lambda number: number.read is None)
    amounts: dict[str, float] = {}
    odd: set[str] = set()  # patterns with a warning
    every: list[RobotNumber | ErrorParameter] = [*numbers, *errors]
    for parameter in every:
        name, unit = parameter.name, parameter.unit
        pattern = named[name]
        given = tolerances[pattern]
        amounts[name] = amount = _amount(parameter, given)
        if pattern not in odd and not (isinstance(given, str) and ("%" in given or typed_unit(given))):
            hints = tolerance_hint(name, amount, parameter.value, family.robot.zero_size) if unit == "m" else []
            hints += angular_tolerance_hint(name, amount) if unit == "rad" else []
            for hint in hints:
                warn(hint)
                odd.add(pattern)
    return numbers, errors, amounts


def _amount(number: RobotNumber | ErrorParameter, given: object) -> float:
    """Return a tolerance in SI."""
    what = f"tolerances: {number.name}"
    amount = math.nan
    if isinstance(given, str) and given.rstrip().endswith("%"):
        amount = 0.01 * abs(number.value) * parse_number(given.rstrip()[:-1], "number", what)
        if number.value == 0:
            raise ArgumentError(f"{what} is {given!r}; a percentage of a number that is zero is zero: give it with a unit")
    elif isinstance(given, str):
        amount = parse_number(given, "", what)
        check_unit(number, typed_unit(given), "tolerances")
    elif isinstance(given, (int, float, np.number)) and not isinstance(given, bool):
        amount = float(given)
    if not 0 < amount < math.inf:
        raise ArgumentError(f"{what} is {given!r}; it must be a positive number such as '0.1mm' or '2%'")
    return amount


# ---- first order -----------------------------------------------------------------------------------------------------------


def _by_number(
    number: RobotNumber,
    amount: float,
    nominal: Result,
    derivatives: Derivatives | None,
    case: LoadCase,
    tool: Array | None,
) -> Effect:
    """Return the effect of a parameter, amount · ∂f/∂p."""
    slopes, _ = slopes_by(number, nominal, derivatives, case, tool, WANTED)
    if not np.all(np.isfinite(slopes["twist"])):
        raise opens_loops(number.name)
    return _effect({name: amount * slope for name, slope in slopes.items()}, nominal.robot.description.actuated)


def _effect(arrays: Mapping[str, Array], names: Sequence[str], force: float = 0.0, at: str = "", moment: float = 0.0) -> Effect:
    forces = ResultMapping({name: frozen(arrays["actuator_forces"][k]) for k, name in enumerate(names)})
    effect = quantities(frozen(arrays["twist"]), frozen(arrays["stiffness"]), forces, np.zeros(6))
    return Effect(effect.twist, effect.displacement, effect.rotation, effect.stiffness, forces, force, at, moment)


def _by_errors(
    errors: Sequence[ErrorParameter],
    amounts: Sequence[float],
    nominal: Result,
    case: LoadCase,
    tool: Array | None,
    only_effective: bool,
) -> dict[str, Effect]:
    """Return the effect of each assembly error on twist and forces, by name; assembly errors do not change the stiffness.

    ``only_effective`` omits errors without an effect.
    """
    if not errors:
        return {}
    robot = nominal.robot
    moved = replace(case, assembly_errors=as_assembly_errors(errors, np.diag(amounts)))
    result = analyzed(nominal.configuration, moved, "nan")
    twists = np.array(result.seen_from(tool).contributions["assembly_errors"])
    is_possible = np.all(np.isfinite(twists), axis=1)
    if not np.all(is_possible):
        bad = [error.name for error, possible in zip(errors, is_possible, strict=True) if not possible]
        reason = f"{bad[0]} contradicts rigid parts, which cannot deform"
        if not only_effective or not np.any(is_possible):
            raise StaticsError(f"{reason}: make these parts elastic (<beam>, <joint_stiffness>)")
        left_out = "it is" if len(bad) == 1 else f"it and {len(bad) - 1} other errors are"
        warn(f"{reason}; {left_out} left out")
    wrenches = np.stack([parts["assembly_errors"] for parts in result.joint_contributions.values()], axis=1)
    twists = np.where(is_possible[:, None], twists, 0.0)
    wrenches = np.where(is_possible[:, None, None], wrenches, 0.0)
    forces, moments = np.linalg.norm(wrenches[..., :3], axis=2), np.linalg.norm(wrenches[..., 3:], axis=2)
    if np.any(result.indeterminate):
        forces, moments = np.nan_to_num(forces), np.nan_to_num(moments)
    shifts, turns = np.linalg.norm(twists[:, :3], axis=1), np.linalg.norm(twists[:, 3:], axis=1)
    forces[forces <= _NO_EFFECT / robot.length * moments.max(axis=1, keepdims=True)] = 0.0  # rounding of moments
    stress = np.maximum(forces.max(axis=1), moments.max(axis=1) / robot.length)
    size = np.maximum(shifts, turns * robot.length)
    # scale of rounding errors: the largest stiffness times the displacement
    stiff = float(np.max(np.abs(np.nan_to_num(nominal.stiffness)), initial=0.0))
    stresses = stress > max(_NO_EFFECT * float(np.max(stress)), _NO_EFFECT * stiff * float(np.max(size)))
    joints, actuated, effects = list(result.joint_contributions), robot.description.actuated, {}
    listed = stresses | (size > _NO_EFFECT * float(np.max(size))) if only_effective else np.ones(len(errors), dtype=bool)
    for k in np.flatnonzero(listed).tolist():
        worst = first_largest(forces[k])
        on_actuators = [result.actuator_contributions[name]["assembly_errors"][k] if stresses[k] else 0.0 for name in actuated]
        arrays = {"twist": twists[k], "stiffness": np.zeros((6, 6)), "actuator_forces": np.array(on_actuators)}
        at = joints[worst] if stresses[k] and forces[k, worst] else ""
        moment = float(moments[k].max()) if stresses[k] else 0.0
        effects[errors[k].name] = _effect(arrays, actuated, float(forces[k, worst]) if at else 0.0, at, moment)
    return effects


def _ordered(effects: Mapping[str, Effect], ranked_by: str) -> dict[str, Effect]:
    """Return the effects from the largest to the smallest; effects with equal forces (within 1e-4) are ordered by moment."""
    names = list(effects)
    for measure in ("moment", "force") if ranked_by == "force" else (ranked_by,):
        names = [names[k] for k in ranked([float(getattr(effects[name], measure)) for name in names], 1e-4)]
    return {name: effects[name] for name in names}


def _array(effect: PoseQuantities, name: str) -> Array:
    if name == "actuator_forces":
        return np.array([float(force) for force in effect.actuator_forces.values()])
    return np.asarray(getattr(effect, name))


def _sampled(made: Mapping[str, Array], nominal: Result, tool: Array | None) -> PoseQuantities:
    actuated = nominal.robot.description.actuated
    forces = ResultMapping({name: frozen(made["actuator_forces"][..., k]) for k, name in enumerate(actuated)})
    return quantities(frozen(made["twist"]), frozen(made["stiffness"]), forces, np.asarray(nominal.seen_from(tool).twist))


def _worst(effects: Sequence[Effect]) -> PoseQuantities:
    """Return Σ |effect|; displacement and rotation are the largest magnitudes over all signs of the effects."""
    furthest = (longest_sum(np.array([effect.twist[part] for effect in effects])) for part in LENGTHS.values())
    return _combined(effects, lambda parts: np.abs(parts).sum(axis=0), *furthest)


def _deviation(effects: Sequence[Effect], ratio: float) -> PoseQuantities:
    """Return √Σ (ratio · effect)², ratio = σ / tolerance; an effect on displacement or rotation is a magnitude."""

    def total(parts: Array) -> Array:
        return np.asarray(ratio * np.linalg.norm(parts, axis=0))

    lengths = (float(total(np.array([getattr(effect, name) for effect in effects]))) for name in LENGTHS)
    return _combined(effects, total, *lengths)


def _combined(effects: Sequence[Effect], total: Callable[[Array], Array], displacement: float, rotation: float) -> PoseQuantities:
    twist, stiffness = (frozen(total(np.array([getattr(effect, name) for effect in effects]))) for name in ("twist", "stiffness"))
    actuators = effects[0].actuator_forces
    forces = {name: frozen(total(np.array([effect.actuator_forces[name] for effect in effects]))) for name in actuators}
    return PoseQuantities(twist, np.asarray(displacement), np.asarray(rotation), stiffness, ResultMapping(forces))


def longest_sum(vectors: Array) -> float:
    """Return the largest magnitude of a sum Σ ± v of vectors (n, 3) over all signs.

    The sums lie in a zonotope; each of its faces is spanned by two of the vectors. The longest sum is a corner of a face. At this
    corner, each vector outside the face has the sign of its component along the face's normal. (G. M. Ziegler, Lectures on
    Polytopes, 1995, section 7.3.)
    """
    largest, n = float(np.abs(vectors).max(initial=0.0)), len(vectors)
    scaled = np.concatenate([vectors, np.zeros((2, 3))]) / (largest or 1.0)
    # small perturbations give faces also for coplanar or collinear vectors
    general = scaled + 1e-9 * np.random.default_rng(0).uniform(-1, 1, scaled.shape)
    longest = 0.0
    for k in range(n + 1):
        signs = np.sign(np.cross(general[k], general[k + 1 :]) @ general.T)
        for first, second in itertools.product((-1, 1), repeat=2):
            signs[:, k] = first
            signs[np.arange(n + 1 - k), np.arange(k + 1, n + 2)] = second
            longest = max(longest, float(np.linalg.norm(signs @ scaled, axis=1).max()))
    return largest * longest
