"""Parts condensed from CAD files: against Timoshenko's beam, exact masses and CalculiX; interfaces, units, cache, refusals."""

import shutil

import numpy as np
import pytest
from calculix_decks import bore_lines, displacements, solid_lines
from netgen import occ

import kinetostatics as ks
from kinetostatics.cli.main import main
from kinetostatics.condensation import condensed_link

E, NU, RHO, ALPHA = 210e9, 0.3, 7850.0, 12e-6
needs_ccx = pytest.mark.skipif(shutil.which("ccx") is None, reason="needs ccx, the solver of CalculiX (apt install calculix-ccx)")


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("KINETOSTATICS_CACHE", str(tmp_path / "cache"))


def written(shape, path):
    shape.WriteStep(str(path))
    return path


def bar(tmp_path, length=120, width=16, height=24):
    return written(occ.Box(occ.Pnt(0, -width / 2, -height / 2), occ.Pnt(length, width / 2, height / 2)), tmp_path / "bar.step")


def arm(tmp_path):
    """Two bosses with bores, ⌀20 at the origin and ⌀12 at x = 90 mm, in a plate with a notch."""
    plate = occ.Box(occ.Pnt(0, -9, -5), occ.Pnt(90, 9, 5)) + occ.Cylinder(occ.Pnt(0, 0, -10), occ.Z, r=16, h=20)
    plate = plate + occ.Cylinder(occ.Pnt(90, 0, -8), occ.Z, r=12, h=16) - occ.Box(occ.Pnt(40, 2, -9), occ.Pnt(55, 20, 9))
    plate = plate - occ.Cylinder(occ.Pnt(0, 0, -20), occ.Z, r=10, h=40) - occ.Cylinder(occ.Pnt(90, 0, -20), occ.Z, r=6, h=40)
    return plate, written(plate, tmp_path / "arm.step")


ARM = {"shoulder": "cylinder d=20mm near 0 0 0", "elbow": "cylinder d=12mm near 90mm 0 0"}
ENDS = {"left": "face near 0 0 0", "right": "face near 120mm 0 0"}


def errors_of_a_cantilever(link, length, area, shear_area, I_y, I_z, torsion=None):
    """Return relative errors of the compliances of a bar along x to those of Timoshenko's beam."""
    F, G = link.flexibility(0), E / (2 * (1 + NU))
    right = {
        (0, 0): length / (E * area),
        (1, 1): length**3 / (3 * E * I_z) + length / (G * shear_area),
        (2, 2): length**3 / (3 * E * I_y) + length / (G * shear_area),
        (1, 5): length**2 / (2 * E * I_z),
        (4, 4): length / (E * I_y),
    }
    if torsion is not None:
        right[3, 3] = length / (G * torsion)
    return {place: F[place] / value - 1 for place, value in right.items()}


# ---- closed forms --------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_bar_with_even_grips_is_a_timoshenko_beam(tmp_path):
    part = ks.condense(bar(tmp_path), ENDS, within=0.03, modes=8, grip="even")
    b, h, L = 0.016, 0.024, 0.12
    errors = errors_of_a_cantilever(part.link, L, b * h, 5 / 6 * b * h, b * h**3 / 12, h * b**3 / 12)
    assert max(map(abs, errors.values())) < 2e-3
    assert part.change <= 0.03 and part.grip == "even" and part.link.internal == 8
    assert part.link.origins == pytest.approx(np.array([[0, 0, 0], [L, 0, 0]]), abs=1e-9)
    assert part.link.body[0] == pytest.approx(RHO * b * h * L, rel=1e-9)
    assert part.link.displacements_by_heat("left")[0] == pytest.approx(ALPHA * L, rel=1e-6)
    sag = RHO * b * h * L**4 / (8 * E * h * b**3 / 12) + RHO * L**2 / (2 * 5 / 6 * E / (2 * (1 + NU)))
    assert part.link.displacements_by_gravity("left")[1, 1] == pytest.approx(sag, rel=3e-3)
    # a bar between walls: its first axial mode
    frequencies = np.sqrt(np.diag(part.link.stiffness)[12:]) / (2 * np.pi)
    assert np.abs(frequencies / (np.sqrt(E / RHO) / (2 * L)) - 1).min() < 5e-3
    # rigid grips hinder the contraction of the ends
    rigid = ks.condense(bar(tmp_path), ENDS, within=0.03, modes=0)
    stiffer = errors_of_a_cantilever(rigid.link, L, b * h, 5 / 6 * b * h, b * h**3 / 12, h * b**3 / 12)
    assert all(-0.06 < error < errors[place] - 1e-3 for place, error in stiffer.items())
    assert rigid.between_grips == pytest.approx(part.between_grips, rel=0.1) and rigid.link.internal == 0
    loosest = max((1 + errors[place]) / (1 + error) - 1 for place, error in stiffer.items())
    assert loosest <= rigid.between_grips * 1.01


@pytest.mark.slow
def test_tube_is_a_timoshenko_beam(tmp_path):
    """⌀50 × 5 × 500 mm, the shear coefficient of Cowper (1966); both grips lie within 0.5 %."""
    tube = occ.Cylinder(occ.Pnt(0, 0, 0), occ.X, r=25, h=500) - occ.Cylinder(occ.Pnt(-1, 0, 0), occ.X, r=20, h=502)
    L, D, d, m = 0.5, 0.05, 0.04, 0.8
    area, I = np.pi / 4 * (D**2 - d**2), np.pi / 64 * (D**4 - d**4)  # noqa: E741
    kappa = 6 * (1 + NU) * (1 + m**2) ** 2 / ((7 + 6 * NU) * (1 + m**2) ** 2 + (20 + 12 * NU) * m**2)
    path = written(tube, tmp_path / "tube.step")
    for grip, bound in (("rigid", 5e-3), ("even", 5e-4)):
        part = ks.condense(path, {"a": "face near 0 0 0", "o": "face near 500mm 0 0"}, grip=grip, modes=0)
        errors = errors_of_a_cantilever(part.link, L, area, kappa * area, I, I, 2 * I)
        assert max(map(abs, errors.values())) < bound, grip


@pytest.mark.slow
def test_mass_properties_are_those_of_the_solid(tmp_path):
    shape, path = arm(tmp_path)
    part = ks.condense(path, ARM, within=0.5, modes=2)
    mass, centre, inertia = part.link.body
    assert mass == pytest.approx(RHO * shape.mass * 1e-9, rel=1e-3)
    assert centre == pytest.approx(np.array([shape.center[k] for k in range(3)]) * 1e-3, abs=2e-6)
    turning = np.array([[shape.inertia[i, j] for j in range(3)] for i in range(3)]) * RHO * 1e-15
    assert np.abs(inertia - turning).max() < 2e-3 * np.abs(turning).max()


@pytest.mark.few(1)
@pytest.mark.parametrize(("material", "expansion"), [("steel", 12e-6), ("aluminium", 23e-6), ("titanium", 8.6e-6)])
def test_heat_expands_materials_known_by_name(tmp_path, material, expansion):
    link = ks.condense(bar(tmp_path), ENDS, material, within=0.5, modes=0).link
    assert link.displacements_by_heat("left")[0] == pytest.approx(0.12 * expansion, rel=0.05)


# ---- CalculiX ------------------------------------------------------------------------------------------------------------


def calculix_deck(mesh, forces):
    """Return a deck with curved quadratic tetrahedra, the first bore held, the second one rigid under loads."""
    lines = [*solid_lines(mesh), "*NODE", "9000001, 0.09, 0, 0", "9000002, 0.09, 0, 0"]
    lines += [*bore_lines(mesh, "HELD", 0, 0, 10), *bore_lines(mesh, "MOVED", 90, 0, 6)]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", f"{E}, {NU}", "*SOLID SECTION, ELSET=PART, MATERIAL=STEEL"]
    lines += ["*RIGID BODY, NSET=MOVED, REF NODE=9000001, ROT NODE=9000002", "*BOUNDARY", "HELD, 1, 3"]
    lines += ["*NSET, NSET=REFERENCE", "9000001, 9000002"]
    for direction in range(6):
        node, freedom = (9000001 if direction < 3 else 9000002), direction % 3 + 1
        lines += ["*STEP", "*STATIC", "*CLOAD, OP=NEW", f"{node}, {freedom}, {forces[direction]}"]
        lines += ["*NODE PRINT, NSET=REFERENCE", "U", "*END STEP"]
    return lines


@pytest.mark.slow
@needs_ccx
def test_arm_agrees_with_calculix(tmp_path):
    _, path = arm(tmp_path)
    part = ks.condense(path, ARM, within=0.03, modes=0)
    mesh = occ.OCCGeometry(str(path)).GenerateMesh(maxh=2.6)
    mesh.SecondOrder()
    forces = [1e3, 1e3, 1e3, 10, 10, 10]
    values = displacements(tmp_path, calculix_deck(mesh, forces), (9000001, 9000002))
    C = (values.reshape(6, 6) / np.array(forces)[:, None]).T
    F = part.link.flexibility("shoulder")
    root = np.linalg.cholesky(np.linalg.inv((C + C.T) / 2))
    assert part.change <= 0.03
    assert np.abs(np.linalg.eigvalsh(root.T @ (F - C) @ root)).max() < part.error


# ---- interfaces ----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_interfaces_are_cylinders_faces_and_spheres(tmp_path):
    _, path = arm(tmp_path)
    part = ks.condense(path, {**ARM, "o": "sphere r=9mm at 47.5mm 2mm 0"}, within=0.9, modes=0)
    assert part.link.names == ("shoulder", "elbow", "o")
    assert part.link.origins == pytest.approx(np.array([[0, 0, 0], [0.09, 0, 0], [0.0475, 0.002, 0]]), abs=1e-6)
    for number, (x, radius) in enumerate([(0.0, 0.010), (0.09, 0.006)]):
        corners = part.link.points[np.unique(part.link.triangles[part.owner == number])]
        assert np.hypot(corners[:, 0] - x, corners[:, 1]) == pytest.approx(radius, rel=1e-6)
    inside = part.link.points[part.link.triangles[part.owner == 2]].mean(1)
    assert len(inside) and np.linalg.norm(inside - part.link.origins[2], axis=1).max() <= 0.009


@pytest.mark.slow
def test_halves_of_a_bore_are_one_cylinder_and_faces_have_names(tmp_path):
    half = occ.Box(occ.Pnt(-15, 0, 0), occ.Pnt(15, 30, 10)) - occ.Cylinder(occ.Pnt(0, 0, -1), occ.Z, r=8, h=12)
    other = occ.Box(occ.Pnt(-15, -15, 0), occ.Pnt(15, 0, 10)) - occ.Cylinder(occ.Pnt(0, 0, -1), occ.Z, r=8, h=12)
    half.faces.Max(occ.Y).name = "flange"
    geometry = occ.OCCGeometry(occ.Glue([half, other]))
    mesh = geometry.GenerateMesh(maxh=10)
    mesh.Save(str(tmp_path / "block.vol"))
    part = ks.condense(
        tmp_path / "block.vol", {"a": "cylinder d=16 near 0 0 0", "b": "face flange"}, within=0.9, modes=0, unit="m"
    )
    around = part.link.points[np.unique(part.link.triangles[part.owner == 0])]
    assert around[:, 1].min() == pytest.approx(-8, rel=1e-3) and around[:, 1].max() == pytest.approx(8, rel=1e-3)
    assert part.link.origins == pytest.approx(np.array([[0, 0, 5], [0, 30, 5]]), abs=1e-3)


@pytest.mark.few(1)
@pytest.mark.parametrize("metres", [False, True])
def test_stl_in_millimetres_is_recognised(tmp_path, metres):
    import trimesh

    block = trimesh.creation.box((120, 16, 24))
    block.apply_translation((60, 0, 0))
    block.apply_scale(1e-3 if metres else 1.0)
    block.export(tmp_path / "bar.stl")
    part = ks.condense(tmp_path / "bar.stl", ENDS, within=0.1, modes=0)
    assert part.link.body[0] == pytest.approx(RHO * 0.12 * 0.016 * 0.024, rel=1e-6)
    assert part.link.origins == pytest.approx(np.array([[0, 0, 0], [0.12, 0, 0]]), abs=1e-8)  # single precision


# ---- cache, picture, command ---------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_coarse_meshes_are_as_accurate_as_stated(tmp_path, monkeypatch):
    """With displacements of second order, coarse meshes of this arm differ by 4 %, and are 10 % too stiff in torsion."""
    _, path = arm(tmp_path)
    coarse = ks.condense(path, ARM, within=0.08, modes=0)
    monkeypatch.setattr(condensed_link, "GROWTH", 6.0)
    fine = ks.condense(path, ARM, within=0.0801, modes=0)
    assert coarse.change <= 0.08 and 3 * coarse.tetrahedra < fine.tetrahedra
    compliances = [part.link.flexibility("shoulder") for part in (fine, coarse)]
    assert condensed_link._difference(*compliances) < coarse.error


def test_results_are_stored_by_content(tmp_path, monkeypatch):
    path = bar(tmp_path)
    first = ks.condense(path, ENDS, "aluminium", within=0.5, modes=1)
    monkeypatch.setattr(condensed_link, "SolidPart", None)  # cannot compute any more
    copy = shutil.copy(path, tmp_path / "copy.step")
    again = ks.condense(copy, ENDS, "aluminium", within=0.5, modes=1)
    assert again.link == first.link and str(again) == str(first) and np.array_equal(again.owner, first.owner)
    with pytest.raises(TypeError):
        ks.condense(path, ENDS, "steel", within=0.5, modes=1)


def test_command_writes_matrices_and_picture(tmp_path, capsys):
    path, out, picture = bar(tmp_path), tmp_path / "bar.npz", tmp_path / "bar.png"
    interfaces = [f"{name}={place}" for name, place in ENDS.items()]
    options = ["--within", "50%", "--modes", "2", "--picture", str(picture), "--out", str(out)]
    assert main(["condense", str(path), "--interface", *interfaces, *options]) == 0
    said = capsys.readouterr().out
    assert "bar.npz: interfaces left, right; 2 internal coordinates; mass 0.361728 kg" in said
    assert "120 x 16 x 24 mm" in said and "compliance, even grips: up to" in said
    assert ks.files.read_link(out).names == ("left", "right") and picture.read_bytes().startswith(b"\x89PNG")
    assert main(["condense", str(path), "--interface", *interfaces, "--within", "some", "--out", str(out)]) == 2
    assert "--within: 'some' is no number or percentage, such as 1%" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("interfaces", "options", "said"),
    [
        (
            {"a": "cylinder d=15mm near 0 0 0"},
            {},
            "a: there is no cylinder of diameter 15 mm; there are 12 mm, 20 mm, 24 mm",
        ),
        ({"a": "hole at 0 0 0"}, {}, "interface a: 'hole at 0 0 0' is not understood; write cylinder d=20mm near X Y Z"),
        ({"a": "face bottom"}, {}, "interface a: there is no face bottom"),
        ({"a": "face near the end"}, {}, "interface a: 'face near the end' is not understood; write cylinder"),
        ({"a": "sphere r=1mm at 1 0 0"}, {}, "interface a: there is no surface in the sphere r=1mm at 1 0 0"),
        ({"a": "face near 0 9mm 0kg"}, {}, "interface a, 'face near 0 9mm 0kg'.*kg"),
        (
            {"a": "sphere r=14mm at 0 0 0"},
            {},
            "interfaces shoulder, elbow, a touch; a gap between them would be right",
        ),
        ({}, {"material": "stell"}, "material: there is no 'stell'; did you mean 'steel'"),
        ({}, {"within": 2}, r"within: between 0 and 1, .*; given are 2, 2, 6, rigid, None"),
        ({}, {"material": ks.description.Material(1e9, 0.3)}, "material: it needs a density"),
    ],
)
def test_wrong_arguments_are_refused(tmp_path, interfaces, options, said):
    _, path = arm(tmp_path)
    with pytest.raises(ks.ArgumentError, match=said):
        ks.condense(path, {**ARM, **interfaces}, **options)


def test_wrong_files_are_refused(tmp_path):
    (tmp_path / "arm.step").write_text("no step")
    (tmp_path / "arm.stl").write_text("no stl")
    two = occ.Compound([occ.Box(occ.Pnt(0, 0, 0), occ.Pnt(1, 1, 1)), occ.Box(occ.Pnt(2, 0, 0), occ.Pnt(3, 1, 1))])
    written(two, tmp_path / "two.step")
    (tmp_path / "arm.iges").write_text("")
    for name, said in (
        ("arm.step", "cannot be read"),
        ("arm.stl", "cannot be read"),
        ("two.step", "has 2 solids; one would be right"),
        ("arm.iges", "files end in .step, .stl"),
        ("none.step", "cannot be read: No such file"),
    ):
        with pytest.raises(ks.ArgumentError, match=said):
            ks.condense(tmp_path / name, ARM)


# ---- surface for pictures ------------------------------------------------------------------------------------------------


def rigid_at(points, origin=(0.0, 0.0, 0.0)):
    """Return displacements (S, 3, 6) of points by unit twists at an origin."""
    turned = [np.cross(axis, points - np.array(origin)) for axis in np.eye(3)]
    return np.concatenate([np.broadcast_to(np.eye(3), (len(points), 3, 3)), np.stack(turned, axis=2)], axis=2)


@pytest.mark.few(1)
@pytest.mark.parametrize("pictured", [10**6, 9_000])
def test_surface_moves_with_rigid_grips(tmp_path, monkeypatch, pictured):
    """The points of a bore follow its interface alone, all points a motion of the whole part; also if points are merged."""
    monkeypatch.setattr(condensed_link, "PICTURED", pictured)
    part = ks.condense(arm(tmp_path)[1], ARM, within=0.9, modes=1)
    link = part.link
    assert len(link.points) < pictured / 30
    assert (len(link.points) > 400) == (pictured == 10**6)
    for number in (0, 1):
        around = np.unique(link.triangles[part.owner == number])
        assert len(around) >= 6
        moved = np.zeros((len(around), 3, 13))
        moved[:, :, 6 * number : 6 * number + 6] = rigid_at(link.points[around], link.origins[number])
        assert np.abs(link.recovery[around] - moved).max() < 1e-10
    assert np.abs(link.recovery @ link.rigid_motions - rigid_at(link.points)).max() < 1e-9
    ks.files.save_link(link, tmp_path / "arm.npz")
    assert ks.files.read_link(tmp_path / "arm.npz") == link and (tmp_path / "arm.npz").stat().st_size < 1e6


def test_surface_of_a_pulled_and_bent_bar_is_that_of_saint_venant(tmp_path):
    """With even grips, tractions are linear over the ends, and solutions are polynomials; the left end is held in the mean."""
    part = ks.condense(bar(tmp_path), ENDS, within=0.9, modes=2, grip="even")
    link, b, h = part.link, 0.016, 0.024
    x, y, z = link.points.T
    pull, couple = 1000.0, 5.0  # N, N·m about z
    stress, bend = pull / (E * b * h), couple / (E * h * b**3 / 12)
    pulled = stress * np.stack([x, -NU * y, -NU * z])
    mean = NU * (b**2 - h**2) / 12
    bent = bend * np.stack([-x * y, (x**2 + NU * (y**2 - z**2) - mean) / 2, NU * y * z])
    F = link.flexibility("left")
    for wrench, expected in (([pull, 0, 0, 0, 0, 0], pulled), ([0, 0, 0, 0, 0, couple], bent)):
        coordinates = np.concatenate([np.zeros(6), F @ wrench, np.zeros(2)])
        assert np.abs(link.recovery @ coordinates - expected.T).max() < 1e-8 * np.abs(expected).max()
