"""The robots of the package, each read once in a process."""

from functools import cache

from places import ROBOTS

import kinetostatics as ks
from kinetostatics.description import JointStiffness
from kinetostatics.statics.link_loads import _joint_around

NAMES = sorted(path.name.partition(".")[0] for path in ROBOTS.glob("*.xacro"))


@cache
def robot(name, **parameters):
    return ks.load_robot(ROBOTS / f"{name}.urdf.xacro", parameters)


def generic_pose(name, description=None):
    """Return a pose without symmetry of a robot, or of a description of its mechanism."""
    one = robot(name)
    other = one if description is None else ks.Robot(description)
    return other.configuration(one.model_q(one.generic_poses)[:, 0], closure_tolerance=1e-9)


def rigid_links(one):
    """Return the rigid links of the limbs of a robot on which loads may act."""
    elastic = {beam.link for beam in one.description.beams.values()}
    limbs = {link for limb in one.topology.limbs for link in limb.links}
    return [link for link in one.description.links if link in limbs - elastic and not _joint_around(one.statics, link)]


@cache
def soft_five_bar():
    """Return the five-bar with drives so soft that 100 N lead it beyond singular poses."""
    description = robot("five_bar").description
    for drive in description.driven:
        description = description.with_part(JointStiffness(drive, drive=1e3))
    return ks.Robot(description)
