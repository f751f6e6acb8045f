//! Hindsight: replays every episode for every sub-task.

use crate::batch::Batch;
use crate::config::{Method, RelayConfig};
use crate::env::{End, EnvSpec, Mirror, Permutation, SignedIndex};
use crate::episode::Episode;
use crate::goal::{
    Achieved, Desired, EncodedGoal, LaterObjects, Position, SUCCESS, Stage, Tail, Tolerances,
};
use crate::input::InputEncoder;
use crate::replay::{Replay, StepIndex};
use rand::{Rng, RngExt as _};
use std::array;
use std::ops::Range;

/// Draws transitions, gives each the goal of a sub-task, and writes them as batch rows.
#[derive(Clone, Debug)]
pub struct Relabeler<const N: usize> {
    tolerances: Tolerances<N>,
    /// The stage that ends the task.
    last: Stage<N>,
    method: Method,
    hindsight: f32,
    redraw_met: f32,
    later_objects: LaterObjects,
    /// Every combination of the scene's mirrors, the first being none.
    reflections: Vec<Reflection>,
    mirror: f32,
    /// For each object, the orders in which an earlier one has its place.
    permutations: [Vec<Permutation<N>>; N],
    exchange: f32,
    permuted: [Vec<f32>; 2],
    mirrored: [Vec<f32>; 2],
}

/// Rows that are drawn before the first of them is filled, so that the memory that they need is
/// fetched together: most of the time of a row is waiting for it.
const AHEAD: usize = 32;

/// How many times a row is drawn again because its goal in hindsight is already met.
const REDRAWS: usize = 4;

/// What a scene is in some of its mirrors; in none of them it has no entries.
#[derive(Clone, Debug, Default)]
struct Reflection {
    mirrors: Vec<Mirror>,
    observation: Vec<SignedIndex>,
    action: Vec<SignedIndex>,
    tail: Vec<SignedIndex>,
}

/// What a row is to be.
#[derive(Clone, Copy, Debug, Default)]
struct Draw {
    index: StepIndex,
    /// Which of the permutations of the sub-task's object takes part.
    permutation: Option<usize>,
    /// The step whose scene is the goal, in hindsight.
    later: Option<usize>,
    /// Which of the reflections.
    reflection: usize,
}

impl<const N: usize> Relabeler<N> {
    /// A relabeler with the shares of `config`, for environments like `spec`.
    pub fn new(config: &RelayConfig, spec: &EnvSpec<N>) -> Self {
        let of_object = |object| {
            let earlier = |permutation: &&Permutation<N>| permutation.order[object] < object;
            spec.permutations.iter().filter(earlier).cloned().collect()
        };
        let scratch = || [vec![0.0; spec.obs_dim], vec![0.0; spec.obs_dim]];
        Self {
            tolerances: config.tolerances(spec),
            last: spec.last_stage(),
            method: config.method,
            hindsight: config.hindsight,
            redraw_met: config.redraw_met,
            later_objects: config.later_objects,
            reflections: Reflection::all(if config.mirror > 0.0 { &spec.mirrors } else { &[] }),
            mirror: config.mirror,
            permutations: array::from_fn(of_object),
            exchange: config.exchange,
            permuted: scratch(),
            mirrored: scratch(),
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
        let later = self.later(step, achieved.len() - 1, rng).map(|later| achieved[later]);
        self.relabel(stage, &achieved[step], later, || *desired).1
    }

    /// The relabeling rule: what is asked of a step at which the scene is `now`, and how the
    /// sub-task of `stage` sees it. It is what was reached `later`, or what the task `asked` for.
    fn relabel(
        &self,
        stage: Stage<N>,
        now: &Achieved<N>,
        later: Option<Achieved<N>>,
        asked: impl FnOnce() -> Desired<N>,
    ) -> (Desired<N>, EncodedGoal<N>) {
        let desired = match later {
            Some(reached) => Desired::in_hindsight(reached, self.later_objects),
            None => asked(),
        };
        (desired, EncodedGoal::new(stage, now, &desired))
    }

    /// The step whose scene is the goal in hindsight of `step`, if it gets one.
    fn later(&self, step: usize, steps: usize, rng: &mut impl Rng) -> Option<usize> {
        (rng.random::<f32>() < self.hindsight).then(|| rng.random_range(step + 1..steps + 1))
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
        let mut rewarded = 0;
        let mut drawn = [Draw::default(); AHEAD];
        for start in rows.clone().step_by(AHEAD) {
            let block = start..rows.end.min(start + AHEAD);
            for (draw, _) in drawn.iter_mut().zip(block.clone()) {
                *draw = self.draw_unmet_row(replay, stage, rng);
                replay.prefetch(draw.index, draw.later);
            }
            for (draw, row) in drawn.iter().zip(block) {
                rewarded += usize::from(self.fill_row(replay, encoder, stage, batch, row, draw));
            }
        }
        rewarded
    }

    /// Draws what a row is to be; with the set probability again where its goal in hindsight is
    /// already met, since most steps move nothing.
    fn draw_unmet_row(&self, replay: &Replay<N>, stage: Stage<N>, rng: &mut impl Rng) -> Draw {
        let mut draw = self.draw_row(replay, stage, rng);
        if self.redraw_met == 0.0 {
            return draw;
        }
        for _ in 0..REDRAWS {
            if !self.is_met_already(replay, stage, &draw) || rng.random::<f32>() >= self.redraw_met
            {
                break;
            }
            draw = self.draw_row(replay, stage, rng);
        }
        draw
    }

    /// Whether a row has a goal in hindsight that is met before its step.
    fn is_met_already(&self, replay: &Replay<N>, stage: Stage<N>, draw: &Draw) -> bool {
        let order = self.order(stage, draw);
        let scene = |step| {
            let at = StepIndex { slot: draw.index.slot, step };
            Achieved(replay.scene(at).0.reordered(&order))
        };
        draw.later.is_some_and(|later| {
            let now = scene(draw.index.step);
            let desired = Desired::in_hindsight(scene(later), self.later_objects);
            EncodedGoal::new(stage, &now, &desired).is_met(&now, &self.tolerances)
        })
    }

    /// The order of objects of a row.
    fn order(&self, stage: Stage<N>, draw: &Draw) -> [usize; N] {
        match draw.permutation {
            None => array::from_fn(|object| object),
            Some(which) => self.permutations[stage.object()][which].order,
        }
    }

    /// Draws what a row is to be.
    fn draw_row(&self, replay: &Replay<N>, stage: Stage<N>, rng: &mut impl Rng) -> Draw {
        let index = replay.draw(rng);
        let permutation = match self.permutations[stage.object()].len() {
            0 => None,
            _ if self.exchange == 0.0 => None,
            // One draw for whether and which: past the last one there is none.
            some => Some((rng.random::<f32>() / self.exchange * some as f32) as usize)
                .filter(|&which| which < some),
        };
        let later = self.later(index.step, replay.steps(index.slot), rng);
        let mirrors = self.reflections.len().ilog2();
        let mirrored = (0..mirrors).map(|_| usize::from(rng.random::<f32>() < self.mirror));
        let reflection = mirrored.fold(0, |which, mirrored| 2 * which + mirrored);
        Draw { index, permutation, later, reflection }
    }

    /// Fills one row, and returns whether it is rewarded.
    fn fill_row(
        &mut self,
        replay: &Replay<N>,
        encoder: &InputEncoder,
        stage: Stage<N>,
        batch: &mut Batch,
        row: usize,
        draw: &Draw,
    ) -> bool {
        let order = self.order(stage, draw);
        let Draw { index, permutation, later, reflection } = *draw;
        let permutation = permutation.map(|which| &self.permutations[stage.object()][which]);
        let at = |step| StepIndex { slot: index.slot, step };
        let scene = |step| Achieved(replay.scene(at(step)).0.reordered(&order));
        let (mut now, mut next) = (scene(index.step), scene(index.step + 1));
        let asked = || replay.desired(index.slot).reordered(&order);
        let (desired, mut goal) = self.relabel(stage, &now, later.map(scene), asked);
        let mut simpler = self.simpler(stage, &now, &desired);
        let reward = goal.reward(&next, &self.tolerances);
        batch.rewards[row] = reward;
        batch.ended[row] = self.is_over(replay, index, stage, reward >= SUCCESS);

        let (mut before, mut after) =
            (replay.observation(index), replay.observation(at(index.step + 1)));
        if let Some(permutation) = permutation {
            let [permuted_before, permuted_after] = &mut self.permuted;
            SignedIndex::apply(&permutation.observation, before, permuted_before);
            SignedIndex::apply(&permutation.observation, after, permuted_after);
            (before, after) = (permuted_before, permuted_after);
        }
        let action = replay.action(index);
        let action_out = &mut batch.actions[row * batch.action_dim..(row + 1) * batch.action_dim];
        if reflection == 0 {
            action_out.copy_from_slice(action);
        } else {
            let reflection = &self.reflections[reflection];
            let [mirrored_before, mirrored_after] = &mut self.mirrored;
            SignedIndex::apply(&reflection.observation, before, mirrored_before);
            SignedIndex::apply(&reflection.observation, after, mirrored_after);
            (before, after) = (mirrored_before, mirrored_after);
            SignedIndex::apply(&reflection.action, action, action_out);
            let place = |position| reflection.position(position);
            let tail = |tail: &Tail| SignedIndex::image(&reflection.tail, tail);
            goal = goal.map(place, tail);
            simpler = simpler.map(|goal| goal.map(place, tail));
            (now, next) = (Achieved(now.0.map(place, tail)), Achieved(next.0.map(place, tail)));
        }
        let input = row * batch.input_dim..(row + 1) * batch.input_dim;
        encoder.write(before, &now, &goal, &mut batch.inputs[input.clone()]);
        encoder.write(after, &next, &goal, &mut batch.next_inputs[input.clone()]);
        batch.imitates[row] = simpler.is_some();
        if let Some(simpler) = simpler {
            encoder.write(before, &now, &simpler, &mut batch.simpler_inputs[input]);
        }
        reward >= SUCCESS
    }

    /// Whether nothing follows a step that is replayed for the sub-task of `stage` with a goal that
    /// it has `met` or not.
    ///
    /// Where an environment ends an episode once its task is done, it would have ended it here, too,
    /// had the goal of the row been that of the task; had it been another one, it would have gone on
    /// where it did end. Where it ended because something failed, nothing follows for any goal.
    fn is_over(&self, replay: &Replay<N>, index: StepIndex, stage: Stage<N>, met: bool) -> bool {
        if met && stage == self.last && replay.ends_when_solved() {
            return true;
        }
        match replay.end(index) {
            None | Some(End::Truncated) => false,
            Some(End::Solved) => met,
            Some(End::Failed) => true,
        }
    }

    /// The goal of the sub-task whose turn it is when an object before that of `stage` is not in
    /// its place: to place it.
    fn simpler(
        &self,
        stage: Stage<N>,
        now: &Achieved<N>,
        desired: &Desired<N>,
    ) -> Option<EncodedGoal<N>> {
        let turn = Stage::of(now, desired, &self.tolerances, 0.0).object();
        let place = Stage::place(turn);
        let trained = self.method == Method::Rher;
        (turn < stage.object() && trained).then(|| EncodedGoal::new(place, now, desired))
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
        let Episode { desired, observations, achieved, actions: _, end: _ } = episode;
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

impl Reflection {
    /// Every combination of `mirrors`, counted in binary with the first mirror in front.
    fn all(mirrors: &[Mirror]) -> Vec<Self> {
        let mut all = vec![Self::default()];
        for mirror in mirrors {
            all = all.iter().flat_map(|one| [one.clone(), one.then(mirror)]).collect();
        }
        all
    }

    fn then(&self, mirror: &Mirror) -> Self {
        Self {
            mirrors: self.mirrors.iter().chain([mirror]).cloned().collect(),
            observation: SignedIndex::then(&self.observation, &mirror.observation),
            action: SignedIndex::then(&self.action, &mirror.action),
            tail: SignedIndex::then(&self.tail, &mirror.tail),
        }
    }

    #[inline]
    fn position(&self, position: Position) -> Position {
        self.mirrors.iter().fold(position, |position, mirror| mirror.position(position))
    }
}
