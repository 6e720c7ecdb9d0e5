"""Values to frames and back, against an independent reader of the same DBC (canmatrix)."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

pytest.importorskip("cantools")

from vehicle.wire.can_codec import Codec, Frame
from vehicle.wire.can_map import CanMapError, find_map
from vehicle.wire.checksum import crc8_j1850, sum8, xor8

SEDAN = Path(__file__).parents[2] / "data" / "can" / "sedan.dbc"
VALUES = {"steer": 0.1234, "throttle": 0.5, "brake": 0.25, "accel": -2.5, "heartbeat": 7.0, "mode": 1.0}


def sent(dbc: Path | None = None, **values: float) -> dict[str, Frame]:
    car = find_map(dbc)
    frames = Codec(car, sends="command").frames(VALUES | values, automatic=True)
    return {car.database.get_message_by_frame_id(frame.id).name: frame for frame in frames}


def independent(dbc: Path, frame: Frame) -> dict[str, float]:
    formats = pytest.importorskip("canmatrix.formats")
    matrix = formats.loadp_flat(str(dbc))
    message = next(m for m in matrix.frames if m.arbitration_id.id == frame.id)
    return {name: float(signal.phys_value) for name, signal in message.decode(frame.data).items()}


def test_the_crc_is_that_of_the_standard() -> None:
    """Check values of CRC-8/SAE-J1850 in AUTOSAR's specification, 7.2.1.2."""
    assert crc8_j1850(b"123456789") == 0x4B
    assert crc8_j1850(bytes(4)) == 0x59
    assert crc8_j1850(bytes.fromhex("F20183")) == 0x37
    assert (xor8(b"\x0f\xf0\x01"), sum8(b"\xff\x02")) == (0xFE, 0x01)


def test_another_reader_of_the_dbc_reads_what_was_meant() -> None:
    dbc = find_map().dbc
    frames = sent()
    assert independent(dbc, frames["DBW_STEER_CMD"])["ANGLE"] == pytest.approx(0.1234, abs=0.00005)
    assert independent(dbc, frames["DBW_BRAKE_CMD"])["PEDAL"] == pytest.approx(0.25, abs=0.00005)
    assert independent(dbc, frames["DBW_MODE_CMD"])["MODE"] == 1.0


def test_a_dbc_of_ones_own_gets_its_units_its_ratio_and_its_bits() -> None:
    """Road wheel 0.1234 rad = 7.0703 deg, steering wheel 15 times that; a bit for automatic mode."""
    frames = sent(SEDAN)
    steering = independent(SEDAN, frames["STEERING_LKA"])
    assert steering["STEER_ANGLE_CMD"] == pytest.approx(15.0 * 7.0703, abs=0.025)
    assert steering["STEER_REQUEST"] == 1.0
    assert independent(SEDAN, frames["ACC_CONTROL"])["ACCEL_CMD"] == pytest.approx(-2.5, abs=0.0005)
    data = frames["STEERING_LKA"].data
    assert data[4] == (0xE4 + sum(data[:4])) % 256  # identifier 228 and all other bytes


def test_reports_come_back_in_si() -> None:
    car = find_map(SEDAN)
    (frame,) = Codec(car, sends="report").frames({"steer": 0.1, "speed": 10.0}, automatic=True)
    assert independent(SEDAN, frame)["VEHICLE_SPEED"] == pytest.approx(36.0)
    said = Codec(car, sends="command").read(frame)
    assert said is not None
    assert said.values == pytest.approx({"steer": 0.1, "speed": 10.0}, abs=0.05 / 57.3 / 15.0)


def test_a_value_beyond_the_signal_goes_as_its_end() -> None:
    frames = sent(steer=-3.0, brake=2.0)
    dbc = find_map().dbc
    assert independent(dbc, frames["DBW_STEER_CMD"])["ANGLE"] == pytest.approx(-1.6)
    assert independent(dbc, frames["DBW_BRAKE_CMD"])["PEDAL"] == pytest.approx(1.0)


@pytest.fixture
def floats(tmp_path: Path) -> Path:
    """A car whose commands are IEEE floats: 32 bits, and 16 with a stated range."""
    dbc = tmp_path / "car.dbc"
    dbc.write_text(
        'VERSION ""\nNS_ :\nBS_:\nBU_: A B\n'
        'BO_ 256 CMD: 8 A\n SG_ STEER : 0|32@1- (1,0) [0|0] "rad" B\n SG_ ACC : 32|16@1- (1,0) [-8|4] "m/s^2" B\n'
        'BO_ 257 REP: 8 B\n SG_ STEER : 0|32@1- (1,0) [0|0] "rad" A\n SG_ V : 32|32@1- (1,0) [0|0] "m/s" A\n'
        "SIG_VALTYPE_ 256 STEER : 1;\nSIG_VALTYPE_ 256 ACC : 1;\n"
        "SIG_VALTYPE_ 257 STEER : 1;\nSIG_VALTYPE_ 257 V : 1;\n"
    )
    dbc.with_suffix(".toml").write_text(
        '[command]\nsteer = "CMD.STEER"\naccel = "CMD.ACC"\n[report]\nsteer = "REP.STEER"\nspeed = "REP.V"\n'
    )
    return dbc


@pytest.mark.parametrize(("asked", "sent_as"), [(-1.5, -1.5), (-20.0, -8.0)])
def test_a_signal_that_is_a_float_has_no_grid_but_its_range(floats: Path, asked: float, sent_as: float) -> None:
    frame = sent(floats, steer=0.2, accel=asked)["CMD"]
    assert struct.unpack("<fe", frame.data[:6]) == pytest.approx((0.2, sent_as), abs=1e-7)


def test_what_is_no_number_is_refused() -> None:
    with pytest.raises(ValueError, match=r"DBW_STEER_CMD\.ANGLE: nan is no number"):
        sent(steer=float("nan"))


def test_every_flipped_bit_is_noticed() -> None:
    car = find_map()
    frame = Codec(car, sends="command").frames(VALUES, automatic=True)[0]
    for bit in range(64):
        data = bytearray(frame.data)
        data[bit // 8] ^= 1 << bit % 8
        said = Codec(car, sends="report").read(frame._replace(data=bytes(data)))
        assert said is not None
        assert (said.wrong, said.values) == ("checksum", {})


def test_the_counter_tells_lost_from_repeated() -> None:
    car = find_map()
    sender, receiver = Codec(car, sends="command"), Codec(car, sends="report")
    frames = [sender.frames(VALUES, automatic=True)[0] for _ in range(20)]
    readings = [receiver.read(frames[k]) for k in (0, 1, 1, 2, 6, 7, 19)]
    told = [(said.wrong, said.lost) for said in readings if said is not None]
    assert told == [("", 0), ("", 0), ("repeated", 0), ("", 0), ("", 3), ("", 0), ("", 11)]


@pytest.mark.parametrize(
    ("stated", "told"), [("[0|14]", [*range(15), *range(5)]), ("[1|15]", [*range(1, 16), *range(1, 6)])]
)
def test_a_counter_keeps_to_the_values_that_the_dbc_states(tmp_path: Path, stated: str, told: list[int]) -> None:
    """Profile 1 of AUTOSAR's E2E protocol counts from 0 to 14; 15 is no number there, and none is lost at 14."""
    ours = find_map()
    (tmp_path / "car.dbc").write_text(ours.dbc.read_text().replace("4@1+ (1,0) [0|15]", f"4@1+ (1,0) {stated}"))
    (tmp_path / "car.toml").write_text(ours.file.read_text())
    car = find_map(tmp_path / "car.dbc")
    sender, receiver = Codec(car, sends="command"), Codec(car, sends="report")
    frames = [sender.frames(VALUES, automatic=True)[0] for _ in range(20)]
    assert [frame.data[1] & 15 for frame in frames] == told
    assert {(said.wrong, said.lost) for said in map(receiver.read, frames) if said is not None} == {("", 0)}


def test_a_short_frame_and_one_of_somebody_else_are_not_read() -> None:
    car = find_map()
    receiver = Codec(car, sends="report")
    frame = Codec(car, sends="command").frames(VALUES, automatic=True)[0]
    said = receiver.read(frame._replace(data=frame.data[:3]))
    assert said is not None
    assert said.wrong == "length"
    assert receiver.read(Frame(0x7FF, False, bytes(8))) is None


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ("STEERING_LKA.STEER_ANGLE_CMD", "STEERING_LKS.STEER_ANGLE_CMD", r"no message STEERING_LKS .* STEERING_LKA\?$"),
        ("STEERING_LKA.STEER_ANGLE_CMD", "STEERING_LKA.STEER_ANGL", r"no signal STEER_ANGL in .* STEER_ANGLE_CMD\?$"),
        ('"STEERING_LKA.STEER_ANGLE_CMD"', "7", r"\[command\] steer: found 7, allowed: \"MESSAGE\.SIGNAL\"$"),
        ("accel =", "acel =", r"\[command\] acel is unknown; did you mean accel\?$"),
        ('accel = "ACC_CONTROL.ACCEL_CMD"', "", r"needs throttle and brake, or accel alone; found steer$"),
        ("[ratio]", '[unit]\nspeed = "furlong"\n[ratio]', r"\[report\] speed: unit 'furlong', allowed: m/s, km/h"),
        ("steer = 15.0", "steer = 0", r"\[ratio\] steer is 0$"),
        ('kind = "sum"', 'kind = "crc16"', r"kind: found 'crc16', allowed: crc8_j1850, xor, sum$"),
        ('counter = "COUNTER"', 'counter = "COUNT"', r"counter: no signal 'COUNT'; did you mean COUNTER\?$"),
        ("[report]", "[reports]", r"reports is unknown; did you mean report\?$"),
        ("[ratio]", "[ratio", r"car\.toml:10: no signal map for car\.dbc: not TOML: Expected"),
        ("steer = 15.0", "ster = 15.0", r"\[ratio\] ster is unknown; did you mean steer\?$"),  # not a ratio of 1
        ("[ratio]", '[unit]\nsped = "m/s"\n[ratio]', r"\[unit\] sped is unknown; did you mean speed\?$"),
        (
            '"STEERING_LKA.STEER_REQUEST" = 1',
            '"STEERING_LKA.STEER_REQUEST" = 2',
            r"found 2, allowed: 0 to 1, as its bits",
        ),
        ('counter = "COUNTER"', 'counter = ["COUNTER"]', r"counter: found \['COUNTER'\], allowed: a name in quotes$"),
    ],
)
def test_a_wrong_map_is_one_line(tmp_path: Path, before: str, after: str, says: str) -> None:
    text = SEDAN.with_suffix(".toml").read_text()
    assert before in text
    (tmp_path / "car.toml").write_text(text.replace(before, after))
    (tmp_path / "car.dbc").write_text(SEDAN.read_text())
    with pytest.raises(CanMapError, match=says) as refused:
        find_map(tmp_path / "car.dbc")
    assert "\n" not in str(refused.value)
    assert "car.toml" in str(refused.value)


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ("LKA_STATE : 31|8@0+ (1,0)", "LKA_STATE : 31|8@0+ (0,0)", r"STEERING_LKA\.LKA_STATE has scale 0 in the DBC"),
        (
            "STEER_ANGLE : 7|16@0- (0.05,0)",
            "STEER_ANGLE : 7|16@0- (0,0)",
            r"SENSOR\.STEER_ANGLE has scale 0 in the DBC",
        ),
        ("COUNTER : 6|6@0+", "COUNTER : 6|6@0-", r"STEERING_LKA\.COUNTER is signed, allowed: unsigned, with scale 1"),
        ("COUNTER : 6|6@0+ (1,0)", "COUNTER : 6|6@0+ (2,0)", r"STEERING_LKA\.COUNTER is scaled, allowed: unsigned"),
    ],
)
def test_a_signal_that_cannot_carry_what_it_is_for_is_one_line(
    tmp_path: Path, before: str, after: str, says: str
) -> None:
    """Also one that the map does not name, if it is in a message of the map: who sends a frame fills all of it."""
    text = SEDAN.read_text()
    assert before in text
    (tmp_path / "car.dbc").write_text(text.replace(before, after))
    (tmp_path / "car.toml").write_text(SEDAN.with_suffix(".toml").read_text())
    with pytest.raises(CanMapError, match=rf"car\.toml: .*{says}") as refused:
        find_map(tmp_path / "car.dbc")
    assert "\n" not in str(refused.value)


def test_a_missing_map_and_a_broken_dbc_are_one_line(tmp_path: Path) -> None:
    (tmp_path / "car.dbc").write_text("BO_ what")
    with pytest.raises(CanMapError, match=r"car\.toml: no signal map for car\.dbc: No such file"):
        find_map(tmp_path / "car.dbc")
    (tmp_path / "car.toml").write_text('[command]\nsteer = "A.B"\n')
    with pytest.raises(CanMapError, match=r"car\.dbc: no DBC: ") as refused:
        find_map(tmp_path / "car.dbc")
    assert "\n" not in str(refused.value)
