"""Spoiled logs: one clean synthetic log, and every way in which a real one has been seen to be broken.

Each `Spoiled` writes one file and says what must come of it: the error or the notices, and the place they name.
"""

import gzip
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
from scipy.io import savemat

from chebid.log import LogSpec

N = 1500
RATE = 500.0
JOINTS = ("q1", "q2")
PLACES = {"start": 41, "middle": 750, "end": 1450}
HEADER_ROW = 2  # the row number of the first sample in a CSV file

Columns = dict[str, np.ndarray]


def clean() -> Columns:
    """Two joints on encoders of 1e-4 rad with a count of noise, torques of 1 % noise, 3 s at 500 Hz."""
    rng = np.random.default_rng(20)
    t = np.arange(N) / RATE
    q1 = 0.8 * np.sin(2 * np.pi * 0.9 * t) + 0.2 * np.sin(2 * np.pi * 2.3 * t + 1)
    q2 = 0.5 * np.cos(2 * np.pi * 0.7 * t + 2.75) + 0.3 * np.sin(2 * np.pi * 1.7 * t)
    q = np.round((np.stack([q1, q2], 1) + 1e-4 * rng.standard_normal((N, 2))) / 1e-4) * 1e-4
    tau = np.stack([40 * np.cos(5 * t) + 9 * np.tanh(30 * np.cos(6 * t)), 8 * np.sin(4 * t + 1)], 1)
    tau += np.array([0.3, 0.05]) * rng.standard_normal((N, 2))
    return {"t": t, "q1": q[:, 0], "q2": q[:, 1], "tau1": tau[:, 0], "tau2": tau[:, 1]}


def cells(columns: Columns) -> list[list[str]]:
    """The log as text, cell by cell, the header first."""
    rows = [[f"{value:.10g}" for value in row] for row in np.column_stack(list(columns.values()))]
    return [list(columns), *rows]


def joined(rows: list[list[str]], separator: str = ",", end: str = "\n") -> str:
    return end.join(separator.join(row) for row in rows) + end


@dataclass(frozen=True)
class Spoiled:
    """A file and its outcome: `error` (a pattern of the message) or the `kinds` of the notices, and where."""

    name: str
    write: Callable[[Path], Path]
    error: str | None = None
    kinds: frozenset[str] = frozenset()
    column: str | None = None
    row: int | None = None
    records: int = 1
    spec: LogSpec = field(default_factory=LogSpec)
    need_torque: bool = True

    def __str__(self) -> str:
        return self.name


def csv(text: str | bytes, name: str = "log.csv") -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        path = folder / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


def numbers(columns: Columns, name: str = "log.csv") -> Callable[[Path], Path]:
    return csv(joined(cells(columns)), name)


# --- faults of the numbers: each at the start, in the middle, at the end ------------------------------------------


def _spike(columns: Columns, place: int) -> None:
    columns["q2"][place] += 0.01


def _burst(columns: Columns, place: int) -> None:
    columns["q1"][place : place + 3] -= 0.2


def _excursion(columns: Columns, place: int) -> None:
    columns["q1"][place : place + 30] = -3.0


def _torque_spike(columns: Columns, place: int) -> None:
    columns["tau1"][place] += 60.0


def _absurd(columns: Columns, place: int) -> None:
    columns["q1"][place] = 1e282


def _huge_torque(columns: Columns, place: int) -> None:
    columns["tau2"][place] = -3e38


def _missing(columns: Columns, place: int) -> None:
    columns["q1"][place] = np.nan


def _infinite(columns: Columns, place: int) -> None:
    columns["tau1"][place] = np.inf


def _seam(columns: Columns, place: int) -> None:
    for name in JOINTS:
        columns[name][place:] += 0.4


def _time_back(columns: Columns, place: int) -> None:
    columns["t"][place:] -= columns["t"][place] - columns["t"][0]


def _gap(columns: Columns, place: int) -> None:
    columns["t"][place:] += 0.75


def _repeated_row(columns: Columns, place: int) -> None:
    for column in columns.values():
        column[place] = column[place - 1]
    columns["t"][place + 1 :] -= 1 / RATE


def _stuck_clock(columns: Columns, place: int) -> None:
    columns["t"][place] = columns["t"][place - 1]


def _repeated_stamp(columns: Columns, place: int) -> None:
    columns["t"][place:] -= 1 / RATE


def _stamp_outlier(columns: Columns, place: int) -> None:
    columns["t"][place] = 99.0


def _stamp_missing(columns: Columns, place: int) -> None:
    columns["t"][place] = np.nan


def _frozen(columns: Columns, place: int) -> None:
    columns["q2"][place : place + 25] = columns["q2"][place - 1]


def _frozen_off(columns: Columns, place: int) -> None:
    _frozen(columns, place)
    for name in JOINTS:
        columns[name][place + 25 :] += 0.6


@dataclass(frozen=True)
class _Fault:
    apply: Callable[[Columns, int], None]
    kind: str
    column: str
    error: str | None = None
    cuts: bool = False


FAULTS: Mapping[str, _Fault] = {
    "spike": _Fault(_spike, "spike", "q2"),
    "burst": _Fault(_burst, "spike", "q1"),
    "excursion": _Fault(_excursion, "spike", "q1"),
    "torque spike": _Fault(_torque_spike, "spike", "tau1"),
    "absurd position": _Fault(_absurd, "", "q1", error="no sensor gives such a value"),
    "absurd torque": _Fault(_huge_torque, "", "tau2", error="no sensor gives such a value"),
    "missing position": _Fault(_missing, "missing", "q1"),
    "infinite torque": _Fault(_infinite, "missing", "tau1"),
    "seam": _Fault(_seam, "seam", "q1", cuts=True),
    "time back": _Fault(_time_back, "time_back", "t", cuts=True),
    "gap": _Fault(_gap, "gap", "t", cuts=True),
    "repeated row": _Fault(_repeated_row, "repeated_row", "t"),
    "stuck clock": _Fault(_stuck_clock, "repeated_time", "t"),
    "repeated stamp": _Fault(_repeated_stamp, "repeated_time", "t", cuts=True),
    "stamp out of line": _Fault(_stamp_outlier, "time_outlier", "t"),
    "stamp missing": _Fault(_stamp_missing, "missing_time", "t"),
    "frozen sensor": _Fault(_frozen, "frozen", "q2"),
    "frozen sensor, then off": _Fault(_frozen_off, "frozen seam", "q2", cuts=True),
}


def _numeric() -> list[Spoiled]:
    found = []
    for name, fault in FAULTS.items():
        for where, place in PLACES.items():
            columns = clean()
            fault.apply(columns, place)
            found.append(
                Spoiled(
                    f"{name} at the {where}",
                    numbers(columns),
                    error=fault.error,
                    kinds=frozenset() if fault.error else frozenset(fault.kind.split()),
                    column=fault.column,
                    row=HEADER_ROW + place,
                    records=2 if fault.cuts else 1,
                )
            )
    return found


# --- faults of the text ------------------------------------------------------------------------------------------


def _with_cell(place: int, column: int, cell: str) -> str:
    rows = cells(clean())
    rows[place + 1][column] = cell
    return joined(rows)


def _with_row(place: int, row: list[str]) -> str:
    rows = cells(clean())
    rows[place + 1] = row
    return joined(rows)


def _textual() -> list[Spoiled]:
    found = []
    for where, place in PLACES.items():
        row = HEADER_ROW + place
        found += [
            Spoiled(
                f"text cell at the {where}", csv(_with_cell(place, 2, "bad")), "not a number", column="q2", row=row
            ),
            Spoiled(
                f"two points at the {where}", csv(_with_cell(place, 1, "0.1.2")), "not a number", column="q1", row=row
            ),
            Spoiled(
                f"empty cell at the {where}",
                csv(_with_cell(place, 1, "")),
                kinds=frozenset({"missing"}),
                column="q1",
                row=row,
            ),
            Spoiled(
                f"#N/A at the {where}",
                csv(_with_cell(place, 4, "#N/A")),
                kinds=frozenset({"missing"}),
                column="tau2",
                row=row,
            ),
            Spoiled(
                f"short row at the {where}",
                csv(_with_row(place, ["0.5", "1"])),
                kinds=frozenset({"ragged", "missing_time"}),
                row=row,
            ),
            Spoiled(
                f"long row at the {where}",
                csv(_with_row(place, ["0.5"] * 9)),
                kinds=frozenset({"ragged", "missing_time"}),
                row=row,
            ),
        ]
    return found


def _encoded() -> list[Spoiled]:
    rows = cells(clean())
    text = joined(rows)
    german = [[cell.replace(".", ",") for cell in row] for row in rows]
    units = [["t [s]", "q1 [rad]", "q2 [rad]", "tau1 [N·m]", "tau2 [N·m]"], *rows[1:]]
    degrees = [["t", "q1 [deg]", "q2", "tau1", "tau2"], *rows[1:]]
    quoted = [[f'"{name}"' for name in rows[0]], *rows[1:]]
    with_blanks = text.replace("\n", "\n\n", 40)
    remarks = "# made by a rig\n# at 500 Hz\n" + text.replace("\n", "\n# a remark\n", 3)
    return [
        Spoiled("byte-order mark", csv(b"\xef\xbb\xbf" + text.encode())),
        Spoiled("UTF-16", csv(text.encode("utf-16"))),
        Spoiled("UTF-16 without mark", csv(text.encode("utf-16-le"))),
        Spoiled("Latin-1", csv(joined(units).encode("latin-1"))),
        Spoiled("UTF-8 units", csv(joined(units))),
        Spoiled("degrees in the header", csv(joined(degrees)), kinds=frozenset({"degrees"}), column="q1 [deg]"),
        Spoiled("CR LF", csv(joined(rows, end="\r\n"))),
        Spoiled("CR alone", csv(joined(rows, end="\r"))),
        Spoiled("semicolons and decimal commas", csv(joined(german, ";"))),
        Spoiled("tabs", csv(joined(rows, "\t"), "log.tsv")),
        Spoiled("tabs and decimal commas", csv(joined(german, "\t"), "log.txt")),
        Spoiled("blanks", csv("\n".join("  " + "   ".join(row) for row in rows), "log.dat")),
        Spoiled("comma and blank", csv(joined(rows, ", "))),
        Spoiled("quoted header", csv(joined(quoted))),
        Spoiled("everything quoted", csv(joined([[f'"{cell}"' for cell in row] for row in rows]))),
        Spoiled("blank lines", csv(with_blanks)),
        Spoiled("comment lines", csv(remarks)),
        Spoiled("header in a comment", csv("# " + joined(rows, " "), "log.txt")),
        Spoiled("unit line", csv(joined([rows[0], ["s", "rad", "rad", "N.m", "N.m"], *rows[1:]]))),
        Spoiled("separator at line ends", csv(text.replace("\n", ",\n"))),
        Spoiled("no line end at the end", csv(text[:-1])),
        Spoiled("spreadsheet tail", csv(text + ",,,,\n" * 30)),
        Spoiled("gzip", csv(gzip.compress(text.encode()), "log.csv.gz")),
        Spoiled("gzip without its suffix", csv(gzip.compress(text.encode()))),
        Spoiled("columns in another order", csv(joined([row[::-1] for row in rows]))),
        Spoiled("cut in the last line", csv(text[:-30]), kinds=frozenset({"truncated"}), row=HEADER_ROW + N - 1),
    ]


def _refused_text() -> list[Spoiled]:
    rows = cells(clean())
    text = joined(rows)
    noise = np.random.default_rng(1).integers(0, 256, 20_000, dtype=np.uint8).tobytes()
    twins = [["t", "q1", "q1", "tau1", "tau2"], *rows[1:]]
    comma = joined([[cell.replace(".", ",") for cell in row] for row in rows])
    stopped = text[: len(text) // 2]
    return [
        Spoiled("empty", csv(b""), "empty"),
        Spoiled("blank", csv(b" \n\t\n" * 5000), "blank"),
        Spoiled("two megabytes of blanks", csv(b" " * 2**21), "blank"),
        Spoiled("zeros", csv(bytes(100_000)), "blank|not a text"),
        Spoiled("header only", csv("t,q1,q2,tau1,tau2\n"), "no data"),
        Spoiled("comments only", csv("# nothing\n" * 50), "no data"),
        Spoiled("binary", csv(noise), "not a text"),
        Spoiled("zeros from the middle on", csv(stopped.encode() + bytes(50_000)), "turns binary|not a text"),
        Spoiled("no header", csv(joined(rows[1:])), "no column 't'"),
        Spoiled("two columns of one name", csv(joined(twins)), "two columns", column="q1"),
        Spoiled("decimal commas between commas", csv(comma), "5 names, the rows have 10 cells"),
        Spoiled("one endless line", csv("t,q1\n" + "1" * 3_000_000), "longer|binary|cells|columns?"),
        Spoiled("nineteen samples", csv(joined(rows[:20])), "fewer than 20"),
        Spoiled("cut gzip", csv(gzip.compress(text.encode())[:-2000], "log.csv.gz"), "damaged|cut short|read as"),
        Spoiled("gzip of rubbish", csv(b"\x1f\x8b" + noise, "log.csv.gz"), "damaged|read as"),
        Spoiled("gigabyte of blanks, zipped", csv(gzip.compress(b" " * 2**24), "log.csv.gz"), "blank"),
        Spoiled("prose", csv("Dear reader,\nthis is a letter, not a log.\nYours\n" * 30), "no|column|number"),
        Spoiled("HTML", csv("<!DOCTYPE html><html><body><p>404</p></body></html>\n"), "no"),
        Spoiled("a half of the rows short", csv("t,q1,q2,tau1,tau2\n" + "0,1,2\n0,1,2,3,4\n" * 50), "cells", row=2),
        Spoiled("spreadsheet", csv(b"PK\x03\x04" + noise, "log.xlsx"), "."),
        Spoiled("unknown suffix", csv(text, "log.xyz"), "unknown kind of file"),
        Spoiled("ROS bag", csv(b"#ROSBAG V2.0\n" + noise, "log.bag"), "ROS"),
        Spoiled("ROS 2 bag", csv(b"SQLite format 3\x00" + noise, "log.db3"), "ROS"),
        Spoiled("MCAP", csv(b"\x89MCAP0\r\n" + noise, "log.mcap"), "ROS"),
    ]


# --- faults of the whole log ---------------------------------------------------------------------------------------


def _changed(**changes: Any) -> Callable[[Path], Path]:
    columns = clean()
    for name, change in changes.items():
        if change is None:
            del columns[name]
        else:
            columns[name] = np.asarray(change(columns[name]), dtype=float)
    return numbers(columns)


def _of_the_whole() -> list[Spoiled]:
    base = clean()
    rng = np.random.default_rng(3)
    shuffled = rng.permutation(N)
    slow = LogSpec(rate=RATE)
    exchanged = {"t": base["t"], "q1": base["tau1"], "q2": base["tau2"], "tau1": base["q1"], "tau2": base["q2"]}
    wrapped = {**base, "q1": (6 * base["t"] + np.pi) % (2 * np.pi) - np.pi}
    return [
        Spoiled("no time, no rate", _changed(t=None), "no time column"),
        Spoiled("no time but a rate", _changed(t=None), spec=slow),
        Spoiled("rate and time agree", numbers(base), spec=slow),
        Spoiled("rate against time", numbers(base), "the stamps come at 500 Hz", column="t", spec=LogSpec(rate=1000.0)),
        Spoiled("milliseconds", _changed(t=lambda t: 1000 * t), "too long for seconds: ms", column="t"),
        Spoiled("nanoseconds", _changed(t=lambda t: 1e9 * t + 1.7e18), "too long for seconds: ns", column="t"),
        Spoiled(
            "milliseconds at a given rate", _changed(t=lambda t: 1000 * t), kinds=frozenset({"time_unit"}), spec=slow
        ),
        Spoiled("days", _changed(t=lambda t: t / 86400 / 100), "usual step is", column="t"),
        Spoiled("constant time", _changed(t=lambda t: 0 * t + 5), "never advances", column="t", row=2),
        Spoiled(
            "time is another column",
            numbers(base),
            "is no clock",
            column="q1",
            spec=LogSpec(time="q1", position=("t", "q2")),
        ),
        Spoiled("shuffled rows", numbers({k: v[shuffled] for k, v in base.items()}), "is no clock", column="t"),
        Spoiled(
            "shuffled rows, far apart",
            numbers({k: 40 * v[shuffled] if k == "t" else v[shuffled] for k, v in base.items()}),
            "is no clock",
            column="t",
        ),
        Spoiled(
            "uneven stamps",
            _changed(t=lambda t: t + 4e-4 * rng.uniform(-1, 1, N)),
            kinds=frozenset({"uneven"}),
            column="t",
        ),
        Spoiled(
            "rounded stamps",
            _changed(t=lambda t: np.round(t * 500 / 300, 3)),
            kinds=frozenset({"time_rounded"}),
            column="t",
        ),
        Spoiled("coarse clock", _changed(t=lambda t: np.floor(t * 100) / 100), "blocks of 5", column="t", row=3),
        Spoiled(
            "coarse clock at a given rate",
            _changed(t=lambda t: np.floor(t * 100 + 1e-9) / 100),
            kinds=frozenset({"time_rounded"}),
            column="t",
            spec=slow,
        ),
        Spoiled("slow sensor", _changed(q1=lambda q: np.repeat(q[::2], 2)), kinds=frozenset({"held"}), column="q1"),
        Spoiled("slower sensor", _changed(q1=lambda q: np.repeat(q[::5], 5)), kinds=frozenset({"held"}), column="q1"),
        Spoiled("one joint at rest", _changed(q2=lambda q: 0 * q + 0.3), kinds=frozenset({"constant"}), column="q2"),
        Spoiled("no joint moves", _changed(q1=lambda q: 0 * q, q2=lambda q: 0 * q + 1), "no joint moves", column="q1"),
        Spoiled("dead torque", _changed(tau2=lambda tau: 0 * tau), kinds=frozenset({"constant"}), column="tau2"),
        Spoiled("no position", _changed(q2=None), "no column 'q2'", column="q2"),
        Spoiled("no torque", _changed(tau1=None), "no column 'tau1'", column="tau1"),
        Spoiled("no torque needed", _changed(tau1=None), need_torque=False),
        Spoiled("columns exchanged", numbers(exchanged), kinds=frozenset({"swapped"}), column="q1"),
        Spoiled("torque is position", numbers({**base, "tau1": base["q1"]}), "same numbers", column="tau1"),
        Spoiled(
            "position twice",
            numbers(base),
            "named both",
            column="q1",
            spec=LogSpec(position=("q1", "q1"), torque=("tau1", "tau2")),
        ),
        Spoiled("equal joints", numbers({**base, "q2": base["q1"]}), kinds=frozenset({"duplicate"}), column="q2"),
        Spoiled(
            "degrees",
            _changed(q1=lambda q: np.rad2deg(q), q2=lambda q: np.rad2deg(q)),
            kinds=frozenset({"degrees"}),
            column="q1",
        ),
        Spoiled("wrapped angle", numbers(wrapped), kinds=frozenset({"wrapped"}), column="q1"),
        Spoiled(
            "saturated torque",
            _changed(tau1=lambda tau: np.clip(tau, -35, 35)),
            kinds=frozenset({"saturation"}),
            column="tau1",
        ),
        Spoiled(
            "mostly missing",
            _changed(q1=lambda q: np.where(np.arange(N) % 3 == 0, q, np.nan)),
            "1000 of 1500 samples are missing",
            column="q1",
            row=3,
        ),
        Spoiled("too few columns", numbers(base), "names 1 columns for 2 joints", spec=LogSpec(position=("q1",))),
        Spoiled("gain of another size", numbers(base), "does not fit", spec=LogSpec(position_gain=(1.0, 2.0, 3.0))),
        Spoiled(
            "offset of another size", numbers(base), "3 numbers for 2", spec=LogSpec(position_offset=(1.0, 2.0, 3.0))
        ),
    ]


# --- binary files --------------------------------------------------------------------------------------------------


def written(columns: Columns, suffix: str) -> Callable[[Path], Path]:
    """The log in the format of `suffix`."""

    def write(folder: Path) -> Path:
        path = folder / f"log{suffix}"
        if suffix == ".npz":
            np.savez(path, **columns)
        elif suffix == ".mat":
            savemat(path, {name: column[:, None] for name, column in columns.items()}, do_compression=True)
        elif suffix == ".parquet":
            pd.DataFrame(columns).to_parquet(path)
        elif suffix == ".h5":
            with h5py.File(path, "w") as file:
                for name, column in columns.items():
                    file[name] = column
        else:
            path.write_text(joined(cells(columns)))
        return path

    return write


def _cut(suffix: str, share: float) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        path = written(clean(), suffix)(folder)
        content = path.read_bytes()
        path.write_bytes(content[: int(len(content) * share)])
        return path

    return write


def _pickled(folder: Path) -> Path:
    path = folder / "log.npz"
    np.savez(path, t=clean()["t"], q1=np.array([{"a": 1}] * 3, dtype=object))
    return path


def _foreign_zip(folder: Path) -> Path:
    path = folder / "log.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("readme.txt", "nothing")
    return path


def _lying_npz(folder: Path) -> Path:
    """An array that claims 8e15 bytes in its header."""
    path = folder / "log.npz"
    head = b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000000,), }"
    head = head.ljust(117) + b"\n"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("t.npy", b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head + bytes(800))
    return path


def _linked(folder: Path) -> Path:
    """External links, soft links out of the file, external storage, a virtual data set: all lead to a secret."""
    secret = folder / "secret.h5"
    with h5py.File(secret, "w") as file:
        file["q1"] = clean()["q1"]
    (folder / "secret.raw").write_bytes(clean()["q1"].tobytes())
    path = folder / "log.h5"
    with h5py.File(path, "w") as file:
        file["t"] = clean()["t"]
        file["door"] = h5py.ExternalLink(str(secret), "/")
        file["q1"] = h5py.SoftLink("/door/q1")
        file["q2"] = h5py.ExternalLink(str(secret), "/q1")
        file.create_dataset("tau1", (N,), "f8", external=[(str(folder / "secret.raw"), 0, 8 * N)])
        layout = h5py.VirtualLayout((N,), "f8")
        layout[:] = h5py.VirtualSource(str(secret), "q1", (N,))
        file.create_virtual_dataset("tau2", layout)
    return path


def _hollow(folder: Path) -> Path:
    """Data sets of 8e12 bytes that take up no room."""
    path = folder / "log.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("t", (10**12,), "f8", chunks=(10**6,))
    return path


def _unequal(folder: Path) -> Path:
    path = folder / "log.npz"
    np.savez(path, **{**clean(), "q2": clean()["q2"][:-7]})
    return path


def _folder(folder: Path) -> Path:
    path = folder / "log.csv"
    path.mkdir()
    return path


def _absent(folder: Path) -> Path:
    (folder / "logs.csv").write_text("t,q1\n")
    return folder / "log.csv"


def _binary() -> list[Spoiled]:
    found = [Spoiled(f"whole {suffix}", written(clean(), suffix)) for suffix in (".npz", ".mat", ".parquet", ".h5")]
    for suffix in (".npz", ".mat", ".parquet", ".h5"):
        for share in (0.05, 0.5, 0.95):
            pattern = "cannot be read|damaged|cut short|empty|no column|no time|samples where|zip|array"
            found.append(Spoiled(f"{suffix} cut at {share:.0%}", _cut(suffix, share), pattern))
    return [
        *found,
        Spoiled("text named .mat", csv(joined(cells(clean())), "log.mat"), "cannot be read as MAT"),
        Spoiled("text named .parquet", csv(joined(cells(clean())), "log.parquet"), "cannot be read as PARQUET"),
        Spoiled("pickled array", _pickled, "Python objects", column="q1"),
        Spoiled("zip without arrays", _foreign_zip, "without numpy arrays"),
        Spoiled("lying array header", _lying_npz, "cut short", column="t"),
        Spoiled("links out of the file", _linked, "no column 'q1'"),
        Spoiled("hollow HDF5", _hollow, "GiB"),
        Spoiled("columns of two lengths", _unequal, "1493 samples where 't' has 1500", column="q2"),
        Spoiled("folder", _folder, "is a folder"),
        Spoiled("no such file", _absent, "no such file"),
    ]


def spoiled_logs() -> list[Spoiled]:
    """All of them."""
    return [*_numeric(), *_textual(), *_encoded(), *_refused_text(), *_of_the_whole(), *_binary()]


# --- clean logs of every kind: in these nothing is to be found -----------------------------------------------------


@dataclass(frozen=True)
class CleanLog:
    """Positions `x` (N,) of one joint at stamps `t` (N,), with `noise` the deviation of all errors of the sensor."""

    t: np.ndarray
    x: np.ndarray
    noise: float


def random_clean(seed: int) -> CleanLog:
    """One joint at 50 Hz to 5 kHz: any motion, white noise, an encoder from 1e-7 to 2e-3 rad, even or uneven stamps."""
    rng = np.random.default_rng(seed)
    rate = 10 ** rng.uniform(np.log10(50), np.log10(5000))
    t = np.arange(int(rng.uniform(2000, 12000))) / rate
    if rng.random() < 0.25:
        t = t + rng.uniform(-0.3, 0.3, len(t)) / rate
    x = 10 ** rng.uniform(-1.3, 0.5) * MOTIONS[rng.integers(len(MOTIONS))](rng, t)
    count = 10 ** rng.uniform(-7, -2.7)
    noise = float(rng.choice([0, 0.3, 1, 3, 10])) * count if rng.random() < 0.8 else 10 ** rng.uniform(-6, -2)
    x = x + noise * rng.standard_normal(len(t))
    if rng.random() < 0.8:
        return CleanLog(t, np.round(x / count) * count, float(np.hypot(noise, count / np.sqrt(12))))
    return CleanLog(t, x, noise)


def _sines(rng: np.random.Generator, t: np.ndarray) -> np.ndarray:
    parts = rng.uniform([0.05, 0], [2.0, 2 * np.pi], (5, 2))
    return np.sum([np.sin(2 * np.pi * f * t + phase) / (1 + f) for f, phase in parts], axis=0)


def _bang_bang(rng: np.random.Generator, t: np.ndarray) -> np.ndarray:
    """Acceleration of one magnitude that changes its sign at random instants."""
    pause = rng.uniform(0.05, 0.5)
    switches = np.cumsum(rng.exponential(pause, int(3 * t[-1] / pause) + 10))
    fine = np.linspace(0, t[-1], 10 * len(t))
    velocity = np.cumsum(np.where(np.searchsorted(switches, fine) % 2 == 0, 1.0, -1.0))
    x = np.cumsum(velocity - velocity.mean())
    return np.interp(t, fine, x / np.ptp(x))


def _moves(rng: np.random.Generator, t: np.ndarray) -> np.ndarray:
    """From place to place with trapezes of velocity, and rests."""
    x, place, now = np.zeros_like(t), 0.0, rng.uniform(0.1, 0.5)
    while now < t[-1]:
        goal, speed, push = rng.uniform(-1, 1), rng.uniform(0.3, 3), rng.uniform(2, 40)
        way = abs(goal - place)
        rise = min(speed / push, np.sqrt(way / push))
        end = 2 * rise + max(way - push * rise**2, 0.0) / (push * rise)
        u = np.clip(t - now, 0, end)
        done = push * (np.minimum(u, rise) ** 2 / 2 + rise * np.clip(u - rise, 0, end - 2 * rise))
        done += push * (rise**2 - np.clip(end - u, 0, rise) ** 2) / 2 * (u > end - rise)
        x = np.where(t >= now, place + np.sign(goal - place) * done, x)
        place, now = goal, now + end + rng.exponential(0.3)
    return x


def _sticking(rng: np.random.Generator, t: np.ndarray) -> np.ndarray:
    """A sine through a dead zone: stands still at every turn."""
    drive, gap = np.sin(2 * np.pi * rng.uniform(0.1, 1) * t), rng.uniform(0.02, 0.3)
    x, here = np.empty_like(t), drive[0]
    for place, value in enumerate(drive):
        here = min(max(here, value - gap), value + gap)
        x[place] = here
    return x


def _chirp(rng: np.random.Generator, t: np.ndarray) -> np.ndarray:
    top = rng.uniform(0.5, 5)
    return np.sin(2 * np.pi * (0.1 * t + (top - 0.1) * t**2 / 2 / t[-1])) / (1 + top)


MOTIONS = (_sines, _bang_bang, _moves, _sticking, _chirp)
