"""Every format gives back the numbers that were written, under the names that were written."""

import gzip

import h5py
import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.io import savemat
from spoiled import clean, written

from chebid.errors import InputError
from chebid.formats import base_name, header_unit, read_table

SUFFIXES = (".csv", ".npz", ".mat", ".parquet", ".h5")
FINITE = st.floats(allow_nan=False, allow_infinity=False, width=64)


def test_every_format_gives_back_the_same_log(tmp_path):
    columns = {name: np.array([float(f"{value:.10g}") for value in column]) for name, column in clean().items()}
    for suffix in SUFFIXES:
        table = read_table(written(columns, suffix)(tmp_path))
        assert set(table.names) == set(columns)
        for name, column in columns.items():
            np.testing.assert_array_equal(table.column(name), column, err_msg=suffix)
        assert table.rows(2).tolist() == ([2, 3] if suffix == ".csv" else [1, 2])


@given(values=arrays(np.float64, st.integers(2, 30), elements=FINITE))
def test_text_is_read_to_the_last_bit(values, tmp_path_factory):
    path = tmp_path_factory.mktemp("exact") / "log.csv"
    path.write_text("x,y\n" + "".join(f"{value!r},{-value!r}\n" for value in values.tolist()))
    table = read_table(path)
    np.testing.assert_array_equal(table.column("x"), values)
    np.testing.assert_array_equal(table.column("y"), -values)


WRITTEN = [(separator, ".") for separator in (",", ";", "\t", "|", "  ", ", ")]
WRITTEN += [(separator, ",") for separator in (";", "\t", "|", "  ")]  # a decimal comma between commas means nothing


@pytest.mark.parametrize(("separator", "decimal"), WRITTEN)
@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_every_dialect(tmp_path, separator, decimal, end, encoding):
    values = np.round(np.random.default_rng(0).standard_normal((40, 3)), 6)
    lines = [separator.join(["t", "q1", "tau1"])]
    lines += [separator.join(f"{value:.6f}".replace(".", decimal) for value in row) for row in values]
    path = tmp_path / "log.csv"
    path.write_bytes((end.join(lines) + end).encode(encoding))
    table = read_table(path)
    assert table.names == ("t", "q1", "tau1")
    np.testing.assert_array_equal(np.stack([table.column(name) for name in table.names], 1), values)


def numbers(count=30):
    return [f"{k / 100},{k / 10},{-k / 5}" for k in range(count)]


TEXTS = {
    "preamble": "Measured on the rig\nDate: 2024-01-01\nt,q1,tau1\n",
    "separator line": "sep=,\nt,q1,tau1\n",
    "quoted names": '"t","q1","tau1"\n',
    "blanks around names": " t , q1 , tau1\n",
    "comment as header": "# run 5\n# t,q1,tau1\n",
    "units below": "t,q1,tau1\n[s],[rad],[N.m]\n",
}


@pytest.mark.parametrize("top", TEXTS.values(), ids=TEXTS)
def test_what_stands_above_the_data(tmp_path, top):
    path = tmp_path / "log.csv"
    path.write_text(top + "\n".join(numbers()) + "\n")
    table = read_table(path)
    assert table.names == ("t", "q1", "tau1")
    np.testing.assert_array_equal(table.column("q1"), np.arange(30) / 10)
    assert table.rows(1).tolist() == [top.count("\n") + 1]


def test_numbers_as_names(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t,1,2\n" + "\n".join(numbers()))
    assert read_table(path).names == ("t", "1", "2")


def test_row_numbers_are_those_of_an_editor(tmp_path):
    rows = numbers()
    rows[3:3] = ["", "# a remark", "   "]
    path = tmp_path / "log.csv"
    path.write_text("# made by hand\n\nt,q1,tau1\n" + "\n".join(rows))
    table = read_table(path)
    assert table.rows(30).tolist() == [4, 5, 6, *range(10, 37)]


def test_columns_without_a_name(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(",t,q1\n" + "\n".join(numbers()))
    assert read_table(path).names == ("column 1", "t", "q1")
    path.write_text("\n".join(numbers()))
    table = read_table(path)
    assert table.headless
    np.testing.assert_array_equal(table.column("column 2"), np.arange(30) / 10)
    with pytest.raises(InputError, match="no column 'q1'") as caught:
        table.column("q1")
    assert "no header line" in caught.value.hint


def test_words_in_a_column_that_nobody_needs_are_no_fault(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t,q1,tau1,mode\n" + "\n".join(row + ",auto" for row in numbers()))
    table = read_table(path)
    assert table.lines is None  # read the fast way
    with pytest.raises(InputError, match="not a number") as caught:
        table.column("mode")
    assert (caught.value.place.row, caught.value.place.value) == (2, "auto")


def test_words_for_missing(tmp_path):
    path = tmp_path / "log.csv"
    rows = numbers()
    for place, word in enumerate(["", "NaN", "nan", "NULL", "null", "N/A", "#N/A", "NA", "None", "-"]):
        rows[place] = f"{place / 100},{word},1"
    path.write_text("t,q1,tau1\n" + "\n".join(rows))
    column = read_table(path).column("q1")
    assert np.isnan(column[:10]).all()
    assert np.isfinite(column[10:]).all()


def test_names_with_units(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t [ms],q1 (deg),q1 [rad]\n" + "\n".join(numbers()))
    table = read_table(path)
    assert table.find("t") == "t [ms]"
    assert table.unit("t [ms]") == "ms"
    with pytest.raises(InputError, match="may be any of"):
        table.column("q1")
    assert table.column("q1 (deg)")[1] == 0.1


def test_base_name_and_unit():
    assert (base_name("q1 [rad]"), header_unit("q1 [rad]")) == ("q1", "rad")
    assert (base_name("tau(N·m)"), header_unit("tau(N·m)")) == ("tau", "N·m")
    assert (base_name("q[:,0]"), header_unit("q[:,0]")) == ("q[:,0]", None)
    assert (base_name("rec.q[3,:]"), header_unit("rec.q[3,:]")) == ("rec.q[3,:]", None)


def matrix():
    return np.random.default_rng(1).standard_normal((50, 3))


def test_columns_of_matrices(tmp_path):
    q = matrix()
    np.savez(tmp_path / "log.npz", t=np.arange(50), q=q, wide=q.T, scalar=5.0, cube=np.ones((2, 2, 2)))
    table = read_table(tmp_path / "log.npz")
    assert table.names == ("t", *(f"q[:,{k}]" for k in range(3)), *(f"wide[{k},:]" for k in range(3)))
    np.testing.assert_array_equal(table.column("q[:,1]"), q[:, 1])
    np.testing.assert_array_equal(table.column("wide[ 2 , : ]"), q[:, 2])
    with pytest.raises(InputError, match="matrix of 50 x 3"):
        table.column("q")
    with pytest.raises(InputError, match="no column"):
        table.column("q[:,3]")


def test_structures_of_matlab(tmp_path):
    content = {"rec": {"t": np.arange(50.0)[:, None], "q": matrix().T, "label": "run"}, "gain": 3.0, "name": "text"}
    savemat(tmp_path / "log.mat", content)
    table = read_table(tmp_path / "log.mat")
    assert set(table.names) == {"rec.t", "rec.q[0,:]", "rec.q[1,:]", "rec.q[2,:]"}
    np.testing.assert_array_equal(table.column("rec.t"), np.arange(50.0))
    np.testing.assert_array_equal(table.column("rec.q[1,:]"), matrix()[:, 1])


@pytest.mark.parametrize("version", ["4", "5"])
def test_integers_and_rows_of_matlab(tmp_path, version):
    savemat(
        tmp_path / "log.mat", {"t": np.arange(50.0)[None], "n": np.arange(50, dtype=np.int32)[:, None]}, format=version
    )
    table = read_table(tmp_path / "log.mat")
    np.testing.assert_array_equal(table.column("t"), table.column("n"))


def write_v73(path):
    """What MATLAB's `save -v7.3` writes: a user block, arrays turned, characters as numbers, references for cells."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in (("t", np.arange(50.0)[None]), ("rec/q", matrix().T)):
            file[name] = values
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
        file["label"] = np.frombuffer(b"forty two characters of text in one row!!!", np.uint8).astype(np.uint16)[
            :, None
        ]
        file["label"].attrs["MATLAB_class"] = np.bytes_("char")
        file["#refs#/a"] = np.arange(50.0)
        file["cells"] = np.array([file["#refs#/a"].ref] * 3, dtype=h5py.ref_dtype)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def test_matlab_7_3(tmp_path):
    write_v73(tmp_path / "log.mat")
    table = read_table(tmp_path / "log.mat")
    assert set(table.names) == {"t", "rec.q[:,0]", "rec.q[:,1]", "rec.q[:,2]"}
    np.testing.assert_array_equal(table.column("t"), np.arange(50.0))
    np.testing.assert_array_equal(table.column("rec.q[:,2]"), matrix()[:, 2])


def test_hdf5_groups_and_loops(tmp_path):
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["arm/q1"] = np.arange(50.0)
        file["arm/again"] = file["/"]  # a hard link back to the top
    assert read_table(tmp_path / "log.h5").names == ("arm.q1",)


def test_parquet_kinds(tmp_path):
    frame = pd.DataFrame(
        {
            "when": pd.date_range("2024-01-01", periods=50, freq="5ms"),
            "count": pd.array([*range(49), None], dtype="Int64"),
            "q1": np.arange(50, dtype=np.float32),
            "mode": ["auto"] * 50,
        }
    )
    frame.to_parquet(tmp_path / "log.parquet")
    table = read_table(tmp_path / "log.parquet")
    np.testing.assert_array_equal(table.column("when"), np.arange(50) * 5 / 1000)
    assert np.isnan(table.column("count")[-1])
    assert table.column("count")[48] == 48
    assert table.column("q1").dtype == np.float64
    with pytest.raises(InputError, match="not a number"):
        table.column("mode")


def test_the_content_counts_more_than_the_suffix(tmp_path):
    path = tmp_path / "log.csv"
    path.write_bytes(written(clean(), ".parquet")(tmp_path).read_bytes())
    assert read_table(path).format == "parquet"
    path.write_bytes(gzip.compress(b"t,q1,tau1\n" + "\n".join(numbers()).encode()))
    assert read_table(path).names == ("t", "q1", "tau1")


def test_a_missing_file_is_told_with_its_likes(tmp_path):
    (tmp_path / "swing_1.csv").write_text("t,q1\n0,1\n")
    with pytest.raises(InputError, match="no such file") as caught:
        read_table(tmp_path / "swing1.csv")
    assert "swing_1.csv" in caught.value.hint
    with pytest.raises(InputError) as caught:
        read_table(tmp_path / "nowhere" / "swing1.csv")
    assert "no folder" in caught.value.hint


def test_a_close_name_is_offered(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t,position_1,tau1\n" + "\n".join(numbers()))
    with pytest.raises(InputError, match="no column 'positon_1'") as caught:
        read_table(path).column("positon_1")
    assert "did you mean position_1?" in caught.value.hint


def test_measured_logs_of_two_formats_agree(shared_data):
    """The MATLAB file and its flat copy of 8 digits."""
    table = read_table(shared_data / "kr300" / "traj_A.csv")
    source = read_table(shared_data / "kr300" / "traj_A.mat")
    for joint in range(6):
        for flat, deep in (
            (f"q{joint + 1}_motor_enc_deg", f"rec.act_pos_mot_deg[{joint},:]"),
            (f"tau{joint + 1}_motor_side_Nm", f"rec.act_torque_abs_nm[{joint},:]"),
        ):
            # half a unit of the eighth digit
            np.testing.assert_allclose(table.column(flat), source.column(deep), rtol=5.1e-8, atol=1e-300)


def test_measured_logs_of_matlab(shared_data):
    table = read_table(shared_data / "emps" / "DATA_EMPS_PULSES.mat")
    assert set(table.names) == {"t", "qm", "qg", "vir", "pulses_N"}
    assert len(table.column("t")) == 24841
    assert table.column("pulses_N").max() == 5
