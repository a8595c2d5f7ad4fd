"""Solution of a frame, with the geometric stiffness of its springs, and with elastic actuators of several joints."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.verification.frame import Actuator, FrameModel
from kinetostatics.verification.opensees import FrameSolution, FrameUnits, answer, inverse, levels, series
from kinetostatics.verification.turning import geometric_stiffness

#: Change of a compliance, in units of the stiffest element's, from which on nothing but a spring of
#: :data:`opensees.REGULARIZATIONS` holds a piece.
LOOSE = 1e9
#: Part of the largest geometric stiffness, or of a motion's size, that is none.
NOTHING = 1e-6
#: Part of the loads that follow the displacement by which these may change with the next, and how often they are put on.
FOLLOWED, PASSES = 1e-12, 4


def solve(model: FrameModel) -> tuple[FrameSolution, FrameSolution]:
    """Solve a frame with elastic actuators that have followers: locked, plus the effects of their deformation.

    Returns and errors are those of :func:`_solve`.
    """
    soft = [actuator for actuator in model.actuators if np.isfinite(actuator.stiffness)]
    held = _solve(model, model)
    ways = [_solve(_moved_by(model, actuator), model) for actuator in soft]
    first, second = (_given_way(model, soft, held[k], [way[k] for way in ways]) for k in (0, 1))
    return first, second


def _moved_by(model: FrameModel, actuator: Actuator) -> FrameModel:
    """Return a frame without loads whose joints are off by what a unit of an actuator's coordinate moves them."""
    by = {part.joint: (ratio, part) for ratio, part in actuator.moves}
    joints = []
    for joint in model.joints:
        ratio, part = by.get(joint.name, (0.0, None))
        along = np.zeros(3) if part is None else ratio * part.axis
        parts = (np.zeros(3), along) if part is not None and part.rotates else (along, np.zeros(3))
        joints.append(replace(joint, assembly_error=np.concatenate(parts)))
    beams = tuple(replace(beam, load=np.zeros(6), length_error=0.0) for beam in model.beams)
    return replace(model, loads=np.zeros_like(model.loads), beams=beams, joints=tuple(joints))


def _given_way(model: FrameModel, soft: Sequence[Actuator], held: FrameSolution, ways: Sequence[FrameSolution]) -> FrameSolution:
    """Add to an answer with rigid actuators what they do in giving way: f = G w and f = −k w, by the sum of both f.

    By reciprocity a unit load of the platform has in an actuator minus the force that a unit of its way moves the platform.
    """
    if not soft:
        return held
    resist = np.array([[way.actuator_forces[item.name] for way in ways] for item in soft])
    resist = np.linalg.inv(resist + np.diag([item.stiffness for item in soft]))
    w = -resist @ [held.actuator_forces[item.name] for item in soft]
    moved = np.stack([way.twist for way in ways], axis=1)

    def summed(pick: Callable[[FrameSolution], Mapping[str, Array]]) -> Mapping[str, Array]:
        return ResultMapping(
            {
                name: frozen(value + sum(a * pick(way)[name] for a, way in zip(w, ways, strict=True)))
                for name, value in pick(held).items()
            }
        )

    C = held.compliance + moved @ resist @ moved.T
    forces = {
        name: force + sum(a * way.actuator_forces[name] for a, way in zip(w.tolist(), ways, strict=True))
        for name, force in held.actuator_forces.items()
    }
    return replace(
        held,
        twist=frozen(held.twist + moved @ w),
        compliance=frozen(C),
        stiffness=frozen(inverse(C, model.length)),
        joint_wrenches=summed(lambda item: item.joint_wrenches),
        beam_wrenches=summed(lambda item: item.beam_wrenches),
        actuator_forces=ResultMapping(forces),
    )


def _solve(model: FrameModel, robot: FrameModel) -> tuple[FrameSolution, FrameSolution]:
    """Solve a frame with rigid actuators, but for those that are springs of joints.

    Returns:
        The solution; and one that is extrapolated from one level less, which tells how sure the first is.

    Raises:
        OpenSeesError: OpenSeesPy is missing, cannot be loaded, or failed.
    """
    scale = FrameUnits(model)
    answers = _with_springs(model, robot, scale) if model.ties else levels(model, scale, [model.platform])
    all_levels, one_less = (answer(model, scale, raw) for raw in answers)
    return all_levels, one_less


def _with_springs(model: FrameModel, robot: FrameModel, scale: FrameUnits) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return what :func:`levels` does, with the geometric stiffness of the forces at the pose.

    OpenSees tells these forces, and how all pieces yield to unit loads, C. Where K_G is the geometric stiffness and u_0 the
    displacement without it, the pieces move by u = (1 + C K_G)⁻¹ u_0; −K_G u is put on them as further loads, under which they
    move by u again, but for the rounding of C: with the u that comes of it once more, until these loads change no more.
    """
    pieces = [model.platform, *(piece for piece in range(len(model.references)) if piece not in (model.base, model.platform))]
    at_the_pose, loaded = levels(robot.at_the_pose, scale, pieces), levels(model, scale, pieces)
    rows = np.concatenate([6 * piece + np.arange(6) for piece in pieces])
    first = np.cumsum([0, *(len(series(joint)) for joint in model.joints)])[:-1]
    found = []
    # only what the regularization alone holds has a compliance that is not the same in both
    of_ground = loaded[0]["compliance"] - loaded[1]["compliance"]
    for forces, raw in zip(at_the_pose, loaded, strict=True):
        K = geometric_stiffness(robot, forces["springs"][first] * scale.wrench, forces["beams"] * scale.wrench)
        K = K[np.ix_(rows, rows)] * np.tile(scale.twist, len(pieces)) / np.tile(scale.wrench, len(pieces))[:, None]
        held = _held(of_ground, K)
        K, C = held @ K @ held, held @ raw["compliance"] @ held
        tangent = np.eye(len(K)) + C @ K
        moved = np.linalg.solve(tangent, held @ np.column_stack([raw["twist"], C[:, :6]]))
        found.append((moved[:6, 1:], np.linalg.solve(tangent, held), moved[:, 0], K))
    *_, guess, K = found[0]
    for _ in range(PASSES):
        loads = model.loads.copy()
        loads[pieces] -= (K @ guess).reshape(-1, 6) * scale.wrench
        with_more = levels(replace(model, loads=loads), scale, pieces)
        answered = [guess + solved @ (raw["twist"] - guess) for raw, (_, solved, *_) in zip(with_more, found, strict=True)]
        step, guess = answered[0] - guess, answered[0]
        if np.abs(K @ step).max(initial=0.0) <= FOLLOWED * np.abs(K @ guess).max(initial=0.0):
            break
    answers = []
    for raw, forces, moved, (compliance, *_) in zip(with_more, at_the_pose, answered, found, strict=True):
        turns = np.zeros((len(model.references), 3))
        turns[pieces] = moved.reshape(-1, 6)[:, 3:] * scale.twist[3:]
        springs = raw["springs"].copy()
        for joint, row in zip(model.joints, first, strict=True):
            # these follow the mean of a joint's own pieces, and are told as those that follow the mean of the ends of its run
            run, ends = robot.run_of(joint)
            turn = np.mean(turns[list(joint.pieces)] - turns[list(ends)], axis=0)
            springs[row] += np.cross(turn, forces["springs"][row].reshape(2, 3)).ravel()
            if len(run) == 2:  # and not about an axis of a universal joint, which a moment across both tilts to
                normal = np.cross(run[0].axes[:, 0], run[1].axes[:, 0])
                springs[row, 3:] = normal * (springs[row, 3:] @ normal) / (normal @ normal)
        answers.append(raw | {"springs": springs, "twist": moved[:6], "compliance": compliance})
    return answers[0], answers[1]


def _held(of_ground: Array, K: Array) -> Array:
    """Return the projection (n, n) onto what something holds, the platform, the first piece, in any case.

    A strut that spins between two balls neither C nor K does.

    Args:
        of_ground: (n, n) by how much C differs between two extrapolations, which what holds a merely soft motion does not.
        K: (n, n) the geometric stiffness.
    """
    values, vectors = np.linalg.eigh((of_ground + of_ground.T) / 2)
    free = vectors[:, np.abs(values) > LOOSE]
    values, turned = np.linalg.eigh(free.T @ K @ free)
    spins = free @ turned[:, np.abs(values) <= NOTHING * np.abs(K).max(initial=0.0)]
    values, turned = np.linalg.eigh(spins[:6].T @ spins[:6])
    spins = spins @ turned[:, values <= NOTHING**2]
    return np.asarray(np.eye(len(K)) - spins @ spins.T)
