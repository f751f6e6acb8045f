//! Hindsight: replays every episode for every sub-task.

use crate::batch::Batch;
use crate::config::RelayConfig;
use crate::env::{EnvSpec, Mirror, Reflection};
use crate::episode::Episode;
use crate::goal::{Achieved, Desired, EncodedGoal, LaterObjects, SUCCESS, Stage, Tolerances};
use crate::input::InputEncoder;
use crate::replay::{Replay, StepIndex};
use rand::{Rng, RngExt as _};
use std::ops::Range;

/// Draws transitions, gives each the goal of a sub-task, and writes them as batch rows.
#[derive(Clone, Debug)]
pub struct Relabeler<const N: usize> {
    tolerances: Tolerances<N>,
    hindsight: f32,
    later_objects: LaterObjects,
    mirror: Option<(Mirror, f32)>,
    mirrored: [Vec<f32>; 2],
}

impl<const N: usize> Relabeler<N> {
    /// A relabeller with the shares of `config`, for environments like `spec`.
    pub fn new(config: &RelayConfig, spec: &EnvSpec<N>) -> Self {
        let mirror = spec.mirror.clone().filter(|_| config.mirror > 0.0);
        Self {
            tolerances: spec.tolerances,
            hindsight: config.hindsight,
            later_objects: config.later_objects,
            mirror: mirror.map(|mirror| (mirror, config.mirror)),
            mirrored: [vec![0.0; spec.observation], vec![0.0; spec.observation]],
        }
    }

    /// The goal with which step `step` of an episode is replayed for the sub-task of `stage`.
    ///
    /// With the set probability it is what was reached at a step drawn from `step + 1` to T, the
    /// `future` strategy of eq. 4; otherwise it is what the task asked for.
    pub fn goal(
        &self,
        stage: Stage<N>,
        achieved: &[Achieved<N>],
        desired: &Desired<N>,
        step: usize,
        rng: &mut impl Rng,
    ) -> EncodedGoal<N> {
        let now = &achieved[step];
        if rng.random::<f32>() < self.hindsight {
            let later = rng.random_range(step + 1..achieved.len());
            let desired = Desired::in_hindsight(achieved[later], self.later_objects);
            EncodedGoal::new(stage, now, &desired)
        } else {
            EncodedGoal::new(stage, now, desired)
        }
    }

    /// Fills `rows` of `batch` with transitions replayed for the sub-task of `stage`, and returns
    /// how many of them are rewarded.
    ///
    /// The next state keeps the goal of the step. Nothing is allocated.
    pub fn draw(
        &mut self,
        replay: &Replay<N>,
        encoder: &InputEncoder,
        stage: Stage<N>,
        batch: &mut Batch,
        rows: Range<usize>,
        rng: &mut impl Rng,
    ) -> usize {
        let mut successes = 0;
        for row in rows {
            let index = replay.draw(rng);
            let achieved = replay.achieved(index.slot);
            let desired = replay.desired(index.slot);
            let goal = self.goal(stage, achieved, desired, index.step, rng);
            let reward = goal.reward(&achieved[index.step + 1], &self.tolerances);
            successes += usize::from(reward >= SUCCESS);
            batch.rewards[row] = reward;
            self.write(replay, encoder, index, &goal, batch, row, rng);
        }
        successes
    }

    #[expect(clippy::too_many_arguments, reason = "the row, where it comes from, where it goes")]
    fn write(
        &mut self,
        replay: &Replay<N>,
        encoder: &InputEncoder,
        index: StepIndex,
        goal: &EncodedGoal<N>,
        batch: &mut Batch,
        row: usize,
        rng: &mut impl Rng,
    ) {
        let (before, after) = replay.observations(index);
        let action = replay.action(index);
        let achieved = &replay.achieved(index.slot)[index.step..index.step + 2];
        let input = row * batch.input..(row + 1) * batch.input;
        let action_out = &mut batch.actions[row * batch.action..(row + 1) * batch.action];
        match &self.mirror {
            Some((mirror, share)) if rng.random::<f32>() < *share => {
                let [mirrored_before, mirrored_after] = &mut self.mirrored;
                Reflection::apply(&mirror.observation, before, mirrored_before);
                Reflection::apply(&mirror.observation, after, mirrored_after);
                Reflection::apply(&mirror.action, action, action_out);
                let goal = goal.map(|position| mirror.position(position));
                let now = achieved[0].mirrored(mirror);
                let next = achieved[1].mirrored(mirror);
                encoder.write(mirrored_before, &now, &goal, &mut batch.inputs[input.clone()]);
                encoder.write(mirrored_after, &next, &goal, &mut batch.next_inputs[input]);
            }
            _ => {
                action_out.copy_from_slice(action);
                encoder.write(before, &achieved[0], goal, &mut batch.inputs[input.clone()]);
                encoder.write(after, &achieved[1], goal, &mut batch.next_inputs[input]);
            }
        }
    }

    /// Takes an episode into the statistics of `encoder`: every step once, with a goal for each of
    /// `stages`.
    pub fn observe(
        &self,
        episode: &Episode<N>,
        stages: &[Stage<N>],
        encoder: &mut InputEncoder,
        rng: &mut impl Rng,
    ) {
        let Episode { desired, observations, achieved, actions: _ } = episode;
        let frames = observations.chunks_exact(encoder.observation());
        for (step, observation) in frames.enumerate().take(achieved.len() - 1) {
            encoder.observe(observation);
            for &stage in stages {
                let goal = self.goal(stage, achieved, desired, step, rng);
                encoder.observe_goal(&achieved[step], &goal);
            }
        }
        encoder.refresh();
    }
}

impl<const N: usize> Achieved<N> {
    /// The mirror image of a scene.
    #[must_use]
    pub fn mirrored(&self, mirror: &Mirror) -> Self {
        let mut scene = self.0;
        scene.gripper = mirror.position(scene.gripper);
        scene.objects = scene.objects.map(|object| mirror.position(object));
        Self(scene)
    }
}
