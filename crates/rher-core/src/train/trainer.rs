//! The loop: explore, store, relabel, update, evaluate, and repeat.

use super::checkpoint::{self, CheckpointError};
use super::error::{Finish, TrainError};
use super::identity::run_id;
use super::memory;
use super::play::{Played, explore_once};
use super::pretrained::Pretrained;
use super::rows::SubtaskBatch;
use super::state::{Pending, RunState};
use super::tally::{SourceCounts, Tally};
use crate::batch::Batch;
use crate::config::{
    AgentConfig, BatchMode, Deployed, EngineKind, Method, Precision, ReplayConfig, TargetEvery,
    TrainConfig,
};
use crate::env::{Env, EnvSpec};
use crate::episode::Episode;
use crate::evaluate::{Evaluation, evaluate_until};
use crate::event::{Event, Observer, Progress, Seconds};
use crate::explore::{ActionLog, Curriculum, Decision, Explorer, Selection};
use crate::files::FileError;
use crate::goal::{EncodedGoal, Stage};
use crate::input::{Attempt, InputEncoder, OrderModel};
use crate::learner::engine::Engine;
use crate::learner::engines;
use crate::learner::network::Shape;
use crate::learner::state::LearnerState;
use crate::normal::StandardNormal;
use crate::policy::{Critic, Policy, PolicyInfo, RunId};
use crate::relabel::Relabeler;
use crate::replay::Replay;
use crate::seed::{Purpose, Seed};
use rand::RngExt as _;
use rayon::prelude::*;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Latest episodes that tell which order of the objects succeeds: as many as the weights need, and
/// few enough to be of the policy as it is.
const ORDER_EPISODES: usize = 2000;

/// A run of relay hindsight experience replay.
///
/// ```
/// use rher_core::testing::Carry;
/// use rher_core::{Event, Preset, Trainer};
/// use std::sync::atomic::AtomicBool;
///
/// let mut config = Preset::Fast.config("carry", 1);
/// config.env_steps = 40;
/// config.agent.hidden = vec![16];
/// config.replay.updates_per_episode = 2;
/// let mut trainer = Trainer::new(config, vec![Carry::new()], 1)?;
/// let mut print = |event: &Event| {
///     if let Event::Evaluated(metrics) = event {
///         println!("{} steps: success {}", metrics.env_steps, metrics.success_final);
///     }
///     Ok(())
/// };
/// trainer.run(None, &mut print, &AtomicBool::new(false))?;
/// assert_eq!(trainer.progress().env_steps, 40);
/// # Ok::<(), rher_core::TrainError>(())
/// ```
pub struct Trainer<const N: usize, E> {
    state: RunState,
    id: RunId,
    envs: Vec<E>,
    pool: rayon::ThreadPool,
    stages: Vec<Stage<N>>,
    replay: Replay<N>,
    /// Episodes that are on disk.
    saved_episodes: u64,
    relabeler: Relabeler<N>,
    batches: Vec<SubtaskBatch<N>>,
    noise: Vec<f32>,
    engine: Box<dyn Engine>,
    actor_shape: Shape,
    critic_shape: Shape,
    /// What plays training episodes.
    explorer: Policy,
    /// What is evaluated and saved.
    policy: Policy,
}

impl<const N: usize, E: Env<N>> Trainer<N, E> {
    /// A new run.
    ///
    /// `envs` are equal and at least as many as `config.envs`; evaluations use all of them, so
    /// more of them let more of the `workers` threads help. No result depends on either.
    pub fn new(config: TrainConfig, envs: Vec<E>, workers: usize) -> Result<Self, TrainError> {
        Self::begin(config, envs, workers, None)
    }

    /// A new run that starts with the networks of another one, and with its statistics of what is
    /// observed; all else is as in a new run. That run becomes part of the identity of this one.
    ///
    /// # Errors
    ///
    /// If the two do not fit each other, besides those of [`Trainer::new`].
    pub fn new_from(
        pretrained: &Pretrained,
        config: TrainConfig,
        envs: Vec<E>,
        workers: usize,
    ) -> Result<Self, TrainError> {
        Self::begin(config, envs, workers, Some(pretrained))
    }

    fn begin(
        mut config: TrainConfig,
        envs: Vec<E>,
        workers: usize,
        pretrained: Option<&Pretrained>,
    ) -> Result<Self, TrainError> {
        config.validate()?;
        config.from = pretrained.map(Pretrained::origin);
        check_envs(&envs, &config)?;
        let spec = envs[0].spec();
        memory::check(&config, spec)?;
        let info = PolicyInfo {
            task: spec.name.clone(),
            variant: spec.variant.clone(),
            objects: N,
            subtasks: spec.subtasks,
            untrained: match config.relay.method {
                Method::Rher => 0,
                Method::Her => spec.subtasks - 1,
            },
            obs_dim: spec.obs_dim,
            action_dim: spec.action_dim,
            reach_distance: config.relay.reach_distance,
        };
        let mut encoder = InputEncoder::new(&config.relay, spec);
        let learner = if let Some(pretrained) = pretrained {
            pretrained.hand_over(&config, spec, &mut encoder)?
        } else {
            let mut rng = Seed(config.seed).stream(Purpose::Init, 0);
            LearnerState::new(&config.agent, encoder.width(), spec.action_dim, &mut rng)
        };
        let state = RunState {
            env_steps: 0,
            episodes: 0,
            updates: 0,
            evaluations: 0,
            last_success: [0.0; 2],
            curriculum: Curriculum::new(&config.exploration, spec.subtasks),
            tally: Tally::new(spec.subtasks, N),
            wall_s: 0.0,
            seconds: Seconds::default(),
            pending: Pending::Nothing,
            encoder,
            info,
            config,
        };
        let replay = Replay::new(spec, state.config.replay.capacity);
        Self::assemble(state, learner, replay, envs, workers)
    }

    /// Goes on with the run whose folder is `folder`, from its last checkpoint.
    ///
    /// What follows is what would have followed had it never stopped.
    pub fn resume(folder: &Path, envs: Vec<E>, workers: usize) -> Result<Self, TrainError> {
        let (state, learner) = checkpoint::read_state(folder)?;
        Self::restore(folder, state, learner, envs, workers)
    }

    /// Resumes the run whose folder is `folder` with another arithmetic than it had, where one is
    /// given.
    ///
    /// What follows differs from what would have followed by rounding alone, to 16 bits where the
    /// precision is [`Precision::Bf16`].
    ///
    /// # Errors
    ///
    /// Also when the engine does not have the precision.
    pub fn resume_on(
        engine: Option<EngineKind>,
        precision: Option<Precision>,
        folder: &Path,
        envs: Vec<E>,
        workers: usize,
    ) -> Result<Self, TrainError> {
        let (mut state, learner) = checkpoint::read_state(folder)?;
        let agent = &mut state.config.agent;
        agent.engine = engine.unwrap_or(agent.engine);
        agent.precision = precision.unwrap_or(agent.precision);
        state.config.validate()?;
        Self::restore(folder, state, learner, envs, workers)
    }

    fn restore(
        folder: &Path,
        state: RunState,
        learner: LearnerState,
        envs: Vec<E>,
        workers: usize,
    ) -> Result<Self, TrainError> {
        check_envs(&envs, &state.config)?;
        let spec = envs[0].spec();
        memory::check(&state.config, spec)?;
        let replay = checkpoint::read_replay(folder, &state, spec)?;
        Self::assemble(state, learner, replay, envs, workers)
    }

    fn assemble(
        state: RunState,
        learner: LearnerState,
        replay: Replay<N>,
        envs: Vec<E>,
        workers: usize,
    ) -> Result<Self, TrainError> {
        let spec = envs[0].spec().clone();
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(workers)
            .build()
            .map_err(|source| TrainError::Threads { workers, source: source.into() })?;
        let RunState { config, info, encoder, .. } = &state;
        let stages: Vec<Stage<N>> = Stage::all().take(info.subtasks).skip(info.untrained).collect();
        let rows = config.replay.batch_size;
        let subtask_batch = |stages: Vec<Stage<N>>| SubtaskBatch {
            batch: Batch::zeros(rows * stages.len(), encoder.width(), info.action_dim),
            stages,
        };
        let batches = match config.replay.batch_mode {
            BatchMode::Joint => vec![subtask_batch(stages.clone())],
            BatchMode::Separate => stages.iter().map(|&stage| subtask_batch(vec![stage])).collect(),
        };
        let relabeler = Relabeler::new(&config.relay, &spec);
        let noise = vec![0.0; rows * stages.len() * info.action_dim];
        let actor_shape = learner.actor.shape.clone();
        let critic_shape = learner.critics[0].shape.clone();
        let engine = engines::build(&state.config.agent, learner)?;
        let id = run_id(&state.config, &state.info.variant);
        let [explorer, policy] = policies(&state, &actor_shape, &*engine, id);
        let policy = policy.of_env(&spec);
        let saved_episodes = replay.pushed();
        Ok(Self {
            state,
            id,
            envs,
            pool,
            stages,
            replay,
            saved_episodes,
            relabeler,
            batches,
            noise,
            engine,
            actor_shape,
            critic_shape,
            explorer,
            policy,
        })
    }

    /// Settings of the run.
    pub fn config(&self) -> &TrainConfig {
        &self.state.config
    }

    /// Changes how many environment steps the run takes.
    pub fn set_env_steps(&mut self, env_steps: u64) {
        self.state.config.env_steps = env_steps;
    }

    /// Changes the success rate that ends the run.
    pub fn set_until(&mut self, until: f32) {
        self.state.config.until = until;
    }

    /// Widths and limits of its environments.
    pub fn spec(&self) -> &EnvSpec<N> {
        self.envs[0].spec()
    }

    /// Identity of the run, which is in every file of it.
    pub fn id(&self) -> RunId {
        self.id
    }

    /// How far the run is.
    pub fn progress(&self) -> Progress {
        Progress {
            env_steps: self.state.env_steps,
            episodes: self.state.episodes,
            updates: self.state.updates,
        }
    }

    /// Evaluations made so far.
    pub fn evaluations(&self) -> u64 {
        self.state.evaluations
    }

    /// The policy as it is now.
    pub fn policy(&self) -> &Policy {
        &self.policy
    }

    /// Whether and why the run is at its end.
    pub fn finished(&self) -> Option<Finish> {
        let config = &self.state.config;
        if self.state.pending != Pending::Nothing {
            None
        } else if config.is_solved(self.state.last_success) {
            Some(Finish::Solved)
        } else {
            (self.state.env_steps >= config.env_steps).then_some(Finish::StepsSpent)
        }
    }

    /// Trains until the run is at its end, or until `stop` is set.
    ///
    /// With a `folder`, which is made if it is not there yet, a checkpoint and the policy are written there before the first step, at
    /// every evaluation, and when stopped. Stopping waits for the end of an episode or an update,
    /// whichever is under way; what is left undone by it follows when the run goes on. A policy there
    /// that is not that of the checkpoint, because a stop fell between the two, is written again.
    pub fn run(
        &mut self,
        folder: Option<&Path>,
        observer: &mut dyn Observer,
        stop: &AtomicBool,
    ) -> Result<Finish, TrainError> {
        if self.state.episodes == 0 {
            if let Some(folder) = folder {
                let made = std::fs::create_dir_all(folder).map_err(FileError::write(folder));
                made.map_err(CheckpointError::from)?;
            }
            self.save_to(folder, observer)?;
        } else if let Some(folder) = folder {
            self.renew_policy(folder)?;
        }
        loop {
            if let Some(finish) = self.finished() {
                return Ok(finish);
            }
            if stop.load(Ordering::Relaxed) {
                self.save_to(folder, observer)?;
                return Ok(Finish::Stopped);
            }
            let started = Instant::now();
            let went_on = self.go_on(observer, stop);
            if matches!(went_on, Err(TrainError::NotFinite { .. })) {
                self.save_to(folder, observer)?;
            }
            let went_on = went_on?;
            self.state.wall_s += started.elapsed().as_secs_f64();
            if matches!(went_on, Iteration::Stopped) {
                continue;
            }
            observer.on(&Event::Progress(self.progress()))?;
            if let Iteration::Evaluated(evaluation) = went_on {
                self.record(&evaluation, observer)?;
                self.save_to(folder, observer)?;
            }
        }
    }

    /// Episodes, updates and, if it is due, an evaluation, or what is left of them.
    fn go_on(
        &mut self,
        observer: &mut dyn Observer,
        stop: &AtomicBool,
    ) -> Result<Iteration, TrainError> {
        let pending = std::mem::take(&mut self.state.pending);
        if pending == Pending::Nothing && !self.explore(observer, stop)? {
            return Ok(Iteration::Stopped);
        }
        if pending != Pending::Evaluation {
            let done = if let Pending::Updates { done } = pending { done } else { 0 };
            if let Some(undone) = self.learn(done, stop)? {
                self.state.pending = undone;
                return Ok(Iteration::Stopped);
            }
            if !self.evaluation_is_due() {
                return Ok(Iteration::Learned);
            }
        }
        // It is still to be made if an environment fails in it.
        self.state.pending = Pending::Evaluation;
        let Some(evaluation) = self.evaluate(stop)? else { return Ok(Iteration::Stopped) };
        self.state.pending = Pending::Nothing;
        Ok(Iteration::Evaluated(evaluation))
    }

    /// Plays one episode in every environment, and stores them; whether it was not stopped before.
    fn explore(
        &mut self,
        observer: &mut dyn Observer,
        stop: &AtomicBool,
    ) -> Result<bool, TrainError> {
        let started = Instant::now();
        let RunState { config, info, curriculum, episodes, .. } = &self.state;
        let seed = Seed(config.seed);
        let count = config.envs;
        let guide = Explorer::new(config, info.subtasks, curriculum);
        let tolerances = config.relay.tolerances(self.envs[0].spec());
        let explorer = &self.explorer;
        let envs = &mut self.envs[..count];
        let played = self.pool.install(|| {
            envs.par_iter_mut()
                .enumerate()
                .map(|(index, env)| {
                    let episode = episodes + index as u64;
                    if stop.load(Ordering::Relaxed) {
                        return Ok(None);
                    }
                    explore_once(env, explorer, &guide, &tolerances, seed, episode)
                        .map(Some)
                        .map_err(|source| TrainError::Rollout { episode, source })
                })
                .collect::<Result<Vec<_>, _>>()
        })?;
        let Some(played) = played.into_iter().collect::<Option<Vec<_>>>() else {
            return Ok(false);
        };
        let storing = Instant::now();
        let spec = self.envs[0].spec();
        let (tolerances, last_stage) = (spec.tolerances, spec.last_stage());
        let (mut acting, mut playing) = (Duration::ZERO, Duration::ZERO);
        for Played { seed: env_seed, episode, choices, acting: of_actor, playing: of_all } in played
        {
            acting += of_actor;
            playing += of_all;
            if observer.wants(self.state.episodes) {
                let script = self.script(env_seed, &episode, &choices);
                observer.on(&Event::Explored(Box::new(script)))?;
            }
            let mut actors = SourceCounts::default();
            for choice in &choices {
                actors.count(choice.source);
            }
            self.state.tally.episode(&episode, actors, last_stage, &tolerances);
            let mut rng = seed.stream(Purpose::Statistics, self.state.episodes);
            let encoder = &mut self.state.encoder;
            self.relabeler.observe(&episode, &self.stages, encoder, &mut rng);
            self.replay.push(&episode);
            self.state.episodes += 1;
            self.state.env_steps += episode.steps() as u64;
        }
        // Episodes are played side by side: the wall clock is shared out as their own time is.
        let inference = acting.div_duration_f64(playing) * (storing - started).as_secs_f64();
        let seconds = &mut self.state.seconds;
        seconds.inference += inference;
        seconds.environment += (storing - started).as_secs_f64() - inference;
        seconds.relabel += storing.elapsed().as_secs_f64();
        Ok(true)
    }

    /// The next training episode for those who look on.
    fn script(&mut self, seed: u64, episode: &Episode<N>, choices: &[Selection<N>]) -> ActionLog {
        let encoder = self.policy.encoder().clone();
        let critic = Critic::new(encoder, self.critic_shape.clone(), self.engine.critic());
        let stages: Vec<Stage<N>> = choices.iter().map(|choice| choice.stage).collect();
        let values = critic.values(episode, &stages);
        let decisions = choices.iter().zip(values).map(|(choice, value)| Decision {
            source: choice.source,
            subtask: choice.stage.index(),
            value: Some(value),
        });
        ActionLog {
            number: self.state.episodes,
            seed,
            actions: episode.actions.clone(),
            decisions: decisions.collect(),
        }
    }

    /// Makes the updates that belong to the last episodes, of which `done` were made before; says what
    /// is left if it was stopped within.
    fn learn(&mut self, done: u64, stop: &AtomicBool) -> Result<Option<Pending>, TrainError> {
        let Self { state, pool, replay, relabeler, batches, noise, engine, .. } = self;
        let TrainConfig {
            seed,
            replay: ReplayConfig { updates_per_episode, warmup_episodes, focus, .. },
            agent,
            envs,
            ..
        } = &state.config;
        let seed = *seed;
        let AgentConfig { target_noise, target_every, .. } = *agent;
        if state.episodes <= *warmup_episodes {
            return Ok(None);
        }
        let rows = |batch: &SubtaskBatch<N>| batch.rows(*focus, &state.curriculum);
        let rows: Vec<Vec<Range<usize>>> = batches.iter().map(rows).collect();
        // As many in all as belong to the steps in all: an episode that ends early has fewer.
        let due = |env_steps: u64| {
            env_steps * *updates_per_episode as u64 / self.envs[0].spec().episode_steps as u64
        };
        let before = state.env_steps - replay.newest_steps(*envs) as u64;
        let all = (due(state.env_steps) - due(before)) * batches.len() as u64;
        // All of it inside the pool: entering it anew for every update would wait each time until
        // a busy machine lets the pool's thread on.
        let done = pool.install(|| {
            for done in done..all {
                if stop.load(Ordering::Relaxed) {
                    return Ok(done);
                }
                let turn = (done % batches.len() as u64) as usize;
                let (SubtaskBatch { stages, batch }, rows) = (&mut batches[turn], &rows[turn]);
                let drawing = Instant::now();
                let update = state.updates;
                let mut rng = Seed(seed).stream(Purpose::Batch, update);
                for (&stage, rows) in stages.iter().zip(rows) {
                    let encoder = &state.encoder;
                    let rewarded =
                        relabeler.draw(replay, encoder, stage, batch, rows.clone(), &mut rng);
                    state.tally.batch(stage, rewarded, rows.len());
                }
                let noise = &mut noise[..batch.rows() * batch.action_dim];
                if target_noise > 0.0 {
                    noise.fill_with(|| rng.sample(StandardNormal));
                }
                let updating = Instant::now();
                let env_steps = state.env_steps;
                let not_finite = |source| TrainError::NotFinite { update, env_steps, seed, source };
                let losses = engine.update(batch, noise).map_err(not_finite)?;
                state.updates += 1;
                state.tally.update(&losses);
                state.seconds.relabel += (updating - drawing).as_secs_f64();
                state.seconds.update += updating.elapsed().as_secs_f64();
            }
            Ok::<_, TrainError>(all)
        })?;
        let is_over = done >= all;
        if is_over && target_every == TargetEvery::Episode {
            self.engine.move_targets();
        }
        self.renew_policies();
        Ok((!is_over).then_some(Pending::Updates { done }))
    }

    fn evaluation_is_due(&self) -> bool {
        let RunState { config, env_steps, episodes: now, .. } = &self.state;
        let every = config.evaluation.every_episodes;
        let before = now - config.envs as u64;
        now / every > before / every || *env_steps >= config.env_steps
    }

    /// Learns from the latest episodes which order of the objects to choose.
    fn learn_order(&mut self) {
        let spec = self.envs[0].spec();
        if !self.state.config.relay.choose_order || !OrderModel::applies(spec) {
            return;
        }
        let latest = self.replay.newest_ends(self.replay.episodes().min(ORDER_EPISODES));
        let attempts = latest.map(|([start, end], desired)| Attempt {
            start,
            desired,
            success: EncodedGoal::new(spec.last_stage(), &end, &desired)
                .is_met(&end, &spec.tolerances),
        });
        let order = OrderModel::fit(spec, attempts);
        self.state.encoder.set_order(order);
        self.renew_policies();
    }

    /// After any change of the networks or the statistics.
    fn renew_policies(&mut self) {
        let [explorer, policy] = policies(&self.state, &self.actor_shape, &*self.engine, self.id);
        self.explorer = explorer;
        self.policy = policy.like(&self.policy);
    }

    /// `None` if it was stopped within.
    fn evaluate(&mut self, stop: &AtomicBool) -> Result<Option<Evaluation>, TrainError> {
        let started = Instant::now();
        self.learn_order();
        let TrainConfig { evaluation, exploration, .. } = &self.state.config;
        let (envs, policy) = (&mut self.envs, &self.policy);
        let evaluation = self
            .pool
            .install(|| evaluate_until(stop, envs, policy, evaluation, exploration.test_policy))
            .map_err(|source| TrainError::Evaluate { episode: self.state.episodes, source })?;
        self.state.seconds.evaluate += started.elapsed().as_secs_f64();
        Ok(evaluation)
    }

    /// Tells the curriculum and the observer what an evaluation found.
    fn record(
        &mut self,
        evaluation: &Evaluation,
        observer: &mut dyn Observer,
    ) -> Result<(), TrainError> {
        let progress = self.progress();
        let state = &mut self.state;
        state.curriculum.record(&evaluation.success);
        state.last_success = [state.last_success[1], evaluation.success_final];
        state.evaluations += 1;
        let (guide, wall_s) = (state.curriculum.guide(), state.wall_s);
        let metrics = state.tally.metrics(progress, guide, state.seconds, wall_s, evaluation);
        state.tally.clear();
        observer.on(&Event::Evaluated(Box::new(metrics)))?;
        Ok(())
    }

    fn save_to(
        &mut self,
        folder: Option<&Path>,
        observer: &mut dyn Observer,
    ) -> Result<(), TrainError> {
        if let Some(folder) = folder {
            observer.on(&Event::Saving)?;
            self.save(folder)?;
            observer.on(&Event::Saved)?;
        }
        Ok(())
    }

    /// Writes the policy again if the one in the run's folder is another or cannot be read.
    fn renew_policy(&self, folder: &Path) -> Result<(), TrainError> {
        let path = folder.join(checkpoint::POLICY_FILE);
        match Policy::load(&path) {
            Ok(found) if found == self.policy => Ok(()),
            _ => Ok(self.policy.save(&path).map_err(CheckpointError::from)?),
        }
    }

    /// Writes a checkpoint of the whole run, and the policy, into its folder, which must be there.
    pub fn save(&mut self, folder: &Path) -> Result<(), TrainError> {
        let started = Instant::now();
        let learner = self.engine.state();
        checkpoint::write(folder, &self.state, &learner, &self.replay, self.saved_episodes)?;
        let policy = folder.join(checkpoint::POLICY_FILE);
        self.policy.save(&policy).map_err(CheckpointError::from)?;
        self.saved_episodes = self.replay.pushed();
        self.state.seconds.save += started.elapsed().as_secs_f64();
        Ok(())
    }
}

/// The policies that explore and that are evaluated, of the networks and statistics as they are.
fn policies(state: &RunState, shape: &Shape, engine: &dyn Engine, id: RunId) -> [Policy; 2] {
    let RunState { config, info, encoder, .. } = state;
    let policy =
        |actor| Policy::new(info.clone(), encoder.clone(), shape.clone(), actor).of_run(id);
    let deployed = match config.agent.deployed {
        Deployed::Trained => engine.actor(),
        Deployed::Target => engine.target_actor(),
    };
    [policy(engine.actor()), policy(deployed)]
}

/// What became of the episodes and the updates between two looks at the end of a run.
enum Iteration {
    /// Something is left undone.
    Stopped,
    /// No evaluation was due.
    Learned,
    Evaluated(Evaluation),
}

/// Whether these environments are enough, valid, and all the same.
fn check_envs<const N: usize, E: Env<N>>(
    envs: &[E],
    config: &TrainConfig,
) -> Result<(), TrainError> {
    if let Some(objects) = config.objects.filter(|objects| *objects != N) {
        return Err(TrainError::OtherObjects { config: objects, envs: N });
    }
    let (given, expected) = (envs.len(), config.envs);
    let Some(first) = envs.first().filter(|_| given >= expected) else {
        return Err(TrainError::TooFewEnvs { given, expected });
    };
    first.spec().validate()?;
    match envs.iter().position(|env| env.spec() != first.spec()) {
        Some(index) => Err(TrainError::DifferentEnvs { index }),
        None => Ok(()),
    }
}
