"""Writers of robots in formats of other tools, each in the syntax of its tool, independent of the readers of the package."""

import xml.etree.ElementTree as ET

import numpy as np
import pinocchio

import kinetostatics as ks

ET.register_namespace("drake", "http://drake.mit.edu")


def frames(description, coordinates=None):
    """Frames of links relative to the root, at coordinates of joints with one freedom, zero for those that are not given."""
    coordinates = coordinates or {}
    result = {}
    children = {joint.child for joint in description.joints.values()}
    result |= {link: np.eye(4) for link in description.links if link not in children}
    while len(result) < len(description.links):
        for joint in description.joints.values():
            if joint.parent in result:
                move, value, axis = np.eye(4), coordinates.get(joint.name, 0.0), np.array(joint.axis)
                if joint.type == "prismatic":
                    move[:3, 3] = value * axis
                elif value:
                    move[:3, :3] = pinocchio.AngleAxis(value, axis).matrix()
                result[joint.child] = result[joint.parent] @ joint.origin.matrix @ move
    return result


def words(values):
    return " ".join(repr(float(value)) for value in values)


def connections(description):
    """Joints and loops: name, type, first link, frame on it, second link, frame on it, axis, second axis, limits."""
    for joint in description.joints.values():
        limits = joint.lower, joint.upper, joint.effort, joint.velocity
        yield joint.name, joint.type, joint.parent, joint.origin, joint.child, None, joint.axis, None, limits
    for loop in description.loops.values():
        ends = loop.predecessor, loop.predecessor_origin, loop.successor, loop.successor_origin
        yield loop.name, loop.type, *ends, loop.axis, loop.axis2, (loop.lower, loop.upper, loop.effort, loop.velocity)


def with_loops_as(robot, path, writer):
    """Save a robot with its loops in another format: ``writer`` returns elements for a loop."""
    ks.save_robot(robot, path)
    tree = ET.parse(path)
    for element in tree.getroot().findall("loop"):
        tree.getroot().remove(element)
    for loop in robot.description.loops.values():
        tree.getroot().extend(ET.fromstring(f"<loop>{writer(loop)}</loop>"))
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


def closing_joints(robot):
    """The YAML text of fusion2URDF: frames of joints with the axes of the child's link, at the joint."""
    at, lines = frames(robot.description), ["joints:"]
    for name, joint in robot.description.joints.items():
        passive = str(name not in robot.description.actuated).lower()
        lines += [f"  {name}:", f"    type: {joint.type}", f"    passive: {passive}"]
    lines += ["closing_joints:"]
    for loop in robot.description.loops.values():
        joint, child = at[loop.predecessor] @ loop.predecessor_origin.matrix, at[loop.successor].copy()
        child[:3, 3] = joint[:3, 3]
        pose = list(map(float, ks_pose(np.linalg.solve(at[loop.predecessor], child))))
        axis = (child[:3, :3].T @ joint[:3, :3] @ loop.axis).tolist()
        lines += [f"  - name: {loop.name}", f"    type: {loop.type}", f"    parent: {loop.predecessor}"]
        lines += [f"    child: {loop.successor}", f"    origin_xyz_m: {pose[:3]}", f"    origin_rpy_rad: {pose[3:]}"]
        lines += [f"    axis: {axis}"]
        if np.isfinite(loop.lower):
            lines += ["    limits:", f"      lower: {loop.lower}", f"      upper: {loop.upper}", "      effort: 100.0"]
    return "\n".join(lines) + "\n"


def bushing(loop, stiffness):
    """Drake's bushing between the two frames of a loop; ``stiffness``: translations, then rotations."""
    ends = (("A", loop.predecessor, loop.predecessor_origin), ("C", loop.successor, loop.successor_origin))
    lines = ['<drake:linear_bushing_rpy xmlns:drake="http://drake.mit.edu">']
    lines += [f'<drake:bushing_frame{side} name="{loop.name}_{side}"/>' for side, _, _ in ends]
    for what, numbers in (("torque", stiffness[3:]), ("force", stiffness[:3])):
        lines.append(f'<drake:bushing_{what}_stiffness value="{words(numbers)}"/><drake:bushing_{what}_damping value="1 1 1"/>')
    lines.append("</drake:linear_bushing_rpy>")
    for side, link, origin in ends:
        lines.append(f'<frame name="{loop.name}_{side}" link="{link}" xyz="{words(origin.xyz)}" rpy="{words(origin.rpy)}"/>')
    return "".join(lines)


def sdf(description, joint_frames="child"):
    """A robot as SDFormat 1.8, with the frames of joints relative to the child, or to the model if ``joint_frames`` is so."""
    at = frames(description)
    lines = ['<sdf version="1.8">', f'<model name="{description.name}">']
    for name, link in description.links.items():
        xx, xy, xz, yy, yz, zz = link.inertia.moments
        pose = ks_pose(at[name])
        tensor = f"<ixx>{xx!r}</ixx><ixy>{xy!r}</ixy><ixz>{xz!r}</ixz><iyy>{yy!r}</iyy><iyz>{yz!r}</iyz><izz>{zz!r}</izz>"
        inertial = words((*link.center_of_mass, *link.inertia.rpy))
        mass = f"<inertial><pose>{inertial}</pose><mass>{link.mass!r}</mass><inertia>{tensor}</inertia></inertial>"
        lines.append(f'<link name="{name}"><pose>{words(pose)}</pose>{mass if link.mass else ""}</link>')
    for name, kind, parent, origin, child, end, axis, axis2, (lower, upper, effort, velocity) in connections(description):
        frame = at[parent] @ origin.matrix if end is None else at[child] @ end.matrix
        limit = (
            f"<limit><lower>{lower}</lower><upper>{upper}</upper><effort>{effort}</effort><velocity>{velocity}</velocity></limit>"
        )
        limit = limit if np.isfinite(lower) else ""
        vectors = [frame[:3, :3].T @ (at[parent] @ origin.matrix)[:3, :3] @ axis, axis2]
        if joint_frames == "model":
            where, turn, marked = (
                f'<pose relative_to="__model__">{words(ks_pose(frame))}</pose>',
                frame[:3, :3],
                ' expressed_in="__model__"',
            )
        else:
            where = f"<pose>{words(ks_pose(np.linalg.inv(at[child]) @ frame))}</pose>"
            turn, marked = np.eye(3), ""
        text = "".join(
            f"<{tag}><xyz{marked}>{words(turn @ vector)}</xyz>{limit}</{tag}>"
            for tag, vector in zip(("axis", "axis2"), vectors, strict=True)
            if vector is not None and kind not in ("fixed", "spherical") and (tag == "axis" or kind == "universal")
        )
        kind = {"spherical": "ball"}.get(kind, kind)
        lines.append(f'<joint name="{name}" type="{kind}">{where}<parent>{parent}</parent><child>{child}</child>{text}</joint>')
    for name in description.actuated:
        lines.append(
            '<plugin filename="gz-sim-joint-position-controller-system" name="gz::sim::systems::JointPositionController">'
        )
        lines.append(f"<joint_name>{name}</joint_name></plugin>")
    return "\n".join((*lines, "</model>", "</sdf>"))


def ks_pose(matrix):
    """xyz and roll, pitch, yaw, by Pinocchio."""
    return [*matrix[:3, 3], *pinocchio.rpy.matrixToRpy(matrix[:3, :3])]


def mjcf(description):
    """A robot whose loops are spherical or fixed as MJCF, bodies nested along its tree."""
    below = {}
    for joint in description.joints.values():
        below.setdefault(joint.parent, []).append(joint)
    roots = [link for link in description.links if link not in {joint.child for joint in description.joints.values()}]

    def joint_lines(joint, into):
        """A joint in the body's frame; ``into``: the joint's frame relative to it."""
        if joint.type == "fixed":
            return []
        kind, limits = {"prismatic": "slide"}.get(joint.type, "hinge"), ""
        if np.isfinite(joint.lower):
            limits = f' range="{words((joint.lower, joint.upper))}"'
        where = f'pos="{words(into[:3, 3])}" axis="{words(into[:3, :3] @ joint.axis)}"'
        return [f'<joint name="{joint.name}" type="{kind}" {where}{limits}/>']

    def body(name, frame, above):
        """Lines of a body; the links without mass that hold it, whose joints are ``above``, are none in MuJoCo."""
        link, after = description.links[name], below.get(name, [])
        if not link.mass and above and len(after) == 1:
            (joint,) = after
            turned = [(one, np.linalg.inv(joint.origin.matrix) @ into) for one, into in above]
            return body(joint.child, frame @ joint.origin.matrix, [*turned, (joint, np.eye(4))])
        lines = [f'<body name="{name}"{placed(frame)}>']
        if link.mass:
            moments = link.inertia.matrix[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)]
            where = f'pos="{words(link.center_of_mass)}" mass="{link.mass!r}" fullinertia="{words(moments)}"'
            lines.append(f"<inertial {where}/>")
        lines += [line for joint, into in above for line in joint_lines(joint, into)]
        lines += [line for child in after for line in body(child.child, child.origin.matrix, [(child, np.eye(4))])]
        return [*lines, "</body>"]

    equalities = []
    for loop in description.loops.values():
        bodies = f'name="{loop.name}" body1="{loop.predecessor}" body2="{loop.successor}"'
        equalities.append(f'<connect {bodies} anchor="{words(loop.predecessor_origin.xyz)}"/>')
    drives = [f'<motor name="drive_{name}" joint="{name}"/>' for name in description.actuated]
    return "\n".join(
        (
            f'<mujoco model="{description.name}"><compiler angle="radian" autolimits="true" balanceinertia="true"/>',
            *("<worldbody>", *(line for root in roots for line in body(root, np.eye(4), [])), "</worldbody>"),
            *("<equality>", *equalities, "</equality>", "<actuator>", *drives, "</actuator>", "</mujoco>"),
        )
    )


def placed(matrix):
    x, y, z, w = pinocchio.Quaternion(np.ascontiguousarray(matrix[:3, :3])).coeffs()
    return f' pos="{words(matrix[:3, 3])}" quat="{words((w, x, y, z))}"'
