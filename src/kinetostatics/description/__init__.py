"""A robot's description as frozen data, read from a file or made in Python."""

from kinetostatics.description.elements import (
    Beam,
    BeamEnd,
    Cone,
    Inertia,
    Joint,
    JointStiffness,
    Link,
    Loop,
    Material,
    Mimic,
    Origin,
    Place,
    Spring,
    Vector,
)
from kinetostatics.description.link_matrices import LinkMatrices
from kinetostatics.description.robot_description import RobotDescription, by_name

__all__ = [
    "Beam",
    "BeamEnd",
    "Cone",
    "Inertia",
    "Joint",
    "JointStiffness",
    "Link",
    "LinkMatrices",
    "Loop",
    "Material",
    "Mimic",
    "Origin",
    "Place",
    "RobotDescription",
    "Spring",
    "Vector",
    "by_name",
]
