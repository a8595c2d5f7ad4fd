"""How much robots of one design differ: tolerances of their parameters, to first order and by robots made at random.

First order: the derivatives of :mod:`kinetostatics.functions.derivatives`, their sizes added for the worst case and their squares
for the standard deviation; of a vector the longest sum that signs can make, and the root mean square of its length. At random:
each robot is computed in full, all of them as one batch (:mod:`kinetostatics.design.many_robots`), or one after the other where
that cannot be recorded.
"""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyze, check_keywords
from kinetostatics.argument_checks import Keyword, check_choice, check_mapping, warn, whole_number
from kinetostatics.description.units import parse_number
from kinetostatics.design.many_robots import WANTED, ManyRobots
from kinetostatics.design.requirements import typed_unit
from kinetostatics.design.sensitivities import numbers_of, quantities_of, slopes_by
from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.functions.derivatives import Derivatives, derivatives_at
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.unit_hints import odd_tolerance
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.parametric.numbers import Number
from kinetostatics.parametric.robot import ParametricRobot, check_unit, opens_loops
from kinetostatics.printing.mappings import Named
from kinetostatics.printing.waiting import waiting
from kinetostatics.results.result import Result
from kinetostatics.results.spread import LENGTHS, Spread, SpreadQuantities, Toleranced, quantities
from kinetostatics.results.tool_point import tool_on_robot
from kinetostatics.robot import robot_of

#: Standard deviation of a parameter, as part of its tolerance, by its distribution.
DEVIATIONS = {"normal": 1 / 3, "uniform": 1 / math.sqrt(3)}
#: Robots where they are made one by one, unless more are asked for, and those that are made so where they are not.
ONE_BY_ONE, CHECKED = 300, 3


def spread(
    configuration: Configuration,
    tolerances: Mapping[str, object],
    *,
    robots: int | None = None,
    distribution: str = "normal",
    seed: int = 0,
    tool: ArrayLike | None = None,
    **analysis: Keyword,
) -> Spread:
    """Find how much robots of one design differ: worst case and standard deviation to first order, and robots made at random.

    Every parameter is off by itself: errors are independent of one another.

    Args:
        configuration: one pose. While parameters change, the coordinates stay that it was assembled with: the platform's, or the
            actuators'.
        tolerances: by how much parameters may be off to either side, by name: a number (SI), a text with a unit ``"0.1mm"``, or
            a part of the value, ``"2%"``. A name is that of a xacro argument of the robot's file, which changes all that the
            file computes from it, or of a number of one part, as :attr:`Function.parameters` has them:
            ``"rod_1.outer_diameter"``, ``"platform.mass"``, ``"revolute_1.placement.x"``, ``"prismatic_1.actuator_stiffness"``.
            ``*`` in it stands for anything: ``"rod_*.outer_diameter"`` are several parameters, each off by itself.
        robots: how many are made at random; default: 10,000, or 300 where they have to be made one by one, as with rigid
            limbs that overconstrain one another, a payload or loads on links.
        distribution: "normal", with a standard deviation of a third of the tolerance and not cut off at it, so that three robots
            in a thousand exceed each tolerance; or "uniform" within it.
        seed: of the random numbers: the same robots for the same seed.
        tool: (3,) a point of the platform, from o in its axes [m], such as a tool's tip, whose twist and stiffness are told;
            default: o. Where ``load`` acts is ``point``.
        analysis: whatever :func:`kinetostatics.analyze` takes: ``load``, ``gravity``, ``payload``, ….

    Returns:
        Effects of the parameters, worst case, standard deviation, and the quantities of every robot made at random.

    Raises:
        ArgumentError: not a single pose; there is no such parameter, or it cannot be off by so much; or a placement opens the
            loops of an overconstrained robot: :func:`kinetostatics.tolerances` tells which forces that locks in.
        StaticsError: as :func:`kinetostatics.analyze`.

    Examples:
        Rods whose diameters are within 0.1 mm, each by itself, and steel whose modulus is within 3 %, the same for all:

        >>> import kinetostatics as ks
        >>> pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.05, "ry": 0.0})
        >>> off = {"rod_*.outer_diameter": "0.1mm", "youngs_modulus": "3%"}
        >>> s = ks.spread(pose, off, load=[0, 0, -500, 0, 0, 0], robots=3000)
        >>> len(s.parameters), len(s)
        (4, 3000)
        >>> mean, deviation, low, high = s.sampled("displacement")
        >>> bool(abs(deviation / s.standard_deviation.displacement - 1) < 0.05)
        True
        >>> max(s.parameters, key=s.share)
        'youngs_modulus'
    """
    check_keywords(spread, analysis)
    if not isinstance(configuration, Configuration) or configuration.shape != ():
        raise ArgumentError("spread wants a single pose: make one with robot.assemble(…)")
    check_choice("distribution", distribution, tuple(DEVIATIONS))
    count = None if robots is None else whole_number("robots", robots, 2)
    seed = whole_number("seed", seed, 0)
    robot = robot_of(configuration)
    place = tool_on_robot(tool, robot)
    family = ParametricRobot(robot)
    numbers, amounts = _read_tolerances(family, tolerances)
    result = analyze(configuration, **analysis)
    if result.shape != ():
        raise ArgumentError("spread wants a single pose and a single load")
    derivatives = derivatives_at(result, analysis, place, WANTED)
    effects = _first_order(result, derivatives, numbers, amounts, analysis, place)
    sigma = DEVIATIONS[distribution] * amounts
    parameters = {
        item.name: Toleranced(item.name, item.value, item.unit, float(amount), float(one))
        for item, amount, one in zip(numbers, amounts, sigma, strict=True)
    }
    count = count or (10_000 if derivatives is not None else ONE_BY_ONE)
    units = np.random.default_rng(seed).standard_normal if distribution == "normal" else _uniform(seed)
    values = sigma[:, None] * units((len(numbers), count))
    worst, deviation = _worst(list(effects.values())), _deviation(list(effects.values()), sigma / amounts)
    samples, difference = _samples(result, derivatives, family, numbers, values, analysis, float(deviation.displacement), place)
    nominal = np.array([item.value for item in numbers])
    return Spread(
        result,
        Named(parameters),
        Named(effects),
        worst,
        deviation,
        samples,
        Named({item.name: frozen(row) for item, row in zip(numbers, values + nominal[:, None], strict=True)}),
        distribution,
        seed,
        derivatives is not None,
        difference,
        place,
    )


def _read_tolerances(family: ParametricRobot, tolerances: Mapping[str, object]) -> tuple[list[Number], Array]:
    """Return what may be off, the file's arguments first, and by how much.

    Raises:
        ArgumentError: they make no sense.
    """
    check_mapping("tolerances", tolerances, '{"rod_*.outer_diameter": "0.1mm"}')
    if not tolerances:
        raise ArgumentError('tolerances has nothing in it; it must be such as {"rod_*.outer_diameter": "0.1mm"}')
    found = []
    for pattern, number in family.select(list(tolerances), "tolerances"):
        given = tolerances[pattern]
        found.append((number, amount := _amount(number, given)))
        if number.unit == "m" and not (isinstance(given, str) and ("%" in given or typed_unit(given))):
            for hint in odd_tolerance(number.name, amount, number.value, family.robot.zero_size):
                warn(hint)
    found.sort(key=lambda item: item[0].read is None)
    return [item[0] for item in found], np.array([item[1] for item in found])


def _amount(number: Number, given: object) -> float:
    """Return a tolerance in SI.

    Raises:
        ArgumentError: it is no positive number, or of another kind than the parameter.
    """
    what = f"tolerances: {number.name}"
    amount = math.nan
    if isinstance(given, str) and given.rstrip().endswith("%"):
        amount = 0.01 * abs(number.value) * parse_number(given.rstrip()[:-1], "number", what)
        if number.value == 0:
            raise ArgumentError(f"{what} is {given!r}, and a part of a number that is zero is nothing: give it with a unit")
    elif isinstance(given, str):
        amount = parse_number(given, "", what)
        check_unit(number, typed_unit(given), "tolerances")
    elif isinstance(given, (int, float, np.number)) and not isinstance(given, bool):
        amount = float(given)
    if not 0 < amount < math.inf:
        raise ArgumentError(f"{what} is {given!r}; it must be a positive number such as '0.1mm' or '2%'")
    return amount


def _uniform(seed: int) -> partial[Array]:
    return partial(np.random.default_rng(seed).uniform, -math.sqrt(3), math.sqrt(3))


# ---- first order -----------------------------------------------------------------------------------------------------------


def _first_order(
    nominal: Result,
    derivatives: Derivatives | None,
    numbers: Sequence[Number],
    amounts: Array,
    analysis: Mapping[str, Keyword],
    tool: Array | None,
) -> dict[str, SpreadQuantities]:
    """Return what each parameter does alone when it is off by its tolerance, to first order."""
    driven, found = nominal.robot.description.driven, {}
    for number, amount in zip(numbers, amounts.tolist(), strict=True):
        slopes, _ = slopes_by(number, nominal, derivatives, analysis, tool, WANTED)
        if not np.all(np.isfinite(slopes["twist"])):
            raise opens_loops(number.name)
        found[number.name] = _quantities({name: amount * slope for name, slope in slopes.items()}, driven, np.zeros(6))
    return found


def _quantities(arrays: Mapping[str, Array], driven: Sequence[str], origin: Array) -> SpreadQuantities:
    forces = Named({name: frozen(arrays["actuator_forces"][..., k]) for k, name in enumerate(driven)})
    return quantities(frozen(arrays["twist"]), frozen(arrays["stiffness"]), forces, origin)


def _worst(effects: Sequence[SpreadQuantities]) -> SpreadQuantities:
    """Return Σ |effect|, and how far the platform is off at most."""
    furthest = (longest_sum(np.array([item.twist[part] for item in effects])) for part in LENGTHS.values())
    return _combined(effects, lambda parts: np.abs(parts).sum(axis=0), *furthest)


def _deviation(effects: Sequence[SpreadQuantities], ratios: Array) -> SpreadQuantities:
    """Return √Σ (ratio · effect)²; of displacement and rotation that is the root mean square of their lengths."""

    def total(parts: Array) -> Array:
        return np.asarray(np.linalg.norm(parts * ratios.reshape(-1, *(1,) * (parts.ndim - 1)), axis=0))

    lengths = (float(total(np.array([getattr(item, name) for item in effects]))) for name in LENGTHS)
    return _combined(effects, total, *lengths)


def _combined(
    effects: Sequence[SpreadQuantities], total: Callable[[Array], Array], displacement: float, rotation: float
) -> SpreadQuantities:
    twist, stiffness = (frozen(total(np.array([getattr(item, name) for item in effects]))) for name in ("twist", "stiffness"))
    actuators = effects[0].actuator_forces
    forces = {name: frozen(total(np.array([item.actuator_forces[name] for item in effects]))) for name in actuators}
    return SpreadQuantities(twist, np.asarray(displacement), np.asarray(rotation), stiffness, Named(forces))


def longest_sum(vectors: Array) -> float:
    """Return the length of the longest sum Σ ± v of vectors (n, 3), each taken with one of two signs.

    All such sums lie in a zonotope, of which two vectors span a face: the longest one is a corner, where the others have the sign
    of their component along the face's normal. (G. M. Ziegler, Lectures on Polytopes, 1995, section 7.3.)
    """
    largest, n = float(np.abs(vectors).max(initial=0.0)), len(vectors)
    own = np.concatenate([vectors, np.zeros((2, 3))]) / (largest or 1.0)
    # vectors in a plane or along a line have faces too, if they are ever so little off
    general = own + 1e-9 * np.random.default_rng(0).uniform(-1, 1, own.shape)
    longest = 0.0
    for k in range(n + 1):
        signs = np.sign(np.cross(general[k], general[k + 1 :]) @ general.T)
        for first, second in itertools.product((-1, 1), repeat=2):
            signs[:, k] = first
            signs[np.arange(n + 1 - k), np.arange(k + 1, n + 2)] = second
            longest = max(longest, float(np.linalg.norm(signs @ own, axis=1).max()))
    return largest * longest


# ---- robots made at random -------------------------------------------------------------------------------------------------


def _samples(
    nominal: Result,
    derivatives: Derivatives | None,
    family: ParametricRobot,
    numbers: Sequence[Number],
    values: Array,
    analysis: Mapping[str, Keyword],
    deviation: float,
    tool: Array | None,
) -> tuple[SpreadQuantities, float]:
    """Return the quantities of all robots, and by how many standard deviations those that were made one by one differ."""
    N, own = values.shape[1], numbers_of(nominal.configuration, nominal, tool, WANTED)
    if derivatives is not None:
        with waiting(f"computing {N:,} robots"):
            made = ManyRobots(derivatives, family, numbers, np.max(np.abs(values), axis=1)).at(values)
        found = {name: np.moveaxis(array, -1, 0) for name, array in made.items()}
    else:
        found = {name: np.full((N, *array.shape), np.nan) for name, array in own.items()}
    is_lost = np.isnan(found["twist"][:, 0])
    checked, lost = np.flatnonzero(~is_lost)[:CHECKED], np.flatnonzero(is_lost)
    worst = math.nan
    for done, k in enumerate([*checked.tolist(), *lost.tolist()]):
        off = {item.name: float(by) for item, by in zip(numbers, values[:, k], strict=True)}
        with waiting(f"making robots one by one: {done} of {checked.size + lost.size}"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                one = quantities_of(family.off(off), nominal, analysis, tool, WANTED)
            except KinetostaticsError:  # there is no such robot
                continue
        if done < checked.size:
            apart = float(np.linalg.norm((one["twist"] - found["twist"][k])[:3]))
            worst = max(apart / deviation if deviation > 0 else 0.0, 0.0 if math.isnan(worst) else worst)
        else:
            for name, array in one.items():
                found[name][k] = array
    return _quantities(found, nominal.robot.description.driven, own["twist"]), worst
