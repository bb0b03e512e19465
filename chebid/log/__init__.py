"""Logs: from the columns of a file to records in SI units, checked, and cut where the recording was not continuous.

`read_log` is the door. Its steps, one file each: `choice` (which column is what), `clock` (time stamps), `seams`
(jumps of position), `held` (frozen sensors), `spikes`, `channels` (everything else about one column). What is found
is an InputError when no honest answer is possible, otherwise a Notice that travels with the Log.

Kinds of notices, by what comes of them:

- a new record begins: `gap`, `time_back`, `repeated_time`, `seam`;
- the row or the record is left out: `missing_time`, `time_outlier`, `repeated_row`, `repeated_time`, `truncated`,
  `short_record`;
- the sample becomes NaN: `missing`, `ragged`, `spike`, `frozen`;
- the values are changed: `wrapped` (continuous again), `time_unit` (seconds), `time_rounded` (even at a given rate);
- nothing is changed: `uneven`, `lost_samples`, `held`, `constant`, `saturation`, `degrees`, `swapped`, `duplicate`,
  `left_out` (a column of which nobody asked for), `seams` (more of the first group, after twenty).
"""

from chebid.log.read import file_sha256, read_log, read_logs
from chebid.log.record import Log, LogSpec, Record

__all__ = ["Log", "LogSpec", "Record", "file_sha256", "read_log", "read_logs"]
