//! Plays an action log again and describes the episode in messages.

use crate::message::{Action, Begin, Frame, Message, Place, Timed};
use crate::paint::{entity, transform};
use foxglove::messages::{FrameTransforms, SceneUpdate};
use rher_core::env::{End, Env, EnvError, EnvSpec, Start};
use rher_core::episode::{Episode, RolloutError, rollout};
use rher_core::evaluate::final_distance;
use rher_core::explore::ActionLog;
use rher_core::goal::{Achieved, Desired, EncodedGoal, Leg, Position, Stage};
use rher_envs::thing::{Color, Thing};
use rher_envs::{STEP_SECONDS, Simulated};

/// Nanoseconds between two frames.
pub(crate) const STEP: u64 = (STEP_SECONDS * 1e3 + 0.5) as u64 * 1_000_000;

/// Nanoseconds between the last frame of an episode and the first of the next.
pub(crate) const PAUSE: u64 = 1_000_000_000;

/// Opaque enough to be seen, clear enough to see through.
const STAGE_GOAL: Mark = Mark { radius: 0.03, color: [1.0, 0.85, 0.1, 0.45] };
const HINDSIGHT: Mark = Mark { radius: 0.015, color: [0.75, 0.75, 0.8, 0.6] };

struct Mark {
    radius: f32,
    color: Color,
}

impl Mark {
    fn at(&self, name: impl Into<String>, place: Position) -> Thing {
        Thing::mark(name, place, self.radius, self.color)
    }
}

/// Plays scripts in an environment of its own.
#[derive(Debug)]
pub struct Player<E, const N: usize> {
    env: E,
    relay: Relay<N>,
}

/// By what an episode is judged, whatever its environment.
#[derive(Debug)]
struct Relay<const N: usize> {
    spec: EnvSpec<N>,
    reach_distance: f32,
    last: Stage<N>,
}

/// An episode that was played again, and what could be seen of it.
#[derive(Debug)]
pub struct Played<const N: usize> {
    /// What was reached and done.
    pub episode: Episode<N>,
    /// `[T + 1]`: what there was to see, goals included.
    pub seen: Vec<Vec<Thing>>,
}

/// A script does not fit its environment.
#[derive(Debug, thiserror::Error)]
pub enum PlayError {
    /// It has too few actions or too many, or they have another width.
    #[error(
        "episode {episode} has {actions} numbers in its actions and {decisions} decisions, \
         expected {steps} actions of {width} numbers"
    )]
    Misfit {
        /// Number of the episode.
        episode: u64,
        /// Numbers in all its actions.
        actions: usize,
        /// Decisions.
        decisions: usize,
        /// Steps of the environment's episodes.
        steps: usize,
        /// Numbers in one of its actions.
        width: usize,
    },
    /// The environment failed.
    #[error(transparent)]
    Rollout(#[from] RolloutError),
}

impl<const N: usize, E: Simulated<N>> Player<E, N> {
    /// Plays in `env`; `reach_distance` is the paper's d, which decides whether an object counts
    /// as reached, in meters.
    pub fn new(env: E, reach_distance: f32) -> Self {
        let spec = env.spec().clone();
        let last = spec.last_stage();
        Self { env, relay: Relay { spec, reach_distance, last } }
    }

    /// Plays an episode again.
    pub fn play(&mut self, script: &ActionLog) -> Result<Played<N>, PlayError> {
        self.relay.check(script)?;
        let mut watched = Watched { env: &mut self.env, seen: Vec::new() };
        let mut chosen = script.actions.chunks_exact(self.relay.spec.action_dim);
        let episode = rollout(&mut watched, script.seed, |_, action| {
            action.copy_from_slice(chosen.next().unwrap_or_default());
            Ok(())
        })?;
        let mut seen = watched.seen;
        self.relay.add_marks(self.env.goals(&episode.desired), &episode, &mut seen);
        Ok(Played { episode, seen })
    }

    /// Plays an episode again; what happens as messages, the first one sent at `begin`, in
    /// nanoseconds.
    pub fn messages(&mut self, script: &ActionLog, begin: u64) -> Result<Vec<Timed>, PlayError> {
        let played = self.play(script)?;
        Ok(self.relay.messages(script, &played, begin))
    }
}

impl<const N: usize> Relay<N> {
    fn check(&self, script: &ActionLog) -> Result<(), PlayError> {
        let &EnvSpec { action_dim: width, episode_steps: steps, .. } = &self.spec;
        let (actions, decisions) = (script.actions.len(), script.decisions.len());
        if actions == steps * width && decisions == steps {
            Ok(())
        } else {
            let episode = script.number;
            Err(PlayError::Misfit { episode, actions, decisions, steps, width })
        }
    }

    fn messages(&self, script: &ActionLog, played: &Played<N>, begin: u64) -> Vec<Timed> {
        let Played { episode, seen } = played;
        let EnvSpec { obs_dim: observation, action_dim: action, tolerances, .. } = self.spec;
        let Episode { desired, observations, achieved, actions, end: _ } = episode;
        let number = script.number;
        let mut messages = Vec::with_capacity(3 * seen.len() + 1);
        let mut time = begin;
        let mut sum = 0.0;
        for (step, (things, now)) in seen.iter().zip(achieved).enumerate() {
            let mut send = |message| messages.push(Timed { time, message });
            if step == 0 {
                send(Message::Begin(Begin {
                    episode: number,
                    seed: script.seed,
                    steps: script.decisions.len(),
                    targets: desired.objects().map(Place::from).to_vec(),
                    tolerances: tolerances.objects.to_vec(),
                    reach_tolerance: tolerances.gripper,
                }));
                let entities = things.iter().map(|thing| entity(thing, time)).collect();
                send(Message::Scene(SceneUpdate { deletions: Vec::new(), entities }));
            }
            let transforms = things.iter().map(|thing| transform(thing, time)).collect();
            send(Message::Transforms(FrameTransforms { transforms }));
            let goal = EncodedGoal::new(self.last, now, desired);
            let reward = (step > 0).then(|| goal.reward(now, &tolerances));
            sum += reward.unwrap_or_default();
            let scene = &now.0;
            let pairs = scene.objects.iter().zip(desired.objects());
            send(Message::Frame(Frame {
                episode: number,
                step,
                stage: self.stage(now, desired).index() + 1,
                success: goal.is_met(now, &tolerances),
                distance: final_distance(self.last, now, desired, &tolerances),
                distances: pairs.map(|(a, b)| nalgebra::distance(a, b)).collect(),
                reward,
                sum,
                gripper: scene.gripper.into(),
                objects: scene.objects.map(Place::from).to_vec(),
                observation: observations[step * observation..][..observation].to_vec(),
            }));
            if let Some(decision) = script.decisions.get(step) {
                send(Message::Action(Action {
                    episode: number,
                    step,
                    action: actions[step * action..][..action].to_vec(),
                    decider: decision.source,
                    subtask: decision.subtask + 1,
                    q: decision.value,
                }));
                time += STEP;
            }
        }
        messages
    }

    fn stage(&self, now: &Achieved<N>, desired: &Desired<N>) -> Stage<N> {
        Stage::of(now, desired, &self.spec.tolerances, self.reach_distance).at_most(self.last)
    }

    /// Marks what the task asks for, what the current stage asks for, and what hindsight will: here
    /// always the end of the episode, of all that was reached.
    fn add_marks(&self, mut marks: Vec<Thing>, episode: &Episode<N>, seen: &mut [Vec<Thing>]) {
        let Episode { desired, achieved, .. } = episode;
        if let Some(Achieved(end)) = achieved.last() {
            marks.push(HINDSIGHT.at("hindsight_gripper", end.gripper));
            for (index, object) in end.objects.iter().enumerate() {
                marks.push(HINDSIGHT.at(format!("hindsight_goal_{}", index + 1), *object));
            }
        }
        for (things, now) in seen.iter_mut().zip(achieved) {
            let stage = self.stage(now, desired);
            let goal = EncodedGoal::new(stage, now, desired);
            let wanted = match stage.leg() {
                Leg::Reach => goal.gripper(),
                Leg::Place => goal.objects()[stage.object()],
            };
            things.extend(marks.iter().cloned());
            things.extend(wanted.map(|wanted| STAGE_GOAL.at("stage_goal", wanted)));
        }
    }
}

/// An environment, and what could be seen in it so far.
struct Watched<'a, E> {
    env: &'a mut E,
    seen: Vec<Vec<Thing>>,
}

impl<const N: usize, E: Simulated<N>> Env<N> for Watched<'_, E> {
    fn spec(&self) -> &EnvSpec<N> {
        self.env.spec()
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<N>, EnvError> {
        let start = self.env.reset(seed, observation)?;
        self.seen.push(self.env.things());
        Ok(start)
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<N>, EnvError> {
        let achieved = self.env.step(action, observation)?;
        self.seen.push(self.env.things());
        Ok(achieved)
    }

    fn end(&self) -> Option<End> {
        self.env.end()
    }
}
