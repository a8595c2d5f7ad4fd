"""Results of an analysis: batch axes first, read-only, SI units, world axes, reference point o.

Quantities that need more work than the twist itself (joint wrenches, beams, motions of links) are computed on first use.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetostatics import hooks
from kinetostatics.arguments import whole_number
from kinetostatics.description.loads import Payload
from kinetostatics.kinematics.configuration import Configuration, spread
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.layout.report import Report, Tabulated
from kinetostatics.math.arrays import Array, Index, frozen
from kinetostatics.results import contributions
from kinetostatics.results.buckling import Buckling, SecondOrder, buckling_of, second_order_of
from kinetostatics.results.contributions import PayloadCoefficients, payload_coefficients
from kinetostatics.results.margins import Margins, margins_of
from kinetostatics.results.parts import BeamResult, LimbResult, beam_results, centre_lines, paper_forces
from kinetostatics.results.pose_arrays import Batch, Chunk, PoseArrays, point_on_robot
from kinetostatics.robot import Robot, robot_of
from kinetostatics.statics import joint_wrenches as joints
from kinetostatics.statics.deformation import Deformation, deform
from kinetostatics.statics.link_loads import sum_of
from kinetostatics.statics.solution import Solution, by_mechanism
from kinetostatics.status import FACTS, REPORTED, Status, status_of


class Result(Tabulated, PoseArrays):
    """The result of :func:`kinetostatics.analyze`; wrenches are ``[force; moment]``, twists ``[displacement; rotation]``.

    Attributes:
        configuration: the pose or poses.
        robot: the robot.
        shape: batch shape of all results: that of the configuration, broadcast against loads and gravity.
        payload: the payload, or None.
        loads: the loads on links as given, or None.
        point: (3,) the reference point of twists, stiffness and compliance, from o in the platform's axes [m]; None: o.
    """

    def __init__(
        self,
        configuration: Configuration,
        shape: tuple[int, ...],
        which: slice | Index,
        chunks: tuple[Chunk, ...],
        reached: NDArray[np.bool_],
        payload: Payload | None = None,
        loads: Mapping[str, object] | None = None,
    ) -> None:
        super().__init__(configuration, shape, which, chunks, reached)
        self.robot: Robot = robot_of(configuration)
        self.payload: Payload | None = payload
        self.loads: Mapping[str, object] | None = loads

    def report(self, *, hinge_axes: Mapping[str, str] | None = None) -> Report:
        """Return the report with all tables; ``print(result)`` prints a short form.

        Args:
            hinge_axes: axis of the limb frame along the first hinge, "y" (default) or "x": ``{"limb_1": "x"}``. The paper uses x
                for its PRU limbs, whose attached force is then "along limb y". z is along the limb in both cases.

        Raises:
            ArgumentError: there is no such limb, or the axis is neither "x" nor "y".
        """
        return hooks.report_of(self, hinge_axes=hinge_axes)  # type: ignore[no-any-return]

    # ---- the platform -----------------------------------------------------------------------------------------------

    @cached_property
    def status(self) -> NDArray[np.int8]:
        """:class:`Status` of every pose (…), the most severe of its facts, see :attr:`facts`."""
        numbers = np.where(self._valid, Status.OK, Status.SINGULAR)
        base = np.where(self._reached, numbers, Status.UNREACHABLE).astype(np.int8).reshape(self.shape)
        status = status_of(base, {name: getattr(self, name) for name in REPORTED})
        status.setflags(write=False)
        return status

    @cached_property
    def facts(self) -> Mapping[str, NDArray[np.bool_]]:
        """(…) whether each of :data:`kinetostatics.status.FACTS` is true of each pose, by name; several can be true."""
        return ResultMapping({name: getattr(self, name) for name in FACTS})

    @cached_property
    def limit_exceeded(self) -> NDArray[np.bool_]:
        """(…) whether a joint is beyond its limit or cone; all results remain valid. False at poses that are not reached."""
        return self._truth(self.configuration.limit_exceeded.ravel()[self._which])

    @cached_property
    def indeterminate(self) -> NDArray[np.bool_]:
        """(…) whether rigid limbs or rings have statically indeterminate forces: these forces are NaN, the twist is valid."""
        return self._fact("indeterminate")

    @cached_property
    def basis_degenerate(self) -> NDArray[np.bool_]:
        """(…) whether the canonical wrench basis of a limb degenerates: the limb's intensities are NaN, other results valid."""
        return self._fact("basis_degenerate")

    @cached_property
    def effort_exceeded(self) -> NDArray[np.bool_]:
        """(…) whether the force of an actuator exceeds the limit of effort in the file; all results remain valid."""
        return self._truth(np.any([np.zeros(self.shape), *(ratio > 1 for ratio in self.utilization.values())], axis=0))

    @cached_property
    def buckles(self) -> NDArray[np.bool_]:
        """(…) whether the tangent stiffness under all loads has an eigenvalue ≤ 0; if so, no result applies."""
        return self._truth(self._valid & np.concatenate(self._of_chunks(lambda chunk: chunk.buckles)))

    @cached_property
    def twist(self) -> Array:
        """(…, 6) displacement of o and rotation of the platform, world axes [m, rad], Eq. (12)."""
        return self._moved(self._batch.public(self._of_chunks(lambda chunk: chunk["contributions"].sum(axis=0))))

    @cached_property
    def contributions(self) -> Mapping[str, Array]:
        """(…, 6) parts of the twist [m, rad]: load, platform and limb weights, link loads, payload, inertia, assembly errors."""
        return self._by("contributions", self.contribution_names)

    def at_point(self, point: ArrayLike) -> Result:
        """Return the result with another reference point on the platform, such as a tool's tip.

        Twist, its contributions, stiffness and compliance refer to this point; wrenches remain about o.

        Args:
            point: (3,) from o in the platform's axes [m].

        Raises:
            ArgumentError: the value is not a point.

        Examples:
            >>> import kinetostatics as ks
            >>> pose = ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.1, "ry": 0.0})
            >>> tip = ks.analyze(pose, [100, 0, 0, 0, 0, 0], gravity=(0, 0, 0)).at_point((0, 0, 0.2))  # of a tool
            >>> [round(1e6 * float(d), 2) for d in tip.twist[:3]]  # [µm]
            [2.44, 0.17, -0.01]
        """
        return self.seen_from(point_on_robot("point", point, self.robot))

    @cached_property
    def mechanism_contributions(self) -> Mapping[str, Mapping[str, Array]]:
        """Twist of the platform due to each limb's weight (…, 6) [m, rad]: ``{"limb_1": {"attached": …, "deformation": …}, …}``.

        They are terms of Eq. (12): −C J_ig W_ig due to attached wrenches, and C J_ic K_ic Δ_igc due to deformation along the
        constraint wrenches. Each depends on the choice of J_ig (method page, section 4); their sum, the limb's part, does not.
        """
        twists = self.by_mechanism.contributions
        return contributions.mechanisms_by_limb(twists, self.robot.topology.limbs)

    @cached_property
    def by_mechanism(self) -> Result:
        """The same result, in which the contribution of every limb's weight is split into two contributions.

        "limb_1" is the part due to its attached wrenches, which carry its weight, "deformation of limb_1" the part due to its
        strains under them. See :attr:`mechanism_contributions`.
        """
        chunk = Chunk(self.robot, [by_mechanism(self.robot.statics, solution) for solution in self.solutions])
        split_result = Result(self.configuration, self.shape, self._which, (chunk,), self._reached, self.payload, self.loads)
        return split_result.seen_from(self.point)

    @cached_property
    def stiffness(self) -> Array:
        """(…, 6, 6) tangent stiffness K at o, actuators locked, Eq. (12) [N/m, N·m/rad]; NaN where limbs are rigid."""
        return self._of("stiffness")

    @cached_property
    def compliance(self) -> Array:
        """(…, 6, 6) compliance C at o, actuators locked [m/N, rad/(N·m)]."""
        return self._of("compliance")

    # ---- stability ----------------------------------------------------------------------------------------------------

    def buckling(self, count: int = 1) -> Buckling:
        """Return the smallest load factors, of all forces of this result, at which the robot buckles, and the buckling modes.

        Args:
            count: number of modes.

        Raises:
            ArgumentError: ``count`` is not a positive whole number.
        """
        poses, number = spread(self.configuration, self.shape), whole_number("count", count, 1)
        return buckling_of(poses, self.solutions, self._valid, number)

    @cached_property
    def second_order(self) -> SecondOrder:
        """Twist, compliance and stiffness of second order: with the effects of forces and displacement on the stiffness."""
        return second_order_of(self.robot, self._batch, self.solutions, self.stiffness, self._moved)

    # ---- loads ----------------------------------------------------------------------------------------------------------

    @cached_property
    def load(self) -> Array:
        """(…, 6) external load about o, world axes [N, N·m]."""
        return self._of("load")

    @cached_property
    def platform_weight(self) -> Array:
        """(…, 6) weight of the platform and the bodies attached to it, about o, world axes [N, N·m]."""
        return self._of("platform_weight")

    @cached_property
    def gravity(self) -> Array:
        """(…, 3) gravity, world axes [m/s²]."""
        return self._of("gravity")

    @cached_property
    def platform_wrench(self) -> Array:
        """(…, 6) external wrench on the platform about o, world axes [N, N·m], Eq. (5): load, weight, loads on its links."""
        return self._of("platform_wrench")

    @cached_property
    def link_loads(self) -> Mapping[str, Array]:
        """(…, 6) load on each link, and weight of the payload, by contribution, about o, world axes [N, N·m]."""
        names = [(k, applied.load.name) for k, applied in enumerate(self.solutions[0].applied) if applied.load.kind == "load"]
        return ResultMapping({name: self._batch.public([sum_of([s.applied[k]]) for s in self.solutions]) for k, name in names})

    @cached_property
    def spring_forces(self) -> Mapping[str, Array]:
        """(…) tension of each spring at the undeformed pose, negative in compression [N]."""
        return self._by("spring_forces", [*self.robot.description.springs])

    @cached_property
    def payload_coefficients(self) -> PayloadCoefficients:
        """Twist and forces per unit of mass and first moment of the payload; without payload, of any mass on the platform."""
        link = None if self.payload is None else self.payload.link
        return payload_coefficients(self.robot.statics, self._batch, self.solutions, link)

    # ---- limbs ------------------------------------------------------------------------------------------------------

    @cached_property
    def limbs(self) -> Mapping[str, LimbResult]:
        """The limbs by name, in the order of the file."""
        limbs, constraint, attached = {}, 0, 0
        for group in self.robot.statics.groups:
            for position, limb in enumerate(group.limbs):
                ends = constraint + len(group.labels[position]), attached + len(group.attached_labels[position])
                rows = slice(constraint, ends[0]), slice(attached, ends[1])
                limbs[limb.name] = LimbResult(self, group, position, rows)
                constraint, attached = ends
        return ResultMapping({limb.name: limbs[limb.name] for limb in self.robot.topology.limbs})

    @cached_property
    def paper_forces(self) -> Mapping[str, Mapping[str, Array]]:
        """Forces of the limbs by the names of the paper: ``{"limb_1": {"f_11": …, "f_12": …, "f_1a": …}, …}``, (…) [N or N·m].

        f_ik is the intensity W_ick, Eq. (11). f_ia, Eq. (17), is the axial force at the base end of the limb's innermost beam,
        tension positive; it equals the actuator force only if the actuator carries the whole rod. Limbs without a beam have no
        f_ia. Networks are omitted, because their intensities are only coordinates in a basis.
        """
        return paper_forces(self.limbs, self.beams)

    # ---- joints -----------------------------------------------------------------------------------------------------

    @cached_property
    def _joint_wrenches(self) -> list[Array]:
        return [joints.joint_wrenches(self.robot.statics, solution) for solution in self.solutions]

    @cached_property
    def _joint_contributions(self) -> list[Array]:
        return [joints.joint_contributions(self.robot.statics, solution) for solution in self.solutions]

    @cached_property
    def joint_wrenches(self) -> Mapping[str, Array]:
        """(…, 6) wrench of each joint's base side on its platform side, at the joint's centre, world axes [N, N·m].

        A joint within a ring has neither; the wrench is exerted by the joint's predecessor link on its successor link.
        """
        chunks = self._joint_wrenches
        return ResultMapping(
            {name: self._batch.public([w[:, k] for w in chunks]) for name, k in joints.joints_in_order(self.robot.statics)}
        )

    @cached_property
    def joint_contributions(self) -> Mapping[str, Mapping[str, Array]]:
        """(…, 6) part of each joint's wrench due to each contribution to the twist, by joint and contribution."""
        chunks, order = self._joint_contributions, joints.joints_in_order(self.robot.statics)
        names = self.contribution_names
        return ResultMapping({name: self._batch.by_contribution(names, [w[:, k] for w in chunks]) for name, k in order})

    @cached_property
    def actuator_forces(self) -> Mapping[str, Array]:
        """(…) force of each actuator, positive along its joint, with those of its followers, Eq. (17) [N or N·m]."""
        return self._by("actuator_forces", self.robot.description.actuated)

    @cached_property
    def utilization(self) -> Mapping[str, Array]:
        """(…) ratio of each actuator's force to the limit of effort in the file [1]; NaN if the file states none."""
        efforts = self.robot.description.actuator_limits("effort")
        ratios = {name: abs(force) / efforts.get(name, np.nan) for name, force in self.actuator_forces.items()}
        return ResultMapping({name: frozen(np.asarray(ratio)) for name, ratio in ratios.items()})

    @cached_property
    def actuator_contributions(self) -> Mapping[str, Mapping[str, Array]]:
        """(…) part of each actuator's force due to each contribution to the twist, by actuator and contribution [N or N·m]."""
        pairs = zip(self.solutions, self._joint_contributions, strict=True)
        chunks = [joints.actuator_forces_from(self.robot.statics, solution, wrenches) for solution, wrenches in pairs]
        names = self.contribution_names
        return ResultMapping({name: self._batch.by_contribution(names, [chunk[name] for chunk in chunks]) for name in chunks[0]})

    @cached_property
    def actuator_mechanism_contributions(self) -> Mapping[str, Mapping[str, Mapping[str, Array]]]:
        """(…) force of each actuator due to each limb's weight, by actuator, limb, and "attached" or "deformation" [N or N·m].

        Both parts are explained at :attr:`mechanism_contributions`; their sum is the contribution of the limb's weight to the
        force (:attr:`actuator_contributions`). The part due to deformation is zero in a robot that is not overconstrained.
        """
        forces, limbs = self.by_mechanism.actuator_contributions, self.robot.topology.limbs
        return ResultMapping({name: contributions.mechanisms_by_limb(force, limbs) for name, force in forces.items()})

    @cached_property
    def base_wrench(self) -> Array:
        """(…, 6) base reaction: the ground's wrench acting on the robot, about the base link's origin, world axes [N, N·m]."""
        return self._batch.public([joints.base_wrench(self.robot.statics, solution) for solution in self.solutions])

    # ---- deformation ------------------------------------------------------------------------------------------------

    @cached_property
    def _deformations(self) -> tuple[Deformation, ...]:
        return tuple(deform(self.robot.statics, solution) for solution in self.solutions)

    @property
    def _motions(self) -> tuple[Robot, Batch, tuple[Solution, ...], tuple[Deformation, ...]]:
        return self.robot, self._batch, self.solutions, self._deformations

    @cached_property
    def beams(self) -> Mapping[str, BeamResult]:
        """The beams by name: section wrenches, deflections, stresses."""
        return beam_results(*self._motions)

    @cached_property
    def centre_lines(self) -> Mapping[str, tuple[Array, Array]]:
        """``axes`` (…, 3, 3) and ``points`` (…, n, 3) [m] of each :class:`BeamResult`, computed without the other results."""
        return centre_lines(*self._motions)

    @cached_property
    def beam_contributions(self) -> Mapping[str, Mapping[str, Array]]:
        """Displacement and rotation (…, n, 6) of the stations of each beam, by contribution, world axes [m, rad].

        Their sum is the deflection in :attr:`beams`; the weight of beams attached only to the base is not a contribution.
        """
        return contributions.beam_contributions(*self._motions)

    @cached_property
    def axial_contributions(self) -> Mapping[str, Mapping[str, Array]]:
        """(…) axial force at the platform end of each beam, by contribution [N], tension positive."""
        return contributions.axial_contributions(*self._motions)

    @cached_property
    def link_contributions(self) -> Mapping[str, Mapping[str, Array]]:
        """(…, 6) twist of each rigid link, by contribution, at the link's origin, world axes [m, rad]."""
        return contributions.link_contributions(*self._motions)

    @cached_property
    def interface_contributions(self) -> Mapping[str, Mapping[str, Array]]:
        """(…, n, 6) twist of the n interfaces of each ``<flexible>`` link, by contribution, world axes [m, rad]."""
        return contributions.interface_contributions(*self._motions)

    @cached_property
    def source_contributions(self) -> Mapping[str, Mapping[str, Array]]:
        """Twists at o [m, rad] by part: ``{"beams": {name: (…, 6)}, "joints": …, "actuators": …, "assembly_errors": …}``.

        The deformation c_s w_s of part s, or its assembly error, causes the twist P_sᵀ c_s w_s; P_s are the wrenches of the part
        under unit loads on the platform. These twists sum to the twist of the platform (method page, section 6). If a part were
        rigid, the twist would change by another amount, because the forces redistribute.
        """
        parts = contributions.source_contributions(*self._motions)
        return ResultMapping(
            {kind: ResultMapping({name: self._moved(twist) for name, twist in named.items()}) for kind, named in parts.items()}
        )

    @cached_property
    def part_contributions(self) -> Mapping[str, tuple[Array, ...]]:
        """(…, 6) twist due to each part of the limbs that consist of several parts in series, from base to platform [m, rad]."""
        return contributions.part_contributions(self.robot, self._batch, self.source_contributions)

    @cached_property
    def margins(self) -> Margins:
        """Safety factors against the efforts of actuators and the yield strengths of beams in the file, and against buckling."""
        return margins_of(self.robot, self._batch, self.solutions, self.utilization, lambda name: self.beams[name].stress)

    @cached_property
    def strain_energy(self) -> Array:
        """(…) strain energy of all beams, elastic joints and actuators [J]."""
        springs = self._batch.public([deformation.spring_energy for deformation in self._deformations])
        return frozen(sum((beam.strain_energy for beam in self.beams.values()), springs))

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about the result, in full sentences."""
        return hooks.result_warnings(self.seen_from(None))
