"""Robot files with xacro arguments, of which closed forms are known."""

import textwrap

HEAD = '<robot name="{}" xmlns:xacro="http://www.ros.org/wiki/xacro">'
BEAM = 'youngs_modulus="$(arg E)" poisson_ratio="0.3" shear_coefficient="inf"'
E, RHO = 2e11, 7850.0
INERTIA = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'


def cantilever(folder):
    """A round rod from the base along x, clamped; the platform is its tip."""
    text = f"""\
        {HEAD.format("cantilever")}
          <xacro:arg name="length" default="0.8"/><xacro:arg name="diameter" default="0.04"/>
          <xacro:arg name="E" default="2e11"/><xacro:arg name="density" default="7850"/>
          <xacro:arg name="tip_mass" default="5"/><xacro:arg name="colour" default="red"/><xacro:arg name="holes" default="0"/>
          <link name="base"/><link name="rod"/>
          <link name="tip"><inertial><mass value="$(arg tip_mass)"/>{INERTIA}</inertial></link>
          <joint name="clamp" type="fixed"><parent link="base"/><child link="rod"/></joint>
          <joint name="end" type="fixed"><parent link="rod"/><child link="tip"/><origin xyz="$(arg length) 0 0"/></joint>
          <beam link="rod" from="clamp" to="end" density="$(arg density)" {BEAM}><circle diameter="$(arg diameter)"/></beam>
          <platform link="tip"/>
        </robot>"""
    path = folder / "cantilever.urdf.xacro"
    path.write_text(textwrap.dedent(text), encoding="utf-8")
    return path


LIMIT = '<limit lower="-3" upper="3" effort="1" velocity="1"/>'


def moving(name, kind, parent, child, axis, origin="0 0 0"):
    """Return a joint that moves, and its child."""
    return (
        f'<link name="{child}"/><joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{origin}"/><axis xyz="{axis}"/>{LIMIT}</joint>'
    )


def pinned_truss(folder, directions):
    """Round bars from base points at ``radius`` in given directions to one point at ``height``, which does not turn.

    A platform on passive slides is held by the bars alone. Two bars stand in the plane y = 0, with hinges at both ends; more have
    a universal joint at the foot and a spherical one at the tip.
    """
    flat = len(directions) == 2
    parts = [moving("slide_x", "prismatic", "base", "first", "1 0 0")]
    parts += [] if flat else [moving("slide_y", "prismatic", "first", "second", "0 1 0")]
    parts += [moving("slide_z", "prismatic", "first" if flat else "second", "tip", "0 0 1", "0 0 ${height}")]
    for k, (x, y) in enumerate(directions):
        foot, tip = f"${{{x}*radius}} ${{{y}*radius}} 0", f"${{-({x})*radius}} ${{-({y})*radius}} ${{height}}"
        if flat:
            parts.append(moving(f"foot_{k}", "revolute", "base", f"bar_{k}", "0 1 0", foot))
        else:
            parts.append(moving(f"swing_{k}", "revolute", "base", f"cross_{k}", "1 0 0", foot))
            parts.append(moving(f"foot_{k}", "revolute", f"cross_{k}", f"bar_{k}", "0 1 0"))
        pin = (
            f'<loop name="pin_{k}" type="{"revolute" if flat else "spherical"}"><predecessor link="bar_{k}"><origin xyz="{tip}"/>'
        )
        axis = '<axis xyz="0 1 0"/>' if flat else ""
        parts.append(f'{pin}</predecessor><successor link="tip"/>{axis}</loop>')
        bar = f'<beam link="bar_{k}" from="foot_{k}" to="pin_{k}" density="{RHO}" {BEAM}>'
        parts.append(f'{bar}<circle diameter="$(arg diameter)"/></beam>')
    text = f"""\
        {HEAD.format("truss")}
          <xacro:arg name="radius" default="0.4"/><xacro:arg name="height" default="0.7"/>
          <xacro:arg name="diameter" default="0.02"/><xacro:arg name="E" default="2e11"/>
          <xacro:property name="radius" value="$(arg radius)"/><xacro:property name="height" value="$(arg height)"/>
          <link name="base"/>
          {"".join(parts)}
          <platform link="tip"/>
        </robot>"""
    path = folder / f"truss_{len(directions)}.urdf.xacro"
    path.write_text(textwrap.dedent(text), encoding="utf-8")
    return path
