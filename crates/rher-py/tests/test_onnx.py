"""Policies as ONNX models: they do in ONNX Runtime what they do here."""

import hashlib
import json
import subprocess
import sys

import gymnasium
import numpy as np
import pytest
import rher
import rher.onnx
from toy import STEPS, Carry

onnx = pytest.importorskip("onnx")
onnxruntime = pytest.importorskip("onnxruntime")

NAMES = {task: name for name, task in rher.IDS.items()}
PARTS = ("observation", "achieved_goal", "desired_goal")


class Model:
    """An exported policy, in ONNX Runtime."""

    def __init__(self, policy, folder):
        self.path = rher.onnx.export(policy, folder / "policy.onnx")
        self.contract = json.loads(self.path.with_suffix(".json").read_text())
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = 1
        self.session = onnxruntime.InferenceSession(self.path, options)
        self.inputs = [value.name for value in self.session.get_inputs()]

    def begin(self, first):
        """What acts in the episodes that begin here, like ``rher.Policy.begin``."""
        first = {f"first_{part}": first[part] for part in PARTS}

        def act(seen):
            given = first | seen
            given = {name: np.asarray(given[name], np.float32) for name in self.inputs}
            return self.session.run(["action"], given)[0]

        return act


def episodes(task, count, acting):
    """Plays episodes; returns every observation with its episode's first, and who succeeded."""
    envs = gymnasium.make_vec(NAMES[task], num_envs=count)
    first, _ = envs.reset(seed=7)
    act, seen, rows = acting.begin(first), first, []
    for _ in range(gymnasium.spec(NAMES[task]).max_episode_steps):
        rows.append({part: seen[part].copy() for part in PARTS})
        seen, _, _, truncated, info = envs.step(act(seen))
    assert truncated.all()
    return first, rows, info["is_success"]


def differences(policy, model, first, rows):
    """How far apart the actions are, number by number."""
    ours, theirs = policy.begin(first), model.begin(first)
    return np.concatenate([np.abs(ours(seen) - theirs(seen)) for seen in rows])


def assert_equal(policy, model, first, rows):
    apart = differences(policy, model, first, rows)
    assert apart.max() <= 1e-5 and np.median(apart) <= 1e-6, (apart.max(), np.median(apart))


@pytest.mark.parametrize("task", NAMES)
def test_shipped_policies_act_the_same_in_ten_thousand_rows(task, tmp_path):
    policy = rher.Policy.pretrained(task)
    model = Model(policy, tmp_path)
    onnx.checker.check_model(onnx.load(model.path), full_check=True)
    steps = gymnasium.spec(NAMES[task]).max_episode_steps
    first, rows, success = episodes(task, -(-10_000 // steps), policy)
    assert len(rows) * len(success) >= 10_000 and success.mean() > 0.8
    apart = differences(policy, model, first, rows)
    print(
        f"{task}: {apart.shape[0]} rows, {apart.max():.2g} at most, median {np.median(apart):.2g}"
    )
    assert apart.max() <= 1e-5
    assert np.median(apart) <= 1e-6


def with_noise(policy, size, seed):
    """The policy with noise on its actions."""

    class Noisy:
        def begin(self, first):
            act, rng = policy.begin(first), np.random.default_rng(seed)

            def noisy(seen):
                action = act(seen)
                noise = rng.uniform(-size, size, action.shape).astype(np.float32)
                return np.clip(action + noise, -1, 1)

            return noisy

    return Noisy()


def test_the_same_episodes_succeed_where_nothing_is_touched(tmp_path):
    policy = rher.Policy.pretrained("reach")
    _, _, ours = episodes("reach", 200, policy)
    _, _, theirs = episodes("reach", 200, Model(policy, tmp_path))
    assert np.array_equal(theirs, ours) and theirs.all()


@pytest.mark.parametrize(("task", "most"), [("push", 2), ("tpush", 10)])
def test_as_many_episodes_succeed_as_with_noise_of_a_millionth(task, most, tmp_path):
    policy = rher.Policy.pretrained(task)
    model = Model(policy, tmp_path)
    _, _, ours = episodes(task, 200, policy)
    first, rows, theirs = episodes(task, 200, model)
    noisy = [episodes(task, 200, with_noise(policy, 1e-6, seed))[2] for seed in range(3)]
    counts = [int(success.sum()) for success in (ours, theirs, *noisy)]
    changed = [int((success != ours).sum()) for success in (theirs, *noisy)]
    print(
        f"{task}: of 200 succeed {counts}: here, in ONNX Runtime, and with noise; {changed} differ"
    )
    # Contacts make another episode of the smallest difference, so this is no equality.
    assert abs(counts[1] - counts[0]) <= most
    # Where the model itself went, both still do the same.
    assert_equal(policy, model, first, rows)


@pytest.mark.parametrize("task", ["dpush", "tpush"])
def test_the_order_of_objects_is_chosen_where_the_episode_began(task, tmp_path):
    policy = rher.Policy.pretrained(task)
    model = Model(policy, tmp_path)
    first, rows, _ = episodes(task, 100, policy)
    assert model.inputs == [*PARTS, "first_observation", "first_achieved_goal"]
    # Some episodes are played in another order than the given one.
    given = np.abs(policy(rows[0]) - model.begin(first)(rows[0])).max(axis=1)
    assert 0 < np.count_nonzero(given > 1e-3) < 100


#: Settings that change what a network sees.
SETTINGS = [
    {"relay.goal_frame": "absolute"},
    {"relay.fine_scale": False},
    {"relay.object_order": "relay"},
    {"relay.goal_frame": "absolute", "relay.fine_scale": False, "relay.object_order": "relay"},
]


@pytest.mark.parametrize("task", ["reach", "tpush"])
@pytest.mark.parametrize("settings", SETTINGS, ids=str)
def test_every_kind_of_input_is_exported(task, settings, tiny, tmp_path):
    run = rher.train(task, set=tiny | settings, env_steps=100, out=tmp_path / "run")
    model = Model(run, tmp_path)
    first, rows, _ = episodes(task, 20, run.policy)
    assert_equal(run.policy, model, first, rows)


@pytest.mark.parametrize("objects", [1, 2])
def test_policies_of_your_own_environment_are_exported(objects, tiny, tmp_path):
    env, out = Carry(objects), tmp_path / "run"
    run = rher.Trainer(env, objects=objects, episode_steps=STEPS, set=tiny, out=out).learn(100)
    model = Model(run, tmp_path)
    rng = np.random.default_rng(0)
    seen = {"observation": rng.uniform(0, 1, (1000, 3 + 3 * objects))}
    seen |= {part: rng.uniform(0, 1, (1000, 3 * objects)) for part in PARTS[1:]}
    assert_equal(run.policy, model, seen, [seen])
    assert model.contract["outputs"][0]["names"] == [] and model.contract["rate_hz"] is None


def changed(file, change):
    """A policy file of version 1, which has no checksum, after ``change`` of its description and its
    tensors.
    """
    body = 8 + int.from_bytes(file[:8], "little")
    header = json.loads(file[8:body])
    about = json.loads(header.pop("__metadata__")["rher"])
    tensors = {
        name: np.frombuffer(file[body:][slice(*it["data_offsets"])], np.float32)
        .copy()
        .reshape(it["shape"])
        for name, it in header.items()
    }
    about["version"] = 1
    change(about, tensors)
    header, data = {"__metadata__": {"rher": json.dumps(about)}}, b""
    for name, tensor in tensors.items():
        begin = len(data)
        data += tensor.astype(np.float32).tobytes()
        place = [begin, len(data)]
        header[name] = {"dtype": "F32", "shape": tensor.shape, "data_offsets": place}
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    return len(text).to_bytes(8, "little") + text + data


@pytest.fixture
def shipped(tmp_path):
    """The file of the policy of ``push``."""
    path = tmp_path / "push.safetensors"
    rher.Policy.pretrained("push").save(path)
    return path


def test_layer_normalization_is_exported(shipped, tmp_path):
    def normalize(about, tensors):
        about["shape"]["layer_norm"] = True
        rng = np.random.default_rng(0)
        for layer in range(2):
            tensors[f"layers.{layer}.norm.scale"] = rng.uniform(0.5, 1.5, 256)
            tensors[f"layers.{layer}.norm.shift"] = rng.normal(0, 0.1, 256)

    shipped.write_bytes(changed(shipped.read_bytes(), normalize))
    policy, model = rher.Policy.load(shipped), Model(shipped, tmp_path)
    assert "LayerNormalization" in {node.op_type for node in onnx.load(model.path).graph.node}
    first, rows, _ = episodes("push", 20, policy)
    assert_equal(policy, model, first, rows)


def test_rows_do_not_depend_on_each_other(tmp_path):
    model = Model(rher.Policy.pretrained("stack"), tmp_path)
    seen, _ = gymnasium.make_vec(NAMES["stack"], num_envs=5).reset(seed=0)
    act = model.begin(seen)
    actions = act(seen)
    for part in PARTS:
        for wrong in (np.nan, np.inf, -np.inf):
            other = {name: array.copy() for name, array in seen.items()}
            other[part][2, 1] = wrong
            answer = act(other)
            assert np.isnan(answer[2]).all(), "this must not be carried out"
            rest = [0, 1, 3, 4]
            np.testing.assert_allclose(answer[rest], actions[rest], atol=1e-6)
    for rows in (0, 1):
        few = {name: array[:rows] for name, array in seen.items()}
        assert act(few).shape == (rows, 4)


def test_the_contract_says_what_the_numbers_are(tmp_path):
    policy = rher.Policy.pretrained("stack")
    model = Model(policy, tmp_path)
    contract, env = model.contract, gymnasium.make(NAMES["stack"])
    assert contract["task"] == "stack" and contract["objects"] == ["block1", "block2"]
    assert contract["rate_hz"] == 25.0 and "right-handed" in contract["frame"]
    assert [row["name"] for row in contract["inputs"]] == model.inputs
    for row in contract["inputs"]:
        (width,) = env.observation_space[row["name"]].shape
        assert row["shape"] == ["batch", width]
        assert len(row["names"]) == len(row["units"]) == width
    (action,) = contract["outputs"]
    assert action["shape"] == ["batch", 4] and action["limits"] == [-1.0, 1.0]
    assert action["names"][0] == "fingers.x" and action["units"][0] == "0.05 m/step"

    policy.save(tmp_path / "policy.safetensors")
    file = hashlib.sha256((tmp_path / "policy.safetensors").read_bytes()).hexdigest()
    assert contract["policy"]["sha256"] == file
    assert contract["model"]["sha256"] == hashlib.sha256(model.path.read_bytes()).hexdigest()
    assert model.session.get_modelmeta().custom_metadata_map["policy_sha256"] == file


def test_a_run_its_folder_its_file_and_its_policy_are_the_same(tiny, out, tmp_path):
    run = rher.train("push", set=tiny, env_steps=100, out=out)
    models = [
        rher.onnx.export(policy, tmp_path / f"{index}.onnx").read_bytes()
        for index, policy in enumerate([run, out, out / "policy.safetensors", run.policy])
    ]
    assert models == models[:1] * 4


def test_what_holds_no_policy_is_refused(shipped, tmp_path):
    out = tmp_path / "policy.onnx"
    with pytest.raises(rher.FileError, match="nowhere"):
        rher.onnx.export(tmp_path / "nowhere", out)
    with pytest.raises(rher.FileError, match="policy.safetensors"):
        rher.onnx.export(tmp_path, out)
    with pytest.raises(rher.InputError, match="policy is 3, expected a path"):
        rher.onnx.export(3, out)
    shipped.write_bytes(shipped.read_bytes()[:-100])
    with pytest.raises(rher.PolicyError, match="push.safetensors"):
        rher.onnx.export(shipped, out)
    assert not out.exists() and not out.with_suffix(".json").exists()


def without_names(about, tensors):
    del about["interface"]


def with_more(about, tensors):
    about["encoder"]["camera"] = {}


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (without_names, "does not say where in an observation the gripper is"),
        (with_more, "unknown field `camera`"),
    ],
)
def test_a_policy_that_cannot_be_expressed_is_refused(change, why, shipped, tmp_path):
    shipped.write_bytes(changed(shipped.read_bytes(), change))
    with pytest.raises(rher.PolicyError, match=why):
        rher.onnx.export(shipped, tmp_path / "policy.onnx")
    assert not (tmp_path / "policy.onnx").exists()


def test_a_policy_of_a_newer_version_is_refused(shipped):
    shipped.write_bytes(changed(shipped.read_bytes(), with_more))
    with pytest.raises(rher.PolicyError, match="unknown field `camera`"):
        rher.Policy.load(shipped)


def test_a_place_that_cannot_be_written_is_named(tmp_path):
    policy = rher.Policy.pretrained("reach")
    with pytest.raises(rher.InputError, match=r"policy.pb`, expected a name that ends in .onnx"):
        rher.onnx.export(policy, tmp_path / "policy.pb")
    with pytest.raises(rher.FileError, match="no.where.policy.onnx"):
        rher.onnx.export(policy, tmp_path / "no" / "where" / "policy.onnx")


def test_the_command_exports_a_run_or_what_ships(tmp_path):
    def command(*arguments):
        python = [sys.executable, "-m", "rher.onnx"]
        return subprocess.run([*python, *arguments], cwd=tmp_path, capture_output=True, text=True)

    ended = command("push", "-o", "push.onnx")
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout == "push.onnx and push.json\n"
    expected = rher.onnx.export(rher.Policy.pretrained("push"), tmp_path / "again.onnx")
    assert (tmp_path / "push.onnx").read_bytes() == expected.read_bytes()
    ended = command("nowhere")
    assert (
        ended.returncode == 1 and ended.stderr.startswith("error: ") and "nowhere" in ended.stderr
    )
