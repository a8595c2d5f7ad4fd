"""Small robots with something odd about them, for what ``kinetostatics check`` says of it: slips of the pen, and shapes.

Each is a function without arguments that returns a robot; its docstring says what is odd.
"""

import re
from dataclasses import replace

import small_robots as small
from mechanisms import Beam, Edge, Joint, Link, Mechanism, Stiffness, circle, write_mechanism
from places import ROBOTS

import kinetostatics as ks
from kinetostatics.description import Loop
from kinetostatics.files.reader import parse_robot_text

Y = (0.0, 1.0, 0.0)


def parsed(text):
    return ks.Robot(parse_robot_text(text))


def written(edges, beams, cuts, links=(), name="odd", **more):
    """Return a robot of joints (name, kind, centre, inner link, outer link, further arguments) and beams (link, start, end)."""
    joints = tuple(Edge(Joint(n, kind, tuple(map(float, c)), **rest), a, b) for n, kind, c, a, b, rest in edges)
    found = tuple(Beam(link, link, start, end, circle(0.03), **rest) for link, start, end, rest in beams)
    mechanism = Mechanism(joints, tuple(links), found, name=name, **{"mass": 2.0, **more})
    return write_mechanism(mechanism, cuts=set(cuts)).text


def four_bar(**changes):
    """A planar four-bar linkage: the coupler is the platform, its actuated crank is ``left``."""
    text = written(
        [
            ("foot", "R", (0, 0, 0), "base", "left", {"axis": Y, "actuated": True, **changes.pop("foot", {})}),
            ("head", "R", (0, 0, 0.5), "left", "platform", {"axis": Y}),
            ("other_foot", "R", (0.4, 0, 0), "base", "right", {"axis": Y}),
            ("other_head", "R", (0.5, 0, 0.6), "right", "platform", {"axis": Y, **changes.pop("other_head", {})}),
        ],
        [("left", "foot", "head", {}), ("right", "other_foot", "other_head", {})],
        {"other_head"},
        o=(0.2, 0, 0.5),
        name="four_bar",
        **changes,
    )
    return text


# ---- slips of the pen --------------------------------------------------------------------------------------------------


def units_of_sections():
    """A diameter in mm, a modulus in GPa, a density in g/cm³."""
    return ks.load_robot(ROBOTS / "3rps.urdf.xacro", parameters={"rod_diameter": 100, "youngs_modulus": 200, "density": 7.82})


def units_of_lengths():
    """A whole robot in mm."""
    text = four_bar()
    larger = re.sub(r'(xyz=")([^"]*)"', lambda found: f'{found[1]}{_times(found[2], 1000)}"', text)
    return parsed(larger.replace('axis xyz="0.0 1000.0 0.0"', 'axis xyz="0 1 0"'))


def _times(numbers, factor):
    return " ".join(repr(float(number) * factor) for number in numbers.split())


def stubby_and_wiry():
    """A beam that is too thick, and one as thin as a hair; a shear modulus that does not fit; a large thermal expansion."""
    text = four_bar().replace('<circle diameter="0.03"/>', '<circle diameter="0.2"/>', 1)
    text = text.replace('<circle diameter="0.03"/>', '<circle diameter="3e-5"/>')
    text = text.replace('poisson_ratio="0.3"', 'shear_modulus="400e9"', 1)
    return parsed(text.replace('density="7850.0"', 'density="7850" thermal_expansion="12"'))


def masses():
    """A link whose <inertial> says otherwise than its beam's density, one whose density is 0, and one with neither."""
    inertial = '<inertial><mass value="{}"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    chain = [
        ("one", "R", (0, 0, 0), "base", "heavy", {"axis": Y, "actuated": True}),
        ("two", "R", (0.5, 0, 0), "heavy", "light", {"axis": Y, "actuated": True}),
        ("three", "R", (1, 0, 0), "light", "bare", {"axis": Y, "actuated": True}),
        ("four", "F", (1.5, 0, 0), "bare", "platform", {}),
    ]
    beams = [
        ("heavy", "one", "two", {}),
        ("light", "two", "three", {"density": 0.0}),
        ("bare", "three", "four", {"density": None}),
    ]
    text = written(chain, beams, (), name="masses", o=(1.5, 0, 0))
    text = text.replace('<link name="heavy"/>', f'<link name="heavy">{inertial.format(12)}</link>')
    return parsed(text.replace('<link name="light"/>', f'<link name="light">{inertial.format(1.5)}</link>'))


def rounded_angles():
    """An overconstrained robot with five digits of everything."""
    return parsed(re.sub(r"\d\.\d{6,}", lambda number: f"{float(number[0]):.5f}", small.write(small.pru2_upr(), twirl=1).text))


def far_from_closed():
    """A zero configuration in which the loop gapes, although the actuator may stay where it is."""
    return parsed(re.sub(r'(<successor link="platform"><origin xyz=")\S+', r"\g<1>0.65", four_bar()))


def drive_out_of_reach():
    """A slider-crank whose actuator at zero is out of reach of the rod."""
    text = written(
        [
            ("slide", "P", (1.2, 0, 0), "base", "slider", {"axis": (1, 0, 0), "actuated": True}),
            ("ankle", "R", (1.2, 0, 0), "slider", "rod", {"axis": Y}),
            ("knee", "R", (0.7, 0, 0.1), "rod", "platform", {"axis": Y}),
            ("pivot", "R", (0, 0, 0), "base", "platform", {"axis": Y}),
        ],
        [("rod", "ankle", "knee", {})],
        {"pivot"},
        o=(0.4, 0, 0.1),
        name="stretched",
    )
    return parsed(re.sub(r'(<successor link="platform"><origin xyz=")\S+', r"\g<1>-0.3", text))


def beyond_limits():
    """An actuator whose limits leave zero out."""
    return parsed(four_bar().replace('lower="-10" upper="10"', 'lower="0.2" upper="1.5"', 1))


def open_loops():
    """A loop that no pose closes, and a rigid crank."""
    text = four_bar()
    text = re.sub(r'(<predecessor link="right"><origin xyz=")\S+', r"\g<1>9.0", text)
    return parsed(re.sub(r'<beam name="right".*', "", text))


def soft_and_hard_joints():
    """Stiffnesses in N/µm and N·m/mrad instead of SI, one that is beyond everything, and a flexure that may be soft."""
    bearing = Stiffness(linear=(50.0, 2e8, 2e8), angular=(3e4, float("inf"), 3e4), drive=20.0)
    flexure = Stiffness(linear=(1e13, 2e8, 2e8), angular=(3e4, 5.0, 3e4))
    return parsed(four_bar(foot={"stiffness": bearing}, other_head={"stiffness": flexure}, mass=40.0))


def no_drives():
    """Nothing is actuated."""
    return parsed(four_bar(foot={"actuated": False}))


def two_drives():
    """Two actuators for one freedom."""
    return parsed(four_bar(other_head={"actuated": True}))


def rigid_limbs():
    """No beams at all."""
    return parsed(re.sub(r"<beam .*", "", four_bar()))


# ---- shapes ------------------------------------------------------------------------------------------------------------


def followers():
    """Two sliders on one rail that a belt moves towards one another, and a tilting head that follows too."""
    inertial = '<inertial><mass value="2"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'
    return parsed(
        f"""<robot name="belt">
  <link name="ground"/><link name="left"/><link name="right"/><link name="left_rod"/><link name="plate">{inertial}</link>
  <link name="lamp">{inertial}</link>
  <joint name="motor" type="prismatic">
    <parent link="ground"/><child link="left"/><axis xyz="1 0 0"/><limit effort="0" velocity="0"/>
  </joint>
  <joint name="belt" type="prismatic">
    <parent link="ground"/><child link="right"/><axis xyz="1 0 0"/><limit effort="0" velocity="0"/>
    <mimic joint="motor" multiplier="-1" offset="0.6"/>
  </joint>
  <joint name="nod" type="continuous">
    <parent link="plate"/><child link="lamp"/><axis xyz="0 1 0"/><mimic joint="motor" multiplier="2.5" offset="-0.1"/>
  </joint>
  <joint name="left_foot" type="continuous">
    <parent link="left"/><child link="left_rod"/><origin rpy="0 0.9272952180016122 0"/><axis xyz="0 1 0"/>
  </joint>
  <joint name="left_head" type="continuous">
    <parent link="left_rod"/><child link="plate"/><origin xyz="0 0 0.5" rpy="0 -0.9272952180016122 0"/><axis xyz="0 1 0"/>
  </joint>
  <platform link="plate"/>
  <loop name="right_foot" type="revolute">
    <predecessor link="right"/><successor link="plate"><origin xyz="0.3 0 -0.4"/></successor><axis xyz="0 1 0"/>
  </loop>
  <beam link="left_rod" from="left_foot" to="left_head" youngs_modulus="70e9" poisson_ratio="0.33" density="2700"
        thermal_expansion="23e-6">
    <circle diameter="0.02"/>
  </beam>
  <transmission name="drive"><joint name="motor"/></transmission>
</robot>"""
    )


def braced_frame():
    """One limb with a brace across its frame, a ring and a pendulum that hang, a pendulum under the platform, and a joint that
    joins base and platform without a link."""
    edges = [
        ("slide", "P", (0, 0, 0), "base", "slider", {"axis": (0, 0, 1), "actuated": True}),
        ("left_foot", "R", (-0.3, 0, 0), "slider", "left", {"axis": Y}),
        ("right_foot", "R", (0.3, 0, 0), "slider", "right", {"axis": Y}),
        ("left_head", "R", (-0.3, 0, 0.5), "left", "left_node", {"axis": Y}),
        ("right_head", "R", (0.3, 0, 0.5), "right", "right_node", {"axis": Y}),
        ("brace_left", "R", (-0.3, 0, 0.5), "left_node", "brace", {"axis": Y}),
        ("brace_right", "R", (0.3, 0, 0.5), "brace", "right_node", {"axis": Y}),
        ("left_arm_foot", "R", (-0.3, 0, 0.5), "left_node", "left_arm", {"axis": Y}),
        ("right_arm_foot", "R", (0.3, 0, 0.5), "right_node", "right_arm", {"axis": Y}),
        ("left_arm_head", "R", (-0.1, 0, 0.9), "left_arm", "platform", {"axis": Y}),
        ("right_arm_head", "R", (0.1, 0, 0.9), "right_arm", "platform", {"axis": Y}),
        ("pin", "E", (0, 0, 0.9), "base", "platform", {"axis": Y}),
        ("hook", "R", (0.2, 0, 0), "slider", "weight", {"axis": Y}),
        ("lamp_hook", "S", (0, 0, 0.9), "platform", "lamp", {}),
        ("ring_1", "R", (-0.6, 0, 0), "base", "ring", {"axis": Y}),
        ("ring_2", "R", (-0.6, 0, 0.3), "ring", "bow", {"axis": Y}),
        ("ring_3", "R", (-0.9, 0, 0), "bow", "base", {"axis": Y}),
    ]  # fmt: skip
    links = [Link("weight", 1.0, (0.2, 0, -0.2)), Link("lamp", 0.5, (0, 0, 0.8)), Link("left_node", 0.1, (-0.3, 0, 0.5)),
             Link("right_node", 0.1, (0.3, 0, 0.5))]  # fmt: skip
    ends = {"left": ("left_foot", "left_head"), "right": ("right_foot", "right_head"), "brace": ("brace_left", "brace_right"),
            "left_arm": ("left_arm_foot", "left_arm_head"), "right_arm": ("right_arm_foot", "right_arm_head")}  # fmt: skip
    beams = [(name, *both, {}) for name, both in ends.items()]
    cuts = {"brace_right", "left_arm_head", "right_arm_head", "ring_3"}
    return parsed(written(edges, beams, cuts, links, o=(0, 0, 0.9), name="braced_frame"))


def seven_axes():
    """A serial arm with seven actuators, which may move with its platform at rest."""
    points = [(0, 0, 0.4 * k) for k in range(8)]
    axes = [(0, 0, 1), Y, (1, 0, 0), Y, (0, 0, 1), Y, (1, 0, 0)]
    return small.robot_of(replace(small.locked_chain(points, axes, mass=3.0), name="seven_axes"))


def loose_parts():
    """A strut of two links that spins between balls, a sleeve that slides, and a hinged lid with two loops on one hinge."""
    base, top = [(-0.3, -0.2, 0), (0.3, -0.2, 0), (0, 0.3, 0)], [(-0.2, -0.1, 0.6), (0.2, -0.1, 0.6), (0, 0.2, 0.6)]
    edges, beams = [], []
    for k, (foot, head) in enumerate(zip(base, top, strict=True), 1):
        along = tuple(h - f for f, h in zip(foot, head, strict=True))
        edges += [
            (f"foot_{k}", "S", foot, "base", f"lower_{k}", {}),
            (f"stroke_{k}", "P", tuple((f + h) / 2 for f, h in zip(foot, head, strict=True)), f"lower_{k}", f"upper_{k}",
             {"axis": along, "actuated": True}),
            (f"head_{k}", "S", head, f"upper_{k}", "platform", {}),
        ]  # fmt: skip
        beams += [(f"lower_{k}", f"foot_{k}", f"stroke_{k}", {}), (f"upper_{k}", f"stroke_{k}", f"head_{k}", {})]
    edges += [
        ("sleeve", "C", (0, 0, 0.6), "platform", "collar", {"axis": (0, 0, 1)}),
        ("hinge_a", "R", (0.3, 0, 0.6), "platform", "lid", {"axis": (0, 1, 0)}),
        ("hinge_b", "R", (0.3, 0.2, 0.6), "platform", "lid", {"axis": (0, 1, 0)}),
        ("mast_foot", "F", (0, 0, 0), "base", "mast", {}),
        ("mast_ball", "S", (0, 0, 0.6), "mast", "platform", {}),
    ]
    beams.append(("mast", "mast_foot", "mast_ball", {}))
    return parsed(
        written(
            edges,
            beams,
            {"head_2", "head_3", "hinge_b", "mast_ball"},
            [Link("collar", 0.2, (0, 0, 0.6))],
            o=(0, 0, 0.6),
            name="loose",
        )
    )


def welded_fork():
    """A Tricept whose passive limb's fork is welded to the base beside its joint: that cannot move, five constraints too many."""
    description = ks.load_robot(ROBOTS / "tricept.urdf.xacro").description
    return ks.Robot(description.with_part(Loop("weld", "fixed", "base", "cross_4")))


ODD = (
    units_of_sections, units_of_lengths, stubby_and_wiry, masses, rounded_angles, far_from_closed, drive_out_of_reach,
    beyond_limits, open_loops, soft_and_hard_joints, no_drives, two_drives, rigid_limbs, followers, braced_frame, seven_axes,
    loose_parts, welded_fork,
)  # fmt: skip
