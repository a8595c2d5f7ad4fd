"""Writers of robots in formats of other tools, each in the syntax of its tool, independent of the readers of the package."""

import xml.etree.ElementTree as ET

import numpy as np

import kinetostatics as ks

ET.register_namespace("drake", "http://drake.mit.edu")


def frames(description):
    """Frames of links relative to the root, all joints at zero."""
    children = {joint.child for joint in description.joints.values()}
    result = {link: np.eye(4) for link in description.links if link not in children}
    while len(result) < len(description.links):
        for joint in description.joints.values():
            if joint.parent in result:
                result[joint.child] = result[joint.parent] @ joint.origin.matrix
    return result


def words(values):
    return " ".join(repr(float(value)) for value in values)


def with_loops_as(robot, path, writer):
    """Save a robot with its loops in another format: ``writer`` returns an element for a loop, or None."""
    ks.save_robot(robot, path)
    tree = ET.parse(path)
    for element in tree.getroot().findall("loop"):
        tree.getroot().remove(element)
    for loop in robot.description.loops.values():
        if (element := writer(loop)) is not None:
            tree.getroot().append(ET.fromstring(element))
    tree.write(path)


def gazebo_joint(loop, at):
    """A joint of SDFormat in URDF's tag of Gazebo, as authors of parallel robots write it; ``at``: frames of all links."""
    kind = {"spherical": "ball"}.get(loop.type, loop.type)
    axes = f"<axis><xyz>{words(loop.axis)}</xyz></axis>"
    if loop.type == "universal":  # the second axis is in the successor's frame; both are given in the frame on the child here
        turn = (at[loop.successor] @ loop.successor_origin.matrix)[:3, :3].T
        first = turn @ (at[loop.predecessor] @ loop.predecessor_origin.matrix)[:3, :3] @ loop.axis
        axes = f"<axis><xyz>{words(first)}</xyz></axis><axis2><xyz>{words(loop.axis2)}</xyz></axis2>"
    pose = words((*loop.successor_origin.xyz, *loop.successor_origin.rpy))
    return (
        f'<gazebo><joint name="{loop.name}" type="{kind}"><parent>{loop.predecessor}</parent><child>{loop.successor}</child>'
        f"<pose>{pose}</pose>{axes if kind != 'ball' else ''}</joint></gazebo>"
    )


def drake_ball(loop):
    points = words(loop.predecessor_origin.xyz), words(loop.successor_origin.xyz)
    return (
        '<drake:ball_constraint xmlns:drake="http://drake.mit.edu">'
        f'<drake:ball_constraint_body_A name="{loop.predecessor}"/><drake:ball_constraint_body_B name="{loop.successor}"/>'
        f'<drake:ball_constraint_p_AP value="{points[0]}"/><drake:ball_constraint_p_BQ value="{points[1]}"/>'
        "</drake:ball_constraint>"
    )


def loop_closures(robot):
    """The YAML text of scikit-robot and of the exporter for SolidWorks."""
    at, lines = frames(robot.description), ["# Closed-loop closures for loop_closure_relay (runtime IK).", "closures:"]
    for loop in robot.description.loops.values():
        frame = at[loop.predecessor] @ loop.predecessor_origin.matrix
        point, axis = frame[:3, 3].tolist(), (frame[:3, :3] @ loop.axis).tolist()
        lines += [f"- link_a: {loop.predecessor}", f"  link_b: {loop.successor}", f"  point: {point}", f"  axis: {axis}"]
    movable = [name for name, joint in robot.description.joints.items() if joint.type != "fixed"]
    driven = list(robot.description.actuated)
    lines += [f"dependent: [{', '.join(name for name in movable if name not in driven)}]", f"independent: [{', '.join(driven)}]"]
    return "\n".join(lines) + "\n"
