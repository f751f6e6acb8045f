//! Computes a part and takes its hash.

use crate::hash::{Bits, tensors};
use crate::part::Part;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rher_core::batch::Batch;
use rher_core::config::{AgentConfig, EngineKind, Precision, Preset, TrainConfig};
use rher_core::env::EnvSpec;
use rher_core::episode::{Episode, RolloutError, rollout};
use rher_core::event::Event;
use rher_core::goal::{EncodedGoal, Stage};
use rher_core::input::InputEncoder;
use rher_core::learner::engine::NotFinite;
use rher_core::learner::engines::{self, EngineError};
use rher_core::learner::infer::Inference;
use rher_core::learner::state::LearnerState;
use rher_core::normal::StandardNormal;
use rher_core::relabel::Relabeler;
use rher_core::replay::Replay;
use rher_core::{TrainError, Trainer};
use rher_envs::{EnvVisitor, Simulated, Task};
use std::sync::atomic::AtomicBool;

/// Episodes whose actions are drawn.
const EPISODES: u64 = 4;
/// Steps for which a drawn action is kept.
const KEPT: usize = 5;
/// Rows of a batch for each sub-task: no whole number of vectors or tiles.
const ROWS: usize = 50;
/// Widths of the hidden layers: no whole numbers of vectors.
const HIDDEN: [usize; 2] = [50, 33];
/// Updates of a learner.
const UPDATES: usize = 200;

/// A part could not be computed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeasureError {
    /// An episode could not be played.
    #[error(transparent)]
    Rollout(#[from] RolloutError),
    /// There is no learner for this machine.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// An update failed.
    #[error(transparent)]
    NotFinite(#[from] NotFinite),
    /// The run failed.
    #[error(transparent)]
    Train(#[from] TrainError),
}

/// The hash of a part of a task: 16 hexadecimal digits.
///
/// With the instructions that `RHER_SIMD` chooses; takes seconds, also with plain loops.
///
/// # Errors
///
/// When this machine cannot compute the part.
pub fn measure(task: Task, part: Part) -> Result<String, MeasureError> {
    task.visit(Measure { task, part })
}

struct Measure {
    task: Task,
    part: Part,
}

impl EnvVisitor for Measure {
    type Output = Result<String, MeasureError>;

    fn visit<const N: usize, E: Simulated<N>>(
        self,
        build: impl Fn() -> E + Sync,
    ) -> Result<String, MeasureError> {
        let mut env = build();
        let spec = env.spec().clone();
        let config = config(self.task);
        if self.part == Part::Run {
            return run(config, env);
        }
        let mut bits = Bits::default();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let episodes = play(&mut env, &mut rng)?;
        if self.part == Part::Physics {
            for Episode { observations, achieved, .. } in &episodes {
                bits.numbers(observations.iter().copied());
                let places = achieved.iter().flat_map(|now| now.0.places());
                bits.numbers(places.flat_map(|place| [place.x, place.y, place.z]));
            }
            return Ok(bits.hash());
        }
        let (mut relabeling, mut batch) = Relabeling::new(&config, &spec, &episodes);
        match self.part {
            Part::Physics | Part::Run => unreachable!("returned above"),
            Part::Relabeling => {
                relabeling.draw(&mut batch, &mut rng);
                let Batch { inputs, next_inputs, simpler_inputs, rewards, actions, .. } = &batch;
                for numbers in [inputs, next_inputs, simpler_inputs, rewards, actions] {
                    bits.numbers(numbers.iter().copied());
                }
            }
            Part::Acting => {
                relabeling.draw(&mut batch, &mut rng);
                let state = learner(&config.agent, &batch, &mut rng);
                let mut actions = vec![0.0; batch.actions.len()];
                Inference::new(&state.actor.shape).act(
                    &state.actor.online,
                    &batch.inputs,
                    &mut actions,
                );
                bits.numbers(actions);
            }
            Part::Update | Part::UpdateBf16 => {
                let precision = match self.part {
                    Part::UpdateBf16 => Precision::Bf16,
                    _ => Precision::F32,
                };
                let agent = AgentConfig { precision, ..config.agent };
                let mut engine = engines::build(&agent, learner(&agent, &batch, &mut rng))?;
                let mut noise = vec![0.0; batch.actions.len()];
                for _ in 0..UPDATES {
                    relabeling.draw(&mut batch, &mut rng);
                    noise.fill_with(|| rng.sample(StandardNormal));
                    engine.update(&batch, &noise)?;
                }
                bits.learner(&engine.state());
            }
        }
        Ok(bits.hash())
    }
}

/// The preset `fast` with small networks, so that plain loops and emulators take seconds, too.
fn config(task: Task) -> TrainConfig {
    let mut config = Preset::Fast.config(task.name(), task.objects());
    config.agent.engine = EngineKind::Fused;
    config.agent.hidden = HIDDEN.to_vec();
    config.env_steps = 300;
    config.until = 0.0;
    config.replay.batch_size = ROWS;
    config.replay.updates_per_episode = 5;
    config.evaluation.every_episodes = 3;
    config.evaluation.episodes = 4;
    config.evaluation.subtask_episodes = 1;
    config
}

/// Episodes with drawn actions.
fn play<const N: usize>(
    env: &mut impl Simulated<N>,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Episode<N>>, RolloutError> {
    (0..EPISODES)
        .map(|seed| {
            let mut kept = vec![0.0; env.spec().action_dim];
            let mut step = 0;
            rollout(env, seed, |_, action| {
                if step % KEPT == 0 {
                    kept.fill_with(|| rng.random_range(-1.0..=1.0));
                }
                step += 1;
                action.copy_from_slice(&kept);
                Ok(())
            })
        })
        .collect()
}

/// What draws batches of episodes.
struct Relabeling<const N: usize> {
    replay: Replay<N>,
    encoder: InputEncoder,
    relabeler: Relabeler<N>,
    stages: Vec<Stage<N>>,
}

impl<const N: usize> Relabeling<N> {
    fn new(config: &TrainConfig, spec: &EnvSpec<N>, episodes: &[Episode<N>]) -> (Self, Batch) {
        let stages: Vec<_> = Stage::all().take(spec.subtasks).collect();
        let mut replay = Replay::new(spec, episodes.len() * spec.episode_steps);
        let mut encoder = InputEncoder::new(&config.relay, spec);
        for episode in episodes {
            replay.push(episode);
            let frames = episode.observations.chunks_exact(spec.obs_dim).zip(&episode.achieved);
            for (observation, now) in frames {
                encoder.observe(observation);
                for &stage in &stages {
                    encoder.observe_goal(now, &EncodedGoal::new(stage, now, &episode.desired));
                }
            }
        }
        encoder.refresh();
        let batch = Batch::zeros(ROWS * stages.len(), encoder.width(), spec.action_dim);
        let relabeler = Relabeler::new(&config.relay, spec);
        (Self { replay, encoder, relabeler, stages }, batch)
    }

    fn draw(&mut self, batch: &mut Batch, rng: &mut ChaCha8Rng) {
        let Self { replay, encoder, relabeler, stages } = self;
        for (index, &stage) in stages.iter().enumerate() {
            let rows = ROWS * index..ROWS * (index + 1);
            relabeler.draw(replay, encoder, stage, batch, rows, rng);
        }
    }
}

fn learner(agent: &AgentConfig, batch: &Batch, rng: &mut ChaCha8Rng) -> LearnerState {
    LearnerState::new(agent, batch.input_dim, batch.action_dim, rng)
}

fn run<const N: usize>(
    config: TrainConfig,
    env: impl Simulated<N>,
) -> Result<String, MeasureError> {
    let mut trainer = Trainer::new(config, vec![env], 1)?;
    trainer.run(None, &mut |_: &Event| Ok(()), &AtomicBool::new(false))?;
    Ok(tensors(&trainer.policy().to_bytes()).expect("a policy is a policy file"))
}
