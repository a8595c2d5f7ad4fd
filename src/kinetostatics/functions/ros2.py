"""ROS 2 packages: controllers of ros2_control around the exported C, and the robot's URDF.

The passive joints of the tree follow from the actuators with all loops closed. robot_state_publisher moves no floating joint: six
single joints replace it.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.exceptions import ArgumentError
from kinetostatics.files.writer import robot_text
from kinetostatics.functions.c_export import recorded, write_files
from kinetostatics.functions.c_names import identifier
from kinetostatics.functions.c_programs import Exported, Programs, array_program
from kinetostatics.functions.c_source import source, valid
from kinetostatics.functions.c_texts import filled, header
from kinetostatics.functions.inputs_outputs import Values
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import matrix_of_quaternion, three_angles
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.mechanism.tree import TreeJoint
from kinetostatics.robot import Robot

_TEMPLATES = Path(__file__).parent / "ros2_package"


def export_ros2(
    function: Exported,
    loops: Exported,
    folder: str | os.PathLike[str],
    name: str | None = None,
    near: Configuration | Values | None = None,
) -> None:
    """Write a function of a robot as a ROS 2 package, see :meth:`Function.export_ros2`.

    ``loops``: the function of all actuators with the output "actuators", whose poses are published.
    """
    robot, prefix = function.robot, identifier(function.robot.name if name is None else name)
    for output in ("actuators", "actuator_forces"):
        if output not in function.outputs:
            raise ArgumentError(f"a ROS 2 package needs the output {output!r}: outputs=('actuators', 'actuator_forces')")
    loops_name, passive = f"{prefix}_loops", list(_passive(robot))
    (_, parts), (_, closing) = recorded(function, near), recorded(loops, near)
    names, measured = ([quantity.name for quantity in part.coordinates] for part in (parts, closing))
    words = {
        "PACKAGE": re.sub("_+", "_", f"{prefix.lower()}_control"),
        "LOOPS_OK": f"{loops_name.upper()}_OK",
        "ROBOT": prefix,
        "IS_VALID": valid(prefix, parts, "status"),
        "NAMES_OF_COORDINATES": _strings(names),
        "NAMES_OF_ACTUATORS": _strings(robot.description.actuated),
        "NAMES_OF_MEASURED": _strings(measured),
        "NAMES_OF_PASSIVE": _strings(name for name, *_ in passive),
        "SET_REFERENCE": ", ".join(f"reference[{k}]" for k in range(len(names))),
        "SET_MEASURED": ", ".join(f"measured({k})" for k in range(len(measured))),
        "REFERENCES": ", ".join(f"pose_controller/{name}" for name in names),
        "START_OF_COORDINATES": ", ".join(str(float(parts.at_start[name])) for name in names),
    }
    texts = {f"{prefix}.urdf": _urdf(robot, closing)}
    for template in sorted(_TEMPLATES.iterdir()):
        texts[f"src/{template.name}" if template.suffix == ".cpp" else template.name] = filled([template], words)
    for part_name, part in ((prefix, parts), (loops_name, closing)):
        texts[f"src/{part_name}.h"] = header(part_name, "double", part)
        texts[f"src/{part_name}.c"] = source(part_name, "double", part)

    def positions(x: Array) -> list[Array]:
        q = robot.equations.to_model(x)
        return [_coordinate(joint, number, q) for _, joint, number in passive]

    program = array_program("positions", {"x": robot.generic_poses.x[:, :1]}, positions)
    texts[f"src/{loops_name}.c"] += f"""
{program.text}
/* Positions of the passive joints [m, rad]. */
void {loops_name}_positions(const {loops_name}_state *state, double *values)
{{
    double work[{max(program.work, 1)}], out[{len(passive) + 1}];
    positions(state->x, work, out);
    memcpy(values, out, {len(passive)} * sizeof *values);
}}
"""
    write_files(folder, texts)


def _strings(names: Iterable[str]) -> str:
    return ", ".join(map(json.dumps, names))


def _passive(robot: Robot) -> Iterator[tuple[str, TreeJoint, int]]:
    """Yield the passive joints without those that mimic others: name, joint of the tree, and number of its coordinate."""
    by_body = {joint.body: joint for joint in robot.mechanism.tree.joints}
    for name, body in robot.mechanism.body_of_joint.items():
        if (joint := by_body.get(body)) and not (name in robot.description.actuated or robot.description.joints[name].mimic):
            if joint.nv not in (1, 6):
                raise ArgumentError(f"the planar joint {name!r} cannot be published: replace it by three single joints")
            yield from [(name, joint, 0)] if joint.nv == 1 else [(f"{name}_{c}", joint, k) for k, c in enumerate(COMPONENTS)]


def _coordinate(joint: TreeJoint, number: int, q: Array) -> Array:
    """Return a coordinate (N,) of a joint, or of the single joints in place of a floating one, at coordinates q (nq, N)."""
    if joint.nv == 1 or number < 3:
        return joint.coordinate(q) if joint.nv == 1 else q[joint.first_q + number]
    R = matrix_of_quaternion(q[joint.first_q + 3 : joint.first_q + 7])
    return np.asarray(three_angles(np.eye(3), R, np.zeros((3, q.shape[1])))[number - 3])


def _urdf(robot: Robot, closing: Programs) -> str:
    """Return the URDF of the tree, with all actuators in simulated hardware."""
    root, folder = ET.fromstring(robot_text(robot.description)), os.path.dirname(robot.description.path or "")
    for mesh in root.iter("mesh"):
        if "://" not in mesh.attrib["filename"]:
            mesh.set("filename", Path(folder, mesh.attrib["filename"]).absolute().as_uri())
    for element in [*root]:
        is_free = element.tag == "joint" and JOINT_TYPES[element.attrib["type"]].is_free
        if is_free or element.tag not in ("link", "joint", "material"):
            root.remove(element)
        if is_free:
            root.extend(_single_joints(element))
    control = ET.SubElement(root, "ros2_control", name="hardware", type="system")
    ET.SubElement(ET.SubElement(control, "hardware"), "plugin").text = "mock_components/GenericSystem"
    for name, value in closing.at_start.items():
        joint = ET.SubElement(control, "joint", name=name)
        joint.extend(ET.Element("command_interface", name=kind) for kind in ("position", "effort"))
        ET.SubElement(ET.SubElement(joint, "state_interface", name="position"), "param", name="initial_value").text = str(value)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _single_joints(floating: ET.Element) -> Iterator[ET.Element]:
    """Yield single joints, and the links between them, that together move as a floating joint."""
    parent, child = (end.attrib["link"] for tag in ("parent", "child") for end in floating.findall(tag))
    for component in COMPONENTS:
        name = f"{floating.attrib['name']}_{component}"
        joint = ET.Element("joint", name=name, type="continuous" if component.startswith("r") else "prismatic")
        joint.extend(floating.findall("origin") if component == "x" else [])
        link = child if component == "rz" else name
        ET.SubElement(joint, "parent", link=parent)
        ET.SubElement(joint, "child", link=link)
        ET.SubElement(joint, "axis", xyz=" ".join(str(int(component.endswith(axis))) for axis in "xyz"))
        ET.SubElement(joint, "limit", lower="-1e3", upper="1e3", effort="0", velocity="1e3")
        yield joint
        if link == name:
            yield ET.Element("link", name=name)
        parent = link
