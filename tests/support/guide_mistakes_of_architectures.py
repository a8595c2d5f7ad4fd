"""The mistakes that are answered when robots are built by name, in the order of the guide's table."""

from guide_mistakes import Mistake, code


def built(architecture: str, cure: str, options: str = "") -> Mistake:
    """Return the mistake of an architecture, or of what else is said of it."""
    return code(f"ks.new_robot({architecture!r}{options and ', '}{options})", cure)


def table(text: str, cure: str) -> Mistake:
    """Return the mistake of a table of placements."""
    source = f"(folder / 'table.csv').write_text({text!r}); ks.new_robot('3-R[P]S', placements=folder / 'table.csv')"
    shown = text.strip().replace("\n", "` and `")
    return code(source, cure, f'`{shown}` in `placements="table.csv"`' if text.strip() else "an empty `table.csv`")


def places(rows: str, cure: str, architecture: str = "R[P]S") -> Mistake:
    """Return the mistake of placements in Python."""
    return built(architecture, cure, f"placements={rows}")


POINTS = "base_x,base_y,base_z,platform_x,platform_y,platform_z"

ARCHITECTURES = (
    built("", "Limbs and joints."),
    code("ks.new_robot('6-' + 'UPS' * 100)", "Limbs that are alike once."),
    built("3-", "A limb behind the number."),
    built("3-RPS+", "Another limb, or no plus."),
    built("99-RPS", "At most twelve."),
    built("7-UPS+7-RPS", "At most twelve."),
    built("3-RXS", "The letters of the table."),
    built("Stewart platform", "The limbs, or a copy of the robot."),
    built("5R", "The same."),
    built("4R", "The limbs."),
    built("Gantry", "The limbs."),
    built("3-R[PS", "`[P]`."),
    built("3-RP]S", "`[P]`."),
    built("3-R[]S", "`[P]`."),
    built("3-R(5S)", "`(4S)` or `(4R)`."),
    built("3-RPR[S]", "R, P and C are driven."),
    built("3-SS", "A joint that can be driven."),
    built("RRRRRRRRR", "Two limbs, perhaps."),
    built("3-PPS", "One direction is known, the other is not."),
    built("3-RRRRR", "U and S for axes that meet."),
    built("3-RPCS", "One telescope between two joints."),
    built("3-RP(4R)S", "One telescope between two joints."),
    built("3-R(4S)R", "`(4S)` comes last."),
    built("3-RRR(4S)", "At most two links."),
    built("3-RRR(4R)", "At most two links."),
    built("3-UP[C]", "Drive P."),
    built("3-RPS", "A number.", "height='high'"),
    built("3-RPS", "A finite number.", "height=inf"),
    built("3-RPS", "A length greater than zero.", "base_radius=-0.3"),
    built("3-RPS", "A number.", "stroke=None"),
    built("3-RPS", "A plain text.", "stroke='<x>'"),
    built("3-RPS", "A name from the file.", "rod_length=0.5"),
    built("3-RPS", "A length that is not zero.", "base_radius=0.2, height=0"),
    built("3-RRS", "One of the two.", "crank_angle=0, rod_length=0.5"),
    built("3-RPS", "One of the two.", "rod_inner_diameter=0.02, rod_wall_thickness=0.002"),
    built("3-RRS", "Longer ones.", "crank_length=0.1, rod_length=0.1"),
    built("3-RPS", "Two angles more.", "azimuths=[0]"),
    built("6-UPS", "Three limbs.", "arrangement='cartesian'"),
    built("3-RPS", "`3-[R]RR`.", "arrangement='spherical'"),
    built("3-RRR", "Longer arcs.", "arrangement='spherical', crank_arc=0.3, rod_arc=0.4"),
    built("3-RPS", "One of these words.", "arrangement='round'"),
    built("3-PRS", "One of these words.", "guide='up'"),
    places("[]", "A row for each limb."),
    places("None, arrangement='planar', platform_turn=None", "A number.", "3-RPR"),
    places("[3]", "Base and platform."),
    places("[{'base': (0.3, 0, 0), 'top': (0.2, 0, 0)}]", "The names of the table."),
    places("[{'base': (0.3, 0, 0)}]", "Both points."),
    places("[((0.3, 0), (0.2, 0))]", "Three numbers each."),
    places("[((0.3, 0, 0), (0.2, 0, 0), (0, 0, 0))]", "A direction."),
    places("[((0.3, 0, 0), (0.2, 0.1, 0), (0, 1, 0))]", "An axis across the limb."),
    code("ks.new_robot('3-RPS', placements='none.csv')", "The path of the table."),
    table("", "The columns."),
    table("base_x,base_y,base\n1,2,3", "Columns end in _x, _y, _z."),
    table("base_x,base_y,base_z\n1,2,3", "The columns of the platform, too."),
    table(f"{POINTS}\n1,2", "Six cells."),
    table(f"{POINTS}\n0.3,0,0,0.2,0,zero", "Metres."),
    built("3-RPS", "A mapping.", "sections='tube'"),
    built("3-RPS", "A role of this robot.", "sections={'crank': 'circle 20mm'}"),
    built("3-RPS", "A shape and its sizes.", "sections={'rod': ''}"),
    built("3-RPS", "A shape of the list.", "sections={'rod': 'pipe 60mm 50mm'}"),
    built("3-RPS", "A material of the list.", "sections={'rod': 'tube 60mm 50mm wood'}"),
    built("3-RPS", "Both diameters.", "sections={'rod': 'tube 60mm'}"),
    built("3-RPS", "The outer one first.", "sections={'rod': 'tube 50mm 60mm'}"),
    built("3-RPS", "Less than half the height.", "sections={'rod': 'rectangular_tube 60mm 50mm 30mm'}"),
    built("3-RPS", "A number, and a unit or not.", "sections={'rod': 'circle thick'}"),
    built("3-RPS", "One decimal point.", "sections={'rod': 'circle 2.0.0mm'}"),
    built("3-RPS", "A unit of length.", "sections={'rod': 'circle 20kg'}"),
    built("3-RPS", "A size in reach.", "sections={'rod': 'circle 2000m'}"),
    code("ks.new_robot('3-RPS', folder / 'robot.urdf')", "Another name.",
         "`ks.new_robot('3-RPS', \"robot.urdf\")`, which is there"),
    code("ks.new_robot('3-RPS', folder / 'none' / 'robot.urdf')", "A folder that is there.",
         "`ks.new_robot('3-RPS', \"none/robot.urdf\")`"),
)  # fmt: skip
