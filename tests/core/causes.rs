//! Every row of a batch has one cause: a step of a stored episode, a later frame or none, a set of
//! mirrors and a permutation of the objects, which together explain everything in the row.
//!
//! The law knows nothing of the crate's goals, rewards and encoders. It says what a row should be
//! in plain lists of points, and tries every cause there is.

use rand::{Rng, RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rher_core::batch::Batch;
use rher_core::config::{GoalFrame, Method, ObjectOrder, Preset, RelayConfig};
use rher_core::env::{End, EnvSpec, Mirror, Permutation, SignedIndex};
use rher_core::episode::Episode;
use rher_core::goal::{
    Achieved, Desired, EncodedGoal, LaterObjects, Leg, Position, Scene, Stage, Tolerances,
};
use rher_core::input::InputEncoder;
use rher_core::relabel::Relabeler;
use rher_core::replay::Replay;
use std::collections::BTreeSet;

const STEPS: usize = 5;
/// More than a relabeler draws ahead.
const ROWS: usize = 40;
const GRIPPER_TOLERANCE: f32 = 0.03;
const TOLERANCES: [f32; 3] = [0.05, 0.02, 0.08];
/// There is a mirror across x and one across y, at these places.
const MIRRORS: [f32; 2] = [0.1, -0.05];

type Point = [f32; 3];

#[derive(Clone, Debug)]
struct Places {
    gripper: Point,
    objects: Vec<Point>,
}

struct Played {
    targets: Vec<Point>,
    frames: Vec<Places>,
    actions: Vec<Point>,
}

#[derive(Clone, Copy, Debug)]
struct Cause<'a> {
    episode: usize,
    step: usize,
    later: Option<usize>,
    mirrors: [bool; 2],
    order: &'a [usize],
}

fn distance(a: Point, b: Point) -> f32 {
    let apart = minus(a, b);
    apart.map(|x| x * x).iter().sum::<f32>().sqrt()
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn mirrored(mirrors: [bool; 2], mut point: Point) -> Point {
    for axis in 0..2 {
        if mirrors[axis] {
            point[axis] = 2.0 * MIRRORS[axis] - point[axis];
        }
    }
    point
}

fn permuted(order: &[usize], objects: &[Point]) -> Vec<Point> {
    order.iter().map(|&object| objects[object]).collect()
}

fn position(point: Point) -> Position {
    Position::from(point)
}

impl Places {
    fn permuted(&self, order: &[usize]) -> Self {
        Self { gripper: self.gripper, objects: permuted(order, &self.objects) }
    }

    fn mirrored(&self, mirrors: [bool; 2]) -> Self {
        Self {
            gripper: mirrored(mirrors, self.gripper),
            objects: self.objects.iter().map(|object| mirrored(mirrors, *object)).collect(),
        }
    }

    /// The gripper's place, then each object's place and where it is from the gripper.
    fn observation(&self) -> Vec<f32> {
        let of_object = |object: &Point| [*object, minus(*object, self.gripper)].concat();
        let objects = self.objects.iter().flat_map(of_object);
        self.gripper.into_iter().chain(objects).collect()
    }

    fn achieved<const N: usize>(&self) -> Achieved<N> {
        let objects = std::array::from_fn(|object| position(self.objects[object]));
        Achieved(Scene::new(position(self.gripper), objects))
    }
}

/// An episode in which things move a little or not at all, near their targets.
fn play(objects: usize, rng: &mut impl Rng) -> Played {
    let mut near = |center: Point, far: f32| center.map(|x| x + rng.random_range(-far..far));
    let first = Places {
        gripper: near([0.0; 3], 0.05),
        objects: (0..objects).map(|_| near([0.0; 3], 0.05)).collect(),
    };
    let targets = first.objects.iter().map(|object| near(*object, 0.04)).collect();
    let actions = (0..STEPS).map(|_| near([0.0; 3], 1.0)).collect();
    let mut frames = vec![first];
    for _ in 0..STEPS {
        let mut next = frames[frames.len() - 1].clone();
        next.gripper = near(next.gripper, 0.03);
        for object in &mut next.objects {
            if near([0.0; 3], 1.0)[0] > 0.0 {
                *object = near(*object, 0.03);
            }
        }
        frames.push(next);
    }
    Played { targets, frames, actions }
}

impl Played {
    fn desired<const N: usize>(&self) -> Desired<N> {
        Desired::of_task(std::array::from_fn(|object| position(self.targets[object])))
    }

    fn episode<const N: usize>(&self) -> Episode<N> {
        Episode {
            desired: self.desired(),
            observations: self.frames.iter().flat_map(Places::observation).collect(),
            achieved: self.frames.iter().map(Places::achieved).collect(),
            actions: self.actions.concat(),
            end: End::Truncated,
        }
    }
}

/// Every order of the objects, the usual one first.
fn orders(objects: usize) -> Vec<Vec<usize>> {
    let all: &[&[usize]] = match objects {
        1 => &[&[0]],
        2 => &[&[0, 1], &[1, 0]],
        _ => &[&[0, 1, 2], &[0, 2, 1], &[1, 0, 2], &[1, 2, 0], &[2, 0, 1], &[2, 1, 0]],
    };
    all.iter().map(|order| order.to_vec()).collect()
}

fn spec<const N: usize>() -> EnvSpec<N> {
    let same = |from| SignedIndex { from, sign: 1.0, offset: 0.0 };
    let mirror = |axis: usize| {
        let flip = |from: usize| {
            let is_place = from < 3 || (from - 3) % 6 < 3;
            let offset = if is_place { 2.0 * MIRRORS[axis] } else { 0.0 };
            if from % 3 == axis { SignedIndex { from, sign: -1.0, offset } } else { same(from) }
        };
        let turn = |from| SignedIndex { offset: 0.0, ..flip(from) };
        Mirror {
            axis,
            center: MIRRORS[axis],
            observation: (0..3 + 6 * N).map(flip).collect(),
            action: (0..3).map(turn).collect(),
            tail: Vec::new(),
        }
    };
    let permutation = |order: &Vec<usize>| {
        let of_object = |object: &usize| 3 + 6 * object..3 + 6 * (object + 1);
        Permutation {
            order: std::array::from_fn(|place| order[place]),
            observation: (0..3).chain(order.iter().flat_map(of_object)).map(same).collect(),
        }
    };
    EnvSpec {
        tolerances: Tolerances {
            gripper: GRIPPER_TOLERANCE,
            objects: std::array::from_fn(|object| TOLERANCES[object]),
            ..Tolerances::uniform(GRIPPER_TOLERANCE)
        },
        mirrors: (0..2).map(mirror).collect(),
        permutations: orders(N)[1..].iter().map(permutation).collect(),
        ..EnvSpec::new("causes", 3 + 6 * N, 3, STEPS)
    }
}

/// Means and deviations of what was seen of a vector.
#[derive(Default)]
struct Statistics(Vec<Vec<f32>>);

impl Statistics {
    fn normalized(&self, vector: &[f32]) -> Vec<f32> {
        let number = |(index, value): (usize, &f32)| {
            let column = || self.0.iter().map(|sample| f64::from(sample[index]));
            let mean = column().sum::<f64>() / self.0.len() as f64;
            let variance =
                column().map(|x| (x - mean) * (x - mean)).sum::<f64>() / self.0.len() as f64;
            let normalized = (f64::from(*value) - mean) / variance.sqrt().max(0.01);
            normalized.clamp(-5.0, 5.0) as f32
        };
        vector.iter().enumerate().map(number).collect()
    }
}

/// A goal: where the gripper should be, where each object should be; `None` is a blank.
type Slots = Vec<Option<Point>>;

struct Law<'a> {
    relay: &'a RelayConfig,
    objects: usize,
    played: Vec<Played>,
    observations: Statistics,
    slots: Vec<Statistics>,
}

impl Law<'_> {
    fn tolerance(&self, object: usize) -> f32 {
        self.relay.tolerance * TOLERANCES[object]
    }

    /// Eq. 8 and 9: what the sub-task (object, leg) asks for.
    fn goal(
        &self,
        (object, leg): (usize, Leg),
        now: &Places,
        targets: &[Point],
        later: Option<&Places>,
    ) -> Slots {
        let gripper = match (leg, later) {
            (Leg::Place, _) => None,
            (Leg::Reach, None) => Some(now.objects[object]),
            (Leg::Reach, Some(later)) => Some(later.gripper),
        };
        let target = |it: usize| later.map_or(targets[it], |later| later.objects[it]);
        let mut slots = vec![gripper];
        for it in 0..self.objects {
            slots.push(if it < object {
                Some(target(it))
            } else if it == object {
                (leg == Leg::Place).then(|| target(it))
            } else if self.relay.later_objects == LaterObjects::Later {
                later.map(|later| later.objects[it]).or(Some(now.objects[it]))
            } else {
                Some(now.objects[it])
            });
        }
        slots
    }

    /// Eq. 3: whether everything that is asked for is within its tolerance.
    fn is_met(&self, slots: &Slots, scene: &Places) -> bool {
        let gripper = slots[0].is_none_or(|it| distance(it, scene.gripper) <= GRIPPER_TOLERANCE);
        let is_met = |object: usize| {
            slots[object + 1]
                .is_none_or(|it| distance(it, scene.objects[object]) <= self.tolerance(object))
        };
        gripper && (0..self.objects).all(is_met)
    }

    /// The first of the objects before `object` that is not where `wanted` has it.
    fn first_misplaced(
        &self,
        object: usize,
        scene: &Places,
        wanted: impl Fn(usize) -> Point,
    ) -> Option<usize> {
        let is_misplaced =
            |it: &usize| distance(wanted(*it), scene.objects[*it]) > self.tolerance(*it);
        (0..object).find(is_misplaced)
    }

    /// The network's input: the object whose turn it is first, if objects come in order of turn.
    fn input(&self, object: usize, scene: &Places, slots: &Slots) -> Vec<f32> {
        let first = match self.relay.object_order {
            ObjectOrder::Relay => 0,
            ObjectOrder::Turn => self
                .first_misplaced(object, scene, |it| slots[it + 1].expect("an earlier object"))
                .unwrap_or(object),
        };
        let order: Vec<usize> = (0..self.objects).map(|it| (first + it) % self.objects).collect();
        let scene = scene.permuted(&order);
        let mut input = self.observations.normalized(&scene.observation());
        let slots: Slots =
            std::iter::once(slots[0]).chain(order.iter().map(|it| slots[it + 1])).collect();
        let places = std::iter::once(&scene.gripper).chain(&scene.objects);
        for ((slot, place), statistics) in slots.iter().zip(places).zip(&self.slots) {
            input.extend(match (slot, self.relay.goal_frame) {
                (None, GoalFrame::Absolute) => vec![-5.0; 3],
                (None, GoalFrame::Relative) => vec![0.0; 3],
                (Some(wanted), GoalFrame::Absolute) => statistics.normalized(wanted),
                (Some(wanted), GoalFrame::Relative) => {
                    statistics.normalized(&minus(*wanted, *place))
                }
            });
        }
        if self.relay.goal_frame == GoalFrame::Relative {
            input.extend(slots.iter().map(|slot| if slot.is_none() { 1.0 } else { 0.0 }));
        }
        if self.relay.fine_scale {
            let tolerances = order.iter().map(|it| self.tolerance(*it));
            let tolerances: Vec<f32> =
                std::iter::once(GRIPPER_TOLERANCE).chain(tolerances).collect();
            input.extend(near_distances(&scene, &slots, &tolerances));
        }
        input
    }

    /// Shows `encoder` every frame with the task's goal of every sub-task, and remembers it.
    fn show<const N: usize>(&mut self, encoder: &mut InputEncoder) {
        let turns = self.relay.object_order == ObjectOrder::Turn;
        self.slots.resize_with(N + 1, Statistics::default);
        for played in &self.played {
            for frame in &played.frames {
                encoder.observe(&frame.observation());
                for first in 0..if turns { N } else { 1 } {
                    let order: Vec<usize> = (0..N).map(|it| (first + it) % N).collect();
                    self.observations.0.push(frame.permuted(&order).observation());
                }
                for stage in Stage::<N>::all() {
                    let now = frame.achieved();
                    encoder.observe_goal(&now, &EncodedGoal::new(stage, &now, &played.desired()));
                    let goal =
                        self.goal((stage.object(), stage.leg()), frame, &played.targets, None);
                    let places = std::iter::once(frame.gripper).chain(frame.objects.clone());
                    for (index, (slot, place)) in goal.into_iter().zip(places).enumerate() {
                        let Some(wanted) = slot else { continue };
                        let seen = match self.relay.goal_frame {
                            GoalFrame::Absolute => wanted,
                            GoalFrame::Relative => minus(wanted, place),
                        };
                        let alike = if turns && index > 0 { 1..N + 1 } else { index..index + 1 };
                        for slot in alike {
                            self.slots[slot].0.push(seen.to_vec());
                        }
                    }
                }
            }
        }
        encoder.refresh();
    }

    /// Whether `cause` explains everything in a row that was drawn for `subtask`.
    fn explains(&self, cause: &Cause, subtask: (usize, Leg), batch: &Batch, row: usize) -> bool {
        let Cause { episode, step, later, mirrors, order } = *cause;
        let played = &self.played[episode];
        let frame = |step: usize| played.frames[step].permuted(order);
        let (now, next) = (frame(step), frame(step + 1));
        let (later, targets) = (later.map(frame), permuted(order, &played.targets));
        let goal = self.goal(subtask, &now, &targets, later.as_ref());
        let reward = if self.is_met(&goal, &next) { 0.0 } else { -1.0 };
        let wanted = |it: usize| later.as_ref().map_or(targets[it], |later| later.objects[it]);
        let simpler = self
            .first_misplaced(subtask.0, &now, wanted)
            .filter(|_| self.relay.method == Method::Rher)
            .map(|it| (it, self.goal((it, Leg::Place), &now, &targets, later.as_ref())));

        let image = |goal: &Slots| -> Slots {
            goal.iter().map(|slot| slot.map(|point| mirrored(mirrors, point))).collect()
        };
        let (now, next) = (now.mirrored(mirrors), next.mirrored(mirrors));
        let is = |numbers: &[f32], expected: &[f32]| {
            let is = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-3;
            numbers.len() == expected.len() && numbers.iter().zip(expected).all(is)
        };
        let input = |inputs: &[f32], object: usize, scene: &Places, goal: &Slots| {
            let range = row * batch.input_dim..(row + 1) * batch.input_dim;
            is(&inputs[range], &self.input(object, scene, &image(goal)))
        };
        batch.rewards[row] == reward
            && batch.imitates[row] == simpler.is_some()
            && input(&batch.inputs, subtask.0, &now, &goal)
            && input(&batch.next_inputs, subtask.0, &next, &goal)
            && simpler
                .is_none_or(|(object, goal)| input(&batch.simpler_inputs, object, &now, &goal))
    }

    /// What explains a row, if anything does.
    fn cause<'a>(
        &self,
        orders: &'a [Vec<usize>],
        subtask: (usize, Leg),
        batch: &Batch,
        row: usize,
    ) -> Option<Cause<'a>> {
        let action = &batch.actions[3 * row..3 * (row + 1)];
        let sides = [[false, false], [false, true], [true, false], [true, true]];
        // An order is for those objects that it puts in the place of an earlier one.
        let orders: Vec<&Vec<usize>> = orders
            .iter()
            .enumerate()
            .filter(|(which, order)| *which == 0 || order[subtask.0] < subtask.0)
            .map(|(_, order)| order)
            .collect();
        for (episode, played) in self.played.iter().enumerate() {
            for (step, taken) in played.actions.iter().enumerate() {
                for mirrors in sides {
                    let [x, y, z] = *taken;
                    let flip = |flips: bool, number: f32| if flips { -number } else { number };
                    if action != [flip(mirrors[0], x), flip(mirrors[1], y), z] {
                        continue;
                    }
                    for order in &orders {
                        for later in std::iter::once(None).chain((step + 1..=STEPS).map(Some)) {
                            let cause = Cause { episode, step, later, mirrors, order };
                            if self.explains(&cause, subtask, batch, row) {
                                return Some(cause);
                            }
                        }
                    }
                }
            }
        }
        None
    }
}

/// From everything to its goal, with the length; from the gripper to the objects; from the first
/// object to the others: in tolerances, as far as two (a length as far as three, counted from one).
fn near_distances(scene: &Places, slots: &Slots, tolerances: &[f32]) -> Vec<f32> {
    let near = |from: Point, to: Point, tolerance: f32| {
        minus(to, from).map(|number| (number / tolerance).clamp(-2.0, 2.0))
    };
    let mut numbers = Vec::new();
    let places = std::iter::once(scene.gripper).chain(scene.objects.clone());
    for ((slot, place), tolerance) in slots.iter().zip(places).zip(tolerances) {
        let Some(wanted) = *slot else {
            numbers.extend([0.0; 4]);
            continue;
        };
        numbers.extend(near(place, wanted, *tolerance));
        numbers.push((distance(wanted, place) / tolerance).min(3.0) - 1.0);
    }
    for (object, tolerance) in scene.objects.iter().zip(&tolerances[1..]) {
        numbers.extend(near(scene.gripper, *object, *tolerance));
    }
    for (object, tolerance) in scene.objects.iter().zip(&tolerances[1..]).skip(1) {
        numbers.extend(near(scene.objects[0], *object, *tolerance));
    }
    numbers
}

/// Draws rows for every sub-task, finds the cause of each, and notes what there was.
fn check<const N: usize>(relay: &RelayConfig, seed: u64, seen: &mut BTreeSet<String>) {
    let spec = spec::<N>();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut encoder = InputEncoder::new(relay, &spec);
    let mut law = Law {
        relay,
        objects: N,
        played: (0..2).map(|_| play(N, &mut rng)).collect(),
        observations: Statistics::default(),
        slots: Vec::new(),
    };
    law.show::<N>(&mut encoder);
    let mut replay = Replay::new(&spec, 2 * STEPS);
    law.played.iter().for_each(|played| replay.push(&played.episode()));
    let orders = orders(N);
    let mut relabeler = Relabeler::new(relay, &spec);
    for stage in Stage::<N>::all() {
        // A row before and a row after those that are drawn.
        let mut batch = Batch::zeros(ROWS + 2, encoder.width(), 3);
        let rewarded = relabeler.draw(&replay, &encoder, stage, &mut batch, 1..ROWS + 1, &mut rng);
        let rewards = &batch.rewards[1..=ROWS];
        assert_eq!(rewarded, rewards.iter().filter(|reward| **reward == 0.0).count());
        for row in [0, ROWS + 1] {
            let input = &batch.inputs[row * batch.input_dim..(row + 1) * batch.input_dim];
            assert!(input.iter().all(|number| *number == 0.0), "row {row} was not asked for");
        }
        for row in 1..=ROWS {
            let subtask = (stage.object(), stage.leg());
            let Some(cause) = law.cause(&orders, subtask, &batch, row) else {
                panic!("nothing explains row {row} of {stage:?} with {relay:?} and seed {seed}");
            };
            seen.insert(format!("hindsight {}", cause.later.is_some()));
            seen.insert(format!("mirrors {:?}", cause.mirrors));
            seen.insert(format!("order {:?}", cause.order));
            seen.insert(format!("reward {}", batch.rewards[row]));
            seen.insert(format!("imitates {}", batch.imitates[row]));
        }
    }
}

#[test]
fn every_row_has_one_cause() {
    let mut seen = BTreeSet::new();
    let mut seed = 0;
    for goal_frame in [GoalFrame::Absolute, GoalFrame::Relative] {
        for later_objects in [LaterObjects::Now, LaterObjects::Later] {
            for object_order in [ObjectOrder::Relay, ObjectOrder::Turn] {
                for method in [Method::Rher, Method::Her] {
                    for (tolerance, fine_scale) in
                        [(1.0, false), (0.6, false), (1.0, true), (0.6, true)]
                    {
                        let relay = RelayConfig {
                            method,
                            tolerance,
                            hindsight: 0.6,
                            redraw_met: 0.5,
                            later_objects,
                            goal_frame,
                            fine_scale,
                            object_order,
                            mirror: 0.5,
                            exchange: 0.6,
                            ..Preset::Paper.config("causes", 1).relay
                        };
                        check::<1>(&relay, seed, &mut seen);
                        check::<2>(&relay, seed + 1, &mut seen);
                        check::<3>(&relay, seed + 2, &mut seen);
                        seed += 3;
                    }
                }
            }
        }
    }
    // Nothing of all this was left out: 2 goals, 4 sides, 9 orders, 2 rewards, imitation or none.
    assert_eq!(seen.len(), 2 + 4 + 9 + 2 + 2, "{seen:?}");
}
