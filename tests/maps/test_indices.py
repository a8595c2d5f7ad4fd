"""Indices of workspace maps against closed forms, their units and masks, and that lazy maps stay lazy."""

from functools import partial

import numpy as np
import pytest
import xarray as xr
from places import ROBOTS
from small_maps import map_of

import kinetostatics as ks
from kinetostatics import indices

E, NU = 210e9, 0.3
G = E / (2 * (1 + NU))
D = 0.05
A, I = np.pi * D**2 / 4, np.pi * D**4 / 64  # noqa: E741
EA, EI, GA, GJ = E * A, E * I, G * A, G * 2 * I
LENGTHS = np.array([0.4, 0.7, 1.0, 1.6])
#: bending and shear of a cantilever's end
TIP = LENGTHS**3 / (3 * EI) + LENGTHS / GA


def cantilevers():
    """Return the end compliances of cantilevers along x."""
    C = np.zeros((len(LENGTHS), 6, 6))
    for k, (L, tip) in enumerate(zip(LENGTHS, TIP, strict=True)):
        C[k] = np.diag([L / EA, tip, tip, L / GJ, L / EI, L / EI])
        C[k, 1, 5] = C[k, 5, 1] = L**2 / (2 * EI)
        C[k, 2, 4] = C[k, 4, 2] = -(L**2) / (2 * EI)
    return C


def beams(C=None, **options):
    return map_of({"length": (LENGTHS, "m")}, compliance=cantilevers() if C is None else C, **options)


def turned(C, seed):
    Q, _ = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    R = np.kron(np.eye(2), Q * np.linalg.det(Q))
    return R @ C @ R.T


def moved(C, p):
    """Return the compliance at another point of the body, at p from o."""
    x, y, z = p
    X = np.eye(6)  # twist at p from twist at o: d + r × p
    X[:3, 3:] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
    return X @ C @ X.T


def random_compliances(seed, n=5):
    rng = np.random.default_rng(seed)
    root = (np.eye(6) + 0.2 * rng.standard_normal((n, 6, 6))) * np.array([1e-4] * 3 + [3e-4] * 3)[:, None]
    return root @ np.swapaxes(root, 1, 2)


def random_map(seed, **options):
    return map_of({"z": (np.linspace(0.3, 0.7, 5), "m")}, compliance=random_compliances(seed), **options)


def close(found, expected, rtol=1e-12):
    np.testing.assert_allclose(np.asarray(found), expected, rtol=rtol)


# ---- stiffness ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", [None, 1, 2])
def test_cantilever_stiffness_has_closed_form_in_any_orientation(seed):
    C = cantilevers() if seed is None else turned(cantilevers(), seed)
    ds = beams(C)
    shear = 12 * EI / (GA * LENGTHS**2)
    close(indices.quantity(ds, "least_translational_stiffness"), 1 / TIP, 1e-11)
    close(indices.quantity(ds, "greatest_translational_stiffness"), EA / LENGTHS, 1e-10)
    # an end that cannot turn: 12 EI/L³, less what shear takes (Timoshenko)
    close(indices.quantity(ds, "least_translational_stiffness_held"), 12 * EI / LENGTHS**3 / (1 + shear), 1e-10)
    close(indices.quantity(ds, "greatest_translational_stiffness_held"), EA / LENGTHS, 1e-10)
    close(indices.quantity(ds, "least_rotational_stiffness"), GJ / LENGTHS, 1e-11)
    close(indices.quantity(ds, "greatest_rotational_stiffness"), EI / LENGTHS, 1e-11)
    # an end that cannot move: 4 EI/L, with shear (4 + φ)/(1 + φ) EI/L
    close(indices.quantity(ds, "least_rotational_stiffness_held"), GJ / LENGTHS, 1e-10)
    close(indices.quantity(ds, "greatest_rotational_stiffness_held"), (4 + shear) / (1 + shear) * EI / LENGTHS, 1e-10)


def test_cantilever_stiffness_along_directions_has_closed_form():
    ds = beams()
    close(indices.stiffness_along(ds, "x"), EA / LENGTHS)
    close(indices.stiffness_along(ds, "z"), 1 / TIP)
    close(indices.stiffness_along(ds, "rx"), GJ / LENGTHS)
    close(indices.stiffness_along(ds, "rz"), EI / LENGTHS)
    close(indices.stiffness_along(ds, (0, 3, 4)), 1 / TIP)  # the same in all directions across
    close(indices.stiffness_along(ds, (2, 2, 0)), 2 / (LENGTHS / EA + TIP))
    close(indices.stiffness_along(ds, (5, 0, 0), rotation=True), GJ / LENGTHS)
    # a direction that differs from pose to pose
    angle = np.linspace(0, 1, len(LENGTHS))
    u = xr.DataArray(np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1), dims=("length", "component"), name="u")
    close(indices.stiffness_along(ds, u), 1 / (np.cos(angle) ** 2 * LENGTHS / EA + np.sin(angle) ** 2 * TIP))
    assert indices.stiffness_along(ds, "ry").attrs == {"units": "N m/rad", "long_name": "stiffness about y"}
    assert indices.stiffness_along(ds, (0, 0, 2)).attrs == {"units": "N/m", "long_name": "stiffness along (0 0 2)"}


@pytest.mark.parametrize("direction", ["w", (0, 0, 0), (1, 2), (1, np.nan, 0), xr.DataArray([1.0, 0, 0], dims="axis")])
def test_invalid_directions_are_refused(direction):
    with pytest.raises(ks.ArgumentError, match="direction"):
        indices.stiffness_along(beams(), direction)


def test_dependence_of_stiffness_on_the_reference_point():
    """Free rotational and held translational stiffness do not depend on it, free translational stiffness does."""
    C = random_compliances(3)
    ds, other = (map_of({"z": (np.arange(5.0), "m")}, compliance=c) for c in (C, moved(C, (0.3, -0.2, 0.5))))
    for extreme in ("least", "greatest"):
        close(*(indices.quantity(item, f"{extreme}_rotational_stiffness") for item in (ds, other)), 1e-10)
        held = [indices.quantity(item, f"{extreme}_translational_stiffness_held") for item in (ds, other)]
        close(*held, 1e-7)
        free = [indices.quantity(item, f"{extreme}_translational_stiffness") for item in (ds, other)]
        assert np.all(np.abs(free[0] / free[1] - 1) > 1e-3)


@pytest.mark.few(8)
@pytest.mark.parametrize("name", sorted(indices.INDICES))
def test_indices_scale_with_their_units_from_metres_to_millimetres(name):
    """In mm and N every index is the same quantity: no eigenvalue mixes metres and radians."""
    C, twist, L = random_compliances(6), np.random.default_rng(7).standard_normal((5, 6)) * 1e-5, 0.31
    grid, more = {"z": (np.arange(5.0), "m")}, {"forces": {"a": np.arange(5.0) + 1}, "frequencies": C[:, 0, :2]}
    metres = map_of(grid, compliance=C, twist=twist, length=L, residual_error=twist, **more)
    s = np.array([1e3] * 3 + [1.0] * 3)
    softer = C * s[:, None] * s / 1e3  # moments are 1e3 times as many N·mm
    millimetres = map_of(grid, compliance=softer, twist=twist * s, length=L * 1e3, residual_error=twist * s, **more)
    factor = {"m": 1e3, "rad": 1.0, "N/m": 1e-3, "N·m/rad": 1e3, "1": 1.0, "N": 1.0, "Hz": 1.0}[indices.INDICES[name].unit]
    close(indices.quantity(millimetres, name), factor * indices.quantity(metres, name), 1e-7)


# ---- conditioning ------------------------------------------------------------------------------------------------------


def gough(height, spread):
    """Return unit wrenches (6, 6) of six struts about o, for a platform of radius 0.25 m; all axial stiffnesses equal."""
    turn = np.radians([10, 110, 130, 230, 250, 350])
    base = np.radians([50, 70, 170, 190, 290, 310])
    a = 0.25 * np.stack([np.cos(turn), np.sin(turn), 0 * turn])
    b = spread * np.stack([np.cos(base), np.sin(base), 0 * base]) - [[0], [0], [height]]
    u = (a - b) / np.linalg.norm(a - b, axis=0)
    return np.concatenate([u, np.cross(a.T, u.T).T])


def test_conditioning_of_struts_equals_that_of_unit_wrenches():
    k, L = 3e7, 0.25
    J = np.stack([gough(height, 0.5) for height in (0.2, 0.4, 0.8, 1.6)])
    ds = map_of({"z": ([0.2, 0.4, 0.8, 1.6], "m")}, compliance=np.linalg.inv(k * J @ np.swapaxes(J, 1, 2)), length=L)
    s = np.linalg.svd(J / np.array([1, 1, 1, L, L, L])[:, None], compute_uv=False)
    close(indices.quantity(ds, "conditioning"), (s[:, -1] / s[:, 0]) ** 2, 1e-9)
    close(indices.quantity(ds, "singularity_distance"), k * s[:, -1] ** 2, 1e-9)


def test_rigid_directions_are_infinitely_stiff():
    C = np.diag([0.0, 1e-6, 1e-6, 0.0, 1e-5, 2e-5])
    ds = map_of({"z": ([0.0, 1.0], "m")}, compliance=np.eye(6))
    ds = ds.assign(compliance=ds.compliance.copy(data=np.stack([C] * 2)), stiffness=ds.stiffness * np.nan)
    close(indices.quantity(ds, "greatest_translational_stiffness"), [np.inf] * 2)
    close(indices.stiffness_along(ds, "x"), [np.inf] * 2)
    close(indices.quantity(ds, "least_translational_stiffness"), [1e6] * 2)
    close(indices.quantity(ds, "least_rotational_stiffness"), [5e4] * 2)
    close(indices.quantity(ds, "conditioning"), [0, 0])
    assert np.all(np.isnan(indices.quantity(ds, "least_translational_stiffness_held")))


# ---- sag and actuators ----------------------------------------------------------------------------------------------------


def test_sag_is_the_norm_of_displacement_and_rotation():
    parts = {"load": [3e-6, 0, 0, 0, 1e-6, 0], "platform_weight": [0, 0, -4e-6, 2e-6, 1e-6, -1e-6]}
    ds = map_of({"z": ([0.4, 0.5], "m")}, twist=np.sum(list(parts.values()), axis=0), contribution=parts)
    close(indices.quantity(ds, "linear_sag"), [5e-6] * 2)
    close(indices.quantity(ds, "angular_sag"), [3e-6] * 2)
    close(indices.quantity(ds, "linear_sag:load"), [3e-6] * 2)
    close(indices.quantity(ds, "angular_sag:platform_weight"), [np.sqrt(6) * 1e-6] * 2)
    assert indices.quantity(ds, "linear_sag").attrs == {"units": "m", "long_name": "linear sag"}
    assert indices.quantity(ds, "angular_sag:load").attrs == {"units": "rad", "long_name": "angular sag by load"}
    assert set(indices.quantity(ds, "linear_sag:load").coords) == {"z"}
    with pytest.raises(ks.ArgumentError, match="no source 'loads': did you mean 'load'"):
        indices.quantity(ds, "linear_sag:loads")


def test_largest_actuator_force_needs_actuators_of_one_unit():
    forces = {"p1": [1.0, -7.0, 2.0], "p2": [-3.0, 4.0, 2.5]}
    ds = map_of({"z": ([0.4, 0.5, 0.6], "m")}, forces=forces, status=[0, 0, 1])
    np.testing.assert_array_equal(indices.quantity(ds, "largest_actuator_force"), [3, 7, np.nan])
    mixed = map_of({"z": ([0.4, 0.5, 0.6], "m")}, forces=forces, turning=["p2"])
    with pytest.raises(ks.ArgumentError, match="forces and torques of actuators cannot be compared"):
        indices.quantity(mixed, "largest_actuator_force")
    assert indices.quantity(mixed, "actuator_force:p2").attrs == {"units": "N m", "long_name": "torque of p2"}
    assert indices.quantity(mixed, "actuator_force:p1").attrs == {"units": "N", "long_name": "force of p1"}
    turning = map_of({"z": ([0.4, 0.5, 0.6], "m")}, forces=forces, turning=["p1", "p2"])
    assert indices.quantity(turning, "largest_actuator_force").attrs == {"units": "N m", "long_name": "largest actuator torque"}


# ---- masks -------------------------------------------------------------------------------------------------------------


STATUSES = list(ks.Status)


@pytest.mark.few(8)
@pytest.mark.parametrize("name", sorted(indices.INDICES))
def test_only_valid_poses_have_numbers(name):
    n = len(STATUSES)
    ds = map_of(
        {"z": (np.arange(float(n)), "m")},
        compliance=np.eye(6) * 1e-6,
        twist=np.ones(6),
        forces={"a": 1.0},
        residual_error=np.ones(6),
        frequencies=[3.0, 4.0],
        status=[int(item) for item in STATUSES],
    )
    good = np.array([item.name in ("OK", "INDETERMINATE", "BASIS_DEGENERATE") for item in STATUSES])
    np.testing.assert_array_equal(np.isfinite(indices.quantity(ds, name)), good)
    beyond = good | np.array([item.name == "LIMIT_EXCEEDED" for item in STATUSES])
    np.testing.assert_array_equal(np.isfinite(indices.quantity(ds, name, beyond_limits=True)), beyond)
    assert set(indices.quantity(ds, name).coords) == {"z"}


# ---- by name, best and worst -------------------------------------------------------------------------------------------


def full_map():
    rng = np.random.default_rng(8)
    parts = {"load": rng.standard_normal((3, 4, 6)), "limb_1": rng.standard_normal((3, 4, 6))}
    ds = map_of(
        {"z": ([0.3, 0.4, 0.5], "m"), "rx": ([-0.1, 0.0, 0.1, 0.2], "rad")},
        compliance=random_compliances(9, 12).reshape(3, 4, 6, 6),
        twist=parts["load"] + parts["limb_1"],
        forces={"p1": rng.standard_normal((3, 4)), "p2": rng.standard_normal((3, 4))},
        contribution=parts,
    )
    wrenches = ["limb_1: force along limb axis at A", "limb_1: couple"]
    return ds.assign_coords(wrench=wrenches).assign(intensity=(("z", "rx", "wrench"), rng.standard_normal((3, 4, 2))))


def test_every_quantity_name_gives_values_per_pose_with_units():
    ds = full_map()
    known = indices.names(ds)
    assert {"linear_sag", "stiffness_along:ry", "twist:rx", "contribution:limb_1:z", "actuator_force:p2"} <= set(known)
    for name in known:
        found = indices.quantity(ds, name)
        assert found.dims == ("z", "rx") and found.attrs["units"] and found.attrs["long_name"], name
        assert set(found.coords) == {"z", "rx"}
    np.testing.assert_array_equal(indices.quantity(ds, "twist:ry"), ds.twist.values[..., 4])
    np.testing.assert_array_equal(indices.quantity(ds, "contribution:limb_1:z"), ds.contribution.values[..., 1, 2])
    np.testing.assert_array_equal(indices.quantity(ds, "intensity:limb_1: couple"), ds.intensity.values[..., 1])
    np.testing.assert_array_equal(indices.quantity(ds, "compliance:x:rz"), ds.compliance.values[..., 0, 5])
    units = {"twist:x": "m", "twist:rz": "rad", "compliance:x:y": "m/N", "compliance:rx:y": "rad/N",
             "compliance:x:ry": "m/(N m)", "stiffness:x:x": "N/m", "stiffness:rx:x": "N m/m", "actuator_force:p1": "N",
             "contribution:load:rx": "rad"}  # fmt: skip
    assert {name: indices.quantity(ds, name).attrs["units"] for name in units} == units


@pytest.mark.parametrize(
    "what, message",
    [
        ("linear_sags", "did you mean 'linear_sag'"),
        ("twist", "not of the form twist:COMPONENT"),
        ("twist:w", "no component 'w'"),
        ("contribution:limb_1", "not of the form contribution:SOURCE:COMPONENT"),
        ("contribution:limb_9:x", "no source 'limb_9': did you mean 'limb_1'"),
        ("actuator_force:p3", "no actuator 'p3'"),
        ("stiffness_along:w", "no direction 'w'"),
        ("status", "no quantity 'status'"),
        ("sag", "no quantity 'sag': did you mean 'linear_sag' or 'angular_sag'?"),
        ("beam_stress:rod", r"the map has no 'beam_stress'; sweep with 'beams' among the outputs"),
        ("compliance:x", "form compliance:COMPONENT:COMPONENT_2, where components are x, y, z, rx, ry, rz$"),
        ("characteristic_length:x", "not of the form characteristic_length"),
    ],
)
def test_unknown_quantity_names_are_refused(what, message):
    with pytest.raises(ks.ArgumentError, match=message):
        indices.quantity(full_map(), what)


def test_other_datasets_are_refused():
    for function in (indices.valid, *(partial(indices.quantity, what=name) for name in indices.INDICES)):
        with pytest.raises(ks.ArgumentError, match=r"not a Dataset of ks\.sweep"):
            function(xr.Dataset({"a": 1}))


def test_best_and_worst_pose_by_magnitude_among_valid_poses():
    twist = np.zeros((2, 3, 6))
    twist[..., 2] = [[-3e-6, -1e-6, 2e-6], [4e-6, -9e-6, np.nan]]
    ds = map_of(
        {"z": ([0.4, 0.5], "m"), "rx": ([-0.1, 0.0, 0.1], "rad")},
        twist=twist,
        compliance=np.eye(6) * np.array([[1, 2, 3], [4, 5, 6]])[..., None, None] * 1e-6,
        status=[[0, 0, 0], [0, 1, 2]],
    )
    good = indices.best(ds, "linear_sag")
    assert (good.value, good.units, good.coordinates, good.index) == (1e-6, "m", {"z": 0.4, "rx": 0.0}, {"z": 0, "rx": 1})
    assert str(good) == "linear_sag = 1e-06 m at z = 0.4 m, rx = 0 rad"
    words = ds.isel(z=0, drop=True).rename(rx="material").assign_coords(material=["steel", "oak", "ash"])
    assert str(indices.worst(words, "linear_sag")) == "linear_sag = 3e-06 m at material = steel"
    assert str(indices.best(words.isel(material=0), "conditioning")) == "conditioning = 1 at the only pose"
    bad = indices.worst(ds, "twist:z")
    assert (bad.value, bad.coordinates, bad.status) == (4e-6, {"z": 0.5, "rx": -0.1}, ks.Status.OK)
    beyond = indices.worst(ds, "twist:z", beyond_limits=True)
    assert (beyond.value, beyond.status) == (-9e-6, ks.Status.LIMIT_EXCEEDED)  # by magnitude, with its sign
    # of stiffness the large is good
    assert indices.best(ds, "least_translational_stiffness").coordinates == {"z": 0.4, "rx": -0.1}
    assert indices.worst(ds, "stiffness_along:x").coordinates == {"z": 0.5, "rx": -0.1}
    with pytest.raises(ks.ArgumentError, match="no pose of the map is valid"):
        indices.best(ds.isel(z=[1], rx=[1, 2]), "linear_sag")


# ---- laziness ----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_lazy_maps_give_lazy_indices_with_equal_values():
    import dask

    ds = full_map()
    lazy = ds.chunk({"z": 2, "rx": 3, "component": 2, "component_2": 4}).assign_coords(
        ds.coords
    )  # a sweep's coordinates are in memory

    def compute(*args, **kwargs):
        raise AssertionError("computed too early")

    with dask.config.set(scheduler=compute):
        found = {name: indices.quantity(lazy, name) for name in indices.names(ds)}
    for name, item in found.items():
        assert dask.is_dask_collection(item.data), name
        np.testing.assert_allclose(item.values, indices.quantity(ds, name).values, rtol=1e-12, err_msg=name)
    for what in ("linear_sag", "conditioning"):
        assert indices.worst(lazy, what).index == indices.worst(ds, what).index
        assert indices.best(lazy, what).index == indices.best(ds, what).index


# ---- robots ------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def swept():
    """The 3RPS over two coordinates, two loads and two parameters."""
    loads = xr.DataArray([[0, 0, 0, 0, 0, 0], [300, 0, -500, 0, 20, 0]], dims=("case", "component"), coords={"case": [1, 2]})
    return ks.sweep(
        "3rps",
        platform={"z": [0.4, 0.6], "rx": 0.1, "ry": [-0.3, 0.0, 0.2]},
        orientation="XYZ",
        load=loads,
        parameters={"rod_diameter": [0.08, 0.1]},
        progress=False,
    )


def test_indices_have_all_swept_dimensions(swept):
    dims = indices.swept(swept)
    assert set(dims) == {"rod_diameter", "case", "z", "ry"}
    for name in indices.names(swept):
        found = indices.quantity(swept, name)
        assert found.dims == dims and np.isfinite(found).all(), name
        assert set(found.coords) == {*dims, "rx"}, name  # and what was held
    worst = indices.worst(swept, "linear_sag")
    assert worst.coordinates["case"] == 2 and worst.coordinates["rod_diameter"] == 0.08


def test_sweep_indices_equal_those_of_single_poses(swept):
    """Against the wrenches and compliances of the limbs, by another way than the Dataset's compliance."""
    rng = np.random.default_rng(11)
    for z, ry, diameter in ((0.4, -0.3, 0.08), (0.6, 0.2, 0.1)):
        robot = ks.load_robot(ROBOTS / "3rps.urdf.xacro", parameters={"rod_diameter": diameter})
        pose = robot.assemble(platform={"z": z, "rx": 0.1, "ry": ry}, orientation="XYZ")
        result = ks.analyze(pose, load=[300, 0, -500, 0, 20, 0])
        here = swept.sel(z=z, ry=ry, rod_diameter=diameter, case=2)
        close(indices.quantity(here, "linear_sag"), np.linalg.norm(result.twist[:3]), 1e-9)
        close(
            indices.quantity(here, "largest_actuator_force"), max(abs(force) for force in result.actuator_forces.values()), 1e-9
        )
        L = robot.length
        scale = np.array([1, 1, 1, 1 / L, 1 / L, 1 / L])
        K = np.zeros((6, 6))
        for limb in result.limbs.values():
            J = scale[:, None] * limb.constraint_wrenches
            K += J @ np.linalg.inv(limb.compliance) @ J.T
        low, *_, high = np.linalg.eigvalsh(K)
        close(indices.quantity(here, "singularity_distance"), low, 1e-8)
        close(indices.quantity(here, "conditioning"), low / high, 1e-8)
        # a small additional force moves the platform by force over stiffness along it
        u = rng.standard_normal(3)
        more = ks.analyze(pose, load=result.load + np.array([*(10 * u), 0, 0, 0])).twist - result.twist
        close(indices.stiffness_along(here, u), 10 * (u @ u) / (u @ more[:3]), 1e-6)


def test_sag_with_a_nan_component_is_nan():
    twist = np.array([[3.0, 4, 0, 0, 0, 0], [np.nan, 4, 0, 0, 3, 4], [0, 0, 0, np.nan, 0, 1]])
    ds = map_of({"x": ([0.0, 1, 2], "m")}, twist=twist, forces={"a": [1.0, -3, 2], "b": [2.0, np.nan, -5]})
    np.testing.assert_equal(ks.indices.quantity(ds, "linear_sag").values, [5, np.nan, 0])
    np.testing.assert_equal(ks.indices.quantity(ds, "angular_sag").values, [0, 5, np.nan])
    np.testing.assert_equal(ks.indices.quantity(ds, "largest_actuator_force").values, [2, np.nan, 5])
    assert isinstance(ks.indices.quantity(ds, "linear_sag"), xr.DataArray)
