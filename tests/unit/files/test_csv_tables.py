"""CSV tables: units of columns and of cells, and errors with file and line."""

import pytest

import kinetostatics as ks
from kinetostatics.files.csv_tables import read_csv


def read(tmp_path, text, known=None, needed=(), least=1):
    path = tmp_path / "table.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8-sig"))
    return read_csv(path, "a table has a line of names, and rows", known, needed, least)


def test_cells_have_their_own_or_the_column_unit(tmp_path):
    table = read(tmp_path, "\nz [mm], rx ,note,\n500,1deg,cold,\n\n 0.5 m ,,,\n")
    assert table.names == ("z", "rx", "note", "") and table.place == f"{tmp_path / 'table.csv'}:2"
    assert table.rows == ((3, ("500mm", "1deg", "cold", "")), (5, ("0.5 m", "", "", "")))
    assert table.where(5) == f"{tmp_path / 'table.csv'}:5"


@pytest.mark.parametrize(
    ("text", "options", "said"),
    [
        ("z\n", {}, "table.csv: a table has a line of names"),
        ("z\n1\n", {"least": 2}, "table.csv: a table has a line of names"),
        (b"z\n\xff\n", {}, "table.csv cannot be read"),
        ("z;rx\n1;2\n", {}, ":1: separate columns by commas, not by semicolons, and write 0.5, not 0,5$"),
        ("z\trx\n1\t2\n", {}, ":1: separate columns by commas, not by tabs$"),
        ("z [,rx\n1,2\n", {}, r":1: 'z \[' is not a name, or a name with its unit: z \[mm\]$"),
        ("z,rx (deg)\n1,2\n", {"known": ("z", "rx")}, r":1: 'rx \(deg\)': units stand in square brackets, as in rx \[deg\]$"),
        ("z,speed\n1,2\n", {"known": ("z", "rx")}, ":1: there is no column 'speed'; known: rx, z$"),
        ("z,z [mm]\n1,2\n", {}, ":1: the column 'z' is given twice$"),
        ("z\n1\n", {"needed": ("z", "rx")}, ":1: the column 'rx' is missing; needed are z, rx$"),
        ("z,rx\n1,2\n\n1,2,3\n", {}, ":4: 3 cells below 2 titles$"),
    ],
)
def test_wrong_tables_are_errors_with_line(tmp_path, text, options, said):
    with pytest.raises(ks.ArgumentError, match=said):
        read(tmp_path, text, **options)


def test_known_names_may_have_brackets_and_files_must_exist(tmp_path):
    assert read(tmp_path, "a(1)\n1\n", ("a(1)",)).names == ("a(1)",)
    for path in (tmp_path / "none.csv", "nul\0l.csv"):
        with pytest.raises(ks.ArgumentError, match="cannot be read"):
            read_csv(path, "")
