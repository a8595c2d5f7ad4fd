"""``<loop_joint>``, an element of Isaac Sim's URDF importer and exporter.

.. code-block:: xml

    <loop_joint name="loop" type="spherical">
      <link1 link="rod" xyz="0 0 0.3" rpy="0 0 0"/>
      <link2 link="platform" xyz="0.1 0 0" rpy="0 0 0"/>
    </loop_joint>

The importer (https://github.com/isaac-sim/urdf-importer-extension, ``UrdfParser.cpp`` ``parseLoopJoints`` and
``UrdfImporter.cpp`` ``addLoopJoints``) takes the joint's pose in each link from ``xyz`` and ``rpy``, and makes a joint of it
only if its type is ``spherical``. The exporter (``isaacsim.asset.exporter.urdf``) also writes ``revolute``, ``prismatic`` and
``fixed``. Neither reads or writes an axis. The documentation of the importer calls both sides ``<link1>``
(https://docs.isaacsim.omniverse.nvidia.com, "URDF Importer Extension"), which the importer itself does not read.
"""

from __future__ import annotations

from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.exceptions import near_names
from kinetostatics.files.attribute_values import reference
from kinetostatics.files.foreign.loop import ForeignLoop, SourceRobot
from kinetostatics.files.tables import NAME, POINT, TEXT, VECTOR, ElementTable, Row
from kinetostatics.files.xml import XmlElement

#: The importer's types that a loop can have.
TYPES = ("fixed", "revolute", "continuous", "prismatic", "planar", "spherical")
_ZERO = (0.0, 0.0, 0.0)
LOOP_JOINT = ElementTable(
    "loop_joint",
    {
        "": (Row("name", NAME), Row("type", TEXT, None)),
        **{
            side: (
                Row("link", TEXT, name=end),
                Row("xyz", POINT, _ZERO, f"{end}_origin.xyz"),
                Row("rpy", VECTOR, _ZERO, f"{end}_origin.rpy"),
            )
            for side, end in (("link1", "predecessor"), ("link2", "successor"))
        },
        "axis": (Row("xyz", TEXT, None),),
    },
)


def read(source: SourceRobot) -> list[ForeignLoop]:
    """Return the loops of all ``<loop_joint>``.

    Raises:
        RobotFileError: one of them is malformed, or joins links that do not exist.
    """
    return [_loop(source, element) for element in source.root.named("loop_joint")]


def _loop(source: SourceRobot, element: XmlElement) -> ForeignLoop:
    sides = [item for item in element.children if item.tag in ("link1", "link2")]
    if [item.tag for item in sides] == ["link1", "link1"]:
        raise sides[1].error(f"{element.label} has two <link1>; call the second one <link2>, as Isaac Sim's importer requires")
    found = LOOP_JOINT.read(element)
    kind, axis = found["type"], found.pop("xyz")
    if kind in JOINT_TYPES and JOINT_TYPES[kind].is_free:
        raise element.error(f"{element.label} is {kind}, which joins nothing; take it out")
    if kind is not None and kind not in TYPES:
        raise element.error(f"{element.label} has the type {kind!r}, which is none of Isaac Sim's; {near_names(kind, TYPES)}")
    for side in sides:
        reference(side, "link", source.links, "link")
    if found["predecessor"] == found["successor"]:
        raise element.error(f"{element.label} joins the link {found['predecessor']!r} to itself")
    note = "" if axis is None else f"its <axis xyz={axis!r}> is not an element of Isaac Sim's format"
    return ForeignLoop(**found, axis=None, place=element.place, note=note)
