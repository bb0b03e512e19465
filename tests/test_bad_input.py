"""Every spoiled log has its right outcome, and nothing but a ChebidError ever comes out of any bytes."""

import gzip
import os
import re
import subprocess
import sys
import textwrap
import warnings

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from spoiled import JOINTS, Spoiled, clean, random_clean, spoiled_logs, written

from chebid.errors import ChebidError, InputError
from chebid.log import LogSpec, read_log
from chebid.log.spikes import distance

SPOILED = spoiled_logs()


def test_there_are_enough_of_them():
    assert len(SPOILED) >= 60
    assert len({case.name for case in SPOILED}) == len(SPOILED)


@pytest.mark.parametrize("case", SPOILED, ids=str)
def test_outcome(case: Spoiled, tmp_path):
    path = case.write(tmp_path)
    if case.error is not None:
        with pytest.raises(InputError) as caught:
            read_log(path, case.spec, JOINTS, need_torque=case.need_torque, name=path.name)
        assert re.search(case.error, caught.value.message), str(caught.value)
        assert caught.value.hint
        assert caught.value.place.file == path.name or caught.value.place.key
        assert case.column in (None, caught.value.place.column)
        assert case.row in (None, caught.value.place.row)
        return
    log = read_log(path, case.spec, JOINTS, need_torque=case.need_torque, name=path.name)
    assert {notice.kind for notice in log.notices} == case.kinds, [str(notice) for notice in log.notices]
    assert len(log.records) == case.records
    places = [notice.place for notice in log.notices]
    if case.column is not None:
        assert case.column in {place.column for place in places}
    if case.row is not None:
        assert case.row in {place.row for place in places}


def test_a_file_that_may_not_be_read(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t,q1\n0,1\n")
    path.chmod(0)
    if os.access(path, os.R_OK):
        pytest.skip("the superuser may read everything")
    with pytest.raises(InputError, match="permission denied"):
        read_log(path)


# --- size -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("head", "tail"),
    [
        (b"", b" "),
        (b"", b"\n"),
        (b"t,q1,q2\n0,1,2\n", b"\n"),
        (b"t,q1,q2\n0,1,2\n", b" "),
        (b"t,q1,q2\n", b"0.000000,0.000000,0.000000\n"),
    ],
    ids=["blanks", "empty lines", "empty lines below a header", "blanks below a header", "a bomb of true rows"],
)
def test_a_file_of_gigabytes_is_refused_in_little_memory(tmp_path, head, tail):
    """2 GiB in 2 MB of gzip, read by a process that may have 4 GiB of address space, libraries and all."""
    block = gzip.compress(tail * (2**25 // len(tail)))
    path = tmp_path / "log.csv.gz"
    path.write_bytes(gzip.compress(head) + block * 64)
    code = f"""
        import resource
        resource.setrlimit(resource.RLIMIT_AS, (2**32, 2**32))
        from chebid.errors import InputError
        from chebid.log import read_log
        try:
            read_log({str(path)!r}, joints=("q1", "q2"))
        except InputError as err:
            print(type(err).__name__, err)
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.stderr == ""
    assert re.search("blank|longer|times its size", done.stdout), done.stdout


def test_a_binary_file_is_refused_from_its_first_bytes(tmp_path):
    path = tmp_path / "log.csv"
    with path.open("wb") as file:
        file.write(np.random.default_rng(0).bytes(10_000))
        file.truncate(2**33)  # sparse: 8 GiB that take no room
    with pytest.raises(InputError, match="not a text file"):
        read_log(path)


# --- any bytes at all -------------------------------------------------------------------------------------------------

SUFFIXES = (".csv", ".tsv", ".csv.gz", ".npz", ".mat", ".parquet", ".h5")


@pytest.fixture(scope="session")
def whole_files(tmp_path_factory):
    """The bytes of a sound small log in every format."""
    folder = tmp_path_factory.mktemp("whole")
    short = {name: column[:120] for name, column in clean().items()}
    files = {
        suffix: written(short, suffix)(folder).read_bytes() for suffix in (".npz", ".mat", ".parquet", ".h5", ".csv")
    }
    return files | {".tsv": files[".csv"].replace(b",", b"\t"), ".csv.gz": gzip.compress(files[".csv"])}


@st.composite
def damages(draw):
    """What is done to a sound file: cut, begun with rubbish, a part doubled, or some bytes changed."""
    kind = draw(st.sampled_from(["cut", "rubbish", "head", "copy", "bytes", "bytes", "bytes"]))
    share = st.floats(0, 1)
    if kind == "cut":
        return kind, draw(share)
    if kind in ("rubbish", "head"):
        return kind, draw(st.binary(max_size=600)), draw(share)
    if kind == "copy":
        return kind, draw(share), draw(share), draw(st.integers(1, 200))
    special = st.sampled_from([0, 255, ord(","), ord("\n"), ord('"'), ord("-"), ord("e"), ord("9")])
    where = st.one_of(share, st.floats(0, 0.05), st.floats(0.97, 1))  # headers and trailers decide most
    return kind, draw(st.lists(st.tuples(where, st.one_of(st.integers(0, 255), special)), min_size=1, max_size=12))


def damaged(content: bytes, damage: tuple) -> bytes:
    kind, *how = damage
    size = len(content)
    if kind == "cut":
        return content[: int(how[0] * size)]
    if kind == "rubbish":
        return how[0]
    if kind == "head":
        return content[: int(how[1] * 300)] + how[0]
    changed = bytearray(content)
    if kind == "copy":
        source, target, length = int(how[0] * size), int(how[1] * size), how[2]
        changed[target : target + length] = changed[source : source + length]
        return bytes(changed)
    for share, byte in how[0]:
        changed[int(share * (size - 1))] = byte
    return bytes(changed)


def survives(whole_files, folder, suffix, damage, with_model, rate):
    """Reading ends in a Log or in a ChebidError, without a warning from any library."""
    path = folder / f"log{suffix}"
    path.write_bytes(damaged(whole_files[suffix], damage))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            log = read_log(path, LogSpec(rate=rate), JOINTS if with_model else None)
        except ChebidError as err:
            assert err.message and err.hint and err.place.file
            return
    for record in log.records:
        assert len(record.t) >= 20
        assert (np.diff(record.t) > 0).all()
        assert record.q.shape == (len(record.t), len(log.names))


ANY = {
    "suffix": st.sampled_from(SUFFIXES),
    "damage": damages(),
    "with_model": st.booleans(),
    "rate": st.sampled_from([None, 500.0]),
}


@settings(max_examples=400, suppress_health_check=list(HealthCheck))
@given(**ANY)
def test_no_bytes_bring_a_traceback(whole_files, tmp_path_factory, suffix, damage, with_model, rate):
    survives(whole_files, tmp_path_factory.getbasetemp(), suffix, damage, with_model, rate)


@pytest.mark.slow
@settings(max_examples=10_000, suppress_health_check=list(HealthCheck))
@given(**ANY)
def test_ten_thousand_bring_no_traceback(whole_files, tmp_path_factory, suffix, damage, with_model, rate):
    survives(whole_files, tmp_path_factory.getbasetemp(), suffix, damage, with_model, rate)


# --- false alarms and misses ------------------------------------------------------------------------------------------

ALARMS = {"spike", "seam", "frozen", "held", "wrapped", "gap", "time_back", "repeated_time", "lost_samples"}


def read_samples(folder, t, x):
    path = folder / "log.npz"
    np.savez(path, t=t, q1=x)
    return read_log(path, joints=["q1"])


def test_clean_logs_raise_no_alarm(tmp_path):
    """200 logs of every rate, encoder, noise and motion; at most 1 % may be suspected of anything."""
    alarms = {}
    for seed in range(200):
        sound = random_clean(seed)
        log = read_samples(tmp_path, sound.t, sound.x)
        alarms[seed] = [str(notice) for notice in log.notices if notice.kind in ALARMS]
    assert sum(map(bool, alarms.values())) <= 2, {seed: found for seed, found in alarms.items() if found}


def test_spikes_of_ten_deviations_are_found(tmp_path):
    """Where the sampling resolves the motion: the cubic through the neighbours misses them by less than two deviations.

    Elsewhere, in the slowest of the logs, a spike of that size cannot be told from the motion itself.
    """
    found = []
    for seed in range(60):
        sound = random_clean(seed)
        if sound.noise == 0:
            continue
        rng = np.random.default_rng(seed)
        places = np.arange(40, len(sound.x) - 40, len(sound.x) // 12)
        places = places[distance(sound.t, sound.x, places, 1)[1] < 2 * sound.noise]
        spoiled = sound.x.copy()
        spoiled[places] += 10 * sound.noise * rng.choice([-1, 1], len(places))
        records = read_samples(tmp_path, sound.t, spoiled).records
        left_out = [record.rows[np.isnan(record.q[:, 0])] - 1 for record in records]
        found += np.isin(places, np.concatenate(left_out)).tolist()
    assert len(found) > 400
    assert np.mean(found) >= 0.95
