"""Sweeps on a Ray cluster of three nodes, whose workers, nodes and drivers die."""

import importlib.util
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import rher
import rher.sweep
from conftest import TINY

#: Steps of a cell, which takes a second or two.
STEPS = 20_000
#: A node of the cluster.
SMALL = {"num_cpus": 1, "object_store_memory": 80_000_000}
COMMAND = [sys.executable, "-m", "rher_command", "sweep"]

with_ray = pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason="there is no Ray")


def made(folder, seeds, steps=STEPS):
    """A plan in this folder."""
    folder.mkdir()
    plan = folder / "plan.jsonl"
    values = [f"{key}={value}".replace(" ", "") for key, value in TINY.items()]
    settings = [part for value in values for part in ("--set", value)]
    arguments = ["reach", "--seeds", seeds, "--until", "0", "--env-steps", str(steps), *settings]
    out = ["--out", folder / "runs", "--plan", plan]
    subprocess.run([*COMMAND, *arguments, *out], check=True, capture_output=True)
    return plan


def bits(plan):
    """What must be the same in every training of a plan: policies, and metrics without wall clocks."""
    found = {}
    for cell in rher.sweep.run(plan):
        lines = (cell.folder / "metrics.jsonl").read_text().splitlines()
        rows = [json.loads(line) for line in lines]
        for row in rows:
            for key in ("wall_s", "time", "crc32"):
                del row[key]
        found[cell.number] = (cell.folder / "policy.safetensors").read_bytes(), rows
    return found


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The bits of cells that nothing disturbed."""
    plan = made(tmp_path_factory.mktemp("undisturbed") / "plan", "1-6")
    subprocess.run([*COMMAND, "--plan", plan, "--jobs", "2"], check=True, capture_output=True)
    return bits(plan)


def processes(plan):
    """Processes that train cells of a plan, each with its parent."""
    found = {}
    for folder in Path("/proc").iterdir():
        try:
            words = (folder / "cmdline").read_bytes().decode().split("\0")
            if "--cell" in words and str(plan) in words:
                status = (folder / "status").read_text()
                found[int(folder.name)] = int(re.search(r"PPid:\s+(\d+)", status)[1])
        except (OSError, ValueError):
            pass
    return found


def is_worker(process):
    """Whether this is a worker of Ray."""
    try:
        return Path(f"/proc/{process}/cmdline").read_bytes().startswith(b"ray::")
    except OSError:
        return False


def wait_until(true, seconds=180):
    deadline = time.monotonic() + seconds
    while not (value := true()):
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.02)
    return value


@pytest.fixture(scope="module")
def cluster():
    """Three nodes with a core each, and an address."""
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    from ray.cluster_utils import Cluster

    cluster = Cluster(initialize_head=True, head_node_args={**SMALL, "include_dashboard": False})
    for _ in range(2):
        cluster.add_node(**SMALL)
    cluster.wait_for_nodes()
    yield cluster
    cluster.shutdown()


@with_ray
def test_driver_workers_and_a_node_die_and_the_bits_are_the_same(cluster, undisturbed, tmp_path):
    plan = made(tmp_path / "disturbed", "1-6")
    command = [sys.executable, "-m", "rher.sweep", plan, "--ray", cluster.address]
    driver = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    wait_until(lambda: len(processes(plan)) >= 2)
    driver.kill()
    driver.wait()
    wait_until(lambda: not processes(plan))
    assert any(cell.status != 0 for cell in rher.sweep._cells(plan))

    events, cells = [], []
    driver = threading.Thread(
        target=lambda: cells.extend(rher.sweep.run(plan, cluster.address, on_event=events.append))
    )
    driver.start()

    def interrupted():
        return sum(event["kind"] == "interrupted" for event in events)

    def kill(choose):
        """Kills a process that trains, or its parent, until the driver has seen one die."""
        before = interrupted()
        while interrupted() == before:
            pairs = [pair for pair in processes(plan).items() if is_worker(pair[1])]
            if pairs:
                os.kill(choose(pairs[0]), signal.SIGKILL)
            time.sleep(0.5)

    kill(lambda pair: pair[1])
    kill(lambda pair: pair[0])
    cluster.remove_node(next(iter(cluster.worker_nodes)), allow_graceful=False)
    driver.join(timeout=300)
    assert not driver.is_alive()
    cluster.add_node(**SMALL)
    assert [(cell.number, cell.status) for cell in cells] == [(n, 0) for n in range(6)]
    assert bits(plan) == undisturbed


@with_ray
def test_ctrl_c_saves_what_is_trained(cluster, tmp_path):
    plan = made(tmp_path / "plan", "1-3", steps=10_000_000)
    command = [sys.executable, "-m", "rher.sweep", plan, "--ray", cluster.address]
    driver = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    wait_until(lambda: len(processes(plan)) == 3)
    time.sleep(0.5)
    driver.send_signal(signal.SIGINT)
    _, said = driver.communicate(timeout=60)
    assert driver.returncode == 130, said
    assert "the same command continues" in said
    assert not processes(plan)
    listing = subprocess.run(
        [*COMMAND, "--status", plan, "--json"], check=True, capture_output=True
    ).stdout
    assert [cell["status"] for cell in json.loads(listing)["list"]] == [143] * 3


@with_ray
def test_a_cell_that_fails_leaves_the_others_alone(cluster, tmp_path):
    plan = made(tmp_path / "plan", "1-3", steps=500)
    occupied = rher.sweep._cells(plan)[1].folder
    rher.train("push", set=dict(TINY), env_steps=500, until=0.0, out=occupied)
    before = (occupied / "policy.safetensors").read_bytes()
    cells = rher.sweep.run(plan, cluster.address)
    assert [cell.status for cell in cells] == [0, 5, 0]
    assert str(occupied) in cells[1].why
    assert cells[0].run.metrics["env_steps"][-1] == 500
    assert (occupied / "policy.safetensors").read_bytes() == before


def test_without_ray_the_error_says_what_to_do(tmp_path):
    plan = made(tmp_path / "plan", "1", steps=500)
    code = "import sys; sys.modules['ray'] = None; import rher.sweep; sys.exit(rher.sweep.main())"
    ran = subprocess.run([sys.executable, "-c", code, plan], capture_output=True, text=True)
    assert ran.returncode == 1
    assert "pip install 'rher[ray]'" in ran.stderr
    assert ran.stderr.count("\n") == 1


def test_the_package_does_not_import_ray():
    code = "import rher, rher.sweep, rher.tune, sys; sys.exit('ray' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("content", [None, "", '{"plan":2}\n', "{}\n"])
def test_what_is_no_plan_is_an_error(content, tmp_path):
    plan = tmp_path / "plan.jsonl"
    if content is not None:
        plan.write_text(content)
    with pytest.raises(rher.FileError, match="plan.jsonl"):
        rher.sweep.run(plan)


@pytest.mark.parametrize("cpus", [0, -1, 1.5, True, "2"])
def test_cpus_are_a_whole_number(cpus, tmp_path):
    with pytest.raises(rher.InputError, match="cpus is"):
        rher.sweep.run(tmp_path / "plan.jsonl", cpus=cpus)
