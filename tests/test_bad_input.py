"""Every spoiled log has its right outcome, and nothing but a ChebidError ever comes out of any bytes."""

import re

import pytest
from spoiled import JOINTS, Spoiled, spoiled_logs

from chebid.errors import InputError
from chebid.log import read_log

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
