"""What `dvp map` proposes for a CSV file whose columns have no usual names: each gap is a line to fill in."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from drives import drive

from pytest_dvp.cli.command_line import main
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.read_log import read_log

DEG = 180.0 / np.pi
COLUMNS = {
    "Nr": ("", 1.0), "Zeit": ("t", 1.0), "Lenkrad Soll [°]": ("steer_cmd", 16.0 * DEG),
    "Beschl. Soll [m/s²]": ("accel_cmd", 1.0), "Tempo (km/h)": ("v", 3.6), "Gierrate [°/s]": ("yaw_rate", DEG),
    "quer [g]": ("ay", 1.0 / 9.80665), "Ost [m]": ("x", 1.0), "Nord [m]": ("y", 1.0), "Kurs [°]": ("yaw", DEG),
    "Ladung [%]": ("", 1.0),
}  # fmt: skip


@pytest.fixture
def foreign(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Semicolons, decimal commas, a counter from 1, a time from 1 s, degrees, km/h, holes."""
    columns = drive(20.0)
    table = {}
    for text, (name, scale) in COLUMNS.items():
        table[text] = scale * columns[name] if name else np.arange(1.0, 1.0 + len(columns["t"]))
    table["Zeit"] = 1.0 + table["Zeit"]
    table["Tempo (km/h)"][::50] = np.nan
    rows = [";".join(table)]
    rows += [
        ";".join("NaN" if np.isnan(v) else f"{v:.6f}".replace(".", ",") for v in row)
        for row in zip(*table.values(), strict=True)
    ]
    (tmp_path / "fahrt.csv").write_text("\n".join(rows) + "\n", encoding="latin-1")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def proposed(capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["map", "fahrt.csv", "--names-only"]) == 0
    return capsys.readouterr().out


def test_the_time_is_the_column_that_rises_evenly_and_is_no_counter(
    foreign: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = proposed(capsys)
    assert 'time = "Zeit"' in text
    assert "rises by about 0.02 from row to row" in text
    assert ", 50 Hz" in text


def test_a_column_with_a_unit_of_signals_waits_for_its_name(foreign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = proposed(capsys)
    asked = re.findall(r'may be (.*): put .*\n# \[\[signal\]\]\n# name = "\?"\n# field = "(.*?)"', text)
    assert {field: names for names, field in asked} == {
        "Lenkrad Soll": "yaw or steer or steer_cmd", "Kurs": "yaw or steer or steer_cmd", "Ost": "x or y",
        "Nord": "x or y", "Beschl. Soll": "ax or ay or accel_cmd", "quer": "ax or ay or accel_cmd",
    }  # fmt: skip
    assert [line.partition(":")[0] for line in text.rpartition("# not mapped")[2].splitlines()[1:]] == [
        "#  Nr",
        "#  Ladung",
    ]


def test_with_the_names_filled_in_the_log_is_sound(foreign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = proposed(capsys)
    wanted = {header.partition(" [")[0].partition(" (")[0]: name for header, (name, _) in COLUMNS.items() if name}
    for field, name in wanted.items():
        text = re.sub(rf'name = "[^"]*"\n# field = "{re.escape(field)}"', f'name = "{name}"\n# field = "{field}"', text)
    text = re.sub(r"^# (?=\[\[signal|name = |field = |unit = )", "", text, flags=re.M)
    head, _, rest = text.partition('name = "steer_cmd"')
    (foreign / "map.toml").write_text(head + 'name = "steer_cmd"' + rest.replace("# ratio", "ratio", 1))
    assert main(["doctor", "fahrt.csv", "--map", "map.toml"]) == 0
    assert " error " not in capsys.readouterr().out
    log, true = read_log("fahrt.csv", mapping=Path("map.toml")), drive(20.0)
    assert log.t[0] == pytest.approx(1.0)
    for name in ("v", "yaw_rate", "ay", "steer_cmd", "x"):
        known = np.isfinite(log.columns[name])
        assert log.columns[name][known] == pytest.approx(true[name][known], abs=1e-5)


def test_what_was_filled_in_is_not_overwritten_without_force(foreign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["map", "fahrt.csv", "--names-only", "--out", "car.map.toml"]
    assert main(command) == 0
    assert main(command) == 0  # the same contents again
    file = foreign / "car.map.toml"
    file.write_text(edited := file.read_text("utf-8") + "# mine\n", encoding="utf-8")
    assert main(command) == 2
    assert "car.map.toml: is there, with other contents: name another file, or add --force" in capsys.readouterr().err
    assert file.read_text("utf-8") == edited
    assert main([*command, "--force"]) == 0
    assert not file.read_text("utf-8").endswith("# mine\n")


def test_a_file_without_units_is_told_of_the_mapping(foreign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "fahrt.csv"]) == 1
    told = capsys.readouterr().out
    assert "`dvp map fahrt.csv > map.toml`" in told
    assert told.count("log.unit_missing") == told.count("columns Nr, Zeit:") == 1


@pytest.mark.parametrize(("scale", "unit"), [(1.0, "s"), (1e3, "ms"), (1e6, "us")])
def test_the_unit_of_a_bare_time_is_guessed_by_its_steps_and_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], scale: float, unit: str
) -> None:
    monkeypatch.chdir(tmp_path)
    rows = "".join(f"{0.02 * i * scale:g},{i}\n" for i in range(100))
    Path("fahrt.csv").write_text("time,speed\n" + rows)
    text = proposed(capsys)
    assert 'time = "time"' in text
    assert f'time_unit = "{unit}"' in text
    assert ", 50 Hz" in text
    Path("map.toml").write_text(
        re.sub(r"^# (?=\[\[signal|name|field|unit)", "", text, flags=re.M).replace('"?"', '"m/s"')
    )
    assert np.diff(read_log("fahrt.csv", mapping=Path("map.toml")).t) == pytest.approx(0.02)


def test_a_unit_of_the_time_that_is_none_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time,v [m/s]\n" + "".join(f"{i},1\n" for i in range(9)))
    (tmp_path / "map.toml").write_text('[log]\ntime_unit = "km"\n[[signal]]\nname = "v"\nfield = "v"\n')
    with pytest.raises(LogError, match=r"log\.time_unit: found 'km', allowed: s, ms, us"):
        read_log(tmp_path / "a.csv", mapping=tmp_path / "map.toml")


def test_what_only_a_name_tells_waits_for_its_unit_and_latitude_is_no_acceleration(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    rows = "".join(f"{0.02 * i:.2f},{48 + 1e-6 * i},{9 + 1e-6 * i},{0.1 * i},{0.01 * i},{i}\n" for i in range(100))
    Path("fahrt.csv").write_text("utc,lat,lon,acc_lat,throttle,lamp\n" + rows)
    text = proposed(capsys)
    entries = re.findall(r'# name = "(.*)"\n# field = "(.*?)".*\n# unit = "(.*?)"', text)
    assert set(entries) == {
        ("x", "lon", "longitude"), ("y", "lat", "latitude"), ("ay", "acc_lat", "?"), ("throttle_cmd", "throttle", "?"),
    }  # fmt: skip
    assert text.splitlines()[-1] == "#  lamp: 0 to 99"


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ('field = "Geschw"', 'no field holds the time; say which: [log] time = "Zeit"? (a guess: rises by about 0.02'),
        ('field = "Temp"\ntime = "Zeit"', "v: no field 'Temp' in fahrt.csv; did you mean 'Tempo'?"),
        ('field = "zz"\ntime = "Zeit"', "v: no field 'zz' in fahrt.csv; nearest of its 11: "),
        ('time = "Zeit"', "v: the entry has no field; nearest of its 11: "),
    ],
)
def test_what_is_wrong_in_an_entry_is_told_with_what_is_near(foreign: Path, entry: str, said: str) -> None:
    (foreign / "map.toml").write_text(f'[[signal]]\nname = "v"\nunit = "km/h"\n{entry}\n')
    with pytest.raises(LogError) as error:
        read_log("fahrt.csv", mapping=Path("map.toml"))
    assert said in str(error.value)


def test_a_mode_waits_for_the_values_in_which_the_car_obeys(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    columns = drive(20.0)
    mode = np.where(columns["t"] < 5.0, 4.0, 1.0)
    head = "t [s],x [m],y [m],yaw [rad],v [m/s],yaw_rate [rad/s],steer_cmd [rad],accel_cmd [m/s^2],control_mode"
    names = ("t", "x", "y", "yaw", "v", "yaw_rate", "steer_cmd", "accel_cmd")
    rows = zip(*(columns[name] for name in names), mode, strict=True)
    log = tmp_path / "log.csv"
    log.write_text("\n".join([head, *(",".join(f"{v:.6f}" for v in row) for row in rows)]) + "\n", encoding="utf-8")
    assert main(["map", str(log)]) == 0
    text = capsys.readouterr().out
    assert "# perhaps who drives: it holds 1, 4; write those into `when`" in text
    mapping = tmp_path / "map.toml"
    mapping.write_text(re.sub(r"(?m)^# (?=\[\[signal|name = \"engaged|field = \"control|when)", "", text), "utf-8")
    engaged = read_log(log, mapping=mapping)["engaged"]
    assert np.array_equal(engaged, np.where(columns["t"] < 5.0, 0.0, 1.0))
