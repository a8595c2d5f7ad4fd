"""Derivatives of an analysis with respect to the arguments of the robot's file.

The file may compute anything from its arguments, so that its constants are differenced; the mathematics behind them is exact
(:mod:`kinetostatics.functions.derivatives`). Where that is not to be had, as with rigid limbs, misfits or loads on links, the
robot is read anew with the argument a little larger and smaller, and the same pose analysed. What the stiffness of a beam, a
joint or a drive does is known without any difference: :attr:`kinetostatics.Result.source_contributions`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyze, check_keywords
from kinetostatics.argument_checks import names_in
from kinetostatics.design.exact import by_argument, derivatives_at
from kinetostatics.design.variants import Variants, same_pose, variants_of
from kinetostatics.exceptions import ArgumentError, RobotFileError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.printing.mappings import Named
from kinetostatics.results.result import Result
from kinetostatics.results.seen import seen
from kinetostatics.results.sensitivities import Sensitivities, Sensitivity
from kinetostatics.results.tool_point import PointResult, point_on_robot
from kinetostatics.robot import robot_of

#: Half the distance between the two values of a parameter, as part of it; of one that is zero, of 1. Truncation and rounding then
#: leave errors of about equal size, some 1e-8 of what is differentiated.
STEP = 3e-5
#: Changes by the whole value of a parameter below this part of what is changed are rounding.
NOTHING = 1e-7


def sensitivities(
    configuration: Configuration, by: Sequence[str] | None = None, *, tool: ArrayLike | None = None, **analysis: Any
) -> Sensitivities:
    """Find what each parameter of the robot's file does to twist, stiffness, drive forces and mass: what to stiffen first.

    Args:
        configuration: a pose or a batch of poses of a robot that was read from a file. While a parameter changes, the coordinates
            stay that the pose was assembled with: the platform's, or the drives'.
        by: names of xacro arguments of the file; default: all that are numbers and change anything.
        tool: (3,) a point of the platform, from o in its axes [m], such as a tool's tip, whose twist and stiffness are
            differentiated; default: o. Where ``load`` acts is ``point``.
        analysis: whatever :func:`kinetostatics.analyze` takes: ``load``, ``gravity``, ``point``, ….

    Returns:
        Derivatives per unit of each parameter, exact but for the file's constants, which are differenced; where
        :attr:`Sensitivity.exact` is False all is (to about 1e-7 of the quantity for a change by the parameter's whole value). And
        per part of the stiffness of each beam, elastic joint and drive, exact.

    Raises:
        ArgumentError: there is no such parameter, or the robot is not what its file says.
        RobotFileError: a parameter that is named makes no robot when it is changed a little.
        StaticsError: as :func:`kinetostatics.analyze`, for one pose.

    Example:
        Half of the modulus is twice the twist, as far as the first derivative tells:

        >>> import kinetostatics as ks
        >>> pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.05, "ry": 0.0})
        >>> s = ks.sensitivities(pose, by=["youngs_modulus", "rod_diameter"])
        >>> s["rod_diameter"].unit, s["rod_diameter"].twist.shape
        ('m', (6,))
        >>> e = s["youngs_modulus"]
        >>> bool(abs(e.twist[2] * e.value / s.result.twist[2] + 1) < 1e-6)
        True
    """
    check_keywords(sensitivities, analysis)
    if not isinstance(configuration, Configuration):
        raise ArgumentError(f"sensitivities wants a pose, not {configuration!r}: make one with robot.assemble(…)")
    variants = variants_of(robot_of(configuration))
    if by is not None:
        by = names_in("by", by, '["rod_diameter"]')
        variants.check(by)
    place = None if tool is None else point_on_robot("tool", tool, robot_of(configuration))
    result = analyze(configuration, **analysis)
    derivatives = derivatives_at(configuration, result, analysis, place)
    found: dict[str, Sensitivity] = {}
    skipped: dict[str, str] = {}
    for name in variants.numbers if by is None else by:
        try:
            exact = None
            if derivatives is not None:
                try:
                    exact = by_argument(derivatives, variants, name, configuration.shape)
                except ArgumentError:
                    derivatives = None
                except RobotFileError:
                    if variants.numbers[name] != 0:
                        raise  # else less than nothing is wrong, as of a mass: it is differenced to one side
            found[name] = _sensitivity(variants, configuration, analysis, name, exact, place)
        except RobotFileError as error:
            if by is not None:
                raise
            skipped[name] = str(error)
    sources = {name: twist for kind in result.source_contributions.values() for name, twist in kind.items()}
    tip = seen(result, place)
    if isinstance(tip, PointResult):
        sources = {name: tip.moved(twist) for name, twist in sources.items()}
    every = Sensitivities(result, Named(found), Named(sources), Named(skipped), place)
    if by is None:
        found = {name: item for name, item in found.items() if _does_anything(item, _numbers(result, place))}
    order = sorted(found, key=lambda name: -abs(every.effect(name)[0]))
    return replace(every, parameters=Named({name: found[name] for name in order}))


def _sensitivity(
    variants: Variants,
    configuration: Configuration,
    analysis: Mapping[str, Any],
    name: str,
    exact: Mapping[str, Array] | None,
    tool: Array | None,
) -> Sensitivity:
    value, driven = variants.numbers[name], robot_of(configuration).description.driven
    step = STEP * (abs(value) or 1.0)
    known = exact is not None and all(np.all(np.isfinite(array)) for array in exact.values())
    given = {key: item for key, item in analysis.items() if key != "on_failure"}

    def numbers(there: float) -> dict[str, Array]:
        robot = variants.robot({name: there})
        if known and not any(beam.telescopic for beam in robot.beams.values()):
            return {"mass": np.broadcast_to(robot.weights.masses(robot.zero_frames).sum(), configuration.shape)}
        pose = same_pose(configuration, robot)
        return {"mass": _mass(pose)} if known else _numbers(analyze(pose, on_failure="nan", **given), tool)

    above = numbers(value + step)
    try:
        below = numbers(value - step)
        slope = {key: np.asarray((above[key] - below[key]) / (2 * step)) for key in above}
    except RobotFileError:
        if value != 0:
            raise
        here, further = numbers(0.0), numbers(2 * step)
        slope = {key: np.asarray((4 * above[key] - 3 * here[key] - further[key]) / (2 * step)) for key in above}
    if known and exact is not None:
        slope |= {key: exact[key] for key in ("twist", "stiffness", "compliance")}
        for k, drive in enumerate(driven):
            slope |= {f"force of {drive}": exact["actuator_forces"][..., k], f"position of {drive}": exact["actuators"][..., k]}
    return Sensitivity(
        name,
        value,
        variants.unit(name),
        frozen(slope["twist"]),
        frozen(slope["stiffness"]),
        frozen(slope["compliance"]),
        Named({drive: frozen(slope[f"force of {drive}"]) for drive in driven}),
        Named({drive: frozen(slope[f"position of {drive}"]) for drive in driven}),
        frozen(np.array(np.broadcast_to(slope["mass"], slope["twist"].shape[:-1]))),
        known,
    )


def _numbers(result: Result, tool: Array | None) -> dict[str, Array]:
    """Return everything that is differentiated."""
    configuration, tip = result.configuration, seen(result, tool)
    return {
        "twist": tip.twist,
        "stiffness": tip.stiffness,
        "compliance": tip.compliance,
        "mass": np.asarray(np.broadcast_to(_mass(configuration), result.shape)),
        **{f"force of {name}": force for name, force in result.actuator_forces.items()},
        **{f"position of {name}": position for name, position in configuration.actuators.items()},
    }


def _mass(configuration: Configuration) -> Array:
    return configuration.robot.weights.masses(configuration.frames).sum(axis=0).reshape(configuration.shape)


def _does_anything(item: Sensitivity, whole: Mapping[str, Array]) -> bool:
    """Return whether a parameter changes twist, forces or mass by more than rounding."""
    part = abs(item.value) or 1.0
    pairs = [(item.twist, whole["twist"]), (item.mass, whole["mass"])]
    pairs += [(force, whole[f"force of {name}"]) for name, force in item.actuator_forces.items()]
    return any(_largest(part * slope) > NOTHING * _largest(size) for slope, size in pairs)


def _largest(array: Array) -> float:
    return float(np.max(np.abs(np.nan_to_num(array)), initial=0.0))
