"""Ray Tune, which stops, kills and continues trials."""

import importlib.util
import os
import signal
from pathlib import Path

import pytest
import rher
import rher.tune

pytestmark = pytest.mark.skipif(
    any(importlib.util.find_spec(name) is None for name in ("ray", "pyarrow", "pandas", "optuna")),
    reason="there is no Ray Tune, or no Optuna",
)


@pytest.fixture(scope="module")
def tune():
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    import ray
    from ray import tune

    ray.init("local", num_cpus=2, include_dashboard=False, object_store_memory=80_000_000)
    yield tune
    ray.shutdown()


def test_hopeless_trials_are_stopped_early(tune, tiny, tmp_path):
    from ray.tune.schedulers import ASHAScheduler
    from ray.tune.search.optuna import OptunaSearch

    results = tune.Tuner(
        rher.tune.trainable("reach", set=tiny, env_steps=5000, until=0.0),
        param_space={"agent.discount": tune.uniform(0.9, 0.99), "seed": tune.randint(1, 1000)},
        tune_config=tune.TuneConfig(
            metric="final_distance",
            mode="min",
            num_samples=4,
            scheduler=ASHAScheduler(
                time_attr="env_steps", max_t=5000, grace_period=500, reduction_factor=2
            ),
            search_alg=OptunaSearch(seed=1),
        ),
        run_config=tune.RunConfig(storage_path=str(tmp_path), verbose=0),
    ).fit()
    assert not results.errors
    steps = sorted(result.metrics["env_steps"] for result in results)
    assert steps[0] < 5000 and steps[-1] == 5000
    best = results.get_best_result()
    with best.checkpoint.as_directory() as folder:
        settings = rher.Run(folder).settings
    assert settings["agent"]["discount"] == pytest.approx(best.config["agent.discount"])
    assert settings["seed"] == best.config["seed"]


def test_a_trial_whose_worker_is_killed_ends_with_the_same_bits(tune, tiny, tmp_path):
    class Kill(tune.Callback):
        """Kills the worker at its twentieth evaluation."""

        def __init__(self):
            self.killed = False

        def on_trial_result(self, iteration, trials, trial, result, **info):
            if result["training_iteration"] >= 20 and not self.killed:
                os.kill(result["pid"], signal.SIGKILL)
                self.killed = True

    results = tune.Tuner(
        rher.tune.trainable("reach", set=tiny, env_steps=20_000, until=0.0),
        param_space={"seed": 7},
        run_config=tune.RunConfig(
            storage_path=str(tmp_path),
            name="tune",
            failure_config=tune.FailureConfig(max_failures=1),
            callbacks=[Kill()],
            verbose=0,
        ),
    ).fit()
    assert not results.errors
    result = results[0]
    assert result.metrics["iterations_since_restore"] < result.metrics["training_iteration"]
    alone = rher.train("reach", seed=7, set=tiny, env_steps=20_000, until=0.0, out=tmp_path / "a")
    with result.checkpoint.as_directory() as folder:
        policies = [Path(run) / "policy.safetensors" for run in (folder, alone.path)]
        assert policies[0].read_bytes() == policies[1].read_bytes()
