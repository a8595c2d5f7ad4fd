"""Figures of workspace maps: values and units of the map, hatches where values are missing, distinct in grey."""

import itertools
import re
import shlex
import subprocess
import sys
import textwrap
import warnings
import xml.etree.ElementTree as ElementTree
from collections import Counter

import matplotlib
import numpy as np
import pytest
from small_maps import map_of

import kinetostatics as ks
from kinetostatics.cli.main import main

matplotlib.use("Agg")

from matplotlib import pyplot as plt
from matplotlib.collections import PathCollection
from matplotlib.colors import to_rgba
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from kinetostatics.plot.masks import extrapolated, smooth_field
from kinetostatics.plot.selection import coordinate_unit, display_unit, main_range
from kinetostatics.plot.style import figure_of
from kinetostatics.plot.surfaces import cut_cells, skin

pytestmark = pytest.mark.usefixtures("no_figures_left")

Z = np.array([0.3, 0.4, 0.5, 0.6])
RX = np.radians(np.linspace(-20, 20, 9))
RY = np.radians(np.linspace(-15, 15, 7))


@pytest.fixture(scope="module")
def ds():
    """A map with every status somewhere, all numbers different."""
    z, rx, ry = np.meshgrid(Z, RX, RY, indexing="ij")
    twist = 1e-6 * np.stack([3 * rx + z, ry - z, -10 * z, rx * ry, ry**2 + z, 0 * z], axis=-1)
    status = np.zeros(z.shape, np.int8)
    status[np.hypot(rx, ry) > 0.36] = ks.Status.UNREACHABLE
    status[:, 0, 2:4] = ks.Status.LIMIT_EXCEEDED
    status[1, 5, 3] = ks.Status.SINGULAR
    gone = np.isin(status, [ks.Status.UNREACHABLE, ks.Status.SINGULAR])
    twist[gone] = np.nan
    mode = np.where(status == ks.Status.UNREACHABLE, -1, 0)
    mode[:, -1][mode[:, -1] == -1] = 1
    found = map_of(
        {"z": (Z, "m"), "rx": (RX, "rad"), "ry": (RY, "rad")},
        twist=twist,
        compliance=np.eye(6) * 1e-7 * (1 + z)[..., None, None],
        forces={"p1": 1000 * z + 100 * rx, "p2": 900 * z},
        status=status,
        pose=np.stack([rx, ry, z, rx, ry, 0 * z], axis=-1),
    )
    return found.assign(mode=(("z", "rx", "ry"), mode.astype(np.int8)))


def coloured(ds, *arguments, **options):
    """A slice without contour lines, whose numbers take most of the time."""
    return ks.plot.slice(ds, *arguments, contours=False, **options)


def texts_of(figure):
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def within(path, place):
    """Return whether a place is inside a path, and in none of its holes."""
    return sum(matplotlib.path.Path(corners).contains_point(place) for corners in path.to_polygons()) % 2 == 1


def regions(ax):
    """Return hatched areas, the one that lies on top last."""
    return {item.get_label(): item for item in ax.collections if isinstance(item, PathCollection) and item.get_hatch()}


def colours_of(ax):
    """Return the numbers (len x, len y) of the colours of a slice, NaN where its clip path leaves none."""
    mesh = ax.collections[0]
    corners = mesh.get_coordinates()
    centres = (corners[:-1, :-1] + corners[1:, 1:]) / 2
    path, _ = mesh.get_clip_path().get_transformed_path_and_affine()
    there = [within(path, place) for place in centres.reshape(-1, 2)]
    return np.where(np.reshape(there, centres.shape[:2]), mesh.get_array().filled(np.nan), np.nan).T


def overlaps(figure):
    """Return pairs of texts of a figure that lie on one another."""
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    boxes = []
    for axes in figure.axes:
        texts = [axes.title, axes.xaxis.label, axes.yaxis.label]
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            texts += [tick.label1 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
            texts += [tick.label2 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
        boxes += [(text.get_text(), text.get_window_extent(renderer)) for text in texts if text.get_visible()]
    boxes += [("legend", legend.get_window_extent(renderer)) for legend in figure.legends]
    boxes = [(text, box.shrunk(0.97, 0.97)) for text, box in boxes if text.strip()]
    outside = [(text, "off the page") for text, box in boxes if box.x0 < figure.bbox.x0 or box.x1 > figure.bbox.x1]
    return outside + [(a, b) for (a, one), (b, two) in itertools.combinations(boxes, 2) if one.overlaps(two)]


# ---- slices ------------------------------------------------------------------------------------------------------------


def test_slice_shows_map_values_and_units(ds):
    ax = ks.plot.slice(ds, "twist:x", x="rx", y="ry", at={"z": 0.5})
    mesh = ax.collections[0]
    expected = ks.indices.quantity(ds, "twist:x").sel(z=0.5).values * 1e6
    np.testing.assert_allclose(colours_of(ax), expected, rtol=1e-14)
    corners = mesh.get_coordinates()
    np.testing.assert_allclose((corners[:-1, :-1] + corners[1:, 1:])[0, :, 0] / 2, np.degrees(RX), atol=1e-12)
    np.testing.assert_allclose((corners[:-1, :-1] + corners[1:, 1:])[:, 0, 1] / 2, np.degrees(RY), atol=1e-12)
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_title()) == ("rx [°]", "ry [°]", "z = 0.5 m")
    assert ax.figure.axes[1].get_ylabel() == "displacement along x [µm]"
    assert not overlaps(ax.figure)


def test_slice_hatches_poses_without_values_by_reason(ds):
    ax = coloured(ds, "linear_sag", x="rx", y="ry", at={"z": 0.4})
    hatched = regions(ax)
    here = ds.sel(z=0.4)
    expected = {
        "unreachable": (here.status == 2).values,
        "beyond joint limits": (here.status == 1).values,
        "singular": (here.status == 3).values,
    }
    assert set(hatched) == set(expected) and all(where.any() for where in expected.values())
    assert sorted(texts_of(ax.figure)) == sorted(expected)
    assert len({item.get_hatch() for item in hatched.values()}) == 3
    on_top = np.full(here.status.shape, "", dtype=object)
    for name, area in hatched.items():
        for i, j in np.ndindex(*on_top.shape):
            if within(area.get_paths()[0], (np.degrees(RX[i]), np.degrees(RY[j]))):
                on_top[i, j] = name
    for name, where in expected.items():
        np.testing.assert_array_equal(on_top == name, where, err_msg=name)
    # legends show what the cells look like
    for legend in ax.figure.legends:
        for patch, text in zip(legend.get_patches(), legend.get_texts(), strict=True):
            assert patch.get_hatch() == hatched[text.get_text()].get_hatch()
    np.testing.assert_array_equal(np.isnan(colours_of(ax)), np.any(list(expected.values()), axis=0))
    ax = coloured(ds, "linear_sag", x="rx", y="ry", at={"z": 0.6}, beyond_limits=True)
    assert "beyond joint limits" not in texts_of(ax.figure) and np.isfinite(colours_of(ax)[0, 2])


def test_slice_title_names_the_nearest_pose_taken(ds):
    assert coloured(ds, "twist:x", x="rx", y="z", at={"ry": np.radians(6)}).get_title() == "ry = 5°"
    ax = coloured(ds, "twist:x", at={"rx": 0.0})
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_title()) == ("z [m]", "ry [°]", "rx = 0°")


def test_slice_with_requested_unit_and_value_range(ds):
    ax = coloured(ds, "twist:ry", x="rx", y="ry", at={"z": 0.5}, unit="deg", value_range=(2e-5, 3e-5))
    np.testing.assert_allclose(colours_of(ax), np.degrees(ks.indices.quantity(ds, "twist:ry").sel(z=0.5).values))
    assert ax.collections[0].get_clim() == (2e-5, 3e-5)
    assert ax.figure.axes[1].get_ylabel() == "rotation about y [°]"
    colorbar = ax.collections[0].colorbar
    assert colorbar.extend == "max"  # some values are larger, none is smaller


RX_RY = {"x": "rx", "y": "ry"}


@pytest.mark.parametrize(
    "kind, options, message",
    [
        ("slice", RX_RY, r"z has 4 values, from z = 0.3 m to z = 0.6 m: choose by at=\{'z': …\} \(--at z=0\.5m\)$"),
        ("slice", {"x": "rx", "y": "rx", "at": {"z": 0.5}}, "must be different"),
        ("slice", {"x": "rx", "y": "rz", "at": {"z": 0.5}}, "'rz' is not swept: did you mean"),
        ("slice", {**RX_RY, "at": {"z": 0.8}}, "z = 0.8 m is outside the map, which ranges from 0.3 to 0.6 m"),
        ("slice", {**RX_RY, "at": {"z": float("nan")}}, "outside the map"),
        ("slice", {"x": "rx", "y": "z", "at": {"rx": 0.0, "ry": 0.0}}, "rx cannot be both an axis of the figure"),
        ("slice", {"at": {"rx": 0.0, "ry": 0.0}}, r"not fixed are: z; ks\.plot\.line shows .* \(--kind line\)"),
        ("slice", {**RX_RY, "unit": "kN", "at": {"z": 0.5}}, "unit 'kN' is not one for values in m: m, mm, µm"),
        (
            "line",
            {"what": ["twist:x", "twist:rx"], "x": "rx", "at": {"z": 0.5, "ry": 0}},
            "m and rad cannot be drawn",
        ),
        ("line", {"what": []}, "one to 6 quantities"),
        ("line", {"what": ["twist:x", "twist:y"], "series": "z", "x": "rx"}, "or one quantity with series="),
        ("line", {"series": "z", "x": "z", "at": {"rx": 0, "ry": 0}}, "z cannot be the series"),
        ("line", {"series": {"z": 7 * [0.3]}, "x": "rx", "at": {"ry": 0}}, "at most 6 values, not 7"),
        ("line", {"x": "rx", "at": {"z": 0.5}}, "ry has 7 values"),
        ("line", {"at": {"z": 0.5, "rx": 0, "ry": 0}}, "a line needs one coordinate with several values; not fixed are: none"),
        ("surface", {**RX_RY, "series": "rx"}, "rx cannot be the series"),
        ("surface", {**RX_RY, "series": {"z": [0.3], "rx": [0]}}, "series takes one coordinate"),
        ("surface", {**RX_RY, "series": {"z": [0.9]}}, "outside the map"),
        ("surface", {"at": {"z": 0.3, "rx": 0}}, "a surface needs two coordinates"),
        ("workspace", {"axes": ("rx", "ry")}, "three axes, not 2"),
        ("workspace", {"axes": ("rx", "ry", "w")}, "'rx' is not swept|'w' is not swept"),
        ("workspace", {"at": {"z": 0.5}}, "a workspace needs three coordinates"),
    ],
)
def test_invalid_figure_arguments_are_refused(ds, kind, options, message):
    with pytest.raises(ks.ArgumentError, match=message):
        getattr(ks.plot, kind)(ds, **options)


def test_figures_need_3d_axes_and_finite_values(ds):
    for kind in ("surface", "workspace"):
        with pytest.raises(ks.ArgumentError, match="projection='3d'"):
            getattr(ks.plot, kind)(ds, "twist:x", ax=plt.figure().add_subplot())
    gone = ds.assign(status=ds.status * 0 + ks.Status.UNREACHABLE).drop_vars("mode")
    for kind, options in (("slice", {**RX_RY, "at": {"z": 0.5}}), ("workspace", {})):
        with pytest.raises(ks.ArgumentError, match=rf"no pose of this {kind} has a number \(unreachable\)"):
            getattr(ks.plot, kind)(gone, **options)


def test_error_lists_all_free_coordinates_with_a_valid_option(tmp_path, capsys):
    ds = map_of({"d": ([0.04, 0.05], "m"), "rx": ([-0.1, 0.0, 0.1], "rad"), "z": ([0.1, 0.2, 0.3], "m"), "y": ([0.0, 0.1], "m")})
    ds.to_netcdf(tmp_path / "m.nc")
    command = ["plot", str(tmp_path / "m.nc"), "--what", "twist:z", "--x", "z", "--y", "y", "--out", str(tmp_path / "m.png")]
    assert main(command) == 2
    message = capsys.readouterr().err
    assert "d has 2 values" in message and "rx has 3 values" in message and "choose by at={'d': …, 'rx': …}" in message
    assert main([*command, "--at", *re.search(r"\(--at (.*)\)", message)[1].split()]) == 0
    plt.close("all")


def test_long_titles_are_wrapped_to_the_figure_width():
    names = [f"a_parameter_of_the_file_{k}" for k in range(6)]
    ds = map_of({**{name: ([0.1, 0.2], "m") for name in names}, "z": ([0.1, 0.2], "m"), "y": ([0.0, 0.1], "m")})
    ax = ks.plot.slice(ds, "twist:z", x="z", y="y", at=dict.fromkeys(names, 0.1))
    lines = ax.get_title().split("\n")
    assert ", ".join(line.rstrip(",") for line in lines) == ", ".join(f"{name} = 0.1 m" for name in names)
    ax.figure.canvas.draw()
    page, title = ax.figure.bbox, ax.title.get_window_extent()
    assert len(lines) == 6 and page.x0 <= title.x0 and title.x1 <= page.x1
    plt.close("all")


def test_slice_over_a_text_coordinate_labels_its_axis(ds):
    named = ds.isel(ry=3, drop=True).rename(z="material").assign_coords(material=["steel", "brass", "oak", "ash"])
    ax = coloured(named, "twist:x", x="rx", y="material")
    assert [text.get_text() for text in ax.get_yticklabels()] == ["steel", "brass", "oak", "ash"]
    assert ks.plot.line(named, "twist:x", at={"material": "oak"}).get_title() == "material = oak"
    with pytest.raises(ks.ArgumentError, match="no material 'gold'"):
        ks.plot.line(named, "twist:x", at={"material": "gold"})


def test_lazy_map_is_computed_only_where_shown(ds):
    from dask import array

    seen = []

    def note(block, block_info=None):
        if block_info:
            seen.append(block_info[0]["chunk-location"][0])
        return block

    lazy = ds.chunk({"z": 1})
    twist = array.map_blocks(note, lazy.twist.data, dtype=float, meta=np.empty((0,) * 4))
    ax = ks.plot.slice(lazy.assign(twist=lazy.twist.copy(data=twist)), "linear_sag", x="rx", y="ry", at={"z": 0.5})
    assert set(seen) == {2}
    reference = ks.plot.slice(ds, "linear_sag", x="rx", y="ry", at={"z": 0.5})
    np.testing.assert_allclose(*(item.collections[0].get_array().filled(0) for item in (ax, reference)), rtol=1e-14)


def test_slices_of_a_series_stand_side_by_side(ds):
    ax = ks.plot.slice(ds, "twist:x", x="rx", y="ry", series="z", contours=False)
    *panels, bar = ax.figure.axes
    assert ax is panels[0] and [panel.get_title() for panel in panels] == [f"z = {z} m" for z in Z]
    assert len({panel.collections[0].get_clim() for panel in panels}) == 1
    for panel, z in zip(panels, Z, strict=True):
        expected = ks.indices.quantity(ds, "twist:x").sel(z=z).values * (1e6 if "µm" in bar.get_ylabel() else 1e9)
        np.testing.assert_allclose(colours_of(panel), expected, rtol=1e-12)
    assert len(texts_of(ax.figure)) == len(set(texts_of(ax.figure)))
    many = ds.isel(z=0, drop=True).expand_dims(rz=np.linspace(0, 1, 7))
    with pytest.warns(UserWarning, match="the figure shows 3 of the 7 values of rz"):
        assert "3 of the 7 values of rz" in ks.plot.slice(many, x="rx", y="ry", series="rz", contours=False).figure.get_suptitle()
    with pytest.raises(ks.ArgumentError, match="slices of a series need a new figure"):
        ks.plot.slice(ds, "twist:x", x="rx", y="ry", series="z", ax=plt.figure().add_subplot())


# ---- azimuth and tilt --------------------------------------------------------------------------------------------------

AZIMUTH = np.radians(np.arange(-180, 180, 30))
TILT = np.radians(np.arange(0, 50, 10))


@pytest.fixture(scope="module")
def tilts():
    """A map over azimuth and tilt, all numbers different, a few poses out of reach at the rim."""
    turn, tilt, z = np.meshgrid(AZIMUTH, TILT, [0.4, 0.5], indexing="ij")
    status = np.zeros(turn.shape, np.int8)
    status[(tilt > 0.6) & (np.cos(3 * turn) > 0.5)] = ks.Status.UNREACHABLE
    twist = 1e-6 * np.stack([turn + 10 * tilt + z] * 6, axis=-1)
    twist[status > 0] = np.nan
    return map_of(
        {"azimuth": (AZIMUTH, "rad"), "tilt": (TILT, "rad"), "z": ([0.4, 0.5], "m")},
        twist=twist,
        compliance=np.eye(6) * 1e-7,
        status=status,
    )


def cell_at(ax, azimuth, tilt):
    """Return what a polar slice shows at a place [°], and whether it is hatched there."""
    mesh = ax.collections[0]
    x, y = mesh.get_coordinates()[0, :, 0], mesh.get_coordinates()[:, 0, 1]
    column = np.searchsorted(x, np.radians(azimuth)) - 1
    if column < 0:
        column = np.searchsorted(x, np.radians(azimuth + 360)) - 1
    value = mesh.get_array().filled(np.nan)[np.searchsorted(y, tilt) - 1, column % (len(x) - 1)]
    # compared on the page, since hatches and cells may be cut at different azimuths
    page = ax.transData.transform((np.radians(azimuth), tilt))
    areas = regions(ax).values()
    return value, any(within(item.get_transform().transform_path(path), page) for item in areas for path in item.get_paths())


@pytest.mark.few(1)
@pytest.mark.parametrize("names", [("azimuth", "tilt"), ("tilt", "azimuth"), (None, None)])
def test_polar_slice_has_azimuth_as_angle_and_tilt_as_radius(tilts, names):
    ax = coloured(tilts, "twist:x", *names, at={"z": 0.5})
    assert ax.name == "polar"
    expected = ks.indices.quantity(tilts, "twist:x").sel(z=0.5).values * 1e6
    ax.figure.draw_without_rendering()
    for i, j in np.ndindex(*expected.shape):
        # near all four borders of the cell: it is where its pose is, and as wide as half the way to its neighbours
        for across, out in itertools.product((-14.9, 0.0, 14.9), (-4.9, 4.9) if j else (0.1, 4.9)):
            value, _ = cell_at(ax, np.degrees(AZIMUTH[i]) + across, np.degrees(TILT[j]) + out)
            if np.isfinite(expected[i, j]):
                np.testing.assert_allclose(value, expected[i, j], rtol=1e-14)
        assert cell_at(ax, np.degrees(AZIMUTH[i]), np.degrees(TILT[j]) + 0.1)[1] == np.isnan(expected[i, j])
    assert ax.get_thetamin() == 0 and ax.get_thetamax() == 360 and ax.get_rmax() == pytest.approx(45)
    # 0° to the right, 90° upwards
    (right, middle), (over, top) = ax.transData.transform([(0.0, 40.0), (np.pi / 2, 40.0)])
    assert right > over and top > middle
    assert ax.get_xlabel() == "azimuth (angular), tilt (radial) [°]" and ax.get_title() == "z = 0.5 m"
    assert ax.figure.axes[1].get_ylabel() == "displacement along x [µm]"
    assert [text.get_text() for text in ax.get_xticklabels()] == ["0°", "45°", "90°", "135°", "180°", "−135°", "−90°", "−45°"]
    names = [text.get_text() for tick, text in zip(ax.get_yticks(), ax.get_yticklabels(), strict=True) if tick <= 45]
    assert names == ["20°", "40°"]
    assert "unreachable" in texts_of(ax.figure)
    corners = ax.collections[0].get_coordinates()
    assert np.degrees(np.diff(corners[0, :, 0])).max() <= 2 + 1e-9  # Matplotlib draws sides straight
    assert corners[:, 0, 1].min() == 0
    (area,) = regions(ax).values()
    on_the_rim = area.get_paths()[0].vertices
    on_the_rim = on_the_rim[np.isclose(on_the_rim[:, 1], 45)]
    assert np.degrees(np.abs(np.diff(np.sort(on_the_rim[:, 0])))).min() <= 2 + 1e-9


def test_polar_contours_close_over_the_full_turn(tilts):
    level = tilts.assign(twist=tilts.twist * 0 + 1e-6 * tilts.tilt).where(tilts.tilt < 0.6)
    ax = ks.plot.slice(level.assign(status=tilts.status), "twist:x", at={"z": 0.5}, contours=3)
    (lines,) = (item for item in ax.collections if type(item).__name__ == "QuadContourSet" and len(item.levels) > 1)
    for path in lines.get_paths():
        assert np.ptp(path.vertices[:, 0]) == pytest.approx(2 * np.pi)


def test_polar_slices_of_a_sector_and_a_closed_turn(tilts):
    part = tilts.isel(azimuth=slice(6, 10))  # 0 to 90°
    ax = coloured(part, "twist:x", at={"z": 0.5})
    assert (ax.get_thetamin(), ax.get_thetamax()) == pytest.approx((-15, 105))
    assert [text.get_text() for text in ax.get_xticklabels()] == ["−15°", *(f"{k}°" for k in range(0, 106, 15))]
    closed = np.append(AZIMUTH, np.pi)
    both = tilts.sel(azimuth=np.append(AZIMUTH, AZIMUTH[0])).assign_coords(azimuth=("azimuth", closed, {"units": "rad"}))
    ax = coloured(both, "twist:x", at={"z": 0.5})
    x = ax.collections[0].get_coordinates()[0, :, 0]
    np.testing.assert_allclose(x[[0, -1]], [-np.pi, np.pi])  # the pose at ±180° has half a cell on either side
    uneven = tilts.isel(azimuth=[0, 4, 8, 11])  # -180°, -60°, 60°, 150°
    x = coloured(uneven, "twist:x", at={"z": 0.5}).collections[0].get_coordinates()[0, :, 0]
    np.testing.assert_allclose(np.degrees(x[[0, -1]]), [-195, 165])


def test_slice_over_non_polar_coordinates_is_rectangular(tilts):
    for other in (
        tilts.assign_coords(tilt=("tilt", TILT - 0.2, {"units": "rad"})),
        tilts.assign_coords(azimuth=("azimuth", AZIMUTH * 1.5, {"units": "rad"})),
    ):
        assert coloured(other, "twist:x", at={"z": 0.5}).name == "rectilinear"
        with pytest.raises(ks.ArgumentError, match="tilts of 0 or more and azimuths within one turn"):
            coloured(other, "twist:x", at={"z": 0.5}, polar=True)
    ax = coloured(tilts, "twist:x", at={"z": 0.5}, polar=False)
    assert (ax.name, ax.get_xlabel(), ax.get_ylabel()) == ("rectilinear", "azimuth [°]", "tilt [°]")
    assert coloured(tilts, "twist:x", x="azimuth", y="z", at={"tilt": 0.2}).name == "rectilinear"
    with pytest.raises(ks.ArgumentError, match="here the coordinates are azimuth and z"):
        coloured(tilts, "twist:x", x="azimuth", y="z", at={"tilt": 0.2}, polar=True)


def test_given_axes_decide_whether_a_slice_is_polar(tilts):
    figure = plt.figure(layout="constrained")
    flat, round_ = figure.add_subplot(1, 2, 1), figure.add_subplot(1, 2, 2, projection="polar")
    for ax in (flat, round_):
        assert coloured(tilts, "twist:x", at={"z": 0.5}, ax=ax) is ax
    assert flat.get_xlabel() == "azimuth [°]" and round_.get_xlabel() == "azimuth (angular), tilt (radial) [°]"
    with pytest.raises(ks.ArgumentError, match="axes made with projection='polar'"):
        coloured(tilts, "twist:x", at={"z": 0.5}, polar=True, ax=flat)
    for options in ({"polar": False, "at": {"z": 0.5}}, {"x": "azimuth", "y": "z", "at": {"tilt": 0.2}}):
        with pytest.raises(ks.ArgumentError, match="axes without projection='polar'"):
            coloured(tilts, "twist:x", ax=round_, **options)


# ---- lines -------------------------------------------------------------------------------------------------------------


def test_lines_show_map_values(ds):
    ax = ks.plot.line(ds, ["twist:x", "twist:y", "twist:z"], x="rx", at={"z": 0.5, "ry": 0.0})
    for line, name in zip(ax.get_lines(), ["twist:x", "twist:y", "twist:z"], strict=True):
        np.testing.assert_allclose(line.get_xdata(), np.degrees(RX), rtol=1e-14)
        expected = ks.indices.quantity(ds, name).sel(z=0.5, ry=0.0, method="nearest").values * 1e6
        np.testing.assert_allclose(line.get_ydata(), expected, rtol=1e-14)
    assert np.isnan(ax.get_lines()[0].get_ydata()[0])  # beyond a limit
    assert (
        len({line.get_marker() for line in ax.get_lines()})
        == len({str(line._unscaled_dash_pattern) for line in ax.get_lines()})
        == 3
    )
    greys = [np.dot(to_rgba(line.get_color())[:3], [0.2126, 0.7152, 0.0722]) for line in ax.get_lines()]
    assert np.all(np.diff(greys) > 0.15)  # told apart in grey
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_title()) == ("rx [°]", "displacement [µm]", "z = 0.5 m, ry = 0°")
    assert texts_of(ax.figure) == ["displacement along x", "displacement along y", "displacement along z", "beyond joint limits"]
    assert not overlaps(ax.figure)


def test_lines_of_gravity_mechanisms_have_the_paper_values():
    """At a tilt of 10° platform −22.0, attached −2.2, deformation −49.9 nm, see unit/results/test_contributions.py."""
    platform = {"z": 0.5, "azimuth": np.radians(-170), "tilt": np.radians([0, 10, 20])}
    ds = ks.sweep("3rps", platform, orientation="tilt_torsion", gravity=(0, 0, -9.8), outputs=["default", "gravity_mechanisms"])
    ways = [f"gravity_mechanism:{way}:z" for way in ("platform_weight", "attached", "deformation")]
    drive = [f"actuator_gravity_mechanism:prismatic_1:{way}" for way in ("platform_weight", "attached", "deformation")]
    assert {*ways, *drive, "actuator_contribution:prismatic_3:limb_1"} < set(ks.indices.names(ds))
    ax = ks.plot.line(ds, ways, x="tilt", unit="nm")
    assert [line.get_ydata()[1] for line in ax.get_lines()] == pytest.approx([-22.0350, -2.2028, -49.8725], abs=1e-3)
    said = ("platform weight", "attached wrenches", "deformation")
    assert texts_of(ax.figure) == [f"displacement along z by {name}" for name in said]
    assert ax.get_ylabel() == "displacement along z [nm]"
    ax = ks.plot.line(ds, drive, x="tilt")
    assert texts_of(ax.figure) == [f"force of prismatic_1 by {name}" for name in said]
    assert ax.get_ylabel() == "force of prismatic_1 [N]"
    np.testing.assert_array_equal(ax.get_lines()[2].get_ydata(), 0)  # not what rounding has left
    assert ax.get_lines()[1].get_ydata()[1] > 300
    with pytest.raises(ks.ArgumentError, match="no mechanism 'atached': did you mean 'attached'"):
        ks.plot.line(ds, "gravity_mechanism:atached:z")
    with pytest.raises(ks.ArgumentError, match=r"has no 'gravity_mechanism'; sweep with 'gravity_mechanisms' among the outputs"):
        ks.plot.line(ds.drop_dims("mechanism"), "gravity_mechanism:attached:z")


def test_line_hatches_ranges_without_values(ds):
    ax = ks.plot.line(ds, "linear_sag", x="rx", at={"z": 0.5, "ry": RY[0]})
    spans = [item for item in ax.patches if item.get_label() == "unreachable"]
    inside = [any(item.get_x() < x < item.get_x() + item.get_width() for item in spans) for x in np.degrees(RX)]
    here = ds.sel(z=0.5).isel(ry=0)
    np.testing.assert_array_equal(inside, here.status == 2)
    assert all(item.get_hatch() for item in spans)


def test_a_series_has_a_line_for_each_value(ds):
    ax = ks.plot.line(ds, "largest_actuator_force", x="rx", series="z", at={"ry": 0.0})
    assert texts_of(ax.figure)[:4] == ["z = 0.3 m", "z = 0.4 m", "z = 0.5 m", "z = 0.6 m"]
    assert ax.get_ylabel() == "largest actuator force [N]"
    expected = ks.indices.quantity(ds, "largest_actuator_force").sel(ry=0.0, method="nearest").values
    for line, row in zip(ax.get_lines(), expected, strict=True):
        np.testing.assert_allclose(line.get_ydata(), row, rtol=1e-14)


# ---- surfaces ----------------------------------------------------------------------------------------------------------


def corners_of(collection):
    """Return the corners (m, n, 3) of a surface, which Matplotlib before 3.11 keeps as one row of points."""
    if hasattr(collection, "_faces"):
        return np.asarray(collection._faces)
    return np.array([collection._vec[:3, part].T for part in collection._segslices])


def faces(ax):
    """Return the corners (m, n, 3) of the first collection of axes."""
    collection = ax.collections[0]
    assert isinstance(collection, Poly3DCollection)
    return corners_of(collection)


def test_surface_corners_have_map_values(ds):
    ax = ks.plot.surface(ds, "twist:x", x="rx", y="ry", series={"z": [0.3, 0.6]})
    values = ks.indices.quantity(ds, "twist:x")
    there = {tuple(np.round(corner, 9)) for corner in faces(ax).reshape(-1, 3)}
    expected = set()
    for z in (0.3, 0.6):
        here = values.sel(z=z).values
        for i, j in np.argwhere(np.isfinite(here)):
            expected.add(tuple(np.round([np.degrees(RX[i]), np.degrees(RY[j]), here[i, j] * 1e6], 9)))
    assert expected <= there
    others = np.array(sorted(there - expected))[:, :2]  # at the rim, between neighbours of which one has no number
    on_lines = [np.isclose(others[:, [k]], np.degrees(names)).any(axis=1) for k, names in enumerate((RX, RY))]
    assert np.all(on_lines[0] ^ on_lines[1])
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_title()) == ("rx [°]", "ry [°]", "displacement along x [µm]")
    assert texts_of(ax.figure)[:2] == ["z = 0.3 m", "z = 0.6 m"]
    assert {"unreachable", "beyond joint limits"} <= set(texts_of(ax.figure))


def test_surface_legend_names_only_differing_coordinates(ds):
    """Coordinates that all surfaces share are in the title."""
    held = ds.assign_coords(x=((), 0.25, {"units": "m"})).expand_dims(y=[0.1])
    held["y"].attrs["units"] = "m"
    ax = ks.plot.surface(held.transpose("y", ...), "twist:x", x="rx", y="ry", series={"z": [0.3, 0.58]})
    assert texts_of(ax.figure)[:2] == ["z = 0.3 m", "z = 0.6 m"]
    assert ax.get_title() == "displacement along x [µm], y = 0.1 m, x = 0.25 m"
    ax = ks.plot.line(held, "twist:x", x="rx", series="z", at={"ry": 0.0})
    assert texts_of(ax.figure)[:4] == ["z = 0.3 m", "z = 0.4 m", "z = 0.5 m", "z = 0.6 m"]
    assert ax.get_title() == "ry = 0°, y = 0.1 m, x = 0.25 m"


def test_one_surface_has_a_colour_bar_and_several_a_legend(ds):
    ax = ks.plot.surface(ds, "actuator_force:p1")  # over the coordinates that are left
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("rx [°]", "ry [°]")
    assert texts_of(ax.figure)[:4] == ["z = 0.3 m", "z = 0.4 m", "z = 0.5 m", "z = 0.6 m"]
    ax = ks.plot.surface(ds, "linear_sag", x="rx", y="ry", at={"z": 0.5})
    assert ax.get_title() == "z = 0.5 m"
    assert ax.figure.axes[1].get_ylabel() == "linear sag [µm]"
    floor = [item for item in ax.collections[1:] if isinstance(item, Poly3DCollection)]
    assert {item.get_label() for item in floor} == {"unreachable", "beyond joint limits"}
    assert len({str(patch.get_facecolor()) for legend in ax.figure.legends for patch in legend.get_patches()}) == 2
    holes = corners_of(floor[0])[..., :2].reshape(-1, 2)
    gone = np.argwhere(np.isnan(ks.indices.quantity(ds, "linear_sag").sel(z=0.5).values))
    for i, j in gone:
        assert np.isclose(holes, [np.degrees(RX[i]), np.degrees(RY[j])]).all(axis=1).any()


def test_overlapping_surfaces_are_drawn_side_by_side(ds):
    same = ds.assign(twist=ds.twist.isel(z=[1] * 4).assign_coords(z=ds.z) * (1 + 1e-3 * ds.z))
    ax = ks.plot.surface(same, "twist:x", x="rx", y="ry", series="z")
    *panels, bar = ax.figure.axes
    assert [panel.get_title() for panel in panels] == [f"z = {z} m" for z in Z]
    assert len({panel.get_zlim() for panel in panels}) == 1 and bar.get_ylabel().split() == "displacement along x [µm]".split()
    assert len(ks.plot.surface(ds, "linear_sag", x="rx", y="ry", series="z").figure.axes) == 1
    ax = plt.figure().add_subplot(projection="3d")
    assert ks.plot.surface(same, "twist:x", x="rx", y="ry", series="z", ax=ax).figure.axes == [ax]


# ---- workspaces --------------------------------------------------------------------------------------------------------


def disc(count, size=0.8, dims=2):
    """Return places along each axis, distances from the middle, and where these are within a size."""
    along = np.linspace(-1, 1, count)
    far = np.sqrt(sum(axis**2 for axis in np.meshgrid(*dims * [along], indexing="ij")))
    return along, far, far < size


def test_workspace_rims_are_smooth_and_pass_between_poses():
    along, _, inside = disc(25)
    field = smooth_field(inside)
    np.testing.assert_array_equal(field > 0, inside)
    (found,) = plt.contour(along, along, field, [0.0]).allsegs[0]
    plt.close()
    off = (np.hypot(*found.T) - 0.8) / (along[1] - along[0])
    steps = np.diff(found, axis=0)
    steps = steps[np.hypot(*steps.T) > 1e-3]
    turns = np.degrees(np.abs(np.diff(np.unwrap(np.arctan2(*steps.T)))))
    assert np.abs(off).max() < 0.6 and np.sqrt(np.mean(off**2)) < 0.3 and np.sqrt(np.mean(turns**2)) < 12  # half way it is 26°
    thin = np.zeros((9, 9), bool)
    thin[4, 1:8] = thin[1, 1] = True
    assert np.array_equal(smooth_field(thin) > 0, thin) and np.array_equal(smooth_field(~thin) > 0, ~thin)
    turned = smooth_field(np.roll(thin, 4, axis=0), closed=True)
    np.testing.assert_allclose(np.roll(turned, -4, axis=0), smooth_field(thin, closed=True), atol=1e-15)


def test_values_are_extrapolated_linearly_beyond_the_rim():
    x, y = np.meshgrid(np.arange(6.0), np.arange(5.0), indexing="ij")
    there = (x > 1) & (y > 1)
    found = extrapolated(np.where(there, 3 * x - 2 * y, np.nan))
    np.testing.assert_allclose(found[1:, 1:], (3 * x - 2 * y)[1:, 1:])


def test_surface_cells_are_cut_where_a_field_is_zero():
    x, y = np.meshgrid(np.linspace(0, 1, 8), np.linspace(0, 1, 6), indexing="ij")
    found = cut_cells(np.dstack([x, y, x]), 0.9 - x - 0.7 * y)
    one, two = found, np.roll(found, -1, axis=1)
    area = np.sum(one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0], axis=1) / 2
    assert np.all(area > 0) and area.sum() == pytest.approx(0.9**2 / 1.4 - 0.2**2 / 1.4 * (0.9 > 0.7) ** 1)
    assert np.all(found[..., 0] + 0.7 * found[..., 1] < 0.9 + 1e-12)


def test_the_skin_of_a_ball_is_closed_and_round():
    along, _, inside = disc(21, dims=3)
    grid = np.stack(np.meshgrid(along, along, along, indexing="ij"), axis=-1)
    corners, nodes = skin(grid, smooth_field(inside), np.zeros_like(inside))
    step = along[1] - along[0]
    off = np.linalg.norm(corners, axis=-1) - 0.8
    assert np.abs(off).max() < 0.6 * step and np.sqrt(np.mean(off**2)) < 0.25 * step
    edges = np.round(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2), 9).reshape(-1, 2, 3)
    each = [tuple(sorted(map(tuple, edge.tolist()))) for edge in edges]
    assert all(count % 2 == 0 for count in Counter(each).values())
    assert inside[tuple(nodes.T)].all()
    far = np.linalg.norm(grid[tuple(nodes.T)] - corners.mean(axis=1), axis=-1)
    assert far.max() < 1.1 * step  # a face is beside its pose
    whole, nodes = skin(grid, smooth_field(np.ones_like(inside)), np.zeros_like(inside))
    assert np.abs(whole).max() == 1 and len(nodes) == 6 * 21**2  # the body of all poses is what the sweep asked for


def test_workspace_is_the_body_of_valid_poses(ds):
    ax = ks.plot.workspace(ds, "linear_sag", cut=False)
    values = ks.indices.quantity(ds, "linear_sag").transpose("rx", "ry", "z").values
    good = np.isfinite(values)
    shown = faces(ax)
    assert len(shown) == sum(np.abs(np.diff(np.pad(good, 1).astype(int), axis=axis)).sum() for axis in range(3))
    reach = shown.reshape(-1, 3)
    for axis, name in enumerate((np.degrees(RX), np.degrees(RY), Z)):
        assert name.min() - 1e-9 <= reach[:, axis].min() and reach[:, axis].max() <= name.max() + 1e-9
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_zlabel()) == ("rx [°]", "ry [°]", "z [m]")
    bar = ax.figure.axes[1]
    assert bar.get_ylabel() == "linear sag [µm]"
    np.testing.assert_allclose(bar.get_ylim(), (1e6 * np.nanmin(values), 1e6 * np.nanmax(values)), rtol=1e-12)
    (note,) = texts_of(ax.figure)
    part = 100 * float((ds.status == 1).mean())
    assert note.startswith("not drawn: ") and f"beyond joint limits {part:.2g} %" in note and "unreachable" in note


def test_cut_workspace_lacks_the_octant_towards_the_viewer(ds):
    whole, cut = (ks.plot.workspace(ds, "linear_sag", cut=cut) for cut in (False, True))
    shown = ks.plot.workspace(ds, "linear_sag", value_range=(0, 1e-9))
    assert shown.figure.axes[1].get_ylim() == (0, 1e-9)
    octant = [np.any(np.all((faces(ax) - [5, -5, 0.5]) * [1, -1, 1] >= 0, axis=-1)) for ax in (whole, cut)]  # towards the viewer
    assert octant == [True, False]


def test_workspace_over_actuators_is_drawn_in_platform_positions(ds):
    actuated = ds.rename(z="p_1", rx="p_2", ry="p_3")
    ax = ks.plot.workspace(actuated, "linear_sag", cut=False)
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_zlabel()) == ("x [m]", "y [m]", "z [m]")
    reach = faces(ax).reshape(-1, 3)
    good = np.isfinite(ks.indices.quantity(actuated, "linear_sag"))
    np.testing.assert_allclose(reach[:, 2].max(), 0.6)
    assert reach[:, 0].max() <= RX[np.any(good, axis=(0, 2))].max() + 1e-12
    explicit = ks.plot.workspace(ds, "linear_sag", ["x", "y", "z"], cut=False)
    np.testing.assert_allclose(np.sort(faces(explicit), axis=None), np.sort(faces(ax), axis=None))


# ---- little to show ----------------------------------------------------------------------------------------------------


def test_axis_with_one_value_has_one_tick_label(ds, tilts):
    row = ds.isel(z=[2], ry=[1])
    ax = coloured(row, "twist:x", x="rx", y="z")
    assert [text.get_text() for text in ax.get_yticklabels()] == ["0.5"] and ax.get_title() == "ry = −10°"
    ax = ks.plot.line(row, "twist:x")
    assert ax.get_title() == "z = 0.5 m, ry = −10°"
    with pytest.raises(ks.ArgumentError, match="ry has one value; a surface needs several values along both"):
        ks.plot.surface(row, "twist:x", x="rx", y="ry")
    ax = coloured(tilts.isel(tilt=[2]), "twist:x", at={"z": 0.5}, x="azimuth", y="tilt")
    assert [text.get_text() for text in ax.get_yticklabels()] == ["20°"]


def test_slice_of_one_pose_has_one_colour_bar_tick(ds):
    ax = coloured(ds.isel(z=[2], rx=[4], ry=[3]), "twist:x", x="rx", y="z")
    bar = ax.figure.axes[1]
    assert bar.get_yticks() == pytest.approx([500.0]) and bar.get_ylabel() == "displacement along x [nm]"


def test_rounding_noise_is_drawn_as_zero(ds):
    noise = ds.twist.copy(deep=True)
    noise[..., 5] = 1e-22 * np.random.default_rng(2).normal(size=noise.shape[:-1])
    noise[..., 1] *= 1e-9
    noisy = ds.assign(twist=noise.where(ds.twist.notnull()))
    shown = coloured(noisy, "twist:rz", x="rx", y="ry", at={"z": 0.5}).collections[0].get_array()
    assert np.all(shown.compressed() == 0)
    small = coloured(noisy, "twist:y", x="rx", y="ry", at={"z": 0.5}).collections[0].get_array()  # small, but there
    assert np.ptp(small.compressed()) > 0
    assert np.all(
        ks.plot.line(noisy, ["twist:rx", "twist:rz"], x="rx", at={"z": 0.5, "ry": 0.0}).get_lines()[1].get_ydata()[2:-2] == 0
    )


def test_flat_workspace_is_drawn_without_warnings(ds, recwarn):
    flat = ds.assign(platform_pose=ds.platform_pose * (ds.platform_coordinate != "x")).rename(z="p_1", rx="p_2", ry="p_3")
    ax = ks.plot.workspace(flat, "linear_sag", cut=False)
    assert np.ptp(faces(ax)[..., 0]) == 0 and np.ptp(ax.get_xlim()) > 0 and not recwarn.list


# ---- values far beyond all others --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def spike(ds):
    """The map with one pose beside a singularity."""
    twist = ds.twist.copy(deep=True)
    twist[2, 4, 3] = 0.5
    return ds.assign(twist=twist)


def test_near_singular_pose_does_not_stretch_the_colour_range(ds, spike):
    ax = coloured(spike, "twist:x", x="rx", y="ry", at={"z": 0.5})
    others = ks.indices.quantity(ds, "twist:x").sel(z=0.5).values * 1e6
    low, high = ax.collections[0].get_clim()
    assert low == pytest.approx(np.nanmin(others)) and np.nanquantile(others, 0.9) < high < 1.2 * np.nanmax(others)
    assert ax.collections[0].colorbar.extend == "max"
    assert ax.figure.axes[1].get_ylabel().split() == "displacement along x [µm], up to 5e+05".split()  # and it says so
    assert np.nanmax(colours_of(ax)) == pytest.approx(5e5)
    ax = coloured(spike, "twist:x", x="rx", y="ry", at={"z": 0.5}, value_range=(0, 500), unit="mm")
    assert ax.collections[0].get_clim() == (0, 500) and ax.figure.axes[1].get_ylabel() == "displacement along x [mm]"


def test_near_singular_pose_does_not_flatten_surfaces(ds, spike):
    ax = ks.plot.surface(spike, "twist:x", x="rx", y="ry", at={"z": 0.5})
    most = np.nanmax(ks.indices.quantity(ds, "twist:x").sel(z=0.5).values) * 1e6
    assert faces(ax)[..., 2].max() < 1.2 * most
    bar = ax.figure.axes[1]
    assert bar.get_ylabel().split() == "displacement along x [µm], up to 5e+05".split()
    ax = ks.plot.surface(ds, "twist:x", x="rx", y="ry", at={"z": 0.5}, value_range=(0, 1))
    assert faces(ax)[..., 2].min() == 0 and faces(ax)[..., 2].max() == 1
    assert "up to" not in ax.figure.axes[1].get_ylabel()


@pytest.mark.parametrize("kind", ["slice", "surface", "workspace"])
def test_invalid_value_ranges_are_refused(ds, kind):
    for limits in [(2, 1), (1, 1), (0, np.inf), (1,), "ab"]:
        with pytest.raises(ks.ArgumentError, match="must be two numbers, the smaller one first"):
            getattr(ks.plot, kind)(ds, "twist:x", value_range=limits)


def test_main_range_leaves_out_only_rare_extremes():
    rng = np.random.default_rng(1)
    smooth = rng.normal(size=1000)
    assert main_range(smooth) == (smooth.min(), smooth.max())
    low, high = main_range(np.append(smooth, [1e3, -1e4]))
    assert -3 < low < -1 and 1 < high < 3
    few = np.array([0.0, 1.0, 1e6])
    assert main_range(few) == (0, 1e6)
    assert main_range(np.append(np.zeros(999), 1.0)) == (0, 1)


def test_grids_in_any_order_are_drawn_sorted(ds):
    mixed = ds.isel(rx=[3, 0, 8, 1, 2, 7, 6, 5, 4], ry=slice(None, None, -1))
    one, two = (coloured(item, "twist:x", x="rx", y="ry", at={"z": 0.5}).collections[0] for item in (ds, mixed))
    np.testing.assert_array_equal(one.get_array().filled(-1), two.get_array().filled(-1))
    np.testing.assert_array_equal(one.get_coordinates(), two.get_coordinates())
    one, two = (ks.plot.line(item, "twist:x", x="rx", at={"z": 0.5, "ry": 0.0}).get_lines()[0] for item in (ds, mixed))
    np.testing.assert_array_equal(one.get_xydata(), two.get_xydata())


@pytest.mark.few(1)
@pytest.mark.parametrize("names", [("azimuth", "tilt"), "xy"])
def test_contour_labels_do_not_overlap(names):
    ends = (-0.5, 0.5) if names == "xy" else (-np.pi, np.pi)
    grid = {names[0]: (np.linspace(*ends, 41)[:40], "m" if names == "xy" else "rad"), names[1]: (np.linspace(0, 1, 31), "rad")}
    twist = np.zeros((40, 31, 6))
    twist[..., 0] = 1e-6 * (np.linspace(0, 1, 31) ** 6 * 300 + 20 * np.cos(grid[names[0]][0])[:, None])  # crowded outside
    ax = ks.plot.slice(map_of(grid, twist=twist, compliance=np.eye(6)), "twist:x", contours=12)
    ax.figure.draw_without_rendering()
    numbers = [text.get_window_extent() for text in ax.texts]
    ticks = [text.get_window_extent() for axis in (ax.xaxis, ax.yaxis) for text in axis.get_ticklabels()]
    (lines,) = (item for item in ax.collections if type(item).__name__ == "QuadContourSet" and len(item.levels) > 1)
    assert len(numbers) >= 4
    assert names == "xy" or lines.get_zorder() < ax.yaxis.get_zorder()  # numbers of tilts lie over the lines
    for k, box in enumerate(numbers):
        assert not any(box.overlaps(other) for other in numbers[:k] + ticks)
        assert all(ax.patch.contains_point(corner) for corner in box.corners())


@pytest.mark.few(1)
@pytest.mark.parametrize("names, height, same", [("xy", 0.5, True), ("zx", 2.0, True), ("xy", 9.0, False), ("xq", 0.5, False)])
def test_position_axes_have_equal_scales_unless_too_elongated(names, height, same):
    grid = {names[0]: (np.linspace(0, 1, 11), "m"), names[1]: (np.linspace(0, height, 11), "m")}
    twist = 1e-6 * np.arange(121.0).reshape(11, 11, 1)
    ax = coloured(map_of(grid, twist=twist, compliance=np.eye(6)), "twist:x")
    ax.figure.draw_without_rendering()
    (x0, y0), (x1, y1) = ax.transData.transform([(0, 0), (1, height)])
    assert ((y1 - y0) / (x1 - x0) == pytest.approx(height, rel=1e-6)) == same
    assert x1 - x0 > 0.35 * ax.figure.bbox.width  # and fill the page
    assert not overlaps(ax.figure)


def test_workspace_in_positions_has_equal_axis_scales(ds):
    actuated = ds.rename(z="p_1", rx="p_2", ry="p_3")
    ax = ks.plot.workspace(actuated, "linear_sag", cut=False)
    size = np.ptp(faces(ax).reshape(-1, 3), axis=0)
    np.testing.assert_allclose(ax._box_aspect / max(ax._box_aspect), size / size.max(), rtol=1e-9)
    body = ks.plot.workspace(ds, "linear_sag")  # z over rx and ry: as the page likes it
    assert not np.allclose(body._box_aspect, ax._box_aspect)


# ---- units and looks ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "units, largest, expected",
    [
        ("m", 2.6e-5, (1e-6, "µm")),
        ("m", 9.99e-7, (1e-9, "nm")),
        ("m", 3.0, (1.0, "m")),
        ("N", 4960.0, (1e3, "kN")),
        ("N m/rad", 3e4, (1e3, "kN·m/rad")),
        ("rad/(N m)", 3e-5, (1e-6, "µrad/(N·m)")),
        ("furlong", 7.0, (1.0, "furlong")),
        ("m", 0.0, (1.0, "m")),
    ],
)
def test_display_unit_suits_the_largest_value(units, largest, expected):
    assert display_unit(units, [-largest, np.nan, largest / 3]) == expected


def test_display_unit_as_requested_and_for_coordinates():
    assert display_unit("rad", [1e-5], "deg") == (pytest.approx(np.pi / 180), "°")
    assert display_unit("N/m", [1e7], "N/um") == (1e6, "N/µm")
    assert [coordinate_unit("m", [most]) for most in (0.6, 0.08)] == [(1.0, "m"), (1e-3, "mm")]


def test_platform_poses_are_drawn_in_degrees_and_metres(ds):
    ax = ks.plot.line(ds, "platform_pose:rx", x="rx", at={"z": 0.5, "ry": 0.0})
    assert ax.get_ylabel() == "platform pose rx [°]"
    np.testing.assert_allclose(ax.get_lines()[0].get_ydata()[1:-1], np.degrees(RX)[1:-1], atol=1e-12)
    assert ks.plot.line(ds, "platform_pose:z", x="z", at={"rx": 0.0, "ry": 0.0}).get_ylabel() == "platform pose z [m]"
    assert (
        ks.plot.line(ds, "platform_pose:rx", x="rx", at={"z": 0.5, "ry": 0.0}, unit="mrad").get_ylabel()
        == "platform pose rx [mrad]"
    )


@pytest.mark.few(1)
@pytest.mark.parametrize("kind", ["slice", "line", "surface", "workspace"])
def test_saved_figures_are_reproducible_vector_graphics(ds, kind, tmp_path):
    options = {"slice": {"x": "rx", "y": "ry", "at": {"z": 0.5}}, "line": {"x": "rx", "at": {"z": 0.5, "ry": 0.1}}}.get(kind, {})
    first, ax = (getattr(ks.plot, kind)(ds, "linear_sag", **options) for _ in range(2))
    for name in ("one.svg", "one.pdf", "one.png") if kind == "slice" else ("one.svg",):
        ks.plot.save(first, tmp_path / name, dpi=80)
    ks.plot.save(figure_of(ax), tmp_path / "two.svg", dpi=80)
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()  # no date, no random names
    assert b"CreationDate" not in b"".join(file.read_bytes() for file in tmp_path.glob("*.pdf"))
    root = ElementTree.parse(tmp_path / "one.svg").getroot()
    assert root.tag.endswith("svg")
    # lines, not pixels, but for the ramp of the colour bar
    assert len(list(root.iter("{http://www.w3.org/2000/svg}image"))) == (kind in ("slice", "workspace"))
    if kind == "slice":
        assert (tmp_path / "one.pdf").read_bytes().startswith(b"%PDF")
        assert plt.imread(tmp_path / "one.png").shape[0] > 100
    with pytest.raises(ks.ArgumentError, match=r"written as \.pdf, \.svg, \.png"):
        ks.plot.save(ax, tmp_path / "one.jpg")


def test_figures_leave_matplotlib_settings_unchanged(ds):
    before = dict(matplotlib.rcParams)
    ks.plot.slice(ds, x="rx", y="ry", at={"z": 0.5})
    assert dict(matplotlib.rcParams) == before


def test_panels_of_one_figure_share_legend_entries(ds):
    figure, panels = plt.subplots(1, 2, layout="constrained", figsize=(7, 3))
    for ax, z in zip(panels, (0.4, 0.5), strict=True):
        assert ks.plot.slice(ds, x="rx", y="ry", at={"z": z}, ax=ax) is ax
    assert len(texts_of(figure)) == len(set(texts_of(figure)))  # nothing is explained twice


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "missing, wanted, message",
    [
        ("matplotlib", "plot", "figures need Matplotlib: pip install 'kinetostatics[plot]'"),
        ("xarray", "plot", "figures need xarray: pip install 'kinetostatics[plot]'"),
        ("xarray", "indices", "workspace maps need xarray: pip install 'kinetostatics[sweep]'"),
    ],
)
def test_missing_packages_are_named_with_their_extra(missing, wanted, message):
    code = f"""
        import sys
        sys.modules[{missing!r}] = None
        import kinetostatics as ks
        try:
            ks.{wanted}
        except ks.KinetostaticsError as error:
            print(error)
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, check=True)
    assert done.stdout == message + "\n"


# ---- the command -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def stored(ds, tmp_path_factory):
    path = tmp_path_factory.mktemp("map") / "map.nc"
    ds.to_netcdf(path, engine="h5netcdf")
    return path


def run(capsys, *arguments):
    code = main(["plot", *map(str, arguments)])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@pytest.mark.few(2)
@pytest.mark.parametrize(
    "options",
    [
        "--what linear_sag --x rx --y ry --at z=500mm",
        "--kind workspace --what stiffness_along:z --unit N/um --whole",
        "--kind line --what actuator_force:p1 --x z --series rx --at ry=0 --beyond-limits",
        "--what linear_sag --x rx --y ry --at z=0.5 --value-range 0 6 --unit µm",
    ],
)
def test_command_writes_figures(capsys, stored, tmp_path, options):
    out = tmp_path / "figure.svg"
    code, said, warned = run(capsys, stored, *options.split(), "--out", out)
    assert (code, said) == (0, f"wrote {out}\n")
    assert warned == ("kinetostatics: warning: the figure shows 5 of the 9 values of rx\n" if "--kind line" in options else "")
    assert ElementTree.parse(out).getroot().tag.endswith("svg")
    assert plt.get_fignums() == []


def test_command_lists_coordinates_and_quantities(capsys, stored):
    code, out, err = run(capsys, stored, "--list")
    assert (code, err) == (0, "")
    assert "  z: 4 values, 0.3 to 0.6 m\n" in out
    for line in ("  linear_sag [m]", "  twist:rz [rad]", "  actuator_force:p1 [N]", "  stiffness_along:rx [N m/rad]"):
        assert line + "\n" in out


@pytest.mark.few(8)
@pytest.mark.parametrize(
    "options, message",
    [
        ("--what linear_sag", "--out FILE is missing"),
        ("--at q=1 --out a.svg", "--at: 'q' is not swept"),
        ("--at z=5deg --out a.svg", "--at: z: '5deg' is an angle, but a length is needed"),
        ("--x rx --y ry --at z=0.5 --out a.doc", "figures are written as .pdf, .svg, .png"),
        ("--kind line --y ry --out a.svg", "--y is not an option of a line"),
        ("--value-range 1 low --out a.svg", "--value-range: 'low' is not a number"),
        ("--dpi 0 --x rx --y ry --at z=0.5 --out a.png", "--dpi: 0 is not between 10 and 2400 dots per inch"),
        ("--what twist:x twist:y --out a.svg", "a slice shows one quantity, not 2"),
    ],
)
def test_command_refuses_invalid_options_in_one_line(capsys, stored, options, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, err = run(capsys, stored, *options.split())
    assert (code, out) == (2, "") and message in err and err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_command_refuses_files_that_are_no_maps(capsys, tmp_path):
    text = tmp_path / "text.nc"
    text.write_text("no map")
    for path, message in ((text, "not a netCDF file or zarr folder"), (tmp_path / "none.nc", "No such file or directory")):
        code, _, err = run(capsys, path, "--out", "a.svg")
        assert code == 2 and message in err and err.count("\n") == 1


@pytest.mark.slow
def test_help_examples_of_sweep_and_plot_run(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    commands = []
    for name in ("sweep", "plot"):
        assert main([name, "--help"]) == 0
        said = capsys.readouterr().out.partition("examples:")[2]
        commands += [shlex.split(line)[1:] for line in said.splitlines() if line.strip()]
    assert [command[0] for command in commands] == ["sweep"] * 8 + ["plot"] * 8
    for command in commands:
        command = [re.sub(":21$", ":5", re.sub(":26$", ":6", word)) for word in command]  # coarser grids
        assert main(command) == 0, capsys.readouterr().err
        assert "--list" in command or (tmp_path / command[command.index("--out") + 1]).exists()
    # nothing goes wrong; a map of many heights has more surfaces than a figure shows
    assert all("the figure shows 5 of the" in line for line in capsys.readouterr().err.splitlines())


@pytest.mark.few(2)
@pytest.mark.parametrize(("kind", "most", "count"), [("surface", 5, 6), ("surface", 5, 5), ("line", 6, 6), ("line", 6, 9)])
def test_series_of_many_values_is_thinned_with_a_warning(ds, kind, most, count):
    values = np.linspace(-0.2, 0.2, count)
    many = (ds.isel(z=0, drop=True) if kind == "surface" else ds.isel(z=0, ry=3, drop=True)).expand_dims(rz=values)
    many.rz.attrs["units"] = "rad"
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        ax = getattr(ks.plot, kind)(many, "linear_sag", x="rx", series="rz")
    left_out = f"5 of the {count} values of rz"
    assert [str(item.message) for item in said] == [f"the figure shows {left_out}"] * (count > most)
    figure = figure_of(ax)
    assert (left_out in f"{ax.get_title()} {figure.get_suptitle()}") == (count > most)
    titles = [panel.get_title() for panel in figure.axes] if len(figure.axes) > 1 else texts_of(figure)
    named = [text for text in titles if "of the" not in text]
    assert len([name for name in named if "rz" in name]) == (count if count <= most else 5)
    assert count % 2 == 0 or any("= 0" in name for name in named)
