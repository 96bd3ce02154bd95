"""Sweeps that are stopped: killed at random, a full disk, too little memory, a scheduler that goes; nothing is lost."""

import errno
import json
import os
import random
import resource
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import suppress
from pathlib import Path

import psutil
import pytest
import zarr

from lure.analysis.sweeps import store as stores
from lure.analysis.sweeps import sweep
from lure.analysis.sweeps.reading import read_study, study_of
from lure.analysis.sweeps.run import opened
from lure.analysis.sweeps.store import Store
from lure.errors import InputError

STUDY = 'system = "paper-rod"\nask = "rod"\nchunk = {chunk}\n[over]\n'
DAMPING = '"rod.damping" = {{ from = 1e-4, to = 1e-2, count = {count} }}\n'


@pytest.fixture
def written(tmp_path):
    """A study in a file, and the command that answers it."""

    def write(count, chunk):
        path = tmp_path / "study.toml"
        path.write_text((STUDY + DAMPING).format(chunk=chunk, count=count))
        return path, [sys.executable, "-m", "lure.analysis.cli", "sweep", str(path), "--json", "--quiet"]

    return write


def same(folder, one, other):
    """Whether two stores hold the same answers, apart from time and place."""
    first, second = (opened(folder / f"{name}.zarr").drop_vars("seconds").drop_attrs() for name in (one, other))
    return first.identical(second)


@pytest.mark.slow
def test_killed_whole_it_goes_on_and_repeats_one_chunk(written, tmp_path):
    study, command = written(count=160, chunk=20)
    done = tmp_path / "study.zarr" / ".lure" / "done"
    with subprocess.Popen(command, stdout=subprocess.PIPE, start_new_session=True) as process:
        while len(list(done.glob("[0-9]*"))) < 2:
            assert process.poll() is None
            time.sleep(0.005)
        os.kill(process.pid, signal.SIGKILL)
    left = 8 - len(list(done.glob("[0-9]*")))
    found = sweep(study, tmp_path / "study.zarr")
    assert found.computed_now == 20 * left
    assert found.repeated <= 1
    sweep(study, tmp_path / "plain.zarr")
    assert same(tmp_path, "study", "plain")


@pytest.mark.slow
def test_one_process_that_is_killed_repeats_its_own_chunk_alone(written, tmp_path):
    _, command = written(count=4000, chunk=200)  # a tenth of a second a chunk
    done, kills = tmp_path / "study.zarr" / ".lure" / "done", 3
    with subprocess.Popen([*command, "--workers=2"], stdout=subprocess.PIPE, cwd=tmp_path) as process:
        for kill in range(kills):
            while len(list(done.glob("[0-9]*"))) < 2 + 4 * kill:
                assert process.poll() is None
                time.sleep(0.005)
            near = psutil.Process(process.pid).children()
            workers = [one for child in near for one in child.children()]
            workers[0].kill()
        found = json.loads(process.stdout.read())
    assert (found["done"], found["failed"]) == (4000, 0)
    assert 1 <= found["repeated"] <= kills


@pytest.mark.slow
def test_what_a_killed_run_had_half_made_is_removed_and_said(written, tmp_path, monkeypatch):
    study, _ = written(count=20, chunk=20)
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()

    class Killed(BaseException):
        pass

    def killed(*_given, **_more):
        raise Killed

    for process in (gone.pid, os.getpid()):
        with monkeypatch.context() as patch:
            patch.setattr(stores.os, "getpid", lambda process=process: process)
            patch.setattr(stores.shutil, "rmtree", lambda *_given, **_more: None)
            patch.setattr(zarr, "consolidate_metadata", killed)
            with pytest.raises(Killed):
                Store(tmp_path / "study.zarr", read_study(study)).make()
    (tmp_path / ".study.zarr.mine").mkdir()
    found = sweep(study, tmp_path / "study.zarr")
    assert (found.removed, found.done) == (1, 20)
    assert "What a run that was killed had left half made was removed." in str(found)
    left = {each.name for each in tmp_path.glob(".study.zarr.*")}
    assert ".study.zarr.mine" in left  # no name of ours
    assert [str(os.getpid()) in name for name in left - {".study.zarr.mine"}] == [True]  # of a process that runs


# runs of one study, each in a process of its own that begins in a moment, as all that it imports is there
RUNS = """
import multiprocessing, os, sys
from pathlib import Path
from types import SimpleNamespace
from lure.analysis.sweeps import run
fork = multiprocessing.get_context("fork")
run.multiprocessing = SimpleNamespace(get_context=lambda _: fork, parent_process=multiprocessing.parent_process)
run.forkserver = SimpleNamespace(set_forkserver_preload=lambda _: None, ensure_running=lambda: None)
for _ in sys.stdin:
    one = os.fork()
    if not one:
        found = run.sweep(sys.argv[1], "study.zarr", workers=2)
        Path("result.json").write_text(found.to_json())
        os._exit(0)
    print(one, flush=True)
    os.waitpid(one, 0)
    print("over", flush=True)
"""


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(3))
def test_killed_twenty_times_at_random_nothing_is_lost(written, tmp_path, seed):
    study, _ = written(count=1000, chunk=4)
    result, done = tmp_path / "result.json", tmp_path / "study.zarr" / ".lure" / "done"
    chance, kills, seen, runs = random.Random(seed), 0, 0, 0
    options = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "cwd": tmp_path}
    with subprocess.Popen([sys.executable, "-c", RUNS, str(study)], **options) as driver:
        while not result.exists():
            runs += 1
            assert runs < 30
            print("on", file=driver.stdin, flush=True)
            process = psutil.Process(int(driver.stdout.readline()))
            workers = set()
            while kills < 20 and process.is_running() and process.status() != psutil.STATUS_ZOMBIE:
                time.sleep(chance.uniform(0.005, 0.05))
                if not done.is_dir() or len(list(done.glob("[0-9]*"))) <= seen:
                    continue
                with suppress(psutil.NoSuchProcess):
                    everyone = [process, *process.children(recursive=True)]
                    workers.update(everyone[1:])
                    for one in chance.choice([everyone[:1], everyone[-1:], everyone]):
                        one.kill()
                kills, seen = kills + 1, len(list(done.glob("[0-9]*"))) + 1
            assert driver.stdout.readline() == "over\n"
            psutil.wait_procs(workers, timeout=10)  # those of a client that was killed end in a moment
        driver.stdin.close()
    found = json.loads(result.read_text())
    assert kills == 20
    assert found["done"] == found["proved"] == 1000
    assert found["repeated"] <= 2 * kills  # two workers die with all
    sweep(written(count=1000, chunk=1000)[0], tmp_path / "plain.zarr")
    assert same(tmp_path, "study", "plain")


def test_what_cannot_be_written_is_said_and_nothing_half_written_counts(written, tmp_path, monkeypatch):
    study, _ = written(count=40, chunk=20)

    put = Store._put

    def full(store, target, content):  # when the third chunk file is written
        if target.match("theta/c/1"):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        put(store, target, content)

    monkeypatch.setattr(Store, "_put", full)
    with pytest.raises(InputError, match=r"study.zarr cannot be written \(No space left on device\); what is done is"):
        sweep(study, tmp_path / "study.zarr")
    monkeypatch.undo()
    found = sweep(study, tmp_path / "study.zarr")
    assert (found.done, found.computed_now, found.repeated) == (40, 20, 1)


@pytest.fixture
def readable():
    """A folder whose files may be read and not written by who asks from then on, also where the tests run as root."""
    own, nobody = os.geteuid(), 65534
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)

        def close():
            for each in [path, *path.rglob("*")]:
                each.chmod(0o555 if each.is_dir() else 0o444)
            if own == 0:
                os.seteuid(nobody)
            return path

        path.chmod(0o755)
        try:
            yield path, close
        finally:
            os.seteuid(own)
            for each in [path, *(one for one in path.rglob("*") if one.is_dir())]:
                each.chmod(0o755)


@pytest.mark.slow
def test_a_store_that_may_not_be_written_is_said(readable):
    folder, close = readable
    study = study_of({"system": "paper-rod", "ask": "rod", "chunk": 1, "over": {"rod.damping": [1e-4, 2e-4]}})
    for name in ("done", "open"):
        sweep(study, folder / f"{name}.zarr")
    (folder / "open.zarr" / ".lure" / "done" / "1").unlink()
    close()
    assert sweep(study, folder / "done.zarr").computed_now == 0
    assert Store(folder / "open.zarr", study).there()
    with pytest.raises(InputError, match=r"open.zarr cannot be written \(Permission denied\); .* make it writable and"):
        sweep(study, folder / "open.zarr")
    with pytest.raises(InputError, match=r"new.zarr cannot be written \(Permission denied\); give another -o"):
        sweep(study, folder / "new.zarr")


def test_a_file_where_a_folder_should_be_is_said(tmp_path):
    (tmp_path / "file").write_text("mine")
    study = study_of({"system": "paper-rod", "ask": "rod", "over": {"rod.damping": [1e-4]}})
    with pytest.raises(InputError, match=r"file exists and is no sweep of lure; give another -o"):
        sweep(study, tmp_path / "file")
    with pytest.raises(
        InputError, match=r"study.zarr cannot be written \((File exists|Not a directory)\); give another -o"
    ):
        sweep(study, tmp_path / "file" / "study.zarr")
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.thorough
def test_a_disk_that_is_full_is_said_and_nothing_half_written_counts(written, tmp_path):
    study, command = written(count=60, chunk=20)
    store = Store(tmp_path / "study.zarr", read_study(study))
    store.make()

    def short():
        resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))

    run = subprocess.run(command, preexec_fn=short, capture_output=True, text=True, check=False)
    assert run.returncode == 2
    assert "study.zarr cannot be written (File too large); what is done is kept" in " ".join(run.stderr.split())
    assert "Traceback" not in run.stderr
    assert store.done() == set()
    assert sweep(study, tmp_path / "study.zarr").done == 60


@pytest.mark.thorough
def test_too_little_memory_in_the_processes_is_said(written, tmp_path, monkeypatch):
    study, command = written(count=40, chunk=20)
    monkeypatch.setenv("PYTHONSTARTUP", "")
    (tmp_path / "sitecustomize.py").write_text(
        "import resource, sys\nif any('forkserver' in each for each in sys.orig_argv):\n"
        "    resource.setrlimit(resource.RLIMIT_AS, (150_000_000, 150_000_000))\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    run = subprocess.run([*command, "--workers", "2"], capture_output=True, text=True, check=False)
    monkeypatch.undo()
    assert run.returncode == 2
    assert "a process died 3 times before anything was done" in " ".join(run.stderr.split())
    assert "give fewer --workers" in " ".join(run.stderr.split())
    assert sweep(study, tmp_path / "study.zarr").done == 40


@pytest.mark.slow
def test_many_files_are_put_together_whatever_moment_it_is_stopped_at(tmp_path, monkeypatch):
    over = {"rod.damping": [-1e-4, 2e-4, "nonsense", 1e-3], "rod.compliance": [1, 10]}
    study = study_of({"system": "paper-rod", "ask": "rod", "chunk": 1, "over": over})
    plain = sweep(study, tmp_path / "plain.zarr")
    sweep(study, tmp_path / "wide.zarr")
    store, moved = Store(tmp_path / "wide.zarr", study), []

    class Killed(BaseException):
        pass

    def stopped(*given, **more):
        moved.append(given)
        if len(moved) == 4:
            raise Killed
        return remove(*given, **more)

    remove = stores.shutil.rmtree
    monkeypatch.setattr(stores.shutil, "rmtree", stopped)
    with pytest.raises(Killed):
        store.widen(most=10)
    monkeypatch.setattr(stores.shutil, "rmtree", remove)
    again = sweep(study, tmp_path / "wide.zarr")
    assert (again.computed_now, again.done, again.proved, again.failed, again.first_error) == (
        0,
        plain.done,
        plain.proved,
        plain.failed,
        plain.first_error,
    )
    assert same(tmp_path, "wide", "plain")
    assert len(list((tmp_path / "wide.zarr" / "verdict").rglob("c/*/*"))) == 1
    assert not store.widen(most=10)


@pytest.fixture
def cluster(tmp_path):
    """The address of a scheduler with two workers, and the scheduler's process."""
    pytest.importorskip("distributed")
    where = tmp_path / "scheduler.json"
    dask = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-show"]
    dask += ["--no-dashboard", "--scheduler-file", str(where)]
    scheduler = subprocess.Popen(dask, stderr=subprocess.DEVNULL)
    while not where.is_file():
        time.sleep(0.1)
    address = json.loads(where.read_text())["address"]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--nworkers", "2"]
    workers = subprocess.Popen([*worker, "--no-dashboard", "--death-timeout", "60"], stderr=subprocess.DEVNULL)
    yield address, scheduler
    for process in (workers, scheduler):
        for child in psutil.Process(process.pid).children(recursive=True) if process.poll() is None else ():
            child.kill()
        process.kill()
        process.wait()


@pytest.mark.thorough
def test_a_cluster_of_processes_gives_the_same_store(written, tmp_path, cluster):
    study, _ = written(count=400, chunk=20)
    found = sweep(study, tmp_path / "cluster.zarr", scheduler=cluster[0])
    assert found.done == found.proved == 400
    sweep(study, tmp_path / "plain.zarr")
    assert same(tmp_path, "cluster", "plain")
    for name in ("verdict", "slowest_decay", "largest_low", "theta"):  # byte for byte
        parts = sorted((tmp_path / "plain.zarr" / name / "c").iterdir())
        assert parts
        for part in parts:
            assert part.read_bytes() == (tmp_path / "cluster.zarr" / name / "c" / part.name).read_bytes()


@pytest.mark.thorough
def test_a_scheduler_that_goes_away_ends_the_run_with_a_sentence(written, tmp_path, cluster):
    study, _ = written(count=1000, chunk=5)
    done = tmp_path / "study.zarr" / ".lure" / "done"

    def kill():
        while len(list(done.glob("[0-9]*"))) < 5:
            time.sleep(0.05)
        cluster[1].kill()

    killer = threading.Thread(target=kill)
    killer.start()
    with pytest.raises(InputError, match=r"the scheduler at tcp.* is gone; what is done is kept"):
        sweep(study, tmp_path / "study.zarr", scheduler=cluster[0])
    killer.join()
    time.sleep(2)
    found = sweep(study, tmp_path / "study.zarr", workers=2)
    assert 5 <= 200 - found.computed_now // 5 < 200
    assert found.done == 1000


def test_a_scheduler_that_never_answers_leaves_nothing_behind(written, tmp_path, monkeypatch):
    cluster = pytest.importorskip("lure.analysis.sweeps.cluster")
    pytest.importorskip("distributed")
    monkeypatch.setattr(cluster, "_PATIENCE", 0.2)
    study, _ = written(count=4, chunk=2)
    with socket.create_server(("127.0.0.1", 0)) as silent:  # takes connections and says nothing
        address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        with pytest.raises(InputError, match=r"no Dask scheduler answers at 'tcp://.*'.*start one: dask scheduler"):
            sweep(study, tmp_path / "folder" / "study.zarr", scheduler=address)
    assert [each.name for each in tmp_path.iterdir()] == ["study.toml"]
