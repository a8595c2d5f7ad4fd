"""A robot's description as frozen data, read from a file or made in Python."""

from kinetostatics.description.elements import Beam, BeamEnd, Inertia, JointStiffness, Link, Material, Origin, Spring
from kinetostatics.description.fields import Place, Vector
from kinetostatics.description.flexible import Flexible
from kinetostatics.description.joints import Cone, Joint, Loop, Mimic
from kinetostatics.description.link_matrices import LinkMatrices
from kinetostatics.description.robot_description import RobotDescription, by_name
from kinetostatics.description.validation import validate

__all__ = [
    "Beam",
    "BeamEnd",
    "Cone",
    "Flexible",
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
    "validate",
]
