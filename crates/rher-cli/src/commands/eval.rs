//! `rher eval`: how often a policy succeeds.

use crate::cli::EvalArgs;
use crate::failure::{Failure, Failures};
use crate::host::threads;
use crate::numbers::percent;
use crate::printer::Printer;
use crate::running::note_policy;
use crate::tables::{table, text};
use crate::trained::Trained;
use rher_core::config::{EvaluationConfig, TestPolicy};
use rher_core::evaluate::{Evaluation, Played, evaluate_each};
use rher_core::goal::Position;
use rher_core::policy::Policy;
use rher_envs::{EnvVisitor, Options, Simulated};
use rher_runs::settings;
use serde::Serialize;
use std::sync::Mutex;

/// What is printed.
#[derive(Serialize)]
pub(super) struct EvalReport {
    task: String,
    pub(super) success_final: f32,
    /// Wilson's 95 % interval of `success_final`.
    pub(super) ci95: [f64; 2],
    /// By sub-task; `null` where a sub-task was not trained.
    pub(super) success: Vec<Option<f32>>,
    /// Mean distance of the objects to their targets at the end, in meters.
    pub(super) final_distance: f32,
    /// The same for where they really were; `null` where sensors tell nothing else.
    true_final_distance: Option<f32>,
    pub(super) episodes: usize,
    /// How many of them failed, by kind.
    failures: Failures,
    /// Settings of the environments.
    options: Options,
    pub(super) env_seed: u64,
    /// Whether these are other episodes than those by which training was judged; `null` where
    /// nobody knows.
    held_out: Option<bool>,
}

pub(crate) fn eval(args: &EvalArgs, printer: Printer) -> anyhow::Result<()> {
    let EvalArgs { path, episodes, seed, set, workers, json } = args;
    let trained = Trained::load(path, printer)?;
    note_policy(path, printer);
    // The last of those that are given twice counts.
    let is_last = |index: usize| set[index + 1..].iter().all(|later| later.key != set[index].key);
    let set: Vec<_> = (0..set.len())
        .filter(|index| is_last(*index))
        .map(|index| (set[index].key.clone(), set[index].value.clone()))
        .collect();
    let options = settings::resolve_options(trained.task, &trained.options, &set)?;
    let env_seed = seed.unwrap_or(trained.training_seed().unwrap_or(0).wrapping_add(1));
    let report = judge(&trained, &options, episodes.get(), env_seed, threads(*workers))?;
    let output = if *json {
        serde_json::to_string_pretty(&report)?
    } else {
        describe(&report, &trained.task.subtasks(), &set)
    };
    printer.data(&output)?;
    Ok(())
}

/// What becomes of the episodes of this seed in environments with these options.
pub(super) fn judge(
    trained: &Trained,
    options: &Options,
    episodes: usize,
    env_seed: u64,
    workers: usize,
) -> anyhow::Result<EvalReport> {
    let evaluate = Evaluate {
        policy: &trained.policy,
        config: EvaluationConfig {
            every_episodes: 1,
            episodes,
            subtask_episodes: episodes,
            env_seed,
        },
        test_policy: trained.test_policy(),
        workers,
    };
    let (evaluation, failures) = trained.task.visit_with(options, evaluate)??;
    let Evaluation { success, success_final, final_distance, true_final_distance } = evaluation;
    let ci95 = wilson(success_final, episodes);
    Ok(EvalReport {
        task: trained.task.name().to_owned(),
        success_final,
        ci95,
        success,
        final_distance,
        true_final_distance,
        episodes,
        failures,
        options: options.clone(),
        env_seed,
        held_out: trained.training_seed().map(|of_training| env_seed != of_training),
    })
}

/// An evaluation of a task that is known at run time.
struct Evaluate<'a> {
    policy: &'a Policy,
    config: EvaluationConfig,
    test_policy: TestPolicy,
    workers: usize,
}

impl EnvVisitor for Evaluate<'_> {
    type Output = anyhow::Result<(Evaluation, Failures)>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let Self { policy, config, test_policy, workers } = self;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(workers).build()?;
        let mut envs: Vec<E> = (0..workers).map(|_| build()).collect();
        let last = policy.info().last_stage::<N>()?;
        let failures = Mutex::new(Failures::default());
        let count = |env: &E, Played { stage, episode, .. }: &Played<N>| {
            let can_reach = |place: &Position| env.can_reach(place);
            if *stage == last
                && let Some(failure) = Failure::of(last, episode, &env.spec().tolerances, can_reach)
            {
                *failures.lock().expect("no thread panics while it counts") += failure;
            }
        };
        let evaluation =
            pool.install(|| evaluate_each(&mut envs, policy, &config, test_policy, count))?;
        Ok((evaluation, failures.into_inner().expect("no thread panics while it counts")))
    }
}

/// Wilson's score interval, 95 %.
fn wilson(rate: f32, episodes: usize) -> [f64; 2] {
    const Z: f64 = 1.959_963_984_540_054;
    let (rate, n) = (f64::from(rate), episodes as f64);
    let scale = 1.0 + Z * Z / n;
    let center = rate + Z * Z / (2.0 * n);
    let margin = Z * (rate * (1.0 - rate) / n + Z * Z / (4.0 * n * n)).sqrt();
    [(center - margin) / scale, (center + margin) / scale].map(|bound| bound.clamp(0.0, 1.0))
}

/// What is printed, for people.
pub(super) fn describe(
    report: &EvalReport,
    subtasks: &[String],
    set: &[(String, toml::Value)],
) -> String {
    let [low, high] = report.ci95;
    let mut lines = table();
    let mut add = |name: &str, value: String| {
        lines.add_row([name, &value]);
    };
    add("task", report.task.clone());
    add(
        "success",
        format!(
            "{} of {} episodes (95 % interval {} to {})",
            percent(report.success_final.into()),
            report.episodes,
            percent(low),
            percent(high)
        ),
    );
    for (name, rate) in subtasks.iter().zip(&report.success) {
        add(name, rate.map_or("not trained".to_owned(), |rate| percent(rate.into())));
    }
    add("final distance", format!("{:.1} cm", 100.0 * report.final_distance));
    if let Some(distance) = report.true_final_distance {
        add("true distance", format!("{:.1} cm", 100.0 * distance));
    }
    add("failures", report.failures.to_string());
    for (key, value) in set {
        add(key, value.to_string());
    }
    let judged = match report.held_out {
        Some(true) => "not those of training",
        Some(false) => "those that training was judged by",
        None => "perhaps those of training, which the policy alone does not say",
    };
    add("episodes", format!("of seed {}, {judged}", report.env_seed));
    text(&lines)
}

#[cfg(test)]
mod tests {
    use super::wilson;

    #[test]
    fn the_interval_is_wilsons() {
        let [low, high] = wilson(0.95, 100);
        assert!((low - 0.8882).abs() < 1e-4 && (high - 0.9785).abs() < 1e-4, "{low} {high}");
        let [low, high] = wilson(1.0, 10);
        assert!((low - 0.7225).abs() < 1e-4 && (high - 1.0).abs() < 1e-9, "{low} {high}");
    }
}
