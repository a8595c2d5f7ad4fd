"""Table of quantities: name, symbol, unit, axes, description and computation of every result of an analysis.

Results, JSON, Datasets, functions, compiled code, exported C and the glossary use the names and descriptions of this table. A new
quantity needs an entry here and an attribute in the class of results.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.math.arrays import Array, Mask
from kinetostatics.math.screws import COMPONENTS, TWIST_UNITS, WRENCH_UNITS, Kind
from kinetostatics.statics.joint_wrenches import actuator_forces
from kinetostatics.statics.link_loads import sum_of
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.solution import Solution
from kinetostatics.statics.springs import contribution_names, placed_springs
from kinetostatics.status import FACTS, REPORTED

#: Kinds of axes of a grid along which a quantity varies: all, those that change the pose, or those that change the robot.
EVERYTHING, POSES, ROBOTS = ("parameter", "case", "coordinate"), ("parameter", "coordinate"), ("parameter",)
#: Units of quantities whose unit differs along an axis; the keys are the coordinates of a Dataset with these units.
UNITS: Mapping[str, str] = {
    "component_unit": "m, rad",
    "stiffness_unit": "N/m, N·m/rad",
    "compliance_unit": "m/N, rad/(N·m)",
    "actuator_force_unit": "N, N·m",
    "actuator_position_unit": "m, rad",
    "wrench_component_unit": "N, N·m",
    "wrench_unit": "N, N·m",
    "attached_wrench_unit": "N, N·m",
    "platform_coordinate_unit": "m, rad",
    "joint_coordinate_unit": "1, m, rad",
}


@dataclass(frozen=True)
class Entry:
    """A quantity of the results of an analysis.

    Attributes:
        words: description, with reference point and axes.
        dims: names of the axes of its array that follow the batch axes.
        unit: unit, or key of :data:`UNITS` for the units along an axis.
        of: function that computes its array (*dims, N); None: the attribute of the result computes it.
        moves_as: transformation to another reference point, for a quantity at o.
        varies: kinds of axes of a grid along which it varies.
        variable: name in a Dataset, if any.
        group: group of outputs of :func:`kinetostatics.sweep` to which the variable belongs; "always": in every map.
        symbol, equation: symbol and equation in the paper, or the section of the method page.
        dtype: data type of its numbers.
    """

    words: str
    dims: tuple[str, ...] = ()
    unit: str = ""
    of: Callable[[RobotStatics, Solution], Array] | None = None
    moves_as: Kind | None = None
    varies: tuple[str, ...] = EVERYTHING
    variable: str = ""
    group: str = "default"
    symbol: str = ""
    equation: str = ""
    dtype: type[np.generic] = np.float64

    @property
    def units(self) -> str:
        return UNITS.get(self.unit, self.unit)

    @property
    def description(self) -> str:
        return f"{self.words} [{self.units}]"


def _platform_wrench(robot: RobotStatics, solution: Solution) -> Array:
    wrench = solution.load + solution.platform_weight
    return wrench + sum_of(solution.applied, robot.topology.platform.attachments) if solution.applied else wrench


def _spring_forces(robot: RobotStatics, solution: Solution) -> Array:
    tensions = [spring.tension for spring in placed_springs(robot, solution.frames)]
    return np.stack(tensions) if tensions else np.empty((0, solution.o.shape[1]))


def _actuator_forces(robot: RobotStatics, solution: Solution) -> Array:
    forces = actuator_forces(robot, solution)
    return np.stack([forces[name] for name in robot.description.actuated]) if forces else np.empty((0, solution.o.shape[1]))


def _is_usual(robot: RobotStatics, solution: Solution) -> Mask:
    """(N,) True where forces are determinate, wrench bases are regular, and limbs have their usual ranks."""
    return ~solution.indeterminate & ~solution.basis_degenerate & ~solution.doubtful


def _of_limbs(robot: RobotStatics, solution: Solution, labels: str, pick: Callable[[int], Array]) -> Array:
    """(Σ k, N) quantity of all limbs, k rows for the wrenches of each; NaN where the labels do not describe the wrench basis.

    Args:
        robot, solution: robot and equilibrium.
        labels: "labels" or "attached_labels", attribute of a group of limbs with the labels of the wrenches.
        pick: function that returns the quantity (k, g, N) of the g limbs of a group, given by its index.
    """
    rows = [np.empty((0, solution.o.shape[1]))]
    for group in robot.groups:
        for limb, limb_labels in zip(group.limbs, getattr(group, labels), strict=True):
            number, position = solution.places[limb.name]
            statics = solution.statics[number]
            if statics.group.at_one_pose:
                rows.append(np.full((len(limb_labels), solution.o.shape[1]), np.nan))
            else:
                rows.append(np.where(statics.degenerate[position], np.nan, pick(number)[:, position]))
    return np.concatenate(rows)


def _intensities(robot: RobotStatics, solution: Solution) -> Array:
    def pick(k: int) -> Array:
        return np.where(solution.undetermined[k], np.nan, solution.intensities[k].sum(axis=1))

    return _of_limbs(robot, solution, "labels", pick)


_COMPONENT, _MATRIX, _ACTUATOR = ("component",), ("component", "component_2"), ("actuator",)
_WRENCH, _TWIST = "wrench_component_unit", "m, rad"

# fmt: off
#: All quantities, in the order of a Dataset, by their paths from a result; those that begin with "sweep" exist in maps only.
QUANTITIES: Mapping[str, Entry] = {
    "status": Entry("most severe state of the pose", variable="status", group="always", dtype=np.int8),
    **{name: Entry(fact.words, variable=name, group="always" if name in REPORTED else "default", dtype=np.bool_)
        for name, fact in FACTS.items()},
    "sweep.mode": Entry("assembly mode that reaches the pose", varies=POSES, variable="mode", group="always", dtype=np.int8),
    "twist": Entry("displacement of o and rotation of the platform, world axes", _COMPONENT, "component_unit",
        lambda robot, solution: solution.twists.sum(axis=1), "twist", variable="twist", symbol="Δ", equation="(12)"),
    "contributions": Entry("contributions of load, platform weight and weight of each limb to the twist", ("source", "component"),
        "component_unit", lambda robot, solution: np.swapaxes(solution.twists, 0, 1), "twist", variable="contribution"),
    "sweep.gravity_mechanisms": Entry("contribution of gravity to the twist by each mechanism, all limbs together",
        ("mechanism", "component"),
        "component_unit", moves_as="twist", variable="gravity_mechanism", group="gravity_mechanisms"),
    "actuator_forces": Entry("force or torque of the actuator, positive along its joint", _ACTUATOR, "actuator_force_unit",
        _actuator_forces, variable="actuator_force", symbol="f", equation="(17)"),
    "sweep.actuator_gravity_mechanisms": Entry("contribution of gravity to the actuator force by each mechanism",
        ("actuator", "mechanism"),
        "actuator_force_unit", variable="actuator_gravity_mechanism", group="gravity_mechanisms"),
    "actuator_contributions": Entry("part of the actuator force due to each contribution to the twist", ("actuator", "source"),
        "actuator_force_unit", variable="actuator_contribution", group="gravity_mechanisms"),
    "limbs.intensities": Entry("intensity of the constraint wrench", ("wrench",), "wrench_unit",
        variable="intensity", symbol="W_ic", equation="(11)"),
    "limbs.attached_intensities": Entry("intensity of the gravity-attached constraint wrench", ("attached_wrench",),
        "attached_wrench_unit", variable="attached_intensity", symbol="W_ig", equation="(3)"),
    "stiffness": Entry("tangent stiffness at o, actuators locked, world axes", _MATRIX, "stiffness_unit",
        lambda robot, solution: solution.stiffness, "stiffness", POSES, "stiffness", symbol="K", equation="(12)"),
    "compliance": Entry("compliance at o, actuators locked, world axes", _MATRIX, "compliance_unit",
        lambda robot, solution: solution.compliance, "compliance", POSES, "compliance", symbol="C", equation="(12)"),
    "configuration.actuators": Entry("coordinate of the actuated joint", _ACTUATOR, "actuator_position_unit",
        varies=POSES, variable="actuator_position"),
    "sweep.corrections": Entry("correction of the actuator that brings the loaded platform to its target pose", _ACTUATOR,
        "actuator_position_unit", variable="actuator_correction", group="compensation"),
    "sweep.residual_error": Entry("pose error of the loaded platform at the corrected actuators", _COMPONENT,
        "component_unit", moves_as="twist", variable="residual_error", group="compensation"),
    "sweep.frequencies": Entry("natural frequency, actuators locked", ("natural_mode",), "Hz",
        varies=POSES, variable="frequency", group="modes"),
    "sweep.zero_frequencies": Entry("number of motions that nothing resists, of frequency zero", (), "1",
        varies=POSES, variable="zero_frequencies", group="modes"),
    "sweep.payload_capacity": Entry("largest mass before an effort, yield or buckling is reached", (), "kg",
        variable="payload_capacity", group="capacity"),
    "spring_forces": Entry("tension of the spring, negative in compression", ("spring",), "N", _spring_forces,
        varies=POSES, variable="spring_force"),
    "sweep.platform_pose": Entry("coordinates of the platform before it deforms", ("platform_coordinate",),
        "platform_coordinate_unit", varies=POSES, variable="platform_pose", group="always"),
    "configuration.q": Entry("coordinates of Pinocchio's model, see Robot.configuration", ("joint_coordinate",),
        "joint_coordinate_unit", varies=POSES, variable="q", group="always"),
    "robot.length": Entry("mean distance of the limbs' outer joints from o", (), "m",
        varies=ROBOTS, variable="characteristic_length", group="always"),
    "beams.stress": Entry("largest von Mises stress of the beam", ("beam",), "Pa", variable="beam_stress", group="beams"),
    "beams.euler_ratio": Entry("ratio of the forces to those at which the member buckles", ("beam",), "1",
        variable="beam_euler_ratio", group="beams"),
    "beams.deflection": Entry("largest displacement of the beam's centre line", ("beam",), "m",
        variable="beam_deflection", group="beams"),
    "utilization": Entry("ratio of the actuator's force to its limit of effort; NaN where the file states none", _ACTUATOR, "1",
        variable="actuator_utilization", group="limits"),
    "margins.smallest": Entry("smallest safety factor: against the efforts of actuators, yield of beams, and buckling", (), "1",
        variable="safety_factor", group="limits"),
    "margins.limit_index": Entry("limit with the smallest safety factor", variable="limited_by", group="limits", dtype=np.int16),
    "beams.section_wrenches": Entry("N, V_y, V_z, T, M_y, M_z in beam axes, exerted by the outer part on the inner one",
        ("beam", "station", "component"), _WRENCH),
    "configuration.residual": Entry("largest gap of a loop", (), _TWIST, varies=POSES),
    "gravity": Entry("gravity, world axes", ("axis",), "m/s²", lambda robot, solution: solution.gravity),
    "load": Entry("external force and moment on the platform about o, world axes", _COMPONENT, _WRENCH,
        lambda robot, solution: solution.load),
    "platform_weight": Entry("weight of the platform and its branches, about o, world axes", _COMPONENT, _WRENCH,
        lambda robot, solution: solution.platform_weight),
    "link_loads": Entry("load on the link, or weight of the payload, about o, world axes", ("source", "component"), _WRENCH),
    "platform_wrench": Entry("load, the platform's weight and loads on its links, about o, world axes", _COMPONENT, _WRENCH,
        _platform_wrench, symbol="W", equation="(5)"),
    "base_wrench": Entry("wrench of the ground on the robot, about the base link's origin, world axes", _COMPONENT, _WRENCH),
    "joint_wrenches": Entry("wrench of the joint's base side on its platform side, at the joint's centre, world axes",
        ("joint", "component"), _WRENCH),
    "strain_energy": Entry("strain energy of all beams and elastic joints", (), "J"),
    "mechanism_contributions": Entry("contribution of the limb's weight to the twist by each mechanism, Eq. (12)",
        ("limb", "mechanism", "component"), _TWIST),
    "source_contributions": Entry("twist due to each beam, elastic joint, actuator and assembly error; they sum to the twist",
        ("kind", "part", "component"), _TWIST),
    "part_contributions": Entry("twist due to each part of a limb that consists of parts in series",
        ("limb", "part", "component"), _TWIST),
    "actuator_mechanism_contributions": Entry("contribution of the limb's weight to the actuator force by the two mechanisms",
        ("actuator", "limb", "mechanism"), "actuator_force_unit"),
    "paper_forces": Entry("f_i1, f_i2, … intensities of limb i, f_ia axial force at its rod's base end, tension positive",
        ("limb", "force"), "wrench_unit"),
    "beam_contributions": Entry("displacement and rotation of the beam's stations due to each contribution, world axes",
        ("beam", "source", "station", "component"), _TWIST),
    "link_contributions": Entry("twist of the rigid link due to each contribution, at the link's origin, world axes",
        ("link", "source", "component"), _TWIST),
    "limbs.constraint_wrenches": Entry("unit constraint wrenches acting on the limb, about o, world axes",
        ("component", "wrench"), "1, m", symbol="J_ic", equation="(2)"),
    "limbs.attached_wrenches": Entry("unit attached wrenches acting on the limb, about o, world axes",
        ("component", "attached_wrench"), "1, m", symbol="J_ig", equation="(4)"),
    "limbs.compliance": Entry("compliance of the limb along its constraint wrenches", ("wrench", "wrench_2"),
        "m/N, rad/(N·m)", symbol="C_ic", equation="(1), (13)"),
    "limbs.stiffness": Entry("stiffness of the limb along its constraint wrenches, the inverse", ("wrench", "wrench_2"),
        "N/m, N·m/rad", symbol="K_ic", equation="(1)"),
    "limbs.sag": Entry("gravity displacement of the limb along its constraint wrenches", ("wrench",), _TWIST,
        symbol="Δ_igc", equation="(16), (19), (21)"),
    "limbs.wrench": Entry("total wrench of the platform on the limb, about o, world axes", _COMPONENT, _WRENCH),
}
# fmt: on
#: The functions that compute a quantity from the equilibrium, by name of the quantity.
COMPUTED: Mapping[str, Callable[[RobotStatics, Solution], Array]] = {
    name: entry.of for name, entry in QUANTITIES.items() if entry.of is not None
}
#: All functions that compute an array (…components, N) from the equilibrium, by name.
OF_EQUILIBRIUM: Mapping[str, Callable[[RobotStatics, Solution], Array | Mask]] = {
    **COMPUTED,
    "intensities": _intensities,
    "attached_intensities": lambda robot, s: _of_limbs(robot, s, "attached_labels", lambda k: s.statics[k].W_g),
    "singular": lambda robot, solution: solution.singular,
    "indeterminate": lambda robot, solution: solution.indeterminate,
    "basis_degenerate": lambda robot, solution: solution.basis_degenerate,
    "doubtful": lambda robot, solution: solution.doubtful,
    "usual": _is_usual,
}
#: The quantities of a Dataset by their names there, in its order.
VARIABLES: Mapping[str, Entry] = {entry.variable: entry for entry in QUANTITIES.values() if entry.variable}


def reported_names(owner: str) -> list[str]:
    """Return the names of the quantities in the report of a result (``owner`` ""), of its "limbs" or of its "beams"."""
    paths = (path.rpartition(".") for path in QUANTITIES if path not in ("status", *FACTS))
    return [name for owner_of_path, _, name in paths if owner_of_path == owner]


def axes_of(robot: RobotStatics) -> dict[str, tuple[str, ...]]:
    """Return the labels along each axis whose labels are the same in all results of a robot, by name of the axis."""
    components = {"component": COMPONENTS, "component_2": COMPONENTS, "axis": COMPONENTS[:3]}
    robots = {"actuator": robot.description.actuated, "spring": tuple(robot.description.springs)}
    return {**components, "source": contribution_names(robot), **robots}


def units_along(robot: RobotStatics) -> dict[str, list[str] | list[list[str]]]:
    """Return the units along axes, by key of :data:`UNITS`, where they are the same in all results of a robot."""
    actuators = [robot.mechanism.connections[name].type for name in robot.description.actuated]
    return {
        "component_unit": list(TWIST_UNITS),
        "wrench_component_unit": list(WRENCH_UNITS),
        "stiffness_unit": [[f"{force}/{move}" for move in TWIST_UNITS] for force in WRENCH_UNITS],
        "compliance_unit": [
            [f"{move}/({force})" if "·" in force else f"{move}/{force}" for force in WRENCH_UNITS] for move in TWIST_UNITS
        ],
        "actuator_force_unit": [kind.force_unit for kind in actuators],
        "actuator_position_unit": [kind.unit for kind in actuators],
    }


def value_at(result: object, path: str) -> object:
    """Return ``result.a.b`` for the path "a.b"; where ``result.a`` is a mapping, the attribute ``b`` of each item."""
    for name in path.split("."):
        if isinstance(result, Mapping):
            result = {key: getattr(part, name) for key, part in result.items()}
        else:
            result = getattr(result, name)
    return result


def stacked(value: object, dims: Sequence[str], labels: Mapping[str, Sequence[str]]) -> Array:
    """Join nested mappings of arrays to an array (…, *dims); the keys are the ``labels`` along each of the axes ``dims``."""
    if not isinstance(value, Mapping):
        return np.asarray(value)
    rows = [stacked(value[label], dims[1:], labels) for label in labels[dims[0]]]
    return np.stack(rows, axis=-len(dims)) if rows else np.empty((0,) * len(dims))
