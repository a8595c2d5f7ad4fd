"""One machine written in many ways: each function returns another description of the same robot.

What a rewriting does to coordinates and names stands in the :class:`Rewritten` that comes back. For other trees links and joints
are seen as bodies and connections with a frame on either side.
"""

import random
import re
import string
from dataclasses import dataclass, field, replace

import numpy as np
from mechanisms import random_rotation, rpy
from scipy.spatial.transform import Rotation

from kinetostatics.description import Cone, Inertia, Joint, Link, Loop, Mimic, Origin, validate

IN_TREES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
TURNING, ONE_FREEDOM = ("revolute", "continuous"), ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class Rewritten:
    """Another description of a robot.

    Attributes:
        description: the description.
        signs: −1 for joints whose coordinate runs the other way.
        shifts: what was taken from coordinates, before they were turned [m, rad].
        names: new names by the old ones, if they have changed.
        moved: joints whose centre is another point of their axis.
    """

    description: object
    signs: dict = field(default_factory=dict)
    shifts: dict = field(default_factory=dict)
    names: dict = field(default_factory=dict)
    moved: frozenset = frozenset()

    def drives(self, coordinates):
        """Return the actuators' coordinates as the new description has them."""
        return {
            self.names.get(name, name): self.signs.get(name, 1) * (np.asarray(value) - self.shifts.get(name, 0.0))
            for name, value in coordinates.items()
        }

    def word(self, label):
        """Return what becomes of a label."""
        for name in sorted(self.names, key=len, reverse=True):
            label = re.sub(rf"(?<![A-Za-z0-9_]){re.escape(name)}(?![A-Za-z0-9_])", self.names[name], label)
        return label


def origin(F):
    return Origin(tuple(map(float, F[:3, 3])), tuple(map(float, rpy(F[:3, :3]))))


def placement(R=None, p=(0, 0, 0)):
    F = np.eye(4)
    F[:3, :3] = np.eye(3) if R is None else R
    F[:3, 3] = p
    return F


def tuple_of(v):
    return tuple(float(x) for x in v)


# ---- frames --------------------------------------------------------------------------------------------------------------


def reframed(description, frames, loop_frames=None):
    """Give links other frames: ``frames`` by link (4, 4) in the old frame; a joint moves with the frame of its child.

    ``loop_frames``: by loop (4, 4), the joint's new frame in its old one, on both sides.
    """
    at = {name: frames.get(name, np.eye(4)) for name in description.links}
    back = {name: np.linalg.inv(F) for name, F in at.items()}
    loop_frames = loop_frames or {}
    links, joints, loops, beams = {}, {}, {}, {}
    for name, link in description.links.items():
        R = back[name][:3, :3]
        com = R @ link.center_of_mass + back[name][:3, 3]
        turned = R @ Rotation.from_euler("xyz", link.inertia.rpy).as_matrix()
        inertia = Inertia(link.inertia.moments, tuple_of(rpy(turned)))
        links[name] = (
            replace(link, center_of_mass=tuple_of(com), inertia=inertia, extra="")
            if link.has_inertial
            else replace(link, extra="")
        )
    for name, joint in description.joints.items():
        F = back[joint.parent] @ joint.origin.matrix @ at[joint.child]
        axis = at[joint.child][:3, :3].T @ joint.axis
        joints[name] = replace(joint, origin=origin(F), axis=tuple_of(axis), extra="")
    for name, loop in description.loops.items():
        D = loop_frames.get(name, np.eye(4))
        turn = D[:3, :3].T
        cone = loop.cone and Cone(
            loop.cone.angle, tuple_of(turn @ loop.cone.predecessor_axis), tuple_of(turn @ loop.cone.successor_axis)
        )
        loops[name] = replace(
            loop,
            predecessor_origin=origin(back[loop.predecessor] @ loop.predecessor_origin.matrix @ D),
            successor_origin=origin(back[loop.successor] @ loop.successor_origin.matrix @ D),
            axis=loop.axis if loop.type in ("fixed", "spherical") else tuple_of(turn @ loop.axis),
            axis2=tuple_of(turn @ loop.axis2) if loop.type == "universal" else loop.axis2,
            cone=cone,
        )
    for name, beam in description.beams.items():
        beams[name] = beam if beam.y_axis is None else replace(beam, y_axis=tuple_of(at[beam.link][:3, :3].T @ beam.y_axis))
    platform = origin(back[description.platform] @ description.platform_origin.matrix)
    return replace(description, links=links, joints=joints, loops=loops, beams=beams, platform_origin=platform)


def _root(description):
    return (set(description.links) - {joint.child for joint in description.joints.values()}).pop()


def _elastic(description):
    """Return the joints that have springs along the axes of their frame."""
    return {name for name, s in description.joint_stiffness.items() if s.linear is not None or s.angular is not None}


def turned(description, seed, about_axes=False):
    """Turn the frames of links, joints and loops: at random, or about their joint's axis."""
    description, rng = validate(description), np.random.default_rng(seed)

    def turn(axis):
        return Rotation.from_rotvec(rng.uniform(-3, 3) * np.array(axis)).as_matrix() if about_axes else random_rotation(rng)

    held = _elastic(description)
    fixed = {_root(description), description.base}
    frames = {
        joint.child: placement(turn(joint.axis))
        for joint in description.joints.values()
        if joint.child not in fixed and joint.name not in held and joint.type not in ("planar", "floating")
    }
    loops = {
        name: placement(turn(loop.axis)) for name, loop in description.loops.items() if name not in held and loop.type != "planar"
    }
    return Rewritten(reframed(description, frames, loops))


def slid(description, seed, size=0.2):
    """Slide the origins of joints along their axes where no beam ends at them."""
    description, rng = validate(description), np.random.default_rng(seed)
    held = {end.joint for beam in description.beams.values() for end in (beam.start, beam.end) if end is not None}
    held |= _elastic(description)
    elastic = {beam.link for beam in description.beams.values()}
    links = set(description.links) - elastic - {description.base}
    ties = {link: {j.name for j in description.joints.values() if link in (j.parent, j.child)} for link in elastic}
    held |= set().union(*ties.values()) if ties else set()
    frames, loops, moved = {}, {}, set()
    for joint in description.joints.values():
        if joint.type in ONE_FREEDOM and joint.name not in held and joint.child in links:
            frames[joint.child] = placement(p=rng.uniform(-size, size) * np.array(joint.axis))
            moved.add(joint.name)
    for loop in description.loops.values():
        apart = not {loop.predecessor, loop.successor} & elastic
        if loop.type in (*ONE_FREEDOM, "cylindrical") and loop.name not in held and apart:
            loops[loop.name] = placement(p=rng.uniform(-size, size) * np.array(loop.axis))
            moved.add(loop.name)
    return Rewritten(reframed(description, frames, loops), moved=frozenset(moved))


# ---- axes and zeros ------------------------------------------------------------------------------------------------------


def flipped(description, seed, share=0.6):
    """Turn axes over, and limits and what follows with them."""
    description, rng = validate(description), np.random.default_rng(seed)
    signs = {name: -1 if rng.random() < share else 1 for name in (*description.joints, *description.loops)}

    def over(item):
        if item.type not in (*ONE_FREEDOM, "cylindrical", "planar", "universal") or signs[item.name] > 0:
            return item
        new = replace(item, axis=tuple(-x for x in item.axis))
        return replace(new, lower=-item.upper, upper=-item.lower) if item.type in ONE_FREEDOM else new

    joints = {name: over(joint) for name, joint in description.joints.items()}
    for name, joint in joints.items():
        if joint.mimic is not None:
            m = joint.mimic
            own = signs[name]
            joints[name] = replace(joint, mimic=Mimic(m.joint, m.multiplier * own * signs[m.joint], m.offset * own))
    loops = {name: over(loop) for name, loop in description.loops.items()}
    return Rewritten(replace(description, joints=joints, loops=loops), signs=signs)


def with_zeros_at(robot, pose):
    """Shift the zeros of the joints so that a pose is the new zero pose, but where beams end at slides."""
    description = robot.description
    ends = {end.joint for beam in description.beams.values() for end in (beam.start, beam.end) if end is not None}
    values = {name: float(value[0]) for name, value in robot.joint_coordinates.at(pose.model_q, pose.frames).items()}
    shifts, joints, loops = {}, dict(description.joints), dict(description.loops)
    for name, value in values.items():
        item = joints.get(name, loops.get(name))
        slides = item.type == "prismatic"
        if slides and name in ends:
            continue
        axis = np.array(item.axis)
        move = placement(p=value * axis) if slides else placement(Rotation.from_rotvec(value * axis).as_matrix())
        limits = {} if item.type == "continuous" else {"lower": item.lower - value, "upper": item.upper - value}
        shifts[name] = value
        if name in joints:
            joints[name] = replace(item, origin=origin(item.origin.matrix @ move), **limits)
        else:
            loops[name] = replace(item, predecessor_origin=origin(item.predecessor_origin.matrix @ move), **limits)
    for name, joint in joints.items():
        if joint.mimic is not None:
            m = joint.mimic
            offset = m.offset + m.multiplier * shifts.get(m.joint, 0.0) - shifts.get(name, 0.0)
            joints[name] = replace(joint, mimic=replace(m, offset=offset))
    return Rewritten(replace(description, joints=joints, loops=loops), shifts=shifts)


# ---- trees ---------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Side:
    link: str
    frame: np.ndarray


@dataclass(frozen=True)
class _Connection:
    item: object
    first: _Side
    second: _Side


def regrown(description, seed):
    """Write another spanning tree: rooted at a random link, its loops cut at random joints.

    Joints that float, move in a plane or have springs along axes of their frame keep their sides. The world stays what
    it is: that of a root to which the base is fixed would be another one.
    """
    for attempt in range(40):
        found, wrong = _regrown(description, (seed, attempt))
        if not wrong:
            return found
    return Rewritten(description)


def _regrown(description, seed):
    """Return another tree, and what of it must not be as it is."""
    description, rng = validate(description), np.random.default_rng(seed)
    connections = [
        _Connection(j, _Side(j.parent, j.origin.matrix), _Side(j.child, np.eye(4))) for j in description.joints.values()
    ]
    connections += [
        _Connection(k, _Side(k.predecessor, k.predecessor_origin.matrix), _Side(k.successor, k.successor_origin.matrix))
        for k in description.loops.values()
    ]
    held = _elastic(description)
    leaders = {j.mimic.joint for j in description.joints.values() if j.mimic is not None}
    followers = {j.name for j in description.joints.values() if j.mimic is not None}
    bound = leaders | followers | {j.name for j in description.joints.values() if j.type in ("floating", "planar")}
    order = [c for c in connections if c.item.type in IN_TREES and not (isinstance(c.item, Loop) and c.item.name in held)]
    rng.shuffle(order)
    order.sort(key=lambda c: c.item.name not in bound | held)
    group = {name: name for name in description.links}

    def find(link):
        while group[link] != link:
            link = group[link]
        return link

    in_tree = []
    for c in order:
        a, b = find(c.first.link), find(c.second.link)
        if a != b:
            group[a] = b
            in_tree.append(c)
    base = description.base
    root = str(rng.choice(sorted(description.links)))
    kept = held | {c.item.name for c in in_tree if c.item.type in ("floating", "planar")}
    wrong = set()
    joints, frames, links = {}, {root: np.eye(4)}, dict(description.links)
    waiting = list(in_tree)
    while waiting:
        c = next(c for c in waiting if c.first.link in frames or c.second.link in frames)
        waiting.remove(c)
        inner, outer, sign = (c.first, c.second, 1) if c.first.link in frames else (c.second, c.first, -1)
        item, child = c.item, outer.link
        if sign < 0 and item.name in kept:
            wrong.add(item.name)
        if child == base:  # whose frame stays what it is: the world's
            child = f"{base}_mount"
            links[child] = Link(child)
            joints[f"{base}_fixing"] = Joint(f"{base}_fixing", "fixed", child, base, origin(np.linalg.inv(outer.frame)))
            frames[base] = np.eye(4)
        else:
            frames[child] = outer.frame
        joints[item.name] = Joint(
            item.name, item.type, inner.link, child, Origin(), tuple(sign * x for x in item.axis), item.lower, item.upper,
            getattr(item, "mimic", None), item.effort, item.velocity,
        )  # fmt: skip
    sides = {c.item.name: (c.first, c.second) for c in in_tree}
    done = {}
    for name, joint in joints.items():
        if name in sides:
            first, second = sides[name]
            inner = first if first.link == joint.parent else second
            joint = replace(joint, origin=origin(np.linalg.inv(frames[joint.parent]) @ inner.frame))
        done[name] = joint
    loops = {}
    for c in connections:
        if c not in in_tree:
            item = c.item
            more = {"axis2": item.axis2, "cone": item.cone} if isinstance(item, Loop) else {}
            loops[item.name] = Loop(
                item.name, item.type, c.first.link, c.second.link,
                origin(np.linalg.inv(frames[c.first.link]) @ c.first.frame),
                origin(np.linalg.inv(frames[c.second.link]) @ c.second.frame),
                item.axis, lower=item.lower, upper=item.upper, effort=item.effort, velocity=item.velocity, **more,
            )  # fmt: skip
    parents = {joint.child: joint for joint in joints.values()}
    here = base
    while here in parents and parents[here].type == "fixed":
        here = parents[here].parent
    if here == root != base:  # the world's axes would be those of the root
        wrong.add(base)
    bare = replace(description, joints={}, loops={})
    new = replace(
        reframed(bare, frames), links=reframed(bare, frames).links | {k: v for k, v in links.items() if k not in bare.links}
    )
    return Rewritten(replace(new, joints=done, loops=loops, base=base)), wrong


# ---- names and order -----------------------------------------------------------------------------------------------------


def renamed(description, seed):
    """Give links, joints, loops and beams names in other letters; joints of a run still begin alike."""
    description = validate(description)
    shuffled = list(string.ascii_lowercase)
    random.Random(seed).shuffle(shuffled)
    table = str.maketrans(string.ascii_lowercase, "".join(shuffled).upper())
    names = {}
    for name in (*description.links, *description.joints, *description.loops, *description.beams):
        names[name] = name.translate(table)
        for end in range(2, len(name)):  # runs are called what their names have in common
            stem = name[:end].rstrip("_-. ")
            if stem:
                names.setdefault(stem, stem.translate(table))

    def new(item, *attributes):
        changes = {key: names[getattr(item, key)] for key in attributes if getattr(item, key)}
        return replace(item, extra="", **changes) if hasattr(item, "extra") else replace(item, **changes)

    def ends(beam):
        return {k: end and replace(end, joint=names[end.joint]) for k, end in (("start", beam.start), ("end", beam.end))}

    joints = [new(joint, "name", "parent", "child") for joint in description.joints.values()]
    joints = [j if j.mimic is None else replace(j, mimic=replace(j.mimic, joint=names[j.mimic.joint])) for j in joints]
    return Rewritten(
        replace(
            description,
            links={names[k]: new(link, "name") for k, link in description.links.items()},
            joints={joint.name: joint for joint in joints},
            loops={names[k]: new(loop, "name", "predecessor", "successor") for k, loop in description.loops.items()},
            beams={names[k]: replace(new(beam, "name", "link"), **ends(beam)) for k, beam in description.beams.items()},
            joint_stiffness={names[k]: new(s, "joint") for k, s in description.joint_stiffness.items()},
            actuated=tuple(names[k] for k in description.actuated),
            platform=names[description.platform],
            base=names[description.base],
            extra="",
        ),
        names=names,
    )


def reordered(description, seed):
    """Write links, joints, loops, beams and actuators in another order; the limbs' numbers follow that of the links."""
    description, rng = validate(description), np.random.default_rng(seed)

    def mixed(table):
        keys = list(table)
        rng.shuffle(keys)
        return {key: table[key] for key in keys}

    tables = {name: mixed(getattr(description, name)) for name in ("links", "joints", "loops", "beams")}
    actuated = list(description.actuated)
    rng.shuffle(actuated)
    return Rewritten(replace(description, actuated=tuple(actuated), **tables))
