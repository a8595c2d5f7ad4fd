"""Files that cannot be completed, as on a full disk, leave the old file; the error names the file."""

import os
import resource
import shutil

import pytest

import kinetostatics as ks
from kinetostatics.output_files import replacing, write_text


@pytest.fixture
def full_disk():
    """Files cannot become larger than 100 bytes."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)

    def limited(write):
        resource.setrlimit(resource.RLIMIT_FSIZE, (100, hard))
        try:
            write()
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))

    return limited


@pytest.fixture(scope="module")
def result():
    return ks.analyze(ks.load_robot("3rps").assemble(platform={"z": 0.5, "rx": 0.0, "ry": 0.0}))


def figure(path):
    from matplotlib.figure import Figure

    drawing = Figure()
    drawing.add_subplot().plot([1, 2], [3, 4])
    ks.plot.save(drawing, path)


WRITERS = {
    "text.csv": lambda result, path: write_text(path, "new\n" * 100),
    "robot.urdf": lambda result, path: ks.save_robot(result.robot, path),
    "page.html": lambda result, path: ks.save_html(result, path),
    "report.html": lambda result, path: ks.save_report(result.configuration, path),
    "corrected.csv": lambda result, path: ks.compensate(result.configuration).save(path),
    "corrected.nc": lambda result, path: ks.compensate(result.configuration).save(path),
    "figure.svg": lambda result, path: figure(path),
    "figure.pdf": lambda result, path: figure(path),
    "figure.png": lambda result, path: figure(path),
}


@pytest.mark.parametrize("name", WRITERS)
def test_a_full_disk_leaves_the_old_file(result, full_disk, tmp_path, name):
    path = tmp_path / name
    path.write_text("old")
    with pytest.raises(ks.ArgumentError, match=f"{name} cannot be written: File too large"):
        full_disk(lambda: WRITERS[name](result, path))
    assert path.read_text() == "old" and os.listdir(tmp_path) == [name]
    WRITERS[name](result, path)
    assert path.stat().st_size > 100 and os.listdir(tmp_path) == [name]


def test_a_full_disk_leaves_all_files_of_exported_code(full_disk, tmp_path):
    function = ks.compile(ks.load_robot("3rps"), ["z", "rx", "ry"], outputs="actuator_forces")
    function.export_c(tmp_path, name="old")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(ks.ArgumentError, match=r"cannot be written: File too large"):
        full_disk(lambda: function.export_c(tmp_path, name="old", scalar="float"))
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_full_disk_leaves_an_old_map(full_disk, tmp_path):
    path = tmp_path / "map.zarr"
    poses = {"z": 0.5, "rx": [0.0, 0.1], "ry": 0.0}
    ks.sweep("3rps", platform=poses, out=path).close()
    with pytest.raises(ks.KinetostaticsError, match=r"map\.zarr"):
        full_disk(lambda: ks.sweep("3rps", platform={**poses, "z": 0.6}, out=path, restart=True))
    with ks.sweep("3rps", platform=poses, out=path) as found:
        assert float(found["z"]) == 0.5


def test_a_netcdf_map_is_not_begun_on_a_full_disk(monkeypatch, tmp_path):
    """The HDF5 library crashes on a full disk; the results are kept, and the next call continues."""
    path, poses = tmp_path / "map.nc", {"z": 0.5, "rx": [0.0, 0.1], "ry": 0.0}
    with monkeypatch.context() as patch:
        almost_full = type(shutil.disk_usage("/"))(10**9, 10**9 - 10**5, 10**5)
        patch.setattr("shutil.disk_usage", lambda _: almost_full)
        with pytest.raises(ks.KinetostaticsError, match=r"map\.nc\.part: No space left on device; the results so far"):
            ks.sweep("3rps", platform=poses, out=path)
    with ks.sweep("3rps", platform=poses, out=path) as found:
        assert found.sizes["rx"] == 2


def test_an_interrupted_file_is_removed(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(KeyboardInterrupt), replacing(path) as partial:
        partial.write_text("half")
        raise KeyboardInterrupt
    assert path.read_text() == "old" and os.listdir(tmp_path) == ["a.txt"]


def test_permissions_and_links_of_a_replaced_file_remain(tmp_path):
    path, link = tmp_path / "a.txt", tmp_path / "link.txt"
    path.write_text("old")
    path.chmod(0o640)
    link.symlink_to(path)
    write_text(link, "new")
    assert link.is_symlink() and path.read_text() == "new" and path.stat().st_mode & 0o777 == 0o640


def test_devices_are_written_directly():
    write_text("/dev/null", "gone")
    assert not os.path.isfile("/dev/null")
