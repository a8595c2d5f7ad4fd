"""Data of small vibrations in chunks of poses: poses, actuators and payload."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetostatics.arguments import check
from kinetostatics.description.loads import Payload
from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Index, Mask
from kinetostatics.mechanism.elastic_joints import drive_of
from kinetostatics.robot import robot_of
from kinetostatics.statics.link_loads import PAYLOAD, LinkLoads, parse_link_loads
from kinetostatics.statics.small_motions import PlacedMotions, SmallMotions
from kinetostatics.vibration.vibration_model import Part, VibrationModel, mass_at, vibration_model


@dataclass(frozen=True)
class Vibrations:
    """Poses, actuators and payload of a robot for small vibrations.

    Attributes:
        configuration: the pose or poses.
        structure: the coordinates of small motions.
        loads: the payload, with the batch axis of its arrays last; None without payload.
        valid: (N,) mask of valid poses: reached, with positive lengths of all telescopic beams.
    """

    configuration: Configuration
    structure: SmallMotions
    loads: LinkLoads | None
    valid: Mask

    @classmethod
    def of(cls, name: str, configuration: Configuration, drives: str, payload: Payload | None) -> Vibrations:
        """Check the arguments of a function ``name``.

        Raises:
            ArgumentError: an argument has an invalid value.
        """
        if not isinstance(configuration, Configuration):
            raise ArgumentError(f"{name} needs a Configuration, got {configuration!r}; create one with robot.assemble(…)")
        check("drives", drives)
        robot, shape = robot_of(configuration), configuration.shape
        free = {name: drive_of(robot.mechanism, name, np.inf) for name in robot.description.driven}
        structure = SmallMotions(robot.statics, free if drives == "free" else None)
        valid = np.array(configuration.reached)
        for beam in robot.beams.values():
            valid &= np.nan_to_num(beam.remaining_length(configuration.frames)) > 0
        loads = parse_link_loads(robot.statics, None, payload)
        if loads is not None:
            try:
                loads = loads.map(lambda array: np.broadcast_to(array, shape + array.shape[-1:]).reshape(-1, array.shape[-1]).T)
            except ValueError:
                raise ArgumentError(f"the payload's arrays do not fit the poses, whose batch shape is {shape}") from None
        return cls(configuration, structure, loads, valid)

    def chunks(self, most: int) -> list[Index]:
        """Return the indices of the valid poses in chunks of at most ``most``."""
        poses = np.flatnonzero(self.valid)
        return np.array_split(poses, -(-len(poses) // most)) if len(poses) else []

    def placed(self, poses: Index) -> tuple[PlacedMotions, VibrationModel]:
        """Return motions, masses and elastic parts at some poses."""
        frames = self.configuration.frames.take(poses)
        motions = PlacedMotions(self.structure, frames, self.configuration.robot.mechanism.platform_pose(frames)[1])
        model = vibration_model(motions)
        if self.loads is None:
            return motions, model
        loads = self.loads.map(lambda array: array[:, poses])
        return motions, replace(model, masses={**model.masses, **_carried(loads, motions)})


def _carried(loads: LinkLoads, motions: PlacedMotions) -> dict[str, Part]:
    """Return the payload as parts, one for each place at which it is attached at some pose."""
    found = {}
    for number, (place, _, point, mass, R, inertia) in enumerate(loads.masses(motions.frames)):
        axes, matrix = R.transpose(2, 0, 1), np.zeros((len(mass), 6, 6))
        matrix[:, :3, :3] = mass[:, None, None] * np.eye(3)
        matrix[:, 3:, 3:] = axes @ inertia.transpose(2, 0, 1) @ np.swapaxes(axes, 1, 2)
        name = f"{PAYLOAD} on {place}" if number else PAYLOAD
        found[name] = mass_at(motions, motions.structure.body_at[place], point, matrix)
    return found
