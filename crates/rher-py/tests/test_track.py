"""Runs in trackers: Trackio, Weights & Biases and MLflow, each with its own package."""

import importlib.util
import json
import os
import subprocess
import sys
import threading

import pytest
import rher
import rher.track

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


@pytest.fixture
def run(tiny, out):
    return rher.train("push", set=tiny, env_steps=1000, out=out)


def steps(run):
    return run.metrics["env_steps"].tolist()


@pytest.fixture
def mlflow(tmp_path, monkeypatch):
    """What MLflow has: the steps and the values of a metric, and the settings."""
    pytest.importorskip("mlflow")
    monkeypatch.setenv("MLFLOW_TRACKING_URI", f"file://{tmp_path}/mlruns")
    monkeypatch.setenv("MLFLOW_ALLOW_FILE_STORE", "true")

    def stored(key):
        from mlflow import MlflowClient

        client = MlflowClient()
        experiment = client.get_experiment_by_name("rher")
        (there,) = client.search_runs([experiment.experiment_id])
        history = client.get_metric_history(there.info.run_id, key)
        return [one.step for one in history], [one.value for one in history], there.data.params

    return stored


def test_mlflow_has_every_row_once(run, mlflow):
    assert rher.track.send(run, "mlflow") == len(steps(run)) > 2
    assert rher.track.send(run.path, "mlflow") == 0
    stored, values, settings = mlflow("success_final")
    assert stored == steps(run)
    assert values == run.metrics["success_final"].tolist()
    assert settings["agent.hidden"] == "[16, 16]" and settings["task.name"] == "push"
    assert mlflow("success.1")[1] == run.metrics["success"][:, 0].tolist()


def test_a_run_that_goes_on_is_continued(run, mlflow):
    before = rher.track.send(run, "mlflow")
    rher.resume(run.path, env_steps=2000)
    assert rher.track.send(run, "mlflow") == len(steps(run)) - before > 0
    assert mlflow("env_steps")[0] == steps(run)


def test_a_run_is_followed_while_it_is_trained(tiny, out, mlflow, monkeypatch):
    monkeypatch.setattr(rher.track, "EVERY", 0.05)
    begun, seen = threading.Event(), []

    def on_event(event):
        begun.set()

    def train():
        rher.train("push", set=tiny, env_steps=2000, out=out, on_event=on_event)

    training = threading.Thread(target=train)
    training.start()
    assert begun.wait(60)
    seen.append(rher.Run(out).state)
    count = rher.track.send(out, "mlflow")
    training.join()
    assert seen == ["running"] and count == len(steps(rher.Run(out)))
    assert mlflow("env_steps")[0] == steps(rher.Run(out))


def test_trackio_has_every_row_once(run, tmp_path):
    pytest.importorskip("trackio")
    # It reads where its data are when it is imported.
    script = """
import json, sys
import rher.track
counts = [rher.track.send(sys.argv[1], "trackio") for _ in range(2)]
import trackio
from trackio.sqlite_storage import SQLiteStorage
(there,) = trackio.Api().runs("rher")
logs = SQLiteStorage.get_logs(there.project, there.name)
rows = [[row["step"], row["success_final"], row["success.1"]] for row in logs]
print(json.dumps([counts, there.config["agent.hidden"], rows]))
"""
    ended = subprocess.run(
        [sys.executable, "-c", script, str(run.path)],
        env=environment(TRACKIO_DIR=tmp_path / "trackio"),
        capture_output=True,
        text=True,
    )
    assert ended.returncode == 0, ended.stderr
    counts, hidden, rows = json.loads(ended.stdout.splitlines()[-1])
    assert counts == [len(steps(run)), 0] and hidden == [16, 16]
    metrics = run.metrics
    expected = zip(steps(run), metrics["success_final"], metrics["success"][:, 0], strict=True)
    assert rows == [list(map(float, row)) for row in expected]


def environment(**more):
    return os.environ | {name: str(value) for name, value in more.items()}


def command(*arguments, **variables):
    """``python -m rher.track``, without an account of Weights & Biases."""
    env = environment(**variables)
    env.pop("WANDB_API_KEY", None)
    python = [sys.executable, "-m", "rher.track"]
    words = [*python, *map(str, arguments)]
    return subprocess.run(words, env=env, capture_output=True, text=True)


def test_wandb_has_every_row_once(run, tmp_path, monkeypatch):
    pytest.importorskip("wandb")
    monkeypatch.setenv("WANDB_MODE", "offline")
    monkeypatch.setenv("WANDB_DIR", str(tmp_path))
    monkeypatch.setenv("WANDB_SILENT", "true")
    assert rher.track.send(run, "wandb") == len(steps(run))
    assert rher.track.send(run, "wandb") == 0
    files = sorted((tmp_path / "wandb").glob("offline-run-*/*.wandb"))
    rows = [row for file in files for row in offline_rows(file)]
    assert [row["_step"] for row in rows] == steps(run)
    assert [row["success_final"] for row in rows] == run.metrics["success_final"].tolist()


def offline_rows(file):
    """The rows in a file of Weights & Biases: a log as LevelDB writes it, of messages."""
    from wandb.proto.wandb_internal_pb2 import Record

    data, place, message = file.read_bytes(), 7, b""
    while place + 7 <= len(data):
        left = -place % 32768 or 32768
        if left < 7:
            place += left
            continue
        length, kind = int.from_bytes(data[place + 4 : place + 6], "little"), data[place + 6]
        message += data[place + 7 : place + 7 + length]
        place += 7 + length
        whole, last = 1, 4
        if kind in (whole, last):
            record, message = Record.FromString(message), b""
            if record.HasField("history"):
                items = record.history.item
                yield {
                    item.key or ".".join(item.nested_key): json.loads(item.value_json)
                    for item in items
                }


@pytest.mark.parametrize("tracker", ["trackio", "wandb", "mlflow"])
def test_a_tracker_that_is_not_installed_is_named(tracker, run, monkeypatch):
    monkeypatch.setitem(sys.modules, tracker, None)
    with pytest.raises(rher.MissingError, match=rf"pip install 'rher\[{tracker}\]'"):
        rher.track.send(run, tracker)


def test_a_tracker_that_cannot_be_reached_is_named(run, monkeypatch):
    pytest.importorskip("mlflow")
    monkeypatch.setenv("MLFLOW_TRACKING_URI", "http://127.0.0.1:9")
    monkeypatch.setenv("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "0")
    with pytest.raises(rher.TrackerError, match="MLflow does not take the run: .*127.0.0.1"):
        rher.track.send(run, "mlflow")


def test_runs_are_in_a_folder_where_mlflow_has_no_database(run, tmp_path, monkeypatch):
    pytest.importorskip("mlflow")
    if importlib.util.find_spec("sqlalchemy"):
        pytest.skip("all of MLflow is installed")
    monkeypatch.setenv("MLFLOW_TRACKING_URI", "")
    monkeypatch.delenv("MLFLOW_TRACKING_URI")
    monkeypatch.chdir(tmp_path)
    assert rher.track.send(run, "mlflow") > 0
    assert (tmp_path / "mlruns").is_dir()


def test_wandb_without_an_account_says_how_to_go_on(run, tmp_path):
    pytest.importorskip("wandb")
    ended = command(
        run.path, "--to", "wandb", WANDB_DIR=tmp_path, HOME=tmp_path, NETRC=tmp_path / "none"
    )
    assert ended.returncode == 1
    (line,) = [line for line in ended.stderr.splitlines() if line.startswith("error: ")]
    assert "Weights & Biases does not take the run: " in line and "WANDB_MODE=offline" in line


def test_what_is_no_run_and_no_tracker_is_refused(run, tmp_path):
    with pytest.raises(rher.FileError, match="holds no run"):
        rher.track.send(tmp_path, "mlflow")
    with pytest.raises(rher.InputError, match="expected one of 'trackio', 'wandb', 'mlflow'"):
        rher.track.send(run, "tensorboard")


def test_the_command_sends_a_run(run, tmp_path):
    pytest.importorskip("mlflow")
    store = f"file://{tmp_path}/mlruns"
    ended = command(run.path, "--to", "mlflow", MLFLOW_TRACKING_URI=store)
    assert ended.returncode == 0, ended.stderr
    assert f"{len(steps(run))} evaluations of {run.path} sent to MLflow" in ended.stdout
    ended = command(tmp_path / "nowhere", "--to", "mlflow")
    assert ended.returncode == 1 and "nowhere" in ended.stderr
