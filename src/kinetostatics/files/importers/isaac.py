"""``<loop_joint>``, an element of Isaac Sim's URDF importer and exporter.

.. code-block:: xml

    <loop_joint name="loop" type="spherical">
      <link1 link="rod" xyz="0 0 0.3" rpy="0 0 0"/>
      <link2 link="platform" xyz="0.1 0 0" rpy="0 0 0"/>
    </loop_joint>

The importer (https://github.com/isaac-sim/urdf-importer-extension, ``UrdfParser.cpp`` ``parseLoopJoints`` and
``UrdfImporter.cpp`` ``addLoopJoints``) takes the joint's pose in each link from ``xyz`` and ``rpy``, and makes a joint of it
only if its type is ``spherical``. The exporter (``isaacsim.asset.exporter.urdf``) also writes ``revolute``, ``prismatic`` and
``fixed``. Neither knows an axis. The documentation of the importer calls both sides ``<link1>``
(https://docs.isaacsim.omniverse.nvidia.com, "URDF Importer Extension"), which the importer itself does not read.
"""

from __future__ import annotations

from kinetostatics.description.elements import Origin
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.exceptions import near_names
from kinetostatics.files.attribute_values import allow, new_name, point, reference, vector
from kinetostatics.files.importers.loop_record import ForeignLoop, SourceRobot
from kinetostatics.files.xml import Element

#: The importer's types that a loop can have.
TYPES = ("fixed", "revolute", "continuous", "prismatic", "planar", "spherical")


def read(source: SourceRobot) -> list[ForeignLoop]:
    """Return the loops of all ``<loop_joint>``.

    Raises:
        RobotFileError: one of them is malformed, or joins links that do not exist.
    """
    return [_loop(source, element) for element in source.root.named("loop_joint")]


def _loop(source: SourceRobot, element: Element) -> ForeignLoop:
    name = new_name(element)
    allow(element, ("name", "type"), ("link1", "link2", "axis"))
    kind = _type(element)
    sides = [item for item in element.children if item.tag in ("link1", "link2")]
    if [item.tag for item in sides] == ["link1", "link1"]:
        raise sides[1].error(f"{element.label} has two <link1>; call the second one <link2>, as Isaac Sim's importer wants")
    (first, first_origin), (second, second_origin) = (_side(element, tag, source) for tag in ("link1", "link2"))
    if first == second:
        raise element.error(f"{element.label} joins the link {first!r} to itself")
    axis = element.child("axis")
    note = "" if axis is None else f"its <axis xyz={axis.attributes.get('xyz', '')!r}> is not an element of Isaac Sim's format"
    return ForeignLoop(name, kind, first, first_origin, second, second_origin, None, element.place, note)


def _type(element: Element) -> str | None:
    kind = element.attributes.get("type", "").strip()
    if not kind:
        return None
    if kind in JOINT_TYPES and JOINT_TYPES[kind].is_free:
        raise element.error(f"{element.label} is {kind}, which joins nothing; take it out")
    if kind not in TYPES:
        raise element.error(f"{element.label} has the type {kind!r}, which Isaac Sim does not have; {near_names(kind, TYPES)}")
    return kind


def _side(element: Element, tag: str, source: SourceRobot) -> tuple[str, Origin]:
    side = element.required_child(tag)
    allow(side, ("link", "xyz", "rpy"))
    readers = {"xyz": point, "rpy": vector}
    origin = Origin(**{name: read(side, name) for name, read in readers.items() if name in side.attributes})
    return reference(side, "link", source.links, "link"), origin
