"""Comparison of an analysis with finite elements: relative differences and a verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.analysis import analyzed
from kinetostatics.arguments import check, positive
from kinetostatics.description.loads import Payload
from kinetostatics.dynamics.vibrations import modes as modes_of
from kinetostatics.exceptions import ArgumentError
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.layout.numbers import join_words
from kinetostatics.layout.report import Reported
from kinetostatics.load_case import LoadCase
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.verification.frame import FrameModel
from kinetostatics.verification.frame_model import build
from kinetostatics.verification.frequencies import frequencies, relative_difference
from kinetostatics.verification.opensees import FrameSolution
from kinetostatics.verification.solve import solve

if TYPE_CHECKING:
    from kinetostatics.kinematics.configuration import Configuration
    from kinetostatics.results.parts import BeamResult
    from kinetostatics.results.result import Result

#: Largest relative difference of a verified robot.
TOLERANCE = 1e-8
#: Largest relative difference of natural frequencies, whose finite-element values are extrapolated from several meshes.
MESHES_AGREE = 1e-5
#: Smallest reference value of a relative difference, as a part of the twist or force that the loads could cause: results may
#: vanish by symmetry.
NOTHING = 1e-3
#: Largest ratio of principal compliances of an invertible compliance. At a larger ratio, the smallest one is a rounding error:
#: rigid limbs make the stiffness infinite.
STIFF = 1e9


@dataclass(frozen=True, eq=False, repr=False)
class Verification(Reported):
    """One pose computed twice: by :func:`kinetostatics.analyze`, and by OpenSees from beam and joint elements.

    Differences are norms over all components of a twist, wrench or matrix, relative to the norm of the finite-element result;
    single components may vanish by symmetry. Angular components are scaled by ``length``. Differences of forces are relative to
    the largest joint wrench.

    Attributes:
        configuration: the pose.
        result: the analysis.
        ours: twist, compliance, stiffness, wrenches of joints and beams, and actuator forces by the analysis.
        finite_elements: the same quantities by finite elements.
        differences: largest relative difference, by quantity.
        joint_differences: relative difference of each joint's wrench, by joint.
        scatter: numerical error of the finite-element result, by quantity: its relative change without the finest mesh or the
            stiffest penalty of joints. Smaller differences are not significant.
        not_compared: reason why a quantity, joint or beam was not compared, by its name.
        length: length by which rotations are multiplied and moments divided [m].
        within: largest permitted relative difference; for natural frequencies at least 1e-5.
        frequencies: natural frequencies (modes,) [Hz] by the analysis and by finite elements, if requested.
    """

    configuration: Configuration
    result: Result
    ours: FrameSolution
    finite_elements: FrameSolution
    differences: Mapping[str, float]
    joint_differences: Mapping[str, float]
    scatter: Mapping[str, float]
    not_compared: Mapping[str, str]
    length: float
    within: float
    frequencies: tuple[Array, Array] = (np.empty(0), np.empty(0))

    def allowed(self, name: str) -> float:
        """Return the largest permitted difference of a quantity."""
        return max(self.within, MESHES_AGREE) if name == "frequencies" else self.within

    @property
    def verified(self) -> bool:
        """Whether all differences are within the tolerance."""
        return all(difference <= self.allowed(name) for name, difference in self.differences.items())

    @property
    def conclusive(self) -> bool:
        """Whether the scatter of every compared quantity is within the tolerance."""
        return all(scatter <= self.allowed(name) for name, scatter in self.scatter.items())

    @property
    def verdict(self) -> str:
        """The verdict as a sentence."""
        name, worst = max(self.differences.items(), key=lambda pair: pair[1] / self.allowed(pair[0]))
        largest = f"the largest difference is {worst:.1e} ({name.replace('_', ' ')}), {self.allowed(name):.0e} is allowed"
        if self.verified:
            return f"verified: {largest}"
        if not self.conclusive:
            accuracy = max(self.scatter.items(), key=lambda pair: pair[1] / self.allowed(pair[0]))[1]
            return f"not verified: {largest}; the reference solution is accurate to {accuracy:.1e} here"
        return f"NOT verified: {largest}"


def verify(
    configuration: Configuration,
    load: ArrayLike = (0, 0, 0, 0, 0, 0),
    gravity: ArrayLike = (0, 0, -9.81),
    *,
    point: ArrayLike | None = None,
    frame: str = "world",
    assembly_errors: Mapping[str, object] | None = None,
    loads: Mapping[str, object] | None = None,
    payload: Payload | None = None,
    modes: int = 0,
    within: float = TOLERANCE,
) -> Verification:
    """Check the analysis of one pose against finite elements (OpenSeesPy, ``pip install 'kinetostatics[verify]'``).

    Args:
        configuration: the pose.
        load: (6,) external wrench on the platform: force [N], moment [N·m].
        gravity: (3,) gravity [m/s²] in world axes.
        point: (3,) point of application of the force [m]; default o.
        frame: "world" or "platform", as in :func:`kinetostatics.analyze`.
        assembly_errors: errors of joints and beams by name, as in :func:`kinetostatics.analyze`.
        loads: loads on links, as in :func:`kinetostatics.analyze`.
        payload: payload on the platform or a link.
        modes: number of natural frequencies to compare; for them, each beam has several elements with consistent masses.
        within: largest permitted relative difference; for natural frequencies at least 1e-5.

    Raises:
        ArgumentError: an argument has an invalid value or shape, or there are several poses or loads.
        OpenSeesError: OpenSeesPy is missing, cannot be loaded, or failed.
        StaticsError: the pose has no equilibrium, as in :func:`kinetostatics.analyze`.
    """
    case = LoadCase(load, gravity, point, frame, assembly_errors, loads, payload)
    result = analyzed(configuration, case)
    there = configuration.robot.description
    by_matrix = (joint for joint, stiffness in there.joint_stiffness.items() if stiffness.matrix is not None)
    with_stations = (name for name, beam in there.beams.items() if beam.section.places)
    if unknown := [*there.flexible, *with_stations, *by_matrix]:
        only = "OpenSees gets uniform beams, joints and springs only; verify a copy of the robot with these in their place"
        raise ArgumentError(f"verify cannot check {join_words(unknown)}: {only}")
    if result.shape != ():
        raise ArgumentError(f"one pose and one load can be verified at a time; here they are a batch of the shape {result.shape}")
    if not positive("within", within) < 1:
        raise ArgumentError(f"within is {within!r}; it must be between 0 and 1")
    count = check("modes", modes)
    model = build(configuration, case)
    compounds = [compound for group in result.robot.statics.groups for limb in group.compounds for compound in limb]
    theirs, less = solve(replace(model, compound_joints=tuple(frozenset(compound.joints) for compound in compounds)))
    ours = FrameSolution(
        twist=result.twist,
        compliance=result.compliance,
        stiffness=result.stiffness,
        joint_wrenches=result.joint_wrenches,
        beam_wrenches=ResultMapping({name: _ends(beam) for name, beam in result.beams.items()}),
        actuator_forces=ResultMapping({name: float(value) for name, value in result.actuator_forces.items()}),
        rotating_actuators=theirs.rotating_actuators,
    )
    sizes = _ReferenceValues(model, theirs)
    not_compared: dict[str, str] = {}
    comparable = {"joint_wrenches": dict(theirs.joint_wrenches), "beam_wrenches": dict(theirs.beam_wrenches)}
    for name in model.outside_limbs - set(ours.joint_wrenches):
        del comparable["joint_wrenches"][name]
    joints = _determined(ours.joint_wrenches, comparable["joint_wrenches"], result, not_compared)
    beams = _determined(ours.beam_wrenches, comparable["beam_wrenches"], result, not_compared)
    joint_differences = {name: sizes.wrench(ours.joint_wrenches[name], theirs.joint_wrenches[name]) for name in joints}
    differences = sizes.differences(ours, theirs, joints, beams)
    if np.any(np.isnan(ours.stiffness)) and not sizes.has_stiffness(theirs):
        del differences["stiffness"]
        not_compared["stiffness"] = "rigid limbs make it infinite; its inverse, the compliance, is compared"
    scatter = {name: value for name, value in sizes.differences(less, theirs, joints, beams).items() if name in differences}
    both = np.empty(0), np.empty(0)
    if count and any(np.isfinite(actuator.stiffness) for actuator in model.actuators):
        not_compared["frequencies"] = "an elastic actuator moves several joints"
    elif count and model.springs:
        not_compared["frequencies"] = "the finite elements vibrate without the effects of springs and weights on the stiffness"
    elif count:
        robot_modes, reference = modes_of(configuration, count, payload=payload), frequencies(model, count)
        both = robot_modes.frequencies, frozen(reference.values)
        differences["frequencies"] = relative_difference(*both) if robot_modes.zero_frequencies == reference.zero else np.inf
        scatter["frequencies"] = reference.scatter
    for what, wrenches in comparable.items():
        for name in sorted(set(getattr(ours, what)) ^ set(wrenches)):
            missing = "the finite elements have" if name in getattr(ours, what) else "the analysis has"
            not_compared[name] = f"{missing} no such {what.partition('_')[0]}"
            differences[what] = np.inf
            if what == "joint_wrenches":
                joint_differences[name] = np.inf
    return Verification(
        configuration,
        result,
        ours,
        theirs,
        differences=ResultMapping(differences),
        joint_differences=ResultMapping(joint_differences),
        scatter=ResultMapping(scatter),
        not_compared=ResultMapping(not_compared),
        length=model.length,
        within=within,
        frequencies=both,
    )


def _ends(beam: BeamResult) -> Array:
    """Return the section wrenches (2, 6) at both ends of a beam, each about the section's centroid, world axes."""
    sections = beam.section_wrenches[[0, -1]].reshape(2, 2, 3)
    return np.asarray(sections @ beam.axes.T).reshape(2, 6)


def _determined(
    ours: Mapping[str, Array], theirs: Mapping[str, Array], result: Result, not_compared: dict[str, str]
) -> list[str]:
    """Return the names that occur in both ``ours`` and ``theirs``, if the wrench is determined in spite of rigid parts.

    The reason for each omitted wrench is added to ``not_compared``.
    """
    names = []
    for name in sorted(set(ours) & set(theirs), key=list(theirs).index):
        if np.any(np.isnan(ours[name])) and result.indeterminate:
            not_compared[name] = "rigid parts are overconstrained: its wrench is not determined"
        else:
            names.append(name)
    return names


class _ReferenceValues:
    """Divisors of relative differences: norms of the finite-element results, or a small part of what the loads could cause."""

    def __init__(self, model: FrameModel, theirs: FrameSolution) -> None:
        self.unit = np.repeat([1.0, model.length], 3)
        loads = float(np.sum(np.linalg.norm(model.loads / self.unit, axis=1)))
        loads += sum(float(np.linalg.norm(beam.load / self.unit)) * beam.length for beam in model.beams)
        self.units = np.outer(self.unit, self.unit)
        # the compliance of a robot without beams is a rounding error
        self.compliance_size = max(float(np.linalg.norm(theirs.compliance * self.units)), NOTHING / model.stiffest)
        softness = max(self.compliance_size, 1 / model.stiffest)
        yielding = softness * loads + model.largest_assembly_error
        self.twist_size = max(float(np.linalg.norm(theirs.twist * self.unit)), NOTHING * yielding)
        sizes = [float(np.linalg.norm(wrench / self.unit)) for wrench in theirs.joint_wrenches.values()]
        self.wrench_size = max([*sizes, NOTHING * yielding / softness])

    def has_stiffness(self, theirs: FrameSolution) -> bool:
        """Whether the compliance can be inverted: rigid limbs prevent no motion of the platform."""
        values = np.linalg.svd(theirs.compliance * self.units, compute_uv=False)
        return bool(values[-1] * STIFF > self.compliance_size)

    def wrench(self, ours: Array, theirs: Array) -> float:
        """Return the difference of two wrenches, relative to the largest joint wrench."""
        return _relative(np.linalg.norm((ours - theirs) / self.unit), self.wrench_size)

    def differences(self, ours: FrameSolution, theirs: FrameSolution, joints: list[str], beams: list[str]) -> dict[str, float]:
        """Return the largest relative difference of each quantity; infinite if a value is NaN."""
        wrenches = [self.wrench(ours.joint_wrenches[name], theirs.joint_wrenches[name]) for name in joints]
        sections = [
            self.wrench(ours.beam_wrenches[name][end], theirs.beam_wrenches[name][end]) for name in beams for end in (0, 1)
        ]
        actuators = [name for name in theirs.actuator_forces if name in joints]
        return {
            "twist": _relative(np.linalg.norm((ours.twist - theirs.twist) * self.unit), self.twist_size),
            "compliance": _relative(np.linalg.norm((ours.compliance - theirs.compliance) * self.units), self.compliance_size),
            "stiffness": _relative(
                np.linalg.norm((ours.stiffness - theirs.stiffness) / self.units),
                float(np.linalg.norm(theirs.stiffness / self.units)),
            ),
            "joint_wrenches": max(wrenches, default=0.0),
            "beam_wrenches": max(sections, default=0.0),
            "actuator_forces": max((self._actuator(name, ours, theirs) for name in actuators), default=0.0),
        }

    def _actuator(self, name: str, ours: FrameSolution, theirs: FrameSolution) -> float:
        """Return the difference of two actuator forces, relative to the largest joint wrench.

        Torques are first divided by the unit of length of rotations.
        """
        gap = abs(ours.actuator_forces[name] - theirs.actuator_forces[name])
        arm = self.unit[3] if name in theirs.rotating_actuators else 1.0
        return _relative(gap / arm, self.wrench_size)


def _relative(gap: float | np.floating, size: float) -> float:
    if np.isnan(gap):
        return float("inf")
    if size > 0:
        return float(gap) / size
    return 0.0 if gap == 0 else float("inf")
