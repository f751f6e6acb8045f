//! What environments must be, and how that is checked.

use crate::toy::Magnet;
#[cfg(feature = "train")]
use crate::toy::small;
use rher_core::env::{Env, EnvError, EnvSpec, Mirror, Permutation, SignedIndex, Start};
use rher_core::goal::{Achieved, Desired, Position, Scene, Tolerances};
use rher_core::testing::{CheckError, check_env};
#[cfg(feature = "train")]
use rher_core::train::{TrainError, Trainer};

/// A specification with every symmetry: two objects on a line, seen from their middle.
fn spec() -> EnvSpec<2> {
    let entry = |from, sign| SignedIndex { from, sign, offset: 0.0 };
    let mut spec = EnvSpec::new("line", 3, 1, 10);
    spec.mirrors = vec![Mirror {
        axis: 0,
        center: 0.0,
        observation: vec![entry(0, -1.0), entry(1, -1.0), entry(2, -1.0)],
        action: vec![entry(0, -1.0)],
        tail: Vec::new(),
    }];
    spec.permutations = vec![Permutation {
        order: [1, 0],
        observation: vec![entry(0, 1.0), entry(2, 1.0), entry(1, 1.0)],
    }];
    spec
}

/// Breaks a specification.
type Change = fn(&mut EnvSpec<2>);

#[test]
fn a_wrong_specification_is_named() {
    assert_eq!(spec().validate(), Ok(()));
    let wrong = |change: Change| {
        let mut spec = spec();
        change(&mut spec);
        spec.validate().unwrap_err().to_string()
    };
    let table: [(Change, &str); 15] = [
        (|spec| spec.obs_dim = 0, "`obs_dim` = 0, expected at least 1"),
        (|spec| spec.action_dim = 0, "`action_dim` = 0, expected at least 1"),
        (|spec| spec.episode_steps = 0, "`episode_steps` = 0, expected at least 1"),
        (|spec| spec.subtasks = 0, "`subtasks` = 0, expected 1 to 4"),
        (|spec| spec.subtasks = 5, "`subtasks` = 5, expected 1 to 4"),
        (|spec| spec.tolerances = Tolerances::uniform(-0.1), "`tolerances.gripper` = -0.1"),
        (|spec| spec.tolerances.objects[1] = f32::NAN, "`tolerances.objects[1]` = NaN"),
        (|spec| spec.mirrors[0].axis = 3, "`mirrors[0]` = axis 3"),
        (|spec| spec.mirrors[0].center = f32::NAN, "at NaN m"),
        (|spec| spec.mirrors[0].action.clear(), "0 entries for its action, expected 1"),
        (
            |spec| spec.mirrors[0].observation[1].from = 3,
            "in observation[1], expected ±1 × a number below 3",
        ),
        (|spec| spec.mirrors[0].observation[1].from = 2, "does not restore"),
        (|spec| spec.mirrors[0].observation[1].sign = 0.5, "expected ±1"),
        (
            |spec| spec.permutations[0].order = [1, 1],
            "the order [1, 1], expected each of the objects",
        ),
        (|spec| spec.permutations[0].observation[0].from = 1, "used twice"),
    ];
    for (change, expected) in table {
        let said = wrong(change);
        assert!(said.contains("the environment `line` has"), "{said}");
        assert!(said.contains(expected), "{said}\nexpected {expected}");
    }
}

#[test]
#[cfg(feature = "train")]
fn training_refuses_environments_that_do_not_fit() {
    let broken = || Broken { spec: EnvSpec { subtasks: 5, ..spec() } };
    let refused = |config, envs| Trainer::new(config, envs, 1).map(drop).unwrap_err();
    let error = refused(small("line", 2), vec![broken()]);
    assert!(matches!(error, TrainError::Spec(_)), "{error}");

    let error =
        Trainer::new(small("magnet", 2), vec![Magnet::<1>::new()], 1).map(drop).unwrap_err();
    assert!(matches!(error, TrainError::OtherObjects { config: 2, envs: 1 }), "{error}");

    let mut two = vec![Broken { spec: spec() }, Broken { spec: spec() }];
    two[1].spec.tolerances = Tolerances::uniform(0.01);
    let error = refused(small("line", 2), two);
    assert!(matches!(error, TrainError::DifferentEnvs { index: 1 }), "{error}");
}

/// An environment for its specification alone.
struct Broken {
    spec: EnvSpec<2>,
}

impl Env<2> for Broken {
    fn spec(&self) -> &EnvSpec<2> {
        &self.spec
    }

    fn reset(&mut self, _: u64, _: &mut [f32]) -> Result<Start<2>, EnvError> {
        Err(EnvError::new("it is never reset"))
    }

    fn step(&mut self, _: &[f32], _: &mut [f32]) -> Result<Achieved<2>, EnvError> {
        Err(EnvError::new("it is never stepped"))
    }
}

/// A cart on a line with two balls, and what can be wrong with it.
struct Cart {
    spec: EnvSpec<2>,
    fault: Fault,
    scene: Scene<2>,
    steps: u64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    None,
    /// A number of the observation is not written.
    Unwritten,
    /// What happened before goes on in the next episode.
    Remembers,
    /// Every seed is the same episode.
    SeedIgnored,
    /// It goes further to the right than to the left.
    Lopsided,
    /// The second ball is heavier than the first, and its number is larger.
    Unlike,
}

impl Cart {
    fn new(fault: Fault) -> Self {
        let origin = Position::origin();
        let scene = Scene::new(origin, [origin; 2]);
        Self { spec: spec(), fault, scene, steps: 0 }
    }

    fn observe(&self, observation: &mut [f32]) -> Achieved<2> {
        observation[0] = self.scene.gripper.x;
        observation[1] = self.scene.objects[0].x;
        if self.fault != Fault::Unwritten {
            let factor = if self.fault == Fault::Unlike { 2.0 } else { 1.0 };
            observation[2] = factor * self.scene.objects[1].x;
        }
        Achieved(self.scene)
    }
}

impl Env<2> for Cart {
    fn spec(&self) -> &EnvSpec<2> {
        &self.spec
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<2>, EnvError> {
        let seed = if self.fault == Fault::SeedIgnored { 0 } else { seed };
        let place = |from: f32| Position::new(from + 0.01 * (seed % 7) as f32, 0.0, 0.0);
        self.scene = Scene::new(place(0.0), [place(0.5), place(-0.8)]);
        if self.fault == Fault::Remembers {
            self.scene.gripper.x += 1e-6 * self.steps as f32;
        }
        let desired = Desired::of_task([place(0.1), place(0.2)]);
        Ok(Start { achieved: self.observe(observation), desired })
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<2>, EnvError> {
        let lopsided = self.fault == Fault::Lopsided && action[0] > 0.0;
        self.scene.gripper.x += if lopsided { 0.2 } else { 0.1 } * action[0];
        self.steps += 1;
        Ok(self.observe(observation))
    }

    fn reset_to(
        &mut self,
        start: &Start<2>,
        observation: &mut [f32],
    ) -> Result<Option<Start<2>>, EnvError> {
        self.scene = start.achieved.0;
        Ok(Some(Start { achieved: self.observe(observation), desired: start.desired }))
    }
}

#[test]
fn an_environment_is_checked_in_one_call() {
    let checked = check_env(|| Cart::new(Fault::None)).unwrap();
    assert_eq!(checked.symmetries, 2);
    assert_eq!(check_env(Magnet::<2>::new).unwrap().symmetries, 0, "it cannot be started anywhere");

    let broken = |fault| check_env(|| Cart::new(fault)).unwrap_err();
    let error = broken(Fault::Unwritten);
    assert!(
        matches!(&error, CheckError::NotFinite { place, .. } if place == "observation[2]"),
        "{error}"
    );
    assert!(matches!(broken(Fault::Remembers), CheckError::NotRepeated { .. }));
    assert!(matches!(broken(Fault::SeedIgnored), CheckError::SeedIgnored));
    let error = broken(Fault::Lopsided);
    assert!(
        matches!(&error, CheckError::Asymmetric { symmetry, .. } if symmetry == "mirrors[0]"),
        "{error}"
    );
    let error = broken(Fault::Unlike);
    let expected = "permutations[0]";
    assert!(
        matches!(&error, CheckError::Asymmetric { symmetry, .. } if symmetry == expected),
        "{error}"
    );
    assert!(check_env(|| Broken { spec: spec() }).is_err());
}
