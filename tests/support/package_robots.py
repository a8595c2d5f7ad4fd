"""The robots of the package, each read once in a process."""

from functools import cache

import numpy as np
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


def rates(one, at, frame):
    """Return how a frame of a pose moves per unit of each actuator (6, actuators), by differences of assembled poses."""
    here, columns, h = one.assemble(actuators=at), [], 1e-6
    for name in at:
        ends = [frame(one.assemble(actuators={**at, name: at[name] + step}, near=here)) for step in (h, -h)]
        moved = (ends[0] - ends[1]) / (2 * h)
        spin = moved[:3, :3] @ frame(here)[:3, :3].T
        columns.append([*moved[:3, 3], spin[2, 1], spin[0, 2], spin[1, 0]])
    return np.array(columns).T


def rigid_links(one):
    """Return the rigid links of the limbs of a robot on which loads may act."""
    elastic = {beam.link for beam in one.description.beams.values()}
    limbs = {link for limb in one.topology.limbs for link in limb.links}
    return [link for link in one.description.links if link in limbs - elastic and not _joint_around(one.statics, link)]


@cache
def soft_five_bar():
    """Return the five-bar with drives so soft that 100 N lead it beyond singular poses."""
    description = robot("five_bar").description
    for drive in description.actuated:
        description = description.with_part(JointStiffness(drive, drive=1e3))
    return ks.Robot(description)
