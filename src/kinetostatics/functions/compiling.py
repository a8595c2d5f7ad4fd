"""Creation of functions of a robot."""

from __future__ import annotations

from collections.abc import Sequence

from kinetostatics.engine.programs import check_engine
from kinetostatics.exceptions import ArgumentError
from kinetostatics.functions.function import Function
from kinetostatics.functions.inputs_outputs import listed
from kinetostatics.kinematics import assembly
from kinetostatics.robot import Robot


def compile(
    robot: Robot,
    platform: Sequence[str] | None = None,
    *,
    actuators: Sequence[str] | None = None,
    orientation: str | None = None,
    outputs: str | Sequence[str] = ("twist", "actuator_forces"),
    engine: str = "auto",
    compensate: bool = False,
) -> Function:
    """Return a function that computes chosen quantities of a robot's pose from coordinates, load and gravity.

    Args:
        robot: the robot.
        platform: names of the platform coordinates that the function takes, as many as the mobility (inverse kinematics).
        actuators: names of all actuated joints (forward kinematics), the default without ``platform``; actuated joints outside
            the limbs, such as a gripper's, may be omitted.
        orientation: convention of the angles, see :meth:`Robot.assemble`.
        outputs: "twist", "contributions", "actuator_forces", "stiffness", "compliance", "spring_forces", "platform_weight",
            "platform_wrench" or "actuators"; with ``compensate``, also "residual_error".
        engine: "numpy", "compiled" at the first call, or "auto", which here is "compiled".
        compensate: the coordinates are targets of the *loaded* platform, and the outputs are those of the corrected pose, see
            :func:`kinetostatics.compensate`: "actuators" are the coordinates to be commanded, "actuator_forces" the feedforward
            forces, "residual_error" the pose error that remains.

    Raises:
        ArgumentError: an output is unknown; both ``platform`` and ``actuators`` are given; or ``compensate`` or ``orientation``
            is given without ``platform``; or an actuator is called load, gravity or near.
        CoordinatesError: the coordinates are unknown or do not determine the pose.

    Examples:
        Actuator forces of a tripod, and their derivatives:

        >>> import kinetostatics as ks
        >>> f = ks.compile(ks.load_robot("3rps"), platform=("z", "rx", "ry"))
        >>> values = f(z=0.5, rx=0.0, ry=0.0, load=[0, 0, -500, 0, 0, 0])
        >>> [round(float(force), 1) for force in values["actuator_forces"]]  # [N]
        [542.8, 542.8, 542.8]
        >>> J = f.jacobian("actuator_forces", by=("z", "load"))(z=0.5, rx=0.0, ry=0.0)
        >>> round(float(J["actuator_forces"]["load"][0, 2]), 3)  # ∂(first actuator force)/∂(load along z)
        -0.34
    """
    if not isinstance(robot, Robot):
        raise ArgumentError(f"compile needs a Robot, got {robot!r}; load one with ks.load_robot(…)")
    if platform is not None and actuators is not None:
        raise ArgumentError("give either platform= or actuators=, not both")
    if platform is None and orientation is not None:
        raise ArgumentError("orientation= applies to coordinates of the platform, not to those of actuators")
    if compensate and platform is None:
        raise ArgumentError(
            "compensate=True (--compensate) needs platform= (--platform), the names of the controlled coordinates of the "
            "loaded platform"
        )
    if platform is not None:
        names = listed("platform", platform, '("z", "rx", "ry")')
        assembly.platform_coordinates(robot, dict.fromkeys(names), orientation)
    else:
        names = listed("actuators", robot.description.actuated if actuators is None else actuators, '("motor_1", "motor_2")')
        assembly.all_actuators(robot, dict.fromkeys(names, 0.0))
    requested = listed("outputs", outputs, '("twist", "actuator_forces")')
    chosen = "compiled" if check_engine(engine) != "numpy" else "numpy"
    return Function(robot, names, platform is None, orientation, requested, chosen, compensate)
