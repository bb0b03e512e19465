"""Logs: from the columns of a file to records in SI units, checked, and cut where the recording was not continuous.

`read_log` is the door. Its steps, one file each: `choice` (which column is what), `clock` (time stamps), `seams`
(jumps of position), `held` (frozen sensors), `spikes`, `channels` (everything else about one column). What is found
is an InputError when no honest answer is possible, otherwise a Notice that travels with the Log.
"""

from chebid.log.read import read_log
from chebid.log.record import Log, LogSpec, Record

__all__ = ["Log", "LogSpec", "Record", "read_log"]
