""".mat, MDF and ROS bags: the same drive comes out of each. Formats of extras are skipped where those are absent."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.read_log import read_log

T = np.arange(0.0, 10.0, 0.02)
V = 10.0 + np.sin(T)
R = 0.1 * np.cos(T)


def test_mat_vectors_with_units_in_their_names_are_signals(tmp_path: Path) -> None:
    from scipy.io import savemat

    savemat(tmp_path / "a.mat", {"t_s": T, "speed_kmh": 3.6 * V, "yaw_rate_degps": np.degrees(R), "note": "text"})
    log = read_log(tmp_path / "a.mat")
    assert log["v"] == pytest.approx(V)
    assert log["yaw_rate"] == pytest.approx(R)


def test_a_struct_in_a_mat_file_is_a_topic(tmp_path: Path) -> None:
    from scipy.io import savemat

    savemat(tmp_path / "a.mat", {"ego": {"time": T, "v_mps": V}})
    assert read_log(tmp_path / "a.mat")["v"] == pytest.approx(V)


def test_the_time_of_a_mat_file_may_stand_in_a_struct_around_its_signals(tmp_path: Path) -> None:
    """Five structs deep, and one of another length beside it that has a time of its own."""
    from scipy.io import savemat

    deep = {"car": {"bus": {"chassis": {"esp": {"v_mps": V}, "gyro": {"t_s": T[::2], "yaw_rate_radps": R[::2]}}}}}
    savemat(tmp_path / "a.mat", {"log": {"t_s": T, **deep}})
    log = read_log(tmp_path / "a.mat")
    assert log["v"] == pytest.approx(V)
    assert log["yaw_rate"][np.isfinite(log["yaw_rate"])] == pytest.approx(R[::2])


def test_signals_of_a_structure_with_time_have_the_names_of_their_labels(tmp_path: Path) -> None:
    """As a To Workspace block or a Scope of Simulink saves them."""
    from scipy.io import savemat

    signals = np.empty(2, dtype=[("values", "O"), ("dimensions", "O"), ("label", "O")])
    signals[0], signals[1] = (V.reshape(-1, 1), 1.0, "v_mps"), (R.reshape(-1, 1), 1.0, "yaw_rate_radps")
    savemat(tmp_path / "a.mat", {"ScopeData": {"time": T, "signals": signals, "blockName": "car/Scope"}})
    log = read_log(tmp_path / "a.mat")
    assert log["v"] == pytest.approx(V)
    assert log["yaw_rate"] == pytest.approx(R)


def test_a_struct_of_time_and_data_is_a_signal_with_the_name_of_the_struct(tmp_path: Path) -> None:
    """As a `timeseries` becomes that is made a struct: each signal has a time of its own, and may tell its unit."""
    from scipy.io import savemat

    signals = {
        "v_kmh": {"Time": T.reshape(-1, 1), "Data": 3.6 * V.reshape(-1, 1)},
        "yaw_rate": {"Time": T[::2], "Data": np.degrees(R[::2]), "Units": "deg/s"},
        "ay": {"time": T, "values": V * R, "unit": "m/s^2", "name": "lateral"},
    }
    savemat(tmp_path / "a.mat", {"log": signals})
    log = read_log(tmp_path / "a.mat")
    assert log["v"] == pytest.approx(V)
    assert log["yaw_rate"][np.isfinite(log["yaw_rate"])] == pytest.approx(R[::2])
    assert log["ay"] == pytest.approx(V * R)


def test_a_struct_of_time_and_several_vectors_keeps_their_names(tmp_path: Path) -> None:
    from scipy.io import savemat

    savemat(tmp_path / "a.mat", {"v_mps": {"time": T, "data": V, "values": R}, "ego": {"t_s": T, "v_mps": V}})
    assert read_log(tmp_path / "a.mat")["v"] == pytest.approx(V)


def test_vectors_of_two_rates_have_each_their_time_in_a_mat_file(tmp_path: Path) -> None:
    from scipy.io import savemat

    fast = np.arange(0.0, 4.0, 0.01)
    vectors = {"t_s": T, "v_mps": V, "time_ms": 1e3 * fast, "yaw_rate_radps": 0.1 * fast, "ay_mps2": fast[:77]}
    savemat(tmp_path / "a.mat", vectors)
    log = read_log(tmp_path / "a.mat")
    assert log["v"][np.isfinite(log["v"])] == pytest.approx(V)
    at = np.isfinite(log["yaw_rate"])
    assert log["yaw_rate"][at] == pytest.approx(0.1 * fast)
    assert log.t[at] == pytest.approx(fast)
    (told,) = log.meta["import"]["findings"]
    assert (told["code"], told["severity"]) == ("log.time_missing", "warning")
    assert "ay_mps2 (77 values)" in str(told)


@pytest.mark.parametrize("name", ["a.mat", "a.mf4", "a.bag"])
def test_a_file_that_is_not_what_its_name_says_is_one_line(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(b"no such thing" * 100)
    with pytest.raises(LogError) as error:
        read_log(tmp_path / name)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(("name", "extra", "package"), [("a.mf4", "mdf", "asammdf"), ("a.bag", "bags", "rosbags")])
def test_a_missing_extra_is_one_line_that_names_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, extra: str, package: str
) -> None:
    (tmp_path / name).write_bytes(b"x")
    for module in [m for m in sys.modules if m == package or m.startswith(f"{package}.")]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(LogError, match=rf"-e '\.\[{extra}\]'") as error:
        read_log(tmp_path / name)
    assert error.value.code == "log.extra_missing"


@pytest.mark.filterwarnings("ignore")
def test_mdf_channels_with_their_units_and_rates(tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf")
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(3.6 * V, T, unit="km/h", name="speed")])
        file.append([asammdf.Signal(R[::5], T[::5], unit="rad", name="steer_cmd")])
        file.save(tmp_path / "a.mf4")
    log = read_log(tmp_path / "a.mf4")
    assert log["v"] == pytest.approx(V)
    assert log["steer_cmd"][4] == R[0]  # a command holds
    assert log["steer_cmd"][5] == R[5]


def _odometry(store: object, i: int, **header: int) -> object:
    types = store.types  # type: ignore[attr-defined]
    vector = types["geometry_msgs/msg/Vector3"]
    stamp = types["builtin_interfaces/msg/Time"](sec=1700000000 + int(T[i]), nanosec=round(T[i] % 1 * 1e9))
    pose = types["geometry_msgs/msg/Pose"](
        position=types["geometry_msgs/msg/Point"](x=10 * T[i], y=1.0, z=0.0),
        orientation=types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=np.sin(0.2), w=np.cos(0.2)),
    )
    twist = types["geometry_msgs/msg/Twist"](linear=vector(x=V[i], y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=R[i]))
    return types["nav_msgs/msg/Odometry"](
        header=types["std_msgs/msg/Header"](stamp=stamp, frame_id="map", **header),
        child_frame_id="base_link",
        pose=types["geometry_msgs/msg/PoseWithCovariance"](pose=pose, covariance=np.zeros(36)),
        twist=types["geometry_msgs/msg/TwistWithCovariance"](twist=twist, covariance=np.zeros(36)),
    )


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_a_ros2_bag_of_standard_messages_needs_no_mapping(tmp_path: Path, storage: str) -> None:
    pytest.importorskip("rosbags")
    from rosbags.rosbag2 import Writer
    from rosbags.rosbag2.enums import StoragePlugin
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin[storage]) as writer:
        connection = writer.add_connection("/odom", "nav_msgs/msg/Odometry", typestore=store)
        for i in range(len(T)):
            late = int((1700000000 + T[i] + 0.005) * 1e9)  # the recorder got it 5 ms later
            writer.write(connection, late, store.serialize_cdr(_odometry(store, i), "nav_msgs/msg/Odometry"))
    log = read_log(tmp_path / "bag")
    assert log["v"] == pytest.approx(V)
    assert log["yaw_rate"] == pytest.approx(R)
    assert log["yaw"] == pytest.approx(0.4)
    assert np.diff(log.t) == pytest.approx(0.02, abs=2e-6)
    if storage == "MCAP":
        assert read_log(tmp_path / "bag" / "bag.mcap")["v"] == pytest.approx(V)


def _one_topic(path: Path, kind: str, definition: str, encoding: str, contents: list[bytes]) -> Path:
    """An MCAP file of one topic, as a converter of bags writes it: messages at T with their definition."""
    from mcap.writer import Writer

    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema(kind, "ros1msg" if encoding == "ros1" else "ros2msg", definition.encode())
        channel = writer.register_channel("/odom", encoding, schema)
        for t, content in zip(T, contents, strict=True):
            stamp = round((1700000000 + t) * 1e9)
            writer.add_message(channel, stamp, content, stamp)
        writer.finish()
    return path


@pytest.mark.parametrize("whole", [True, False])
def test_messages_of_ros1_in_an_mcap_have_the_header_of_ros1(tmp_path: Path, whole: bool) -> None:
    """Its `seq` is gone in ROS 2; a file without definitions has the standard ones of ROS 1."""
    pytest.importorskip("rosbags")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    kind = "nav_msgs/msg/Odometry"
    contents = [bytes(store.serialize_ros1(_odometry(store, i, seq=i), kind)) for i in range(len(T))]
    definition = store.generate_msgdef(kind)[0] if whole else ""
    log = read_log(_one_topic(tmp_path / "a.mcap", "nav_msgs/Odometry", definition, "ros1", contents))
    assert log["v"] == pytest.approx(V)
    assert log["yaw"] == pytest.approx(0.4)


def test_a_message_is_read_as_its_file_defines_it(tmp_path: Path) -> None:
    """Not as the standard message of that name."""
    pytest.importorskip("rosbags")
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store, kind, definition = get_typestore(Stores.EMPTY), "geometry_msgs/msg/Point", "float32 x\nfloat32 y\n"
    store.register(get_types_from_msg(definition, kind))
    contents = [bytes(store.serialize_cdr(store.types[kind](x=float(v), y=0.0), kind)) for v in V]
    file = _one_topic(tmp_path / "a.mcap", kind, definition, "cdr", contents)
    mapping = tmp_path / "map.toml"
    mapping.write_text('[[signal]]\nname = "v"\nfield = "x"\nunit = "m/s"\n')
    assert read_log(file, mapping=mapping)["v"] == pytest.approx(V, abs=1e-5)


def test_custom_ros_messages_need_their_definition(tmp_path: Path) -> None:
    pytest.importorskip("rosbags")
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    definition = "float64 speed\nfloat64 angle\n"
    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg(definition, "car_msgs/msg/State"))
    with Writer(tmp_path / "a.bag") as writer:
        connection = writer.add_connection("/state", "car_msgs/msg/State", typestore=store)
        for i in range(len(T)):
            message = store.types["car_msgs/msg/State"](speed=V[i], angle=0.1)
            raw = store.serialize_ros1(message, "car_msgs/msg/State")
            writer.write(connection, int((1700000000 + T[i]) * 1e9), raw)
    (tmp_path / "car_msgs" / "msg").mkdir(parents=True)
    (tmp_path / "car_msgs" / "msg" / "State.msg").write_text(definition)
    mapping = tmp_path / "map.toml"
    mapping.write_text('[[signal]]\nname = "v"\ntopic = "/state"\nfield = "speed"\nunit = "m/s"\n')
    log = read_log(tmp_path / "a.bag", mapping=mapping, msg_dirs=[tmp_path / "car_msgs"])
    assert log["v"] == pytest.approx(V)


def test_the_formats_load_no_large_package_before_a_file_needs_it() -> None:
    code = (
        "import sys; from pytest_dvp.logs.formats.log_format import log_formats\n"
        "print(*[one.kind for one in log_formats()])\n"
        "print(*(set('pandas scipy asammdf rosbags mcap numba'.split()) & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "csv mcap mat mdf bag\n\n"


def test_no_two_formats_claim_one_file() -> None:
    from pytest_dvp.logs.formats.log_format import log_formats

    endings = [ending for one in log_formats() for ending in one.endings]
    begins = [begin for one in log_formats() for begin, _ in one.begins]
    assert len(set(endings)) == len(endings)
    assert not [(a, b) for a in begins for b in begins if a is not b and a.startswith(b)]
