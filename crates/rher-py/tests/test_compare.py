"""The comparison, shortened: that it runs, what it writes, and its bars at a distance."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("gymnasium_robotics")
pytest.importorskip("stable_baselines3")

from rher import _rher  # noqa: E402
from rher.compare import command  # noqa: E402

DATA = Path(__file__).parent / "data"


def measured(out, *arguments):
    command.main(["--quick", "--out", str(out), *arguments])
    table = (out / "compare.md").read_text()
    assert "no results" in table
    return json.loads((out / "compare.json").read_text()), table


def test_the_package_does_not_import_it():
    loaded = "import sys, rher; print([name for name in sys.modules if 'compare' in name])"
    said = subprocess.run([sys.executable, "-c", loaded], capture_output=True, text=True)
    assert said.stdout.strip() == "[]", said.stdout + said.stderr


def test_it_is_run_as_a_module():
    command = [sys.executable, "-m", "rher.compare", "--help"]
    said = subprocess.run(command, capture_output=True, text=True)
    assert said.returncode == 0 and "python -m rher.compare" in said.stdout, said.stderr


def test_environments_and_relabeling_are_faster_than_their_neighbors(out):
    results, table = measured(out, "--parts", "single", "vector", "relabeling")
    # A busy machine must not fail this: half of what is published.
    assert results["single"]["ratio"] > 12
    assert results["vector"]["ratio"] > 17
    assert results["relabeling"]["ratio"] > 10
    assert table.count(" × |") == 4 and "of two processes" in table


def test_policies_of_our_tasks_work_in_fetch(out):
    arguments = ["--parts", "transfer"]
    for task in ("push", "pick"):
        arguments += [f"--{task}", str(DATA / f"{task}.safetensors")]
    results, _ = measured(out, *arguments)
    solved = [policy["solved"] for policy in results["transfer"]["policies"]]
    assert solved[0]["FetchPush-v4"] >= 16 and solved[1]["FetchPickAndPlace-v4"] >= 14


def test_learners_are_timed_and_stopped(out):
    results, table = measured(
        out, "--parts", "learning", "--runs", "rher-in-rher", "sb3-in-fetch", "--budget", "5"
    )
    runs = results["learning"]["runs"]
    assert all(run["spent_s"] < 60 for run in runs.values())
    assert table.count("not reached") == 2


def test_tasks_of_other_packages_are_trained_and_judged(out):
    arguments = ["--parts", "foreign", "--tasks", "FetchPush-v4", "--seeds", "3"]
    results, table = measured(out, *arguments)
    (run,) = results["foreign"]["runs"]
    assert (run["task"], run["seed"], run["judged"]["episodes"]) == ("FetchPush-v4", 3, 2)
    assert run["env_steps"] > 0 and run["cpu_s"] > 0
    assert "| FetchPush-v4 | rher | 3 |" in table
    kept = out / "FetchPush-v4-rher-seed3"
    assert (kept / "run/metrics.jsonl").exists() and (kept / "run/config.toml").exists()
    # What is finished is read, not measured again.
    before = (kept / "result.json").read_bytes()
    again, _ = measured(out, *arguments)
    assert again["foreign"]["runs"] == [run] and (kept / "result.json").read_bytes() == before
