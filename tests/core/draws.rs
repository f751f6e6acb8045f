//! How often a row is what: counts of what was drawn with one seed, beside what is expected.

use crate::fixed::fixed;
use insta::assert_snapshot;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::batch::Batch;
use rher_core::config::{GoalFrame, ObjectOrder, Preset, RelayConfig};
use rher_core::env::{End, EnvSpec, Mirror, Permutation, SignedIndex};
use rher_core::episode::Episode;
use rher_core::goal::{Achieved, Desired, EncodedGoal, LaterObjects, Position, Scene, Stage};
use rher_core::input::InputEncoder;
use rher_core::relabel::Relabeler;
use rher_core::replay::Replay;
use std::array;
use std::fmt::Write as _;

const STEPS: usize = 5;
const ROWS: usize = 10_000;

fn relay(objects: usize) -> RelayConfig {
    RelayConfig {
        goal_frame: GoalFrame::Absolute,
        object_order: ObjectOrder::Relay,
        ..Preset::Paper.config("draws", objects).relay
    }
}

/// An episode in which everything says which frame it is of: the observation is the number of the
/// frame, and so are decimeters of every place; targets are at −0.1 m.
fn numbered<const N: usize>(steps: usize, obs_dim: usize) -> Episode<N> {
    let frame = |frame: usize| {
        let place = Position::new(0.1 * frame as f32, 0.0, 0.0);
        Achieved(Scene::new(place, [place; N]))
    };
    let numbers = |frame: usize| std::iter::repeat_n(frame as f32, obs_dim);
    Episode {
        desired: Desired::of_task([Position::new(-0.1, 0.0, 0.0); N]),
        observations: (0..=steps).flat_map(numbers).collect(),
        achieved: (0..=steps).map(frame).collect(),
        actions: vec![1.0; steps],
        end: End::Truncated,
    }
}

/// Within four standard deviations of a share of `all`.
fn is_near(count: usize, share: f64, all: usize) -> bool {
    let all = all as f64;
    (count as f64 - share * all).abs() <= 4.0 * (all * share * (1.0 - share)).sqrt()
}

#[test]
fn later_frames_are_drawn_evenly_from_the_next_to_the_last() {
    let spec = EnvSpec::<1>::new("draws", 1, 1, STEPS);
    let relay = RelayConfig { hindsight: 0.8, ..relay(1) };
    let encoder = InputEncoder::new(&relay, &spec);
    let mut replay = Replay::new(&spec, STEPS);
    replay.push(&numbered::<1>(STEPS, 1));
    let mut batch = Batch::zeros(ROWS, encoder.width(), 1);
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    Relabeler::new(&relay, &spec).draw(
        &replay,
        &encoder,
        Stage::place(0),
        &mut batch,
        0..ROWS,
        &mut rng,
    );
    // The first number is the step; the object's goal comes after the gripper's.
    let mut counts = [[0_usize; STEPS + 1]; STEPS];
    for row in batch.inputs.chunks_exact(batch.input_dim) {
        let (step, later) = (row[0] as usize, (10.0 * row[4]).round());
        counts[step][if later < 0.0 { 0 } else { later as usize }] += 1;
    }
    let mut table = "step  task  frame 1     2     3     4     5\n".to_owned();
    for (step, counts) in counts.iter().enumerate() {
        write!(table, "{step} ").unwrap();
        for count in counts {
            write!(table, "{count:6}").unwrap();
        }
        table.push('\n');
        assert!(is_near(counts[0], 0.2 / 5.0, ROWS), "the task's goal, {counts:?}");
        let left = STEPS - step;
        for (later, count) in counts.iter().enumerate().skip(1) {
            let share = if later > step { 0.8 / 5.0 / left as f64 } else { 0.0 };
            assert!(is_near(*count, share, ROWS), "frame {later} after {step}: {counts:?}");
        }
    }
    assert_snapshot!(table, @r"
    step  task  frame 1     2     3     4     5
    0    421   308   319   314   312   328
    1    443     0   427   405   427   402
    2    399     0     0   498   549   536
    3    396     0     0     0   767   815
    4    405     0     0     0     0  1529
    ");
}

#[test]
fn every_mirror_is_drawn_for_itself() {
    let mirror = |axis: usize, flips: [f32; 2]| Mirror {
        axis,
        center: 0.0,
        observation: vec![SignedIndex { from: 0, sign: 1.0, offset: 0.0 }],
        action: (0..2).map(|from| SignedIndex { from, sign: flips[from], offset: 0.0 }).collect(),
        tail: Vec::new(),
    };
    let spec = EnvSpec::<1> {
        mirrors: vec![mirror(0, [-1.0, 1.0]), mirror(1, [1.0, -1.0])],
        ..EnvSpec::new("draws", 1, 2, STEPS)
    };
    let mut replay = Replay::new(&spec, STEPS);
    replay.push(&Episode { actions: vec![1.0; 2 * STEPS], ..numbered(STEPS, 1) });
    let count = |mirror| {
        let relay = RelayConfig { mirror, ..relay(1) };
        let encoder = InputEncoder::new(&relay, &spec);
        let mut batch = Batch::zeros(ROWS, encoder.width(), 2);
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        Relabeler::new(&relay, &spec).draw(
            &replay,
            &encoder,
            Stage::FIRST,
            &mut batch,
            0..ROWS,
            &mut rng,
        );
        let sides = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
        sides.map(|side| batch.actions.chunks_exact(2).filter(|action| **action == side).count())
    };
    assert_eq!(count(0.0), [ROWS, 0, 0, 0]);
    let counts = count(0.25);
    for (count, share) in counts.iter().zip([9.0, 3.0, 3.0, 1.0]) {
        assert!(is_near(*count, share / 16.0, ROWS), "{counts:?}");
    }
    assert_eq!(count(1.0), [0, 0, 0, ROWS]);
}

#[test]
fn permutations_are_drawn_evenly_of_those_that_bring_an_earlier_object() {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let permutation = |order: &[usize; 3]| Permutation {
        order: *order,
        observation: order
            .iter()
            .map(|&from| SignedIndex { from, sign: 1.0, offset: 0.0 })
            .collect(),
    };
    let spec = EnvSpec::<3> {
        permutations: orders[1..].iter().map(permutation).collect(),
        ..EnvSpec::new("draws", 3, 1, STEPS)
    };
    let mut replay = Replay::new(&spec, STEPS);
    let names = [0.0, 1.0, 2.0].repeat(STEPS + 1);
    replay.push(&Episode { observations: names, ..numbered(STEPS, 3) });
    let count = |exchange, object| {
        let relay = RelayConfig { exchange, ..relay(3) };
        let encoder = InputEncoder::new(&relay, &spec);
        let mut batch = Batch::zeros(ROWS, encoder.width(), 1);
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        Relabeler::new(&relay, &spec).draw(
            &replay,
            &encoder,
            Stage::place(object),
            &mut batch,
            0..ROWS,
            &mut rng,
        );
        orders.map(|order| {
            let seen = order.map(|object| object as f32);
            batch.inputs.chunks_exact(batch.input_dim).filter(|row| row[..3] == seen).count()
        })
    };
    let shares = [
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.4, 0.0, 0.3, 0.0, 0.3, 0.0],
        [0.4, 0.15, 0.0, 0.15, 0.15, 0.15],
    ];
    for (object, shares) in shares.into_iter().enumerate() {
        let counts = count(0.6, object);
        for (count, share) in counts.iter().zip(shares) {
            assert!(is_near(*count, share, ROWS), "object {object}: {counts:?}");
        }
        assert_eq!(count(0.0, object), [ROWS, 0, 0, 0, 0, 0]);
    }
    assert_eq!(count(1.0, 1)[0], 0, "a share of 1 leaves nothing as it was");
}

/// A share ends below its number: one that is 0 is never drawn, and 0.5 is not below 0.5.
#[test]
fn shares_end_where_they_should() {
    let relabeler = |hindsight| {
        let relay = RelayConfig { hindsight, ..relay(1) };
        Relabeler::new(&relay, &EnvSpec::<1>::new("draws", 1, 1, STEPS))
    };
    let episode = numbered::<1>(STEPS, 1);
    let goal = |hindsight, share| {
        let (achieved, desired) = (&episode.achieved, &episode.desired);
        relabeler(hindsight).goal(Stage::place(0), achieved, desired, 0, &mut fixed(share))
    };
    let of_task = EncodedGoal::new(Stage::place(0), &episode.achieved[0], &episode.desired);
    assert_eq!([goal(0.0, 0.0), goal(0.5, 0.5)], [of_task; 2]);
    assert_ne!(goal(0.5, 0.5 - 1e-6), of_task);

    let flip = SignedIndex { from: 0, sign: -1.0, offset: 0.0 };
    let same = SignedIndex { sign: 1.0, ..flip };
    let mirror = Mirror {
        axis: 0,
        center: 0.0,
        observation: vec![same],
        action: vec![flip],
        tail: Vec::new(),
    };
    let spec = EnvSpec::<1> { mirrors: vec![mirror], ..EnvSpec::new("draws", 1, 1, STEPS) };
    let relay = RelayConfig { mirror: 0.5, hindsight: 0.0, ..relay(1) };
    let encoder = InputEncoder::new(&relay, &spec);
    let mut replay = Replay::new(&spec, STEPS);
    replay.push(&episode);
    let action = |share| {
        let mut batch = Batch::zeros(1, encoder.width(), 1);
        let rng = &mut fixed(share);
        Relabeler::new(&relay, &spec).draw(&replay, &encoder, Stage::FIRST, &mut batch, 0..1, rng);
        batch.actions[0]
    };
    assert_eq!([action(0.5), action(0.5 - 1e-6)], [1.0, -1.0]);
}

/// Without permutations a batch is the same, whether it is the setting or the environment that has
/// none: nothing is drawn for them.
#[test]
fn a_share_of_no_permutations_draws_nothing() {
    let same = |from| SignedIndex { from, sign: 1.0, offset: 0.0 };
    let permutation = Permutation { order: [1, 0], observation: vec![same(1), same(0)] };
    let draw = |exchange, permutations| {
        let relay = RelayConfig { exchange, ..relay(2) };
        let spec = EnvSpec::<2> { permutations, ..EnvSpec::new("draws", 2, 1, STEPS) };
        let encoder = InputEncoder::new(&relay, &spec);
        let mut replay = Replay::new(&spec, STEPS);
        replay.push(&numbered::<2>(STEPS, 2));
        let mut batch = Batch::zeros(20, encoder.width(), 1);
        let rng = &mut ChaCha8Rng::seed_from_u64(0);
        let stage = Stage::place(1);
        Relabeler::new(&relay, &spec).draw(&replay, &encoder, stage, &mut batch, 0..20, rng);
        batch
    };
    assert_eq!(draw(0.0, vec![permutation]), draw(0.0, Vec::new()));
    assert_eq!(draw(0.5, Vec::new()), draw(0.0, Vec::new()), "nor where there are none");
}

/// The normalizer sees every step once, with a goal of every sub-task: what the task asked for, or
/// what was reached at the only later step.
#[test]
fn statistics_are_of_every_step_and_its_goals() {
    for (steps, hindsight) in [(STEPS, 0.0), (1, 1.0)] {
        let spec = EnvSpec::<2>::new("draws", 1, 1, steps);
        let relay = RelayConfig { hindsight, later_objects: LaterObjects::Later, ..relay(2) };
        let stages: Vec<Stage<2>> = Stage::all().collect();
        let episode = numbered::<2>(steps, 1);
        let mut encoder = InputEncoder::new(&relay, &spec);
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        Relabeler::new(&relay, &spec).observe(&episode, &stages, &mut encoder, &mut rng);

        let mut expected = InputEncoder::new(&relay, &spec);
        for (step, now) in episode.achieved[..steps].iter().enumerate() {
            expected.observe(&[step as f32]);
            let desired = if hindsight > 0.0 {
                Desired::in_hindsight(episode.achieved[step + 1], LaterObjects::Later)
            } else {
                episode.desired
            };
            for stage in &stages {
                expected.observe_goal(now, &EncodedGoal::new(*stage, now, &desired));
            }
        }
        assert_ne!(encoder, expected, "its means are not those of nothing");
        expected.refresh();
        assert_eq!(encoder, expected);
    }
}

/// What a normalizer was shown is in force after it was refreshed, and not before.
#[test]
fn statistics_are_applied() {
    let spec = EnvSpec::<1>::new("draws", 1, 1, STEPS);
    let mut encoder = InputEncoder::new(&relay(1), &spec);
    let now = Achieved(Scene::new(Position::origin(), [Position::origin()]));
    let goal = EncodedGoal::new(Stage::FIRST, &now, &Desired::of_task([Position::origin()]));
    let first = |encoder: &InputEncoder, number: f32| {
        let mut row = vec![0.0; encoder.width()];
        encoder.write(&[number], &now, &goal, &mut row);
        row[0]
    };
    assert_eq!([first(&encoder, 4.0), first(&encoder, 9.0)], [4.0, 5.0], "clipped to 5");
    for number in [1.0, 3.0] {
        encoder.observe(&[number]);
    }
    assert_eq!(first(&encoder, 4.0), 4.0);
    encoder.refresh();
    // The mean is 2 and the deviation 1.
    let numbers: [f32; 4] = array::from_fn(|number| first(&encoder, 2.0 * number as f32));
    assert_eq!(numbers, [-2.0, 0.0, 2.0, 4.0]);
    // A number that hardly varies is divided by 0.01.
    let mut encoder = InputEncoder::new(&relay(1), &spec);
    encoder.observe(&[1.0]);
    encoder.refresh();
    assert_eq!(
        [first(&encoder, 1.0), first(&encoder, 1.5), first(&encoder, 0.0)],
        [0.0, 5.0, -5.0]
    );
    assert!((first(&encoder, 1.01) - 1.0).abs() < 1e-4);
}

/// In half of the episodes nothing moves, so that every goal in hindsight is already met.
#[test]
fn goals_that_are_already_met_are_drawn_again() {
    let spec = EnvSpec::<1>::new("draws", 1, 1, STEPS);
    let mut still = numbered::<1>(STEPS, 1);
    still.achieved = vec![still.achieved[0]; STEPS + 1];
    still.observations.fill(-1.0);
    let mut replay = Replay::new(&spec, 2 * STEPS);
    replay.push(&still);
    replay.push(&numbered::<1>(STEPS, 1));
    for (hindsight, redraw_met) in [(1.0, 0.0), (1.0, 0.5), (0.6, 0.5), (1.0, 1.0)] {
        let relay = RelayConfig { hindsight, redraw_met, ..relay(1) };
        let encoder = InputEncoder::new(&relay, &spec);
        let mut batch = Batch::zeros(ROWS, encoder.width(), 1);
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        Relabeler::new(&relay, &spec).draw(
            &replay,
            &encoder,
            Stage::place(0),
            &mut batch,
            0..ROWS,
            &mut rng,
        );
        // A row of the still episode whose goal is its own place, not the task's.
        let is_met = |row: &&[f32]| row[0] == -1.0 && row[4] == 0.0;
        let met = batch.inputs.chunks_exact(batch.input_dim).filter(is_met).count();
        let share = f64::from(hindsight) / 2.0;
        let again = f64::from(redraw_met);
        let expected = (0..4).fold(share, |after, _| share * (1.0 - again + again * after));
        assert!(is_near(met, expected, ROWS), "{met} rows with {relay:?}, expected {expected}");
    }
}
