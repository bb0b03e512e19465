"""ROS 1 bags, the SQLite and MCAP files of ROS 2 bags: the joint states in them, as columns.

Of `sensor_msgs/JointState` messages on one topic: `t` (s, from the stamps of their headers, from the first on), and
per joint NAME its position `NAME`, velocity `velocity_NAME` and effort `tau_NAME`, where they are given. The messages
are decoded by rosbags, the containers read by rosbags, mcap and sqlite3.
"""

import sqlite3
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chebid.errors import InputError, Notice, Place
from chebid.formats.limits import check_size
from chebid.formats.table import Table

_STATE = "sensor_msgs/msg/JointState"
_USUAL = "/joint_states"
_PARTS = (("", "position"), ("velocity_", "velocity"), ("tau_", "effort"))


@dataclass(frozen=True)
class _Message:
    """A message of joint states: its topic, when it was received (ns), and itself."""

    topic: str
    received: int
    state: Any

    @property
    def stamp(self) -> int:
        """ns of the header; 0 where nobody set it."""
        stamp = self.state.header.stamp
        return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def read(path: Path, shown: str) -> Table:
    """The joint states of a bag. Raises InputError for a bag without any, or with several topics of them."""
    try:
        import mcap.reader  # noqa: F401
        import rosbags.typesys  # noqa: F401
    except ImportError as err:
        hint = "install the reader: pip install 'chebid[ros]'; or export the joint states to CSV"
        raise InputError(f"reading a bag needs the package {err.name}", hint=hint, place=Place(file=shown)) from None
    with path.open("rb") as file:
        head = file.read(16)
    reader = _sqlite if head.startswith(b"SQLite format 3") else _mcap if head.startswith(b"\x89MCAP") else _ros1
    found: dict[str, list[_Message]] = {}
    others: Counter[str] = Counter()
    for message in reader(path, others):
        found.setdefault(message.topic, []).append(message)
    return _table(path, shown, _chosen(found, others, shown))


def _is_state(kind: str) -> bool:
    return kind in (_STATE, "sensor_msgs/JointState")


def _sqlite(path: Path, others: Counter[str]) -> Iterator[_Message]:
    """The one file of a ROS 2 bag stored by sqlite3; no metadata.yaml is needed."""
    from rosbags.typesys import Stores, get_typestore

    decode = get_typestore(Stores.ROS2_HUMBLE).deserialize_cdr
    with closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)) as bag:
        topics = {number: (name, kind) for number, name, kind in bag.execute("SELECT id, name, type FROM topics")}
        others.update(f"{name} ({kind})" for name, kind in topics.values() if not _is_state(kind))
        wanted = [number for number, (_, kind) in topics.items() if _is_state(kind)]
        marks = ",".join("?" * len(wanted))
        rows = f"SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN ({marks}) ORDER BY timestamp, id"
        for number, received, data in bag.execute(rows, wanted):
            yield _Message(topics[number][0], received, decode(data, _STATE))


def _mcap(path: Path, others: Counter[str]) -> Iterator[_Message]:
    from mcap.reader import make_reader
    from rosbags.typesys import Stores, get_typestore

    ros1, ros2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            kind = schema.name if schema is not None else "without a schema"
            if not _is_state(kind):
                others[f"{channel.topic} ({kind})"] += 1
                continue
            decode = ros1.deserialize_ros1 if channel.message_encoding == "ros1" else ros2.deserialize_cdr
            yield _Message(channel.topic, message.log_time, decode(message.data, _STATE))


def _ros1(path: Path, others: Counter[str]) -> Iterator[_Message]:
    from rosbags.rosbag1 import Reader
    from rosbags.typesys import Stores, get_typestore

    decode = get_typestore(Stores.ROS1_NOETIC).deserialize_ros1
    with Reader(path) as bag:
        wanted = [connection for connection in bag.connections if _is_state(connection.msgtype)]
        others.update(f"{c.topic} ({c.msgtype})" for c in bag.connections if not _is_state(c.msgtype))
        if not wanted:  # rosbags would take none for all
            return
        for connection, received, data in bag.messages(wanted):
            yield _Message(connection.topic, received, decode(data, _STATE))


def _chosen(found: dict[str, list[_Message]], others: Counter[str], shown: str) -> list[_Message]:
    """The messages of the one topic of joint states, or of the usual one."""
    if not found:
        listed = ", ".join(sorted(others)[:6]) or "none at all"
        raise InputError(
            "holds no joint states (sensor_msgs/JointState)",
            hint=f"its topics are: {listed}; record the topic of the joint states, or export them to CSV",
            place=Place(file=shown),
        )
    if len(found) > 1 and _USUAL not in found:
        hint = "keep one of them (ros2 bag convert, rosbag filter), or rename it to /joint_states"
        raise InputError(f"holds joint states on {', '.join(sorted(found))}", hint=hint, place=Place(file=shown))
    return found[_USUAL if _USUAL in found else next(iter(found))]


def _table(path: Path, shown: str, messages: list[_Message]) -> Table:
    """Columns of the messages that name the same joints; what other messages on the topic name is told."""
    sets = Counter(tuple(message.state.name) for message in messages)
    names = max(sets, key=lambda joints: (len(joints), sets[joints]))
    kept = [message for message in messages if tuple(message.state.name) == names]
    check_size(8 * len(kept) * (3 * len(names) + 1), shown)
    notices = []
    if len(kept) < len(messages):
        listed = "; ".join(", ".join(other) or "no joint" for other in sets if other != names)
        text = f"{len(messages) - len(kept)} messages of other joints ({listed}) are left out"
        notices.append(Notice("other_joints", text, Place(file=shown)))
    arrays = {"t": _clock(kept, shown, notices)}
    for prefix, part in _PARTS:
        columns = [getattr(message.state, part) for message in kept]
        if all(len(column) == len(names) for column in columns):
            values = np.array(columns, dtype=np.float64)
            arrays |= {f"{prefix}{name}": values[:, i].copy() for i, name in enumerate(names)}
        elif any(len(column) for column in columns):
            text = f"{part} is not in every message: left out"
            notices.append(Notice("incomplete", text, Place(file=shown, column=part)))
    return Table(path, shown, "ros", arrays, notices=tuple(notices))


def _clock(messages: list[_Message], shown: str, notices: list[Notice]) -> NDArray[np.float64]:
    """Seconds from the first message on, by the stamps of the headers; by the time of arrival where there are none."""
    stamps = [message.stamp for message in messages]
    if len(set(stamps)) == 1 and len(stamps) > 1:
        text = "the headers have no stamps: times are those of arrival, late by what the network takes"
        notices.append(Notice("arrival", text, Place(file=shown, column="t")))
        stamps = [message.received for message in messages]
    return np.array([stamp - stamps[0] for stamp in stamps], dtype=np.float64) / 1e9
