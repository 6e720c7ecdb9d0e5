"""Jobs on several machines: the same bytes as in one process, whoever dies; a machine that is not alike is refused."""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import socket
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

sys.path[:0] = [str(Path(__file__).parent)]
import bowl  # noqa: E402
import farm  # noqa: E402

from pytest_dvp.cli.command_line import main  # noqa: E402
from pytest_dvp.text.errors import SettingError  # noqa: E402
from pytest_dvp.tuning.tune import tune  # noqa: E402
from pytest_dvp.workers import dask_cluster as cluster_module  # noqa: E402
from pytest_dvp.workers import job as job_module  # noqa: E402
from pytest_dvp.workers.cache import Cache  # noqa: E402
from pytest_dvp.workers.dask_cluster import Cluster  # noqa: E402
from pytest_dvp.workers.errors import TuneError  # noqa: E402
from pytest_dvp.workers.installation import installed  # noqa: E402
from pytest_dvp.workers.job import Job  # noqa: E402
from pytest_dvp.workers.pool import Workers  # noqa: E402
from pytest_dvp.workers.run_job import work  # noqa: E402
from scenarios import path as shipped  # noqa: E402

needs_distributed = pytest.mark.skipif(
    importlib.util.find_spec("distributed") is None, reason="needs the extra cluster"
)
needs_ros2 = pytest.mark.skipif(importlib.util.find_spec("cyclonedds") is None, reason="needs the extra ros2")


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[farm.Farm]:
    pytest.importorskip("distributed", reason="needs the extra cluster")
    found = farm.Farm(tmp_path_factory.mktemp("farm"))
    yield found
    found.close()


@pytest.fixture
def address(running: farm.Farm) -> str:
    """A scheduler that has two workers."""
    running.staffed(2)
    return running.address


def kept(folder: Path) -> dict[str, bytes]:
    return {file.relative_to(folder).as_posix(): file.read_bytes() for file in folder.rglob("*.*") if file.is_file()}


def jobs(folder: Path, seeds: tuple[int, ...] = (7, 8)) -> list[Job]:
    scenario = folder / "bowl.xosc"
    scenario.write_text("<OpenSCENARIO/>", encoding="utf-8")
    return [Job(str(scenario), seed=seed, P=(("LQR_q11", 20.0), ("MPC_w", 3.0))) for seed in seeds]


def worked(address: str, folder: Path, what: Any, asked: list[Job]) -> list[dict[str, Any]]:
    with Cluster(address) as cluster, Workers(Cache(folder / "cache"), work=what, cluster=cluster) as workers:
        return workers.run(asked)


def tuned(address: str, folder: Path, what: Any = bowl.work) -> str:
    folder.mkdir(exist_ok=True)
    (folder / "bowl.xosc").write_text("<OpenSCENARIO/>", encoding="utf-8")
    with Cluster(address) as cluster, Workers(Cache(folder / "cache"), work=what, cluster=cluster) as workers:
        return json.dumps(tune(bowl.study(folder / "bowl.xosc"), workers).as_dict())


@pytest.mark.nightly
def test_a_tuning_is_byte_for_byte_that_of_one_process(address: str, tmp_path: Path) -> None:
    alone = json.dumps(bowl.tuned(tmp_path / "alone").as_dict())
    assert tuned(address, tmp_path / "cluster") == alone
    assert kept(tmp_path / "cluster" / "cache") == kept(tmp_path / "alone" / "cache")


def test_a_worker_that_dies_changes_nothing(address: str, tmp_path: Path, running: farm.Farm) -> None:
    assert tuned(address, tmp_path / "cluster", farm.dies_once) == json.dumps(bowl.tuned(tmp_path / "alone").as_dict())
    assert running.mark.exists()


@pytest.mark.nightly
def test_a_job_that_kills_its_workers_is_one_line_and_what_came_before_is_kept(address: str, tmp_path: Path) -> None:
    asked = jobs(tmp_path, (7, 8))
    worked(address, tmp_path, farm.dies_at_seed_8, asked[:1])
    with pytest.raises(TuneError, match=r"2 workers died while they had bowl dt seed 8, the last one tcp://\S+; what"):
        worked(address, tmp_path, farm.dies_at_seed_8, asked)
    with Workers(Cache(tmp_path / "cache"), work=bowl.work) as workers:
        workers.run(asked)
        assert (workers.known, workers.done) == (1, 1)


@pytest.mark.nightly
def test_when_no_worker_is_left_it_ends_with_one_line(tmp_path: Path, running: farm.Farm) -> None:
    running.staffed(1)
    (job,) = jobs(tmp_path, (7,))
    with Cluster(running.address, patience=0.0) as cluster:
        running.dismissed()
        with pytest.raises(TuneError, match="no workers are left, waited 0 s"):
            list(cluster.worked(bowl.work, {job.key: job}))


@pytest.mark.nightly
def test_drives_are_those_of_one_process_and_their_logs_come_home(address: str, tmp_path: Path) -> None:
    found = []
    for name in ("alone", "cluster"):
        drive = Job(
            str(shipped("follow.xosc")), model=str(shipped("models/surrogate.toml")), duration=2.0,
            save=str(tmp_path / name / "logs" / "drive.mcap"),
        )  # fmt: skip
        if name == "alone":
            with Workers(Cache(tmp_path / name / "cache"), work=work) as workers:
                workers.run([drive])
        else:
            worked(address, tmp_path / name, work, [drive])
        found.append(kept(tmp_path / name))
    assert found[0] == found[1]
    assert "logs/drive.mcap" in found[0]


@pytest.mark.nightly
def test_files_are_carried_with_the_paths_between_them(address: str, tmp_path: Path) -> None:
    """On the worker the scenario lies at another place, and `../roads` leads from it to the road all the same."""
    for name, text in (("scenes/catalogs/car.xosc", "<Car/>"), ("roads/town.xodr", "<OpenDRIVE/>")):
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    (job,) = jobs(tmp_path / "scenes", (7,))
    job = dataclasses.replace(job, library=(str(tmp_path / "roads"),))
    (found,) = worked(address, tmp_path, farm.reads, [job])
    assert found["metrics"] == {"elsewhere": 1.0, "catalogue": len("<Car/>"), "road": len("<OpenDRIVE/>")}


def test_a_machine_with_other_sources_refuses(address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    edited = {**installed(), "vehicle/twin.py": "0" * 64}
    monkeypatch.setattr(cluster_module, "installed", lambda: edited)
    with pytest.raises(TuneError, match=r"worker tcp://\S+ on \S+: its vehicle/twin.py differs"):
        worked(address, tmp_path, bowl.work, jobs(tmp_path))
    assert not kept(tmp_path / "cache")


def test_a_machine_with_another_package_refuses(address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster_module, "installed", lambda: {**installed(), "numpy": "1.0"})
    with pytest.raises(TuneError, match=rf"numpy is {installed()['numpy']} there, 1.0 here"):
        worked(address, tmp_path, bowl.work, jobs(tmp_path))


def test_a_stack_that_changed_since_the_worker_began_is_refused(address: str, tmp_path: Path) -> None:
    """It is not carried, and what a worker has loaded of it is what it was."""
    stack = tmp_path / "stack.py"
    stack.write_text("speed = 1", encoding="utf-8")
    asked = [dataclasses.replace(job, ads=f"{stack}:Stack") for job in jobs(tmp_path, (7, 8, 9, 10))]
    worked(address, tmp_path, bowl.work, asked)
    stack.write_text("speed = 2", encoding="utf-8")
    job_module._sources.cache_clear()  # as in a command that begins anew
    with pytest.raises(TuneError, match=f"{tmp_path}: its Python files differ, or changed since the worker began"):
        worked(address, tmp_path, bowl.work, asked)


def test_what_fails_there_and_not_here_ends_it_and_the_result_here_counts(address: str, tmp_path: Path) -> None:
    asked = jobs(tmp_path, (7,))
    file = asked[0].scenario
    with pytest.raises(TuneError, match=f"fails there, not here: RuntimeError: no graphics at {file}; what"):
        worked(address, tmp_path, farm.fails_there, asked)
    with pytest.raises(TuneError, match="fails there, not here: the stack broke"):
        worked(address, tmp_path / "other", farm.breaks_there, asked)
    assert kept(tmp_path / "cache") == kept(tmp_path / "other" / "cache")
    with Workers(Cache(tmp_path / "cache"), work=bowl.work) as workers:
        assert workers.run(asked) == [bowl.work(asked[0])]
        assert workers.known == 1


def test_a_mistake_in_a_users_file_is_the_line_of_one_process(address: str, tmp_path: Path) -> None:
    (job,) = jobs(tmp_path, (7,))
    with pytest.raises(TuneError, match=f"^{job.scenario}:3: unknown element$"):
        worked(address, tmp_path, farm.refuses, [job])


@needs_distributed
def test_an_address_where_nobody_listens_is_one_line() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))  # and does not listen
        nobody = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(SettingError, match=f"--scheduler {nobody}: no scheduler answers within 0.2 s"):
            Cluster(nobody, connect=0.2).__enter__()


def test_a_scheduler_without_workers_is_one_line_with_the_command(running: farm.Farm) -> None:
    running.dismissed()
    with pytest.raises(SettingError, match=f"it has no workers; .* dask worker {running.address} --nworkers N"):
        Cluster(running.address, connect=0.2).__enter__()


STUDY = """[study]
[[scenario]]
file = "follow.xosc"
[parameters]
"P.LQR_q11" = [20, 30]
"""


@pytest.mark.parametrize(
    ("options", "told"),
    [
        pytest.param(["--scheduler", "nowhere"], "missing port number in address 'nowhere'", marks=needs_distributed),
        pytest.param(["--scheduler", "smtp://a:1"], "unknown address scheme 'smtp'", marks=needs_distributed),
        (["--scheduler", "tcp://a:1", "--jobs", "2"], "--jobs 2 and --scheduler tcp://a:1, expected one of them"),
    ],
)
@pytest.mark.parametrize("command", ["tune", pytest.param("iterate", marks=needs_ros2)])
def test_a_slip_is_one_line_of_usage(
    command: str, options: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study = tmp_path / "study.toml"
    study.write_text(STUDY, encoding="utf-8")
    file = str(study if command == "tune" else shipped("mcrpg/paper.toml"))
    assert main([command, file, "--out", str(tmp_path / "out"), "--cache", str(tmp_path / "cache"), *options]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert told in line


def test_without_distributed_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(SettingError, match=r"pip install -e '\.\[cluster\]'"):
        Cluster("tcp://127.0.0.1:1").__enter__()
