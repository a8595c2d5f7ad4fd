"""Robot files of the tests, written element by element, and the simplest machines made of them."""

import numpy as np

import kinetostatics as ks
from kinetostatics.files.reader import parse_robot_text

E, RHO = 2.0e11, 7850.0
THERMAL_EXPANSION = 1.2e-5
CIRCLE = '<circle diameter="0.05"/>'
AREA = 1e-4  # of the bars of trusses
BEAM = f'youngs_modulus="{E}" poisson_ratio="0.3" shear_coefficient="inf"'
#: A section that is elastic along its axis only, for trusses.
BAR = f'<section area="{AREA}" I_y="1" I_z="1" J="1"/>'
#: Length of the stem on the truss.
STEM = 0.5


def robot(*parts, platform="platform"):
    return ks.Robot(parse_robot_text(f'<robot name="r">{"".join(parts)}<platform link="{platform}"/></robot>'))


def link(name, mass=0.0, com="0 0 0"):
    if not mass:
        return f'<link name="{name}"/>'
    return (
        f'<link name="{name}"><inertial><origin xyz="{com}"/><mass value="{mass}"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def joint(name, kind, parent, child, xyz="0 0 0", axis="0 1 0", rpy="0 0 0"):
    along = "" if kind in ("fixed", "floating") else f'<axis xyz="{axis}"/>'
    limits = '<limit lower="-9" upper="9" effort="1" velocity="1"/>' if kind in ("revolute", "prismatic") else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin rpy="{rpy}" xyz="{xyz}"/>'
        f"{along}{limits}</joint>"
    )


def loop(name, kind, predecessor, successor, at="0 0 0", there="0 0 0", axis=None):
    along = "" if axis is None else f'<axis xyz="{axis}"/>'
    return (
        f'<loop name="{name}" type="{kind}"><predecessor link="{predecessor}"><origin xyz="{at}"/></predecessor>'
        f'<successor link="{successor}"><origin xyz="{there}"/></successor>{along}</loop>'
    )


def bar(link_name, start, end, density=0.0, section=BAR):
    y = "" if section is not BAR else ' y_axis="0 1 0"'
    return f'<beam link="{link_name}" from="{start}" to="{end}" density="{density}"{y} {BEAM}>{section}</beam>'


def truss():
    """Three pinned bars in the plane y = 0 from base points x = −1, 0, 1 to a pin at height 1; an elastic stem on the pin.

    A weld behind two slides lets the pin move in the plane but not turn.
    """
    parts = [link("base"), link("pin"), link("stem"), link("platform", 2.0), link("guide"), link("slide")]
    for k, x in enumerate((-1, 0, 1)):
        length, angle = float(np.hypot(x, 1)), float(np.arctan2(-x, 1))
        parts += [link(f"bar_{k}"), joint(f"foot_{k}", "continuous", "base", f"bar_{k}", f"{x} 0 0", rpy=f"0 {angle!r} 0")]
        if k == 1:
            parts += [joint("head_1", "continuous", "bar_1", "pin", "0 0 1")]
        else:
            parts += [loop(f"head_{k}", "revolute", f"bar_{k}", "pin", f"0 0 {length!r}", "0 0 0", "0 1 0")]
        parts += [bar(f"bar_{k}", f"foot_{k}", f"head_{k}")]
    parts += [joint("stem_foot", "fixed", "pin", "stem"), joint("stem_head", "fixed", "stem", "platform", f"0 0 {STEM}")]
    parts += [bar("stem", "stem_foot", "stem_head"), joint("along", "prismatic", "base", "guide", "0 0 1", "1 0 0")]
    parts += [joint("up", "prismatic", "guide", "slide", "0 0 0", "0 0 1"), loop("weld", "fixed", "slide", "pin")]
    return robot(*parts)


def parallelogram_parts(density=RHO, crank_joint="continuous"):
    """A table on two equal vertical cranks of length 1, hinged at both ends, whose turning is actuated at one foot."""
    circle = '<circle diameter="0.05"/>'
    parts = [link("base"), link("platform", 4.0, "0.25 0 0")]
    for k, x in enumerate((0.0, 0.5)):
        parts += [link(f"crank_{k}"), joint(f"foot_{k}", "continuous", "base", f"crank_{k}", f"{x} 0 0")]
    parts += [joint("head_0", crank_joint, "crank_0", "platform", "0 0 1")]
    parts += [loop("head_1", "revolute", "crank_1", "platform", "0 0 1", "0.5 0 0", "0 1 0")]
    parts += [bar(f"crank_{k}", f"foot_{k}", f"head_{k}", density, circle) for k in (0, 1)]
    return [*parts, '<transmission name="t"><joint name="foot_0"/></transmission>']


def parallelogram():
    return robot(*parallelogram_parts())


def springs(name, **values):
    return f'<joint_stiffness joint="{name}" ' + " ".join(f'{key}="{value}"' for key, value in values.items()) + "/>"


def mount(*more, kind="fixed", axis="0 1 0"):
    """A platform that a single joint without links joins to the base, 0.3 above it."""
    return robot(link("base"), link("platform", 3.0), joint("mount", kind, "base", "platform", "0 0 0.3", axis), *more)


def arm(*more, actuated=True, elastic=True, kind="revolute"):
    """A two-jointed arm in the plane y = 0: links of 0.4 and 0.3 along x at zero, the platform at its tip."""
    parts = [link("base"), link("upper", 2.0, "0.2 0 0"), link("fore", 1.0, "0.15 0 0"), link("platform", 0.5)]
    parts += [joint("shoulder", kind, "base", "upper"), joint("elbow", kind, "upper", "fore", "0.4 0 0")]
    parts += [joint("wrist", "fixed", "fore", "platform", "0.3 0 0")]
    if elastic:
        parts += [bar("upper", "shoulder", "elbow", RHO, CIRCLE), bar("fore", "elbow", "wrist", RHO, CIRCLE)]
    if actuated:
        parts += [f'<transmission name="t_{name}"><joint name="{name}"/></transmission>' for name in ("shoulder", "elbow")]
    return robot(*parts, *more)


def two_columns():
    """Two equal vertical columns, 0.4 apart, clamped to base and platform."""
    column = (
        '<beam link="{0}" from="foot_{0}" to="head_{0}" youngs_modulus="{1}" poisson_ratio="0.3" density="0" '
        'thermal_expansion="{2}" shear_coefficient="inf"><circle diameter="0.05"/></beam>'
    )
    parts = [link("base"), link("a"), link("b"), link("platform", 5.0)]
    parts += [joint("foot_a", "fixed", "base", "a"), joint("foot_b", "fixed", "base", "b", "0.4 0 0")]
    parts += [joint("head_a", "fixed", "a", "platform", "0 0 1"), loop("head_b", "fixed", "b", "platform", "0 0 1", "0.4 0 0")]
    parts += [column.format(name, E, THERMAL_EXPANSION) for name in "ab"]
    return ks.Robot(
        parse_robot_text(f'<robot name="r">{"".join(parts)}<platform link="platform"><origin xyz="0.2 0 0"/></platform></robot>')
    )
