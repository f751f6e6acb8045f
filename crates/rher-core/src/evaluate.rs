//! How good a policy is: deterministic, on fixed episodes, judged at the last step.

use crate::config::{EvaluationConfig, TestPolicy};
use crate::env::{Env, Permutation, SpecError};
use crate::episode::{Episode, RolloutError, rollout};
use crate::explore::ActionSource;
use crate::explore::{ActionLog, Decision};
use crate::goal::{Achieved, Desired, EncodedGoal, Leg, Stage, Tolerances};
use crate::policy::Critic;
use crate::policy::{Mismatch, Policy};
use crate::seed::{Purpose, Seed};
use rand::RngExt as _;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// What an evaluation found.
///
/// ```no_run
/// use rher_core::testing::Carry;
/// use rher_core::{Policy, Preset, evaluate};
///
/// let policy = Policy::load("policy.safetensors".as_ref())?;
/// let config = Preset::Fast.config("carry", 1);
/// let (of, which) = (&config.evaluation, config.exploration.test_policy);
/// let evaluation = evaluate(&mut [Carry::new()], &policy, of, which)?;
/// println!("success {}", evaluation.success_final);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Success rate of every sub-task; `None` where it was not evaluated.
    pub success: Vec<Option<f32>>,
    /// Success rate of the last sub-task.
    pub success_final: f32,
    /// Mean distance of the objects to their targets at the end of the last sub-task's episodes,
    /// in meters; of the gripper to the object where the last sub-task is to reach it. Where goals
    /// are more than positions, [`final_distance`] has another unit.
    pub final_distance: f32,
    /// The same for where everything really was, if sensors told otherwise.
    pub true_final_distance: Option<f32>,
}

/// An evaluation could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvaluateError {
    /// The environment's specification is wrong.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// The policy is for another task.
    #[error(transparent)]
    Mismatch(#[from] Mismatch),
    /// The environment failed.
    #[error(transparent)]
    Rollout(#[from] RolloutError),
}

/// Plays `config.episodes` episodes for the last sub-task of `policy`, and
/// `config.subtask_episodes` for each sub-task before it that it was trained for.
///
/// A sub-task has succeeded if its goal is met at the last step. One that reaches an object on the
/// way to a later sub-task also has if the object was moved, for it is there to be moved, and all
/// before it are in their places.
///
/// Episodes are shared out among `envs`, in parallel on the current thread pool; the result does
/// not depend on how.
///
/// # Panics
///
/// If there is no environment.
pub fn evaluate<const N: usize, E: Env<N>>(
    envs: &mut [E],
    policy: &Policy,
    config: &EvaluationConfig,
    test_policy: TestPolicy,
) -> Result<Evaluation, EvaluateError> {
    evaluate_each(envs, policy, config, test_policy, |_, _| {})
}

/// The same, and `seen` is called with every episode that was played and the environment that it
/// was played in, which is at its end; in any order, and from several threads at once.
///
/// # Panics
///
/// If there is no environment.
pub fn evaluate_each<const N: usize, E: Env<N>>(
    envs: &mut [E],
    policy: &Policy,
    config: &EvaluationConfig,
    test_policy: TestPolicy,
    seen: impl Fn(&E, &Played<N>) + Sync,
) -> Result<Evaluation, EvaluateError> {
    let stop = AtomicBool::new(false);
    let evaluation = evaluate_seen(&stop, envs, policy, config, test_policy, seen)?;
    Ok(evaluation.expect("nobody stops it"))
}

/// Evaluates; `None` if `stop` was set before all episodes were played.
pub(crate) fn evaluate_until<const N: usize, E: Env<N>>(
    stop: &AtomicBool,
    envs: &mut [E],
    policy: &Policy,
    config: &EvaluationConfig,
    test_policy: TestPolicy,
) -> Result<Option<Evaluation>, EvaluateError> {
    evaluate_seen(stop, envs, policy, config, test_policy, |_, _| {})
}

fn evaluate_seen<const N: usize, E: Env<N>>(
    stop: &AtomicBool,
    envs: &mut [E],
    policy: &Policy,
    config: &EvaluationConfig,
    test_policy: TestPolicy,
    seen: impl Fn(&E, &Played<N>) + Sync,
) -> Result<Option<Evaluation>, EvaluateError> {
    let spec = envs[0].spec();
    spec.validate()?;
    policy.check_spec(spec)?;
    let tolerances = spec.tolerances;
    let stages: Vec<Stage<N>> = Stage::all().take(policy.info().subtasks).collect();
    let last = stages.len() - 1;
    let first = policy.info().untrained;
    let plays: Vec<(Stage<N>, u64)> = stages[first..]
        .iter()
        .flat_map(|&stage| {
            let full = stage.index() == last;
            let episodes = if full { config.episodes } else { config.subtask_episodes };
            (0..episodes as u64).map(move |episode| (stage, episode))
        })
        .collect();

    let workers = envs.len();
    let results = envs
        .par_iter_mut()
        .enumerate()
        .map(|(worker, env)| {
            plays
                .iter()
                .skip(worker)
                .step_by(workers)
                .map(|&(stage, episode)| {
                    if stop.load(Ordering::Relaxed) {
                        return Ok(None);
                    }
                    let whole =
                        play(env, policy, stage, test_policy, Seed(config.env_seed), episode)?;
                    seen(env, &whole);
                    let played = &whole.episode;
                    let end = played.achieved[played.achieved.len() - 1];
                    let met = EncodedGoal::new(stage, &end, &played.desired)
                        .is_met(&end, &tolerances)
                        || stage.index() < last && was_touched(stage, played, &tolerances);
                    let distance = |end: &Achieved<N>| {
                        final_distance(stage, end, &played.desired, &tolerances)
                    };
                    let truly = env.truth().map(|end| distance(&end));
                    Ok(Some((stage.index(), met, distance(&end), truly)))
                })
                .collect::<Result<Option<Vec<_>>, EvaluateError>>()
        })
        .collect::<Result<Vec<_>, EvaluateError>>()?;
    let Some(results) = results.into_iter().collect::<Option<Vec<_>>>() else { return Ok(None) };
    let mut results = results.into_iter().map(Vec::into_iter).collect::<Vec<_>>();
    let in_order = (0..plays.len()).filter_map(|play| results[play % workers].next());

    let mut successes = vec![0_usize; stages.len()];
    let mut distances = 0.0;
    let mut true_distances = None;
    for (stage, met, distance, truly) in in_order {
        successes[stage] += usize::from(met);
        if stage == last {
            distances += f64::from(distance);
            if let Some(truly) = truly {
                *true_distances.get_or_insert(0.0) += f64::from(truly);
            }
        }
    }
    let rate = |stage: usize, episodes: usize| successes[stage] as f32 / episodes as f32;
    let success_final = rate(last, config.episodes);
    let success = (0..last)
        .map(|stage| (stage >= first).then(|| rate(stage, config.subtask_episodes)))
        .chain([Some(success_final)])
        .collect();
    let mean = |sum: f64| (sum / config.episodes as f64) as f32;
    Ok(Some(Evaluation {
        success,
        success_final,
        final_distance: mean(distances),
        true_final_distance: true_distances.map(mean),
    }))
}

/// An evaluation episode.
#[derive(Clone, Debug, PartialEq)]
pub struct Played<const N: usize> {
    /// The sub-task that it was for.
    pub stage: Stage<N>,
    /// Seed that the environment was reset with.
    pub seed: u64,
    /// What happened.
    pub episode: Episode<N>,
    /// The order of the objects that the policy chose, if not the given one.
    pub order: Option<Permutation<N>>,
    /// The sub-tasks whose policies chose the actions: `[T]`.
    pub stages: Vec<Stage<N>>,
}

impl<const N: usize> Played<N> {
    /// What the episode can be played again from, as number `number` of its kind, with what
    /// `critic` expects of its actions.
    pub fn script(&self, number: u64, critic: Option<&Critic>) -> ActionLog {
        let Self { stage: goal, seed, episode, order, stages } = self;
        let values = critic.map(|critic| match order {
            None => critic.values(episode, stages),
            Some(order) => critic.values(&episode.reordered(order), stages),
        });
        let decision = |(step, stage): (usize, &Stage<N>)| Decision {
            source: if stage == goal { ActionSource::Learner } else { ActionSource::Guide },
            subtask: stage.index(),
            value: values.as_ref().map(|values| values[step]),
        };
        let decisions = stages.iter().enumerate().map(decision).collect();
        ActionLog { number, seed: *seed, actions: episode.actions.clone(), decisions }
    }
}

/// Plays the evaluation episode with this number for the sub-task that ends with `stage`.
pub fn play<const N: usize>(
    env: &mut impl Env<N>,
    policy: &Policy,
    stage: Stage<N>,
    test_policy: TestPolicy,
    seed: Seed,
    episode: u64,
) -> Result<Played<N>, EvaluateError> {
    let tolerances = env.spec().tolerances;
    let reach_distance = policy.info().reach_distance;
    let mut actor = policy.actor(env.spec())?;
    let mut rng = seed.stream(Purpose::Exploration, episode);
    let mut stages = Vec::with_capacity(env.spec().episode_steps);
    let env_seed = seed.episode(Purpose::Evaluation, episode);
    let episode = rollout(env, env_seed, |view, action| {
        let current =
            || Stage::of(view.achieved, view.desired, &tolerances, reach_distance).at_most(stage);
        let acting = match test_policy {
            TestPolicy::Guide => current(),
            TestPolicy::Mix if rng.random() => current(),
            TestPolicy::Mix | TestPolicy::Final => stage,
        };
        if stages.is_empty() && test_policy == TestPolicy::Final {
            actor.begin(view.achieved, view.desired)?;
        }
        stages.push(acting);
        actor.act(acting, view.observation, view.achieved, view.desired, action)
    })?;
    let order = actor.order().filter(|_| stage == actor.task()).cloned();
    Ok(Played { stage, seed: env_seed, episode, order, stages })
}

/// Whether the object that `stage` reaches has moved, and all before it end in their places.
fn was_touched<const N: usize>(
    stage: Stage<N>,
    played: &Episode<N>,
    tolerances: &Tolerances<N>,
) -> bool {
    let (start, end) = (&played.achieved[0], &played.achieved[played.achieved.len() - 1]);
    let object = stage.object();
    let is_placed = |earlier: usize| tolerances.placed(earlier, end, &played.desired);
    stage.leg() == Leg::Reach && end.0.has_moved(object, &start.0) && (0..object).all(is_placed)
}

/// How far a scene is from what the sub-task that ends with `stage` is for: the mean over objects to
/// their targets, or the gripper to the object it should reach, in meters.
///
/// Where goals are more than positions, an object is as far from its target as in the part in which
/// it is furthest, in units of that part's tolerance.
pub fn final_distance<const N: usize>(
    stage: Stage<N>,
    Achieved(end): &Achieved<N>,
    desired: &Desired<N>,
    tolerances: &Tolerances<N>,
) -> f32 {
    match stage.leg() {
        Leg::Reach => nalgebra::distance(&end.gripper, &end.objects[stage.object()]),
        Leg::Place => {
            let distance = |object| tolerances.distance(object, end, desired);
            (0..N).map(distance).sum::<f32>() / N as f32
        }
    }
}
