"""`read_log`: records, checks, and what must not be found in clean logs."""

import numpy as np
import pytest

from chebid.errors import InputError
from chebid.log import LogSpec, read_log


def write_csv(path, **columns):
    names = list(columns)
    np.savetxt(path, np.column_stack([columns[name] for name in names]), "%.17g", ",", header=",".join(names), comments="")
    return path


def test_columns_become_one_record(tmp_path):
    t = np.arange(100) * 0.01
    path = write_csv(tmp_path / "log.csv", t=t, q1=np.sin(t), tau1=np.cos(t))
    log = read_log(path, LogSpec(position_gain=2.0, torque_gain=3.0), ["q1"], need_torque=True)
    (record,) = log.records
    np.testing.assert_array_equal(record.t, t)
    np.testing.assert_array_equal(record.q[:, 0], 2 * np.sin(t))
    np.testing.assert_array_equal(record.tau[:, 0], 3 * np.cos(t))
    assert record.uniform
    assert record.rows[0] == 2


def test_a_log_without_torque_is_refused_only_when_it_is_needed(tmp_path):
    t = np.arange(100) * 0.01
    path = write_csv(tmp_path / "log.csv", t=t, q1=np.sin(t))
    assert read_log(path, joints=["q1"]).records[0].tau is None
    with pytest.raises(InputError, match="no column 'tau1'"):
        read_log(path, joints=["q1"], need_torque=True)
