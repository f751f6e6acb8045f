//! Laws of hindsight, for any episode.

use proptest::prelude::*;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::batch::Batch;
use rher_core::config::{GoalFrame, ObjectOrder, Preset, RelayConfig};
use rher_core::env::{End, EnvSpec, Mirror, Permutation, SignedIndex};
use rher_core::episode::Episode;
use rher_core::goal::{
    Achieved, Desired, EncodedGoal, LaterObjects, Position, Scene, Stage, Tolerances,
};
use rher_core::input::InputEncoder;
use rher_core::relabel::Relabeler;
use rher_core::replay::Replay;
use rher_core::{Control, Names};

const STEPS: usize = 6;

fn spec(mirrors: Vec<Mirror>, permutations: Vec<Permutation<2>>) -> EnvSpec<2> {
    EnvSpec {
        name: "law".to_owned(),
        variant: String::new(),
        obs_dim: 2,
        action_dim: 1,
        episode_steps: STEPS,
        subtasks: 4,
        tolerances: Tolerances::uniform(0.05),
        mirrors,
        permutations,
        any_order: false,
        names: Names::default(),
        control: Control::default(),
    }
}

fn position() -> impl Strategy<Value = Position> {
    prop::array::uniform3(-0.2_f32..0.2).prop_map(Position::from)
}

fn scene() -> impl Strategy<Value = Scene<2>> {
    (position(), prop::array::uniform2(position()))
        .prop_map(|(gripper, objects)| Scene::new(gripper, objects))
}

fn episode() -> impl Strategy<Value = Episode<2>> {
    (
        prop::array::uniform2(position()),
        prop::collection::vec(scene(), STEPS + 1),
        prop::collection::vec(-1.0_f32..1.0, 2 * (STEPS + 1)),
        prop::collection::vec(-1.0_f32..1.0, STEPS),
    )
        .prop_map(|(targets, scenes, observations, actions)| Episode {
            desired: Desired::of_task(targets),
            achieved: scenes.into_iter().map(Achieved).collect(),
            observations,
            actions,
            end: End::Truncated,
        })
}

fn relabeler(hindsight: f32, later_objects: LaterObjects, mirror: f32) -> Relabeler<2> {
    let mut config = Preset::Paper.config("law", 2).relay;
    config.hindsight = hindsight;
    config.later_objects = later_objects;
    config.mirror = mirror;
    let reflect = |sign| SignedIndex { from: 0, sign, offset: 0.0 };
    let mirror = Mirror {
        axis: 1,
        center: 0.1,
        observation: vec![reflect(1.0), SignedIndex { from: 1, sign: -1.0, offset: 0.2 }],
        action: vec![reflect(-1.0)],
        tail: Vec::new(),
    };
    Relabeler::new(&config, &spec(vec![mirror], Vec::new()))
}

fn input_encoder<const N: usize>(goal_frame: GoalFrame, spec: &EnvSpec<N>) -> InputEncoder {
    let relay = Preset::Paper.config("law", N).relay;
    InputEncoder::new(&RelayConfig { goal_frame, ..relay }, spec)
}

/// The two objects change places; the two numbers of an observation belong to one each, the second
/// with the other sign.
fn exchange() -> Permutation<2> {
    let from = |from| SignedIndex { from, sign: -1.0, offset: 0.0 };
    Permutation { order: [1, 0], observation: vec![from(1), from(0)] }
}

proptest! {
    #[test]
    fn a_hindsight_goal_is_the_goal_of_some_later_frame(
        episode in episode(), stage in 0..4_usize, step in 0..STEPS, seed: u64,
    ) {
        let stage = Stage::from_index(stage).unwrap();
        for later_objects in [LaterObjects::Now, LaterObjects::Later] {
            let relabeler = relabeler(1.0, later_objects, 0.0);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let goal =
                relabeler.goal(stage, &episode.achieved, &episode.desired, step, &mut rng);
            let of_frame = |later: &Achieved<2>| {
                let desired = Desired::in_hindsight(*later, later_objects);
                EncodedGoal::new(stage, &episode.achieved[step], &desired)
            };
            prop_assert!(episode.achieved[step + 1..].iter().any(|later| of_frame(later) == goal));
        }
    }

    #[test]
    fn without_hindsight_the_goal_is_the_tasks(
        episode in episode(), stage in 0..4_usize, step in 0..STEPS, seed: u64,
    ) {
        let stage = Stage::from_index(stage).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let goal = relabeler(0.0, LaterObjects::Now, 0.0)
            .goal(stage, &episode.achieved, &episode.desired, step, &mut rng);
        let expected = EncodedGoal::new(stage, &episode.achieved[step], &episode.desired);
        prop_assert_eq!(goal, expected);
    }

    #[test]
    fn what_the_next_frame_reached_is_rewarded(
        episode in episode(), stage in 0..4_usize, seed: u64,
    ) {
        // The last step has one later frame, the one it ends at.
        let step = STEPS - 1;
        let stage = Stage::from_index(stage).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let goal = relabeler(1.0, LaterObjects::Later, 0.0)
            .goal(stage, &episode.achieved, &episode.desired, step, &mut rng);
        prop_assert!(goal.is_met(&episode.achieved[STEPS], &Tolerances::uniform(0.0)));
    }

    #[test]
    fn rows_are_steps_of_stored_episodes(
        episodes in prop::collection::vec(episode(), 1..5), stage in 0..4_usize, seed: u64,
    ) {
        let spec = spec(Vec::new(), Vec::new());
        let mut replay = Replay::new(&spec, 3 * STEPS);
        for episode in &episodes {
            replay.push(episode);
        }
        let encoder = input_encoder(GoalFrame::Absolute, &spec);
        let mut batch = Batch::zeros(16, encoder.width(), 1);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let stage = Stage::from_index(stage).unwrap();
        let rewarded = relabeler(0.8, LaterObjects::Now, 0.0)
            .draw(&replay, &encoder, stage, &mut batch, 0..16, &mut rng);
        prop_assert_eq!(rewarded, batch.rewards.iter().filter(|reward| **reward == 0.0).count());
        let kept = &episodes[episodes.len().saturating_sub(3)..];
        for row in 0..16 {
            let input = &batch.inputs[row * batch.input_dim..][..batch.input_dim];
            let next = &batch.next_inputs[row * batch.input_dim..][..batch.input_dim];
            let is_step = |episode: &Episode<2>, step: usize| {
                input[..2] == episode.observations[2 * step..][..2]
                    && next[..2] == episode.observations[2 * (step + 1)..][..2]
                    && batch.actions[row] == episode.actions[step]
            };
            prop_assert!(kept.iter().any(|e| (0..STEPS).any(|step| is_step(e, step))));
            prop_assert_eq!(&input[2..], &next[2..], "the next state keeps the goal");
        }
    }

    #[test]
    fn a_row_imitates_the_sub_task_whose_turn_it_is(
        episode in episode(), stage in 0..4_usize, seed: u64,
    ) {
        let spec = spec(Vec::new(), Vec::new());
        let mut replay = Replay::new(&spec, STEPS);
        replay.push(&episode);
        let encoder = input_encoder(GoalFrame::Relative, &spec);
        let mut batch = Batch::zeros(8, encoder.width(), 1);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let stage = Stage::from_index(stage).unwrap();
        relabeler(0.0, LaterObjects::Now, 0.0)
            .draw(&replay, &encoder, stage, &mut batch, 0..8, &mut rng);
        let inputs = batch.inputs.chunks(batch.input_dim);
        let simpler = batch.simpler_inputs.chunks(batch.input_dim);
        for ((input, simpler), imitates) in inputs.zip(simpler).zip(&batch.imitates) {
            let is_step = |step: &usize| input[..2] == episode.observations[2 * step..][..2];
            let step = (0..STEPS).find(is_step).unwrap();
            let now = &episode.achieved[step];
            let apart = nalgebra::distance(&now.0.objects[0], &episode.desired.objects()[0]);
            prop_assert_eq!(*imitates, stage.object() == 1 && apart > 0.05);
            if *imitates {
                let goal = EncodedGoal::new(Stage::place(0), now, &episode.desired);
                let mut expected = vec![0.0; batch.input_dim];
                encoder.write(&input[..2], now, &goal, &mut expected);
                prop_assert_eq!(simpler, expected);
            }
        }
    }

    #[test]
    fn a_mirrored_batch_is_the_mirror_image(episode in episode(), stage in 0..4_usize, seed: u64) {
        let spec = spec(Vec::new(), Vec::new());
        let mut replay = Replay::new(&spec, STEPS);
        replay.push(&episode);
        let encoder = input_encoder(GoalFrame::Absolute, &spec);
        let stage = Stage::from_index(stage).unwrap();
        let draw = |mirror: f32| {
            let mut batch = Batch::zeros(8, encoder.width(), 1);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            relabeler(0.8, LaterObjects::Now, mirror)
                .draw(&replay, &encoder, stage, &mut batch, 0..8, &mut rng);
            batch
        };
        // A share this small is never drawn, and leaves the generator in step.
        let (plain, mirrored) = (draw(f32::MIN_POSITIVE), draw(1.0));
        prop_assert_eq!(&plain.rewards, &mirrored.rewards);
        let flipped = |a: f32, b: f32| (a + b - 0.2).abs() < 1e-5;
        for (a, b) in plain.inputs.chunks(11).zip(mirrored.inputs.chunks(11)) {
            prop_assert!(a[0] == b[0] && flipped(a[1], b[1]));
            for (a, b) in a[2..].chunks(3).zip(b[2..].chunks(3)) {
                let blank = a == [-5.0; 3] && b == [-5.0; 3];
                prop_assert!(blank || a[0] == b[0] && flipped(a[1], b[1]) && a[2] == b[2]);
            }
        }
        for (a, b) in plain.actions.iter().zip(&mirrored.actions) {
            prop_assert_eq!(*a, -b);
        }
    }
}

proptest! {
    /// Whether a batch is drawn from an episode with its objects exchanged, or the objects are
    /// exchanged when it is drawn.
    #[test]
    fn an_exchanged_batch_is_that_of_the_exchanged_episode(
        episode in episode(), stage in 0..4_usize, seed: u64,
    ) {
        let spec = spec(Vec::new(), vec![exchange()]);
        let order = exchange().order;
        // The first object takes nobody's place.
        let order = if stage < 2 { [0, 1] } else { order };
        let mut other = episode.clone();
        other.desired = episode.desired.reordered(&order);
        other.achieved = episode.achieved.iter().map(|a| Achieved(a.0.reordered(&order))).collect();
        let pairs = episode.observations.chunks_exact(2).zip(other.observations.chunks_exact_mut(2));
        for (observation, image) in pairs {
            if stage >= 2 {
                SignedIndex::apply(&exchange().observation, observation, image);
            }
        }
        let encoder = input_encoder(GoalFrame::Relative, &spec);
        let stage = Stage::from_index(stage).unwrap();
        let draw = |episode, exchange| {
            let mut config = Preset::Paper.config("law", 2).relay;
            config.exchange = exchange;
            let mut replay = Replay::new(&spec, STEPS);
            replay.push(episode);
            let mut batch = Batch::zeros(8, encoder.width(), 1);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            Relabeler::new(&config, &spec)
                .draw(&replay, &encoder, stage, &mut batch, 0..8, &mut rng);
            batch
        };
        // One share is always drawn, the other never.
        prop_assert_eq!(draw(&episode, 1.0), draw(&other, f32::MIN_POSITIVE));
    }
}

proptest! {
    /// One object is in its place and the other is not: in order of turn it is the same input
    /// whichever of the two comes first in the relay.
    #[test]
    fn in_order_of_turn_it_does_not_matter_which_object_is_left(
        scene in scene(), target in position(), numbers in prop::array::uniform2(-1.0_f32..1.0),
    ) {
        let spec = spec(Vec::new(), vec![exchange()]);
        let relay = Preset::Fast.config("law", 2).relay;
        prop_assert_eq!(relay.object_order, ObjectOrder::Turn);
        let mut encoder = InputEncoder::new(&relay, &spec);
        let (now, desired) = (Achieved(scene), Desired::of_task([scene.objects[0], target]));
        prop_assume!(nalgebra::distance(&scene.objects[1], &target) > 0.05);
        encoder.observe(&numbers);
        encoder.observe(&[0.3, -0.4]);
        encoder.observe_goal(&now, &EncodedGoal::new(Stage::place(1), &now, &desired));
        encoder.refresh();

        let row = |now: &Achieved<2>, desired: &Desired<2>, numbers: &[f32]| {
            let mut row = vec![0.0; encoder.width()];
            let goal = EncodedGoal::new(Stage::place(1), now, desired);
            encoder.write(numbers, now, &goal, &mut row);
            row
        };
        let Permutation { order, observation } = exchange();
        let mut exchanged = [0.0; 2];
        SignedIndex::apply(&observation, &numbers, &mut exchanged);
        prop_assert_eq!(
            row(&now, &desired, &numbers),
            row(&Achieved(scene.reordered(&order)), &desired.reordered(&order), &exchanged)
        );
    }
}

/// An object that is as far from its target as its tolerance allows is in its place: the turn goes
/// to the next.
#[test]
fn at_its_tolerance_an_object_is_in_its_place() {
    let spec = spec(Vec::new(), vec![exchange()]);
    let relay = Preset::Fast.config("law", 2).relay;
    assert_eq!(relay.object_order, ObjectOrder::Turn);
    let encoder = InputEncoder::new(&relay, &spec);
    let origin = Position::origin();
    let desired = Desired::of_task([origin, Position::new(0.0, 1.0, 0.0)]);
    let first_number = |apart: f32| {
        let objects = [Position::new(apart, 0.0, 0.0), origin];
        let now = Achieved(Scene::new(origin, objects));
        let goal = EncodedGoal::new(Stage::place(1), &now, &desired);
        let mut row = vec![0.0; encoder.width()];
        encoder.write(&[0.25, 0.75], &now, &goal, &mut row);
        row[0]
    };
    // Exchanged, the second number comes first, with the other sign.
    assert_eq!([first_number(0.05), first_number(0.051)], [-0.75, 0.25]);
}

/// The first object ends 4 cm beside its target, where 5 cm are allowed.
#[test]
fn training_can_ask_for_more_than_the_task() {
    let spec = spec(Vec::new(), Vec::new());
    let scene = |x| {
        let objects = [Position::new(x, 0.0, 0.0), Position::origin()];
        Achieved(Scene::new(Position::origin(), objects))
    };
    let mut replay = Replay::new(&spec, STEPS);
    replay.push(&Episode {
        desired: Desired::of_task([Position::origin(); 2]),
        achieved: vec![scene(0.04); STEPS + 1],
        observations: vec![0.0; 2 * (STEPS + 1)],
        actions: vec![0.0; STEPS],
        end: End::Truncated,
    });
    let rewarded = |tolerance| {
        let relay =
            RelayConfig { tolerance, hindsight: 0.0, ..Preset::Paper.config("law", 2).relay };
        let encoder = InputEncoder::new(&relay, &spec);
        let mut batch = Batch::zeros(8, encoder.width(), 1);
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let stage = Stage::place(0);
        Relabeler::new(&relay, &spec).draw(&replay, &encoder, stage, &mut batch, 0..8, &mut rng)
    };
    assert_eq!(rewarded(1.0), 8);
    assert_eq!(rewarded(0.7), 0, "3.5 cm are allowed");
}

#[test]
fn a_blank_slot_is_a_flag_that_no_position_can_be_taken_for() {
    let now = Achieved(Scene::new(Position::new(1.3, 0.7, 0.4), [Position::new(1.4, 0.8, 0.4)]));
    let desired = Desired::of_task([Position::new(1.2, 0.6, 0.4)]);
    for (frame, blank) in [(GoalFrame::Absolute, -5.0), (GoalFrame::Relative, 0.0)] {
        let mut encoder = input_encoder(frame, &EnvSpec::<1>::new("law", 1, 1, STEPS));
        for stage in Stage::<1>::all() {
            encoder.observe_goal(&now, &EncodedGoal::new(stage, &now, &desired));
        }
        encoder.refresh();
        let mut row = vec![0.0; encoder.width()];
        for (stage, (blank_at, real_at)) in Stage::<1>::all().zip([(4, 1), (1, 4)]) {
            encoder.write(&[0.0], &now, &EncodedGoal::new(stage, &now, &desired), &mut row);
            assert_eq!(row[blank_at..blank_at + 3], [blank; 3], "{frame:?}");
            assert!(row[real_at..real_at + 3].iter().all(|x| x.abs() < 1.0), "{frame:?} {row:?}");
            if frame == GoalFrame::Relative {
                let flags = if stage == Stage::FIRST { [0.0, 1.0] } else { [1.0, 0.0] };
                assert_eq!(row[7..], flags);
            }
        }
    }
}
