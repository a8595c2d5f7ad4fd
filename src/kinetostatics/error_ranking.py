"""What every small error of every joint and beam does to the platform, and which forces it locks into the robot.

One at a time (:mod:`kinetostatics.statics.assembly_errors`), nothing loaded: as all is linear, the effects of several
errors add up.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyze
from kinetostatics.argument_checks import check_choice, positive, warn
from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.unit_hints import odd_angle, odd_tolerance
from kinetostatics.math.arrays import Array
from kinetostatics.math.ordering import first_largest, ranked
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.results.tolerances import Tolerance, Tolerances
from kinetostatics.results.tool_point import seen, tool_on_robot
from kinetostatics.robot import robot_of

#: What the table may be ranked by.
RANKINGS = ("force", "displacement", "rotation")
#: Part of the largest effect of all errors below which one counts as none: along a joint's own freedoms.
_NO_EFFECT = 1e-9


def tolerances(
    configuration: Configuration,
    length: float = 1e-4,
    angle: float = 1e-3,
    temperature: float = 1.0,
    *,
    by: str | None = None,
    tool: ArrayLike | None = None,
) -> Tolerances:
    """Rank what errors of joints and beams do: pose errors, and forces locked into an overconstrained robot.

    Loads and a payload are no arguments, because they would change no number: what errors do is added to what loads do. Both
    together are ``analyze(pose, load, assembly_errors=…, payload=…)``.
    Tolerances of sizes and materials, whose effect does depend on the
    load, are :func:`kinetostatics.spread`.

    Args:
        configuration: one pose.
        length: error of a joint along the axes of its frame, and of a beam's length [m].
        angle: error of a joint about the axes of its frame [rad].
        temperature: rise of one beam's temperature [K], for beams with a thermal expansion.
        by: what the table is ranked by: "force" (of equal ones, by the moment), "displacement" or "rotation"; default: force,
            where any error locks in a force or moment.
        tool: (3,) a point of the platform, from o in its axes [m], such as a tool's tip, whose displacement is told; default: o.

    Returns:
        One row for each error that has an effect: a joint's errors along its own freedoms have none.

    Raises:
        ArgumentError: not a single pose, or an amount that is not a positive number.
        SingularPoseError: with the actuators locked the platform can still move.

    Examples:
        The error that locks the largest force into an overconstrained robot:

        >>> import kinetostatics as ks
        >>> worst = ks.tolerances(ks.load_robot("2pru_upr").assemble()).rows[0]
        >>> worst.name, worst.error, worst.amount, worst.at, round(worst.force)  # [rad], [N]
        ('revolute_1', 'ry', 0.001, 'prismatic_1', 261)
    """
    if not isinstance(configuration, Configuration) or configuration.shape != ():
        raise ArgumentError("tolerances wants a single pose: make one with robot.assemble(…)")
    if by is not None:
        check_choice("by", by, RANKINGS)
    length, angle, temperature = positive("length", length), positive("angle", angle), positive("temperature", temperature)
    robot = configuration.robot
    for hint in (*odd_tolerance("length", length, 0.0, robot.zero_size), *odd_angle("angle", angle)):
        warn(hint)
    place = tool_on_robot(tool, robot_of(configuration))
    errors = _errors(configuration, length, angle, temperature)
    if not errors:
        return Tolerances(configuration, (), by or "displacement", place)
    gravity = (
        0.0,
        0.0,
        -9.81 if robot.description.springs else 0.0,
    )  # where there are springs weights have part in the stiffness
    analyze(configuration, gravity=gravity)  # which raises at a singular pose
    found: dict[str, dict[str, Array]] = {}
    for row, (name, _, error, amount) in enumerate(errors):
        if error in ("length", "temperature"):
            found.setdefault(name, {}).setdefault(error, np.zeros(len(errors)))[row] = amount
        else:
            twist = found.setdefault(name, {}).setdefault("twist", np.zeros((len(errors), 6)))
            twist[row, COMPONENTS.index(error)] = amount
    assembly_errors = {name: {**own, "frame": "joint"} if "twist" in own else own for name, own in found.items()}
    result = analyze(configuration, gravity=gravity, assembly_errors=assembly_errors, on_failure="nan")
    loose = np.any(result.indeterminate)
    # of these alone: springs pull without any load
    twists = seen(result, place).contributions["assembly_errors"]
    wrenches = np.stack([parts["assembly_errors"] for parts in result.joint_contributions.values()], axis=1)
    forces, moments = np.linalg.norm(wrenches[..., :3], axis=2), np.linalg.norm(wrenches[..., 3:], axis=2)
    if loose:
        forces, moments = np.nan_to_num(forces), np.nan_to_num(moments)
    names = list(result.joint_contributions)
    shifts, turns = np.linalg.norm(twists[:, :3], axis=1), np.linalg.norm(twists[:, 3:], axis=1)
    forces[forces <= _NO_EFFECT / robot.length * moments.max(axis=1, keepdims=True)] = 0.0  # the rounding of moments
    stress = np.maximum(forces.max(axis=1), moments.max(axis=1) / robot.length)
    effect = np.maximum(shifts, turns * robot.length)
    # unit loads tell which forces are more than the rounding of locked ones
    stiff = float(np.max(np.abs(np.nan_to_num(result.stiffness[0])), initial=0.0))
    no_force = stress <= max(_NO_EFFECT * float(np.max(stress)), _NO_EFFECT * stiff * float(np.max(effect)))
    keep = ~no_force | (effect > _NO_EFFECT * float(np.max(effect)))
    rows = []
    for row in np.flatnonzero(keep).tolist():
        name, kind, error, amount = errors[row]
        worst = first_largest(forces[row])
        rows.append(
            Tolerance(
                name,
                kind,
                error,
                amount,
                tuple(twists[row].tolist()),
                float(shifts[row]),
                float(turns[row]),
                0.0 if no_force[row] else float(forces[row, worst]),
                "" if no_force[row] or not forces[row, worst] else names[worst],
                0.0 if no_force[row] else float(moments[row].max()),
                {
                    actuator: 0.0 if no_force[row] else float(parts["assembly_errors"][row])
                    for actuator, parts in result.actuator_contributions.items()
                },
            )
        )
    ranked_by = by or ("force" if any(item.force > 0 or item.moment > 0 for item in rows) else "displacement")
    for measure in (
        ("moment", "force") if ranked_by == "force" else (ranked_by,)
    ):  # of forces that are printed alike the larger moment is first
        rows = [rows[k] for k in ranked([getattr(item, measure) for item in rows], 1e-4)]
    return Tolerances(configuration, tuple(rows), ranked_by, place)


def _errors(configuration: Configuration, length: float, angle: float, temperature: float) -> list[tuple[str, str, str, float]]:
    """Return name, kind, error and amount of all errors of what holds the platform."""
    robot = configuration.robot
    found: list[tuple[str, str, str, float]] = []
    for limb in robot.topology.limbs:
        for edge in limb.edges:
            if edge.joint is not None:
                for k, component in enumerate(COMPONENTS):
                    found.append((edge.joint, "joint", component, length if k < 3 else angle))
            elif edge.beam is not None:
                found.append((edge.beam, "beam", "length", length))
                if robot.description.beams[edge.beam].thermal_expansion:
                    found.append((edge.beam, "beam", "temperature", temperature))
    return found
