//! Laws of goals that are more than positions, for any number of objects.

#![expect(clippy::disallowed_methods, reason = "what is compared is nearly the same anywhere")]

use proptest::prelude::*;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::batch::Batch;
use rher_core::config::{GoalFrame, Preset, RelayConfig};
use rher_core::env::{End, Env, EnvError, EnvSpec, Mirror, Permutation, SignedIndex, Start};
use rher_core::episode::{Episode, rollout};
use rher_core::goal::{
    Achieved, Desired, EncodedGoal, LaterObjects, Leg, Metric, Position, Scene, Stage, TailError,
    TailPart, TailSpec, Tails, Tolerances,
};
use rher_core::input::InputEncoder;
use rher_core::relabel::Relabeler;
use rher_core::replay::Replay;
use rher_core::testing::check_env;
use std::array;
use std::f32::consts::{PI, TAU};

/// All there is: a length, an angle, an orientation and a flag, 7 numbers.
const NUMBERS: usize = 7;
const LENGTH: f32 = 0.02;
const ANGLE: f32 = 0.3;
const TURN: f32 = 0.4;

fn all_parts() -> TailSpec {
    let (length, angle) = (TailPart::difference(LENGTH), TailPart::angle(ANGLE));
    TailSpec::beside_positions(&[length, angle, TailPart::rotation(TURN), TailPart::flag()])
        .unwrap()
}

fn tolerances<const N: usize>() -> Tolerances<N> {
    Tolerances { tail: all_parts(), ..Tolerances::uniform(0.05) }
}

/// A turn by `angle` about an axis through the pole at this longitude, as `(x, y, z, w)`.
fn turn(angle: f32, longitude: f32, length: f32) -> [f32; 4] {
    let (sin, cos) = (angle / 2.0).sin_cos();
    let axis = [longitude.cos() * 0.6, longitude.sin() * 0.6, 0.8];
    let [x, y, z] = axis.map(|part| part * sin);
    [x, y, z, cos].map(|number| number * length)
}

fn tail(rng: &mut ChaCha8Rng) -> [f32; NUMBERS] {
    let [x, y, z, w] = turn(rng.random_range(0.0..TAU), rng.random_range(0.0..TAU), 1.0);
    let flag = f32::from(u8::from(rng.random::<bool>()));
    [rng.random_range(-1.0..1.0), rng.random_range(-9.0..9.0), x, y, z, w, flag]
}

fn place(rng: &mut ChaCha8Rng) -> Position {
    Position::new(rng.random(), rng.random(), rng.random())
}

fn scene<const N: usize>(rng: &mut ChaCha8Rng) -> Scene<N> {
    let gripper = place(rng);
    let objects = array::from_fn(|_| place(rng));
    Scene::new(gripper, objects).with_tails(Tails::new(array::from_fn(|_| tail(rng))))
}

/// A scene near another one: each part is within its tolerance or a little beyond it, as `is_near`
/// says of the position, the length, the angle, the orientation and the flag of each object.
fn near<const N: usize>(scene: &Scene<N>, is_near: &[[bool; 5]; N], sign: f32) -> Scene<N> {
    let beyond = |near: bool| if near { 0.9 } else { 1.1 };
    let objects = array::from_fn(|object| {
        let shift = sign * 0.05 * beyond(is_near[object][0]);
        scene.objects[object] + nalgebra::Vector3::y() * shift
    });
    let tails = array::from_fn(|object| {
        let [_, length, angle, orientation, flag] = is_near[object].map(beyond);
        let t = scene.tails.of_object(object);
        let q = nalgebra::Quaternion::new(t[5], t[2], t[3], t[4]);
        let [x, y, z, w] = turn(sign * TURN * orientation, 1.0, -1.7);
        let q = nalgebra::Quaternion::new(w, x, y, z) * q;
        let flag = if flag < 1.0 { t[6] } else { 1.0 - t[6] };
        let angle = t[1] + sign * ANGLE * angle + sign * TAU;
        [t[0] + sign * LENGTH * length, angle, q.i, q.j, q.k, q.w, flag]
    });
    Scene::new(scene.gripper, objects).with_tails(Tails::new(tails))
}

/// Calls a law for one to six objects.
macro_rules! for_every_n {
    ($law:ident($($argument:expr),*)) => {
        $law::<1>($($argument),*)?;
        $law::<2>($($argument),*)?;
        $law::<3>($($argument),*)?;
        $law::<4>($($argument),*)?;
        $law::<5>($($argument),*)?;
        $law::<6>($($argument),*)?;
    };
}

type Law = Result<(), TestCaseError>;

proptest! {
    #[test]
    fn distances_are_symmetric_and_know_what_is_the_same(
        a in -9.0_f32..9.0, b in -9.0_f32..9.0, turns in -3_i32..=3,
        angle in 0.0_f32..PI, longitude in 0.0_f32..TAU, length in 0.1_f32..3.0, seed: u64,
    ) {
        for metric in [Metric::Difference, Metric::Angle, Metric::Flag] {
            prop_assert_eq!(metric.distance(&[a], &[b]), metric.distance(&[b], &[a]));
            prop_assert_eq!(metric.distance(&[a], &[a]), 0.0);
        }
        let far = Metric::Angle.distance(&[a], &[b]);
        prop_assert!((0.0..=PI + 1e-6).contains(&far));
        let around = Metric::Angle.distance(&[a + TAU * turns as f32], &[b]);
        prop_assert!((far - around).abs() < 1e-5, "{far} and {around}");
        prop_assert!(((a - b).cos() - far.cos()).abs() < 1e-5);

        let t = tail(&mut ChaCha8Rng::seed_from_u64(seed));
        let q = nalgebra::Quaternion::new(t[5], t[2], t[3], t[4]);
        let [x, y, z, w] = turn(angle, longitude, length);
        let turned = nalgebra::Quaternion::new(w, x, y, z) * q;
        let (q, turned) = (q.coords, turned.coords);
        for sign in [1.0, -1.0] {
            let other: Vec<f32> = turned.iter().map(|number| sign * number).collect();
            let ways = [
                Metric::Rotation.distance(q.as_slice(), &other),
                Metric::Rotation.distance(&other, q.as_slice()),
            ];
            for far in ways {
                prop_assert!((far - angle).abs() < 2e-3, "{far}, turned by {angle}");
            }
        }
    }

    #[test]
    fn a_step_is_rewarded_if_and_only_if_every_part_is_within_its_tolerance(
        seed: u64, is_near in prop::array::uniform6(prop::array::uniform5(prop::bool::weighted(0.9))),
        positive: bool,
    ) {
        fn law<const N: usize>(seed: u64, is_near: &[[bool; 5]; 6], sign: f32) -> Law {
            let wanted = scene::<N>(&mut ChaCha8Rng::seed_from_u64(seed));
            let is_near: [[bool; 5]; N] = array::from_fn(|object| is_near[object]);
            let mut reached = Achieved(near(&wanted, &is_near, sign));
            let desired = Desired::of_task(wanted.objects).with_tails(wanted.tails);
            let is_there = |object: usize| is_near[object].iter().all(|near| *near);
            for stage in Stage::<N>::all() {
                // The gripper is where it should be, and the later objects stay where they are.
                reached.0.gripper = reached.0.objects[stage.object()];
                let about = stage.object() + usize::from(stage.leg() == Leg::Place);
                let goal = EncodedGoal::new(stage, &reached, &desired);
                let expected = (0..about).all(is_there);
                prop_assert_eq!(goal.is_met(&reached, &tolerances()), expected, "{:?}", stage);
                let reward = goal.reward(&reached, &tolerances());
                prop_assert_eq!(reward, if expected { 0.0 } else { -1.0 });
            }
            for object in 0..N {
                let placed = tolerances().placed(object, &reached, &desired);
                prop_assert_eq!(placed, is_there(object));
            }
            let turn = Stage::of(&reached, &desired, &tolerances(), 0.0).object();
            prop_assert_eq!(turn, (0..N - 1).find(|i| !is_there(*i)).unwrap_or(N - 1));
            Ok(())
        }
        for_every_n!(law(seed, &is_near, if positive { 1.0 } else { -1.0 }));
    }

    #[test]
    fn the_tail_of_a_blank_slot_does_not_matter(seed: u64) {
        fn law<const N: usize>(seed: u64) -> Law {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let (wanted, mut now) = (scene::<N>(&mut rng), scene::<N>(&mut rng));
            now.gripper = now.objects[N - 1];
            for object in 0..N - 1 {
                now.objects[object] = wanted.objects[object];
            }
            let tails: [[f32; NUMBERS]; N] = array::from_fn(|object| {
                let of = if object < N - 1 { &wanted } else { &now };
                array::from_fn(|number| of.tails.of_object(object)[number])
            });
            let now = Achieved(now.with_tails(Tails::new(tails)));
            let desired = Desired::of_task(wanted.objects).with_tails(wanted.tails);
            let stage = Stage::<N>::from_index(2 * N - 2).unwrap();
            prop_assert_eq!(stage.leg(), Leg::Reach);
            prop_assert!(EncodedGoal::new(stage, &now, &desired).is_met(&now, &tolerances()));
            Ok(())
        }
        for_every_n!(law(seed));
    }

    #[test]
    fn hindsight_asks_for_the_tails_that_were_reached(seed: u64) {
        fn law<const N: usize>(seed: u64) -> Law {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let frames = [scene::<N>(&mut rng), scene(&mut rng)].map(Achieved);
            let asked = Desired::of_task(scene::<N>(&mut rng).objects);
            let config = RelayConfig {
                hindsight: 1.0,
                later_objects: LaterObjects::Later,
                ..Preset::Paper.config("law", N).relay
            };
            let spec = EnvSpec::<N> { tolerances: tolerances(), ..EnvSpec::new("law", 1, 1, 1) };
            for stage in Stage::<N>::all() {
                let relabeler = Relabeler::new(&config, &spec);
                let goal = relabeler.goal(stage, &frames, &asked, 0, &mut rng);
                // A quaternion is compared with itself up to rounding.
                let exact = [
                    TailPart::difference(0.0),
                    TailPart::angle(0.0),
                    TailPart::rotation(1e-3),
                    TailPart::flag(),
                ];
                let tail = TailSpec::beside_positions(&exact).unwrap();
                let exact = Tolerances { tail, ..Tolerances::uniform(0.0) };
                prop_assert!(goal.is_met(&frames[1], &exact), "{:?}", stage);
            }
            Ok(())
        }
        for_every_n!(law(seed));
    }

    #[test]
    fn a_replay_gives_back_what_was_stored(seed: u64) {
        fn law<const N: usize>(seed: u64) -> Law {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let spec = EnvSpec::<N> { tolerances: tolerances(), ..EnvSpec::new("law", 2, 1, 2) };
            let mut replay = Replay::new(&spec, 4);
            let mut episodes = Vec::new();
            for _ in 0..3 {
                let wanted = scene::<N>(&mut rng);
                episodes.push(Episode {
                    desired: Desired::of_task(wanted.objects).with_tails(wanted.tails),
                    observations: (0..6).map(|_| rng.random()).collect(),
                    achieved: (0..3).map(|_| Achieved(scene(&mut rng))).collect(),
                    actions: vec![rng.random(), rng.random()],
                    end: End::Truncated,
                });
                replay.push(&episodes[episodes.len() - 1]);
            }
            prop_assert_eq!(replay.newest(2).collect::<Vec<_>>(), &episodes[1..]);
            Ok(())
        }
        for_every_n!(law(seed));
    }

    #[test]
    fn networks_see_the_same_of_the_same_orientation_and_angle(seed: u64, relative: bool) {
        fn law<const N: usize>(seed: u64, relative: bool) -> Law {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let spec = EnvSpec::<N> { tolerances: tolerances(), ..EnvSpec::new("law", 1, 1, 1) };
            let goal_frame = if relative { GoalFrame::Relative } else { GoalFrame::Absolute };
            let relay = RelayConfig { goal_frame, ..Preset::Fast.config("law", N).relay };
            let encoder = InputEncoder::new(&relay, &spec);
            let now = Achieved(scene::<N>(&mut rng));
            let wanted = scene::<N>(&mut rng);
            let other: [[f32; NUMBERS]; N] = array::from_fn(|object| {
                let t = wanted.tails.of_object(object);
                [t[0], t[1] + TAU, -t[2], -t[3], -t[4], -t[5], t[6]]
            });
            let rows = [wanted.tails, Tails::new(other)].map(|tails| {
                let desired = Desired::of_task(wanted.objects).with_tails(tails);
                let goal = EncodedGoal::new(Stage::place(N - 1), &now, &desired);
                let mut row = vec![f32::NAN; encoder.width()];
                encoder.write(&[0.5], &now, &goal, &mut row);
                row
            });
            for (index, (one, other)) in rows[0].iter().zip(&rows[1]).enumerate() {
                // The distance on the fine scale is in units of the tolerance.
                prop_assert!((one - other).abs() < 2e-4, "{}: {} and {}", index, one, other);
            }
            // A length, cosine and sine, two axes, a flag; and how far each part is.
            prop_assert_eq!(encoder.width(), 1 + 3 + 13 * N
                + if relative { N + 1 } else { 0 } + 4 * (N + 1) + 6 * N - 3 + 4 * N);
            Ok(())
        }
        for_every_n!(law(seed, relative));
    }

    #[test]
    fn without_positions_only_the_tail_matters(seed: u64, relative: bool) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let tail = TailSpec::instead_of_positions(&[TailPart::angle(ANGLE)]).unwrap();
        let tolerances = Tolerances { tail, ..Tolerances::uniform(0.05) };
        let spec = EnvSpec::<2> { tolerances, ..EnvSpec::new("law", 1, 1, 1) };
        let goal_frame = if relative { GoalFrame::Relative } else { GoalFrame::Absolute };
        let relay = RelayConfig { goal_frame, ..Preset::Fast.config("law", 2).relay };
        let encoder = InputEncoder::new(&relay, &spec);
        let now = Achieved(scene::<2>(&mut rng).with_tails(Tails::new([[1.0], [2.0]])));
        let rows = [(); 2].map(|()| {
            let anywhere = [place(&mut rng), place(&mut rng)];
            let desired = Desired::of_task(anywhere).with_tails(Tails::new([[1.1], [2.1]]));
            let goal = EncodedGoal::new(Stage::place(1), &now, &desired);
            assert!(goal.is_met(&now, &tolerances));
            assert!(tolerances.placed(0, &now, &desired));
            let mut row = vec![f32::NAN; encoder.width()];
            encoder.write(&[0.5], &now, &goal, &mut row);
            row
        });
        prop_assert_eq!(&rows[0], &rows[1]);
        let desired = Desired::of_task(now.0.objects).with_tails(Tails::new([[1.1], [2.5]]));
        let goal = EncodedGoal::new(Stage::place(1), &now, &desired);
        prop_assert!(!goal.is_met(&now, &tolerances));
    }
}

#[test]
fn tails_that_no_goal_can_have_are_refused() {
    let message = |error: TailError| error.to_string();
    let refused = |parts: &[TailPart]| TailSpec::beside_positions(parts).map_err(message);
    assert_eq!(
        refused(&[TailPart::rotation(0.1), TailPart::rotation(0.1), TailPart::flag()]),
        Err("9 numbers for an object, expected at most 8".to_owned())
    );
    assert_eq!(
        refused(&[TailPart::flag(), TailPart::angle(-0.1)]),
        Err("part 2 has the tolerance -0.1, expected a finite number, at least 0".to_owned())
    );
    assert!(refused(&[TailPart::difference(f32::INFINITY)]).is_err());
    assert_eq!(
        refused(&[TailPart { metric: Metric::Flag, tolerance: 1.0 }]),
        Err("part 1 is a flag with the tolerance 1, expected less than 1".to_owned())
    );
    assert_eq!(
        TailSpec::instead_of_positions(&[]).map_err(message),
        Err("goals without positions and without anything else".to_owned())
    );
}

/// A hand on a line, and blocks that it turns where it touches them; each is to be turned to an
/// angle, wherever it is.
#[derive(Clone)]
struct Knobs<const N: usize> {
    spec: EnvSpec<N>,
    hand: f32,
    places: [f32; N],
    angles: [f32; N],
}

impl<const N: usize> Knobs<N> {
    fn new() -> Self {
        let tail = TailSpec::instead_of_positions(&[TailPart::angle(0.3)]).unwrap();
        let flip = |from| SignedIndex { from, sign: -1.0, offset: 0.0 };
        let mirror = Mirror {
            axis: 0,
            center: 0.0,
            observation: (0..=2 * N).map(flip).collect(),
            action: vec![flip(0), flip(1)],
            tail: vec![flip(0)],
        };
        let spec = EnvSpec {
            tolerances: Tolerances { tail, ..Tolerances::uniform(0.1) },
            mirrors: vec![mirror],
            ..EnvSpec::new("knobs", 1 + 2 * N, 2, 15)
        };
        let spec = EnvSpec { names: names(&spec), ..spec };
        Self { spec, hand: 0.0, places: [0.0; N], angles: [0.0; N] }
    }

    fn observe(&self, observation: &mut [f32]) -> Achieved<N> {
        observation[0] = self.hand;
        observation[1..=N].copy_from_slice(&self.places);
        observation[1 + N..].copy_from_slice(&self.angles);
        let at = |x| Position::new(x, 0.0, 0.0);
        let scene = Scene::new(at(self.hand), self.places.map(at));
        Achieved(scene.with_tails(Tails::new(self.angles.map(|angle| [angle]))))
    }
}

fn names<const N: usize>(spec: &EnvSpec<N>) -> rher_core::Names {
    let list = |what: &str, count| (0..count).map(|n| format!("{what}{n}")).collect();
    rher_core::Names {
        objects: list("knob", N),
        observation: list("number", spec.obs_dim),
        action: list("motor", spec.action_dim),
        tail: list("yaw", 1),
    }
}

impl<const N: usize> Env<N> for Knobs<N> {
    fn spec(&self) -> &EnvSpec<N> {
        &self.spec
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<N>, EnvError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        self.hand = 0.0;
        self.places = array::from_fn(|_| rng.random_range(-0.5..0.5));
        self.angles = array::from_fn(|_| rng.random_range(-PI..PI));
        let achieved = self.observe(observation);
        let wanted = array::from_fn(|_| [rng.random_range(-PI..PI)]);
        let desired = Desired::of_task(achieved.0.objects).with_tails(Tails::new(wanted));
        Ok(Start { achieved, desired })
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<N>, EnvError> {
        self.hand = (self.hand + 0.1 * action[0]).clamp(-0.5, 0.5);
        for (place, angle) in self.places.iter().zip(&mut self.angles) {
            if (self.hand - place).abs() < 0.1 {
                *angle += 0.5 * action[1];
            }
        }
        Ok(self.observe(observation))
    }

    fn reset_to(
        &mut self,
        start: &Start<N>,
        observation: &mut [f32],
    ) -> Result<Option<Start<N>>, EnvError> {
        let scene = &start.achieved.0;
        self.hand = scene.gripper.x;
        self.places = scene.objects.map(|place| place.x);
        self.angles = array::from_fn(|object| scene.tails.of_object(object)[0]);
        Ok(Some(Start { achieved: self.observe(observation), ..*start }))
    }
}

#[test]
fn a_mirror_says_what_it_does_to_a_tail() {
    assert_eq!(check_env(Knobs::<2>::new).unwrap().symmetries, 1);
    let mut without = Knobs::<2>::new();
    without.spec.mirrors[0].tail.clear();
    assert_eq!(
        without.spec.validate().unwrap_err().to_string(),
        "the environment `knobs` has `mirrors[0]` = 0 entries for its tail, expected 1"
    );
    let mut wrong = Knobs::<2>::new();
    wrong.spec.mirrors[0].tail[0].sign = 1.0;
    let error = check_env(|| wrong.clone()).unwrap_err().to_string();
    assert!(error.starts_with("mirrors[0] does not hold: observation[3]"), "{error}");
    let mut unnamed = Knobs::<2>::new();
    unnamed.spec.names.tail.push("pitch".to_owned());
    assert_eq!(
        unnamed.spec.validate().unwrap_err().to_string(),
        "the environment `knobs` has `names.tail` = 2 names, expected 1, or none"
    );
}

#[test]
fn rows_of_a_mirrored_or_reordered_scene_have_its_tails() {
    let mut env = Knobs::<2>::new();
    let exchanged = [0, 2, 1, 4, 3].map(|from| SignedIndex { from, sign: 1.0, offset: 0.0 });
    env.spec.permutations = vec![Permutation { order: [1, 0], observation: exchanged.into() }];
    let episode = rollout(&mut env, 3, |_, action| {
        action.copy_from_slice(&[0.3, 1.0]);
        Ok(())
    });
    let mut replay = Replay::new(&env.spec, 15);
    replay.push(&episode.unwrap());
    let row = |mirror, exchange| {
        let relay = RelayConfig {
            mirror,
            exchange,
            hindsight: 0.0,
            goal_frame: GoalFrame::Absolute,
            fine_scale: false,
            ..Preset::Fast.config("knobs", 2).relay
        };
        let encoder = InputEncoder::new(&relay, &env.spec);
        let mut relabeler = Relabeler::new(&relay, &env.spec);
        let mut batch = Batch::zeros(1, encoder.width(), 2);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        relabeler.draw(&replay, &encoder, Stage::place(1), &mut batch, 0..1, &mut rng);
        batch.inputs
    };
    // Both objects' cosine and sine come after their positions, these after the gripper's.
    let tails = |row: &[f32]| [8 + 3, 8 + 4, 8 + 8, 8 + 9].map(|index| row[index]);
    let [cos1, sin1, cos2, sin2] = tails(&row(0.0, 0.0));
    assert_ne!(cos1, cos2);
    assert_eq!(tails(&row(1.0, 0.0)), [cos1, -sin1, cos2, -sin2]);
    assert_eq!(tails(&row(0.0, 1.0)), [cos2, sin2, cos1, sin1]);
}

#[cfg(feature = "train")]
mod trained {
    use super::Knobs;
    use crate::toy::{Lines, Magnet, small};
    use rher_core::config::TrainConfig;
    use rher_core::evaluate::evaluate;
    use rher_core::goal::{Achieved, TailPart, TailSpec, Tails, Tolerances};
    use rher_core::train::{Finish, Trainer};
    use rher_core::{Desired, EnvSpec, Policy, Position, Scene};
    use std::fs;
    use std::path::Path;
    use std::sync::atomic::AtomicBool;

    fn config(episodes: u64) -> TrainConfig {
        let mut config = small("knobs", 2);
        config.agent.hidden = vec![8];
        config.replay.updates_per_episode = 2;
        config.replay.batch_size = 8;
        config.evaluation.episodes = 2;
        config.evaluation.subtask_episodes = 1;
        config.evaluation.every_episodes = 4;
        config.env_steps = 15 * episodes;
        config
    }

    fn run(trainer: &mut Trainer<2, Knobs<2>>, folder: &Path) -> Vec<f32> {
        let mut lines = Lines::default();
        let finish = trainer.run(Some(folder), &mut lines, &AtomicBool::new(false)).unwrap();
        assert_eq!(finish, Finish::StepsSpent);
        lines.0.iter().map(|metrics| metrics.final_distance).collect()
    }

    #[test]
    fn a_run_that_is_resumed_goes_on_with_its_tails() {
        let [whole, parts] = [(); 2].map(|()| tempfile::tempdir().unwrap());
        let mut trainer = Trainer::new(config(8), vec![Knobs::new()], 1).unwrap();
        let distances = run(&mut trainer, whole.path());
        assert_eq!(distances.len(), 2);

        let mut trainer = Trainer::new(config(4), vec![Knobs::new()], 1).unwrap();
        run(&mut trainer, parts.path());
        let mut resumed = Trainer::resume(parts.path(), vec![Knobs::new()], 1).unwrap();
        resumed.set_env_steps(15 * 8);
        assert_eq!(run(&mut resumed, parts.path()), distances[1..]);
        let file = |folder: &Path| fs::read(folder.join("policy.safetensors")).unwrap();
        assert_eq!(file(parts.path()), file(whole.path()));

        let mut other = Knobs::<2>::new();
        other.spec.tolerances.tail = TailSpec::beside_positions(&[TailPart::angle(0.3)]).unwrap();
        let error = Trainer::resume(parts.path(), vec![other], 1).map(drop).unwrap_err();
        let error = format!("{error}");
        assert!(error.contains("goals of angle"), "{error}");
        assert!(error.contains("goals of positions, angle"), "{error}");
    }

    #[test]
    fn a_policy_file_says_what_its_goals_are() {
        let folder = tempfile::tempdir().unwrap();
        let mut trainer = Trainer::new(config(4), vec![Knobs::new()], 1).unwrap();
        run(&mut trainer, folder.path());
        let policy = Policy::load(&folder.path().join("policy.safetensors")).unwrap();
        assert_eq!(&policy, trainer.policy());
        assert_eq!(policy.names().tail, ["yaw0"]);
        assert_eq!(policy.tail().numbers(), 1);
        assert!(!policy.tail().has_positions());

        let mut spec = EnvSpec::<2>::new("arm", 5, 2, 15);
        assert_eq!(
            policy.actor(&spec).map(drop).unwrap_err().to_string(),
            "the policy does not fit the environment: the goal of an object is angle in the policy \
             and positions in the environment"
        );
        // Tolerances are no matter of a policy.
        let tail = TailSpec::instead_of_positions(&[TailPart::angle(1.0)]).unwrap();
        spec.tolerances = Tolerances { tail, ..spec.tolerances };
        let mut actor = policy.actor(&spec).unwrap();
        let scene = Scene::new(Position::origin(), [Position::origin(); 2]);
        let now = Achieved(scene.with_tails(Tails::new([[0.1], [0.2]])));
        let (task, mut action) = (actor.task(), [0.0; 2]);
        let mut act = |wanted: f32| {
            let desired = Desired::of_task(scene.objects).with_tails(Tails::new([[0.0], [wanted]]));
            actor.act(task, &[0.0; 5], &now, &desired, &mut action).map(|()| action)
        };
        assert_ne!(act(0.0).unwrap(), act(2.0).unwrap());
        assert_eq!(
            act(f32::NAN).unwrap_err().to_string(),
            "number 8 of `desired tails` is NaN, expected a finite number"
        );
        let mut lying = Knobs::<2>::new();
        lying.spec.tolerances.tail = TailSpec::NONE;
        lying.spec.mirrors[0].tail.clear();
        lying.spec.names.tail.clear();
        let (of, test_policy) = (config(4).evaluation, config(4).exploration.test_policy);
        assert!(evaluate(&mut [lying], &policy, &of, test_policy).is_err());
    }

    #[test]
    fn a_policy_without_tails_has_none_in_its_file() {
        let config = TrainConfig { env_steps: 25, ..config(0) };
        let config = TrainConfig { task: "magnet".to_owned(), ..config };
        let mut trainer = Trainer::new(config, vec![Magnet::<2>::new()], 1).unwrap();
        trainer.run(None, &mut Lines::default(), &AtomicBool::new(false)).unwrap();
        let file = trainer.policy().to_bytes();
        assert!(!String::from_utf8_lossy(&file).contains("tail"));
    }
}
