//! The trainer against its own loop, spelled out: what is played, stored, drawn, learned and
//! evaluated, and from which random stream.

use crate::toy::{Lines, Magnet, small};
use rand::RngExt as _;
use rher_core::batch::Batch;
use rher_core::config::{BatchMode, Method, TargetEvery, TrainConfig};
use rher_core::env::Env as _;
use rher_core::episode::{Episode, rollout};
use rher_core::evaluate::{Evaluation, evaluate};
use rher_core::event::{Metrics, Seconds, SourceShares};
use rher_core::explore::{ActionSource, Curriculum, Explorer};
use rher_core::goal::Stage;
use rher_core::input::InputEncoder;
use rher_core::learner::engine::Losses;
use rher_core::learner::engines::build;
use rher_core::learner::state::LearnerState;
use rher_core::normal::StandardNormal;
use rher_core::policy::{Policy, PolicyInfo};
use rher_core::relabel::Relabeler;
use rher_core::replay::Replay;
use rher_core::seed::{Purpose, Seed};
use rher_core::train::Trainer;
use std::sync::atomic::AtomicBool;

/// Eq. 10: random actions are kept for a while, and all others get noise.
fn explore(
    config: &TrainConfig,
    policy: &Policy,
    curriculum: &Curriculum,
    number: u64,
) -> (Episode<2>, Vec<ActionSource>) {
    let mut env = Magnet::<2>::new();
    let spec = env.spec().clone();
    let explorer = Explorer::<2>::new(config, spec.subtasks, curriculum);
    let seed = Seed(config.seed);
    let mut rng = seed.stream(Purpose::Exploration, number);
    let mut actor = policy.actor(env.spec()).unwrap();
    let mut kept: Option<Vec<f32>> = None;
    let mut sources = Vec::new();
    let env_seed = seed.episode(Purpose::Environment, number);
    let episode = rollout(&mut env, env_seed, |view, action| {
        // Training asks for a share of the tolerances, and so do the stages in it.
        let tolerances = config.relay.tolerances(&spec);
        let reach = config.relay.reach_distance;
        let stage = Stage::of(view.achieved, view.desired, &tolerances, reach);
        if let Some(kept) = &kept
            && explorer.keeps_random(&mut rng)
        {
            action.copy_from_slice(kept);
            sources.push(ActionSource::Random);
            return Ok(());
        }
        let selection = explorer.draw(stage, &mut rng);
        sources.push(selection.source);
        if selection.source == ActionSource::Random {
            action.fill_with(|| rng.random_range(-1.0..=1.0));
            kept = Some(action.to_vec());
            return Ok(());
        }
        kept = None;
        actor.act(selection.stage, view.observation, view.achieved, view.desired, action)?;
        for number in action {
            let draw: f32 = rng.sample(StandardNormal);
            *number = (*number + explorer.noise(selection.stage) * draw).clamp(-1.0, 1.0);
        }
        Ok(())
    });
    (episode.unwrap(), sources)
}

/// What happened since the last evaluation.
#[derive(Default)]
struct Since {
    played: Vec<(Episode<2>, Vec<ActionSource>)>,
    losses: Vec<Losses>,
    /// For each sub-task and batch, whether every reward was the same.
    single_reward: [Vec<bool>; 4],
}

fn mean(values: impl Iterator<Item = f64> + Clone) -> f32 {
    let count = values.clone().count();
    if count == 0 { 0.0 } else { (values.sum::<f64>() / count as f64) as f32 }
}

fn share(values: impl Iterator<Item = bool> + Clone) -> f32 {
    mean(values.map(|it| if it { 1.0 } else { 0.0 }))
}

impl Since {
    fn metrics(
        &self,
        [env_steps, episodes, updates]: [u64; 3],
        guide: usize,
        found: &Evaluation,
    ) -> Metrics {
        let episode = || self.played.iter().map(|(episode, _)| episode);
        let source = |source| {
            share(self.played.iter().flat_map(|(_, sources)| sources).map(move |it| *it == source))
        };
        let solved = |episode: &Episode<2>| {
            let end = episode.achieved[episode.achieved.len() - 1].0.objects;
            (0..2).all(|it| nalgebra::distance(&end[it], &episode.desired.objects()[it]) <= 0.07)
        };
        let moved = |episode: &Episode<2>, object: usize| {
            let place = |step: usize| episode.achieved[step].0.objects[object];
            (0..episode.achieved.len()).any(|it| nalgebra::distance(&place(0), &place(it)) > 0.01)
        };
        let losses = || self.losses.iter();
        let q = |pick: fn(f32, f32) -> f32, of: fn(&Losses) -> f32| {
            losses().map(of).reduce(pick).unwrap_or(0.0)
        };
        Metrics {
            env_steps,
            episodes,
            updates,
            wall_s: 0.0,
            success: found.success.clone(),
            success_final: found.success_final,
            guide: guide + 1,
            final_distance: found.final_distance,
            train_success: share(episode().map(solved)),
            acted: SourceShares {
                guide: source(ActionSource::Guide),
                learner: source(ActionSource::Learner),
                random: source(ActionSource::Random),
            },
            moved: (0..2).map(|object| share(episode().map(|it| moved(it, object)))).collect(),
            single_reward: self
                .single_reward
                .iter()
                .map(|batches| (!batches.is_empty()).then(|| share(batches.iter().copied())))
                .collect(),
            critic_loss: mean(losses().map(|it| f64::from(it.critic))),
            actor_loss: mean(losses().filter_map(|it| it.actor).map(f64::from)),
            q_mean: mean(losses().map(|it| f64::from(it.q_mean))),
            q_min: q(f32::min, |it| it.q_min),
            q_max: q(f32::max, |it| it.q_max),
            critic_gradient: mean(losses().map(|it| f64::from(it.critic_gradient))),
            actor_gradient: mean(losses().filter_map(|it| it.actor_gradient).map(f64::from)),
            time: Seconds::default(),
        }
    }
}

/// A whole run: the policy that it ends with, and the line of every evaluation.
fn spelled_out(config: &TrainConfig) -> (Policy, Vec<Metrics>) {
    let spec = Magnet::<2>::new().spec().clone();
    let untrained = if config.relay.method == Method::Her { spec.subtasks - 1 } else { 0 };
    let stages: Vec<Stage<2>> = Stage::all().skip(untrained).collect();
    let info = PolicyInfo {
        task: spec.name.clone(),
        variant: spec.variant.clone(),
        objects: 2,
        subtasks: spec.subtasks,
        untrained,
        obs_dim: spec.obs_dim,
        action_dim: spec.action_dim,
        reach_distance: config.relay.reach_distance,
    };
    let seed = Seed(config.seed);
    let mut encoder = InputEncoder::new(&config.relay, &spec);
    let (input_dim, action_dim) = (encoder.width(), spec.action_dim);
    let mut rng = seed.stream(Purpose::Init, 0);
    let learner = LearnerState::new(&config.agent, input_dim, action_dim, &mut rng);
    let shape = learner.actor.shape.clone();
    let mut engine = build(&config.agent, learner).unwrap();
    let mut relabeler = Relabeler::new(&config.relay, &spec);
    let mut replay = Replay::new(&spec, config.replay.capacity);
    let mut curriculum = Curriculum::new(&config.exploration, spec.subtasks);
    let policy_of = |encoder: &InputEncoder, actor| {
        Policy::new(info.clone(), encoder.clone(), shape.clone(), actor)
    };
    let mut explorer = policy_of(&encoder, engine.actor());
    let mut policy = policy_of(&encoder, engine.target_actor());
    let (mut episodes, mut updates, mut lines) = (0, 0, Vec::new());
    let mut since = Since::default();
    let envs = config.envs as u64;
    while episodes * (spec.episode_steps as u64) < config.env_steps {
        // Episodes that are played side by side are played by the same policy.
        let played: Vec<_> =
            (0..envs).map(|env| explore(config, &explorer, &curriculum, episodes + env)).collect();
        for (episode, _) in &played {
            let mut rng = seed.stream(Purpose::Statistics, episodes);
            relabeler.observe(episode, &stages, &mut encoder, &mut rng);
            replay.push(episode);
            episodes += 1;
        }
        since.played.extend(played);
        if episodes > config.replay.warmup_episodes {
            let together: Vec<&[Stage<2>]> = match config.replay.batch_mode {
                BatchMode::Joint => vec![&stages[..]],
                BatchMode::Separate => stages.chunks(1).collect(),
            };
            for _ in 0..envs * config.replay.updates_per_episode as u64 {
                for stages in &together {
                    let size = config.replay.batch_size;
                    let mut batch = Batch::zeros(size * stages.len(), input_dim, action_dim);
                    let mut rng = seed.stream(Purpose::Batch, updates);
                    // Some rows go to the sub-tasks by how often they fail, the others evenly.
                    let failing = |it: &Stage<2>| 1.0 - curriculum.rate(it.index());
                    let failures: f32 = stages.iter().map(failing).sum();
                    let focus = config.replay.focus;
                    let (mut share, mut start) = (0.0, 0);
                    for stage in *stages {
                        let even = (1.0 - focus) / stages.len() as f32;
                        share += even + focus * failing(stage) / failures;
                        let end = (share * batch.rows() as f32).round() as usize;
                        let rows = start..end;
                        relabeler.draw(&replay, &encoder, *stage, &mut batch, rows, &mut rng);
                        let rewards = &batch.rewards[start..end];
                        let same = rewards.iter().all(|reward| *reward == rewards[0]);
                        since.single_reward[stage.index()].push(same);
                        start = end;
                    }
                    let mut noise = vec![0.0; batch.rows() * action_dim];
                    noise.fill_with(|| rng.sample(StandardNormal));
                    since.losses.push(engine.update(&batch, &noise).unwrap());
                    updates += 1;
                }
            }
            if config.agent.target_every == TargetEvery::Episode {
                engine.move_targets();
            }
            explorer = policy_of(&encoder, engine.actor());
            policy = policy_of(&encoder, engine.target_actor());
        }
        if episodes.is_multiple_of(config.evaluation.every_episodes) {
            let test_policy = config.exploration.test_policy;
            let found =
                evaluate(&mut [Magnet::<2>::new()], &policy, &config.evaluation, test_policy);
            let found = found.unwrap();
            curriculum.record(&found.success);
            let counts = [episodes * spec.episode_steps as u64, episodes, updates];
            lines.push(since.metrics(counts, curriculum.guide(), &found));
            since = Since::default();
        }
    }
    (policy, lines)
}

#[test]
fn a_run_is_its_loop_spelled_out() {
    let mut config = small("magnet", 2);
    config.agent.hidden = vec![8];
    config.agent.critics = 2;
    config.agent.policy_delay = 2;
    config.agent.target_noise = 0.2;
    config.relay.tolerance = 0.5;
    config.relay.reach_distance = 0.09;
    config.exploration.random_steps = 3.0;
    config.exploration.adjust_to_success = true;
    config.exploration.success_threshold = 0.2;
    config.exploration.window = 2;
    config.replay.focus = 0.5;
    config.replay.batch_size = 8;
    config.replay.updates_per_episode = 3;
    config.replay.warmup_episodes = 4;
    // Few enough that the oldest make room.
    config.replay.capacity = 10 * 25;
    config.evaluation.every_episodes = 6;
    config.evaluation.episodes = 4;
    config.evaluation.subtask_episodes = 5;
    config.env_steps = 18 * 25;
    for (batch_mode, target_every, method, envs) in [
        (BatchMode::Joint, TargetEvery::Update, Method::Rher, 1),
        (BatchMode::Separate, TargetEvery::Episode, Method::Rher, 3),
        (BatchMode::Joint, TargetEvery::Episode, Method::Her, 2),
    ] {
        let mut config = config.clone();
        (config.replay.batch_mode, config.agent.target_every) = (batch_mode, target_every);
        (config.relay.method, config.envs) = (method, envs);
        let (policy, expected) = spelled_out(&config);
        let worlds = (0..envs).map(|_| Magnet::<2>::new()).collect();
        let mut lines = Lines::default();
        let mut trainer = Trainer::new(config, worlds, 1).unwrap();
        trainer.run(None, &mut lines, &AtomicBool::new(false)).unwrap();
        let timeless = |line| Metrics { wall_s: 0.0, time: Seconds::default(), ..line };
        let lines: Vec<Metrics> = lines.0.into_iter().map(timeless).collect();
        assert_eq!(lines, expected);
        assert!(
            *trainer.policy() == policy.of_run(trainer.id()),
            "{batch_mode:?}, targets with every {target_every:?}, {method:?}, {envs} environments"
        );
    }
}
