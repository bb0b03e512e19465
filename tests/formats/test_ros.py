"""Bags of joint states: written by other libraries, read as columns; and the one measured bag, against its table."""

import sqlite3

import numpy as np
import pytest

from chebid.errors import InputError
from chebid.formats import read_table

pytest.importorskip("rosbags", reason="the readers of bags come with chebid[ros]")
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as BagWriter
from rosbags.typesys import Stores, get_typestore

STATE = "sensor_msgs/msg/JointState"
STORES = {".bag": get_typestore(Stores.ROS1_NOETIC)} | dict.fromkeys(
    (".db3", ".mcap"), get_typestore(Stores.ROS2_HUMBLE)
)
COUNT = 20


def state(suffix, stamp, names=("a", "b"), position=None, velocity=None, effort=None):
    """A serialised message of joint states at `stamp` ns."""
    store = STORES[suffix]
    time = store.types["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
    header = store.types["std_msgs/msg/Header"]
    head = header(0, time, "") if suffix == ".bag" else header(time, "")
    parts = [np.array(part if part is not None else [], dtype=float) for part in (position, velocity, effort)]
    message = store.types[STATE](head, list(names), *parts)
    return bytes(store.serialize_ros1(message, STATE) if suffix == ".bag" else store.serialize_cdr(message, STATE))


def write(path, messages):
    """A bag of (topic, type, received ns, data)."""
    suffix = path.suffix
    if suffix == ".bag":
        with BagWriter(path) as bag:
            known = {}
            for topic, kind, received, data in messages:
                if topic not in known:
                    known[topic] = bag.add_connection(topic, kind, typestore=STORES[suffix])
                bag.write(known[topic], received, data)
    elif suffix == ".db3":
        with sqlite3.connect(path) as bag:
            bag.execute("CREATE TABLE topics(id INTEGER, name TEXT, type TEXT)")
            bag.execute("CREATE TABLE messages(id INTEGER, topic_id INTEGER, timestamp INTEGER, data BLOB)")
            known = {}
            for number, (topic, kind, received, data) in enumerate(messages):
                if topic not in known:
                    known[topic] = len(known) + 1
                    bag.execute("INSERT INTO topics VALUES (?, ?, ?)", (known[topic], topic, kind))
                bag.execute("INSERT INTO messages VALUES (?, ?, ?, ?)", (number, known[topic], received, data))
        bag.close()
    else:
        with path.open("wb") as file:
            bag = McapWriter(file)
            bag.start("ros2")
            known = {}
            for topic, kind, received, data in messages:
                if topic not in known:
                    schema = bag.register_schema(name=kind, encoding="ros2msg", data=b"")
                    known[topic] = bag.register_channel(schema_id=schema, topic=topic, message_encoding="cdr")
                bag.add_message(channel_id=known[topic], log_time=received, publish_time=received, data=data)
            bag.finish()
    return path


def row(k):
    return {"position": [0.1 * k, -k], "velocity": [0.1, -1.0], "effort": [k**2, 2.0]}


def plain(suffix, topic="/joint_states", **changes):
    """Messages at 100 Hz that arrive 3 ms late."""
    return [
        (topic, STATE, 10**18 + 10**7 * k + 3 * 10**6, state(suffix, 10**18 + 10**7 * k, **{**row(k), **changes}))
        for k in range(COUNT)
    ]


@pytest.mark.parametrize("suffix", STORES)
def test_joint_states_become_columns(tmp_path, suffix):
    table = read_table(write(tmp_path / f"log{suffix}", plain(suffix)))
    assert list(table.arrays) == ["t", "a", "b", "velocity_a", "velocity_b", "tau_a", "tau_b"]
    k = np.arange(COUNT)
    np.testing.assert_allclose(table.arrays["t"], 0.01 * k, atol=1e-12)
    np.testing.assert_allclose(table.arrays["a"], 0.1 * k, atol=1e-15)
    np.testing.assert_allclose(table.arrays["tau_a"], k**2)
    assert not table.notices


@pytest.mark.parametrize("suffix", STORES)
def test_other_joints_and_other_topics_are_left_out(tmp_path, suffix):
    """A gripper that speaks on the same topic is told; a second topic gives way to /joint_states."""
    gripper = [("/joint_states", STATE, 10**18 + k, state(suffix, 10**18 + k, ("finger",), [0.5])) for k in range(3)]
    table = read_table(write(tmp_path / f"log{suffix}", plain(suffix) + gripper + plain(suffix, "/other")))
    assert len(table.arrays["t"]) == COUNT
    assert "finger" not in table.arrays
    assert "3 messages of other joints (finger)" in str(table.notices[0])


@pytest.mark.parametrize("suffix", STORES)
def test_a_bag_that_cannot_be_used(tmp_path, suffix):
    two = plain(suffix, "/left") + plain(suffix, "/right")
    with pytest.raises(InputError, match="/left, /right") as caught:
        read_table(write(tmp_path / f"two{suffix}", two))
    assert caught.value.hint
    text = STORES[suffix].types["std_msgs/msg/String"]("hello")
    store = STORES[suffix]
    kind = "std_msgs/msg/String"
    data = store.serialize_ros1(text, kind) if suffix == ".bag" else store.serialize_cdr(text, kind)
    with pytest.raises(InputError, match="no joint states") as caught:
        read_table(write(tmp_path / f"none{suffix}", [("/chatter", kind, 1, bytes(data))]))
    assert "/chatter" in caught.value.hint


def test_without_stamps_the_times_are_those_of_arrival(tmp_path):
    messages = [(t, kind, received, state(".mcap", 0, **row(3))) for t, kind, received, _ in plain(".mcap")]
    table = read_table(write(tmp_path / "log.mcap", messages))
    np.testing.assert_allclose(table.arrays["t"], 0.01 * np.arange(COUNT), atol=1e-12)
    assert [notice.kind for notice in table.notices] == ["arrival"]


def test_what_is_not_in_every_message_is_left_out(tmp_path):
    messages = plain(".db3", velocity=None)
    messages[4] = plain(".db3", effort=None)[4]
    table = read_table(write(tmp_path / "log.db3", messages))
    assert list(table.arrays) == ["t", "a", "b"]
    assert {notice.kind for notice in table.notices} == {"incomplete"}


@pytest.mark.parametrize("suffix", STORES)
@pytest.mark.parametrize("share", [0.1, 0.5, 0.95])
def test_a_bag_that_is_cut_short_is_an_error(tmp_path, suffix, share):
    """Or all that is left of it; never anything else."""
    path = write(tmp_path / f"log{suffix}", plain(suffix))
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    try:
        table = read_table(path)
    except InputError as err:
        assert err.hint
    else:
        assert len(table.arrays["t"]) <= COUNT


def test_the_measured_bag_is_its_table(shared_data):
    """data/ur10: the same log as a bag and as CSV of nine digits."""
    folder = shared_data / "ur10"
    bag, csv = (read_table(folder / f"ur10_exciting_trajectory.{suffix}").arrays for suffix in ("db3", "csv"))
    joints = [name for name in bag if f"tau_{name}" in bag]
    assert len(joints) == 6
    np.testing.assert_allclose(bag["t"], csv["t_s"] - csv["t_s"][0], atol=1e-6)
    for joint in joints:
        np.testing.assert_allclose(bag[joint], csv[f"q_{joint}"], atol=1e-6)
        np.testing.assert_allclose(bag[f"tau_{joint}"], csv[f"effort_{joint}"], atol=1e-6)
