//! A run that starts from that of another task.

use crate::support::{Rher, TINY};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rher_core::config::{Preset, TrainConfig};
use rher_core::episode::{Episode, View, rollout};
use rher_core::policy::Critic;
use rher_core::train::checkpoint::read_critic;
use rher_core::{
    Achieved, Desired, Env as _, EnvSpec, Event, Names, Policy, Position, Pretrained, Scene, Stage,
    Trainer,
};
use rher_envs::tasks::{DPush, ObstaclePush, Pick, Push, Stack, TPush, TStack};
use rher_envs::{Scenario, Simulation};
use std::array;
use std::sync::atomic::AtomicBool;
use tempfile::TempDir;

/// Settings that train in seconds, and under which runs of all these tasks fit each other.
fn config(task: &str, objects: usize, fine_scale: bool) -> TrainConfig {
    let mut config = Preset::Fast.config(task, objects);
    config.relay.fine_scale = fine_scale;
    config.agent.hidden = vec![16, 16];
    config.agent.critic_layer_norm = true;
    config.replay.batch_size = 16;
    config.replay.updates_per_episode = 10;
    config.evaluation.episodes = 1;
    config.evaluation.subtask_episodes = 1;
    config.env_steps = 200;
    config.until = 0.0;
    config
}

/// The networks of a run.
struct Networks {
    policy: Policy,
    critic: Critic,
    names: Names,
    folder: TempDir,
}

impl Networks {
    fn of<S: Scenario<N>, const N: usize>(mut trainer: Trainer<N, Simulation<S, N>>) -> Self {
        let folder = TempDir::new().unwrap();
        trainer.save(folder.path()).unwrap();
        let critic = read_critic(folder.path()).unwrap();
        let names = Simulation::<S, N>::new().spec().names.clone();
        Self { policy: trainer.policy().clone(), critic, names, folder }
    }

    /// Of a run that was trained for a few episodes.
    fn trained<S: Scenario<N>, const N: usize>(fine_scale: bool) -> Self {
        let envs = vec![Simulation::<S, N>::new()];
        let mut trainer = Trainer::new(config(S::NAME, N, fine_scale), envs, 1).unwrap();
        trainer.run(None, &mut |_: &Event| Ok(()), &AtomicBool::new(false)).unwrap();
        Self::of(trainer)
    }

    /// Of a run that starts from this one.
    fn begun<S: Scenario<N>, const N: usize>(&self, fine_scale: bool) -> Self {
        let pretrained = Pretrained::read(self.folder.path(), |_| self.names.clone()).unwrap();
        let envs = vec![Simulation::<S, N>::new()];
        Self::of(Trainer::new_from(&pretrained, config(S::NAME, N, fine_scale), envs, 1).unwrap())
    }
}

/// An episode with random actions.
fn played<S: Scenario<N>, const N: usize>() -> Episode<N> {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let play = |_: View<'_, N>, action: &mut [f32]| {
        action.fill_with(|| rng.random_range(-1.0..1.0));
        Ok(())
    };
    rollout(&mut Simulation::<S, N>::new(), 3, play).unwrap()
}

/// What was seen in `episode` by who calls its numbers `names`, for who calls them `asked`.
fn seen<const N: usize>(episode: &Episode<N>, names: &[String], asked: &[String]) -> Vec<f32> {
    let place = |name: &String| names.iter().position(|other| other == name).unwrap();
    let places: Vec<usize> = asked.iter().map(place).collect();
    let steps = episode.observations.chunks_exact(names.len());
    steps.flat_map(|step| places.iter().map(|place| step[*place])).collect()
}

/// Actions and values at every step, in a sub-task.
fn judged<const N: usize>(
    networks: &Networks,
    episode: &Episode<N>,
    spec: &EnvSpec<N>,
    stage: Stage<N>,
) -> (Vec<f32>, Vec<f32>) {
    let mut actor = networks.policy.actor(spec).unwrap();
    let mut actions = Vec::new();
    let steps = episode.observations.chunks_exact(spec.obs_dim).zip(&episode.achieved);
    for (observation, achieved) in steps {
        let mut action = vec![0.0; spec.action_dim];
        actor.act(stage, observation, achieved, &episode.desired, &mut action).unwrap();
        actions.extend(action);
    }
    let stages = vec![stage; episode.achieved.len() - 1];
    (actions, networks.critic.values(episode, &stages))
}

fn assert_near(found: &[f32], expected: &[f32], what: &str) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        let distance = (found - expected).abs() / (1.0 + expected.abs());
        assert!(distance < 1e-4, "{what}: {found}, not {expected}");
    }
}

/// Checks that in the sub-tasks of its first object, a run on the task `L` that starts from one on `S`
/// does what that one does, whatever becomes of the other objects; the two may see near distances on
/// a finer scale.
fn starts_where_it_left_off<S, L, const M: usize, const N: usize>(fine_scale: [bool; 2])
where
    S: Scenario<M>,
    L: Scenario<N>,
{
    let small = Networks::trained::<S, M>(fine_scale[0]);
    let large = small.begun::<L, N>(fine_scale[1]);
    let (small_env, large_env) = (Simulation::<S, M>::new(), Simulation::<L, N>::new());
    let of_small = played::<S, M>();

    // The same scene among other things, which are anywhere, and seen as anything.
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let width = large_env.spec().obs_dim;
    let mut observations = vec![0.0; width * of_small.achieved.len()];
    observations.fill_with(|| rng.random_range(-0.5..1.5));
    let known = of_small.observations.chunks_exact(small.names.observation.len());
    for (large_step, step) in observations.chunks_exact_mut(width).zip(known) {
        for (name, number) in small.names.observation.iter().zip(step) {
            let place = large.names.observation.iter().position(|other| other == name);
            large_step[place.unwrap()] = *number;
        }
    }
    let mut among_others = |places: &[Position; M]| {
        let mut anywhere = || Position::from([(); 3].map(|()| rng.random_range(0.4..1.4)));
        array::from_fn(|object| places.get(object).copied().unwrap_or_else(&mut anywhere))
    };
    let of_large = Episode {
        desired: Desired::of_task(among_others(of_small.desired.objects())),
        achieved: of_small
            .achieved
            .iter()
            .map(|Achieved(Scene { gripper, objects, .. })| {
                Achieved(Scene::new(*gripper, among_others(objects)))
            })
            .collect(),
        actions: of_small.actions.clone(),
        end: of_small.end,
        observations,
    };
    for subtask in 0..2 {
        let [of_small, of_large] = [
            judged(&small, &of_small, small_env.spec(), Stage::from_index(subtask).unwrap()),
            judged(&large, &of_large, large_env.spec(), Stage::from_index(subtask).unwrap()),
        ];
        let what = format!("{} from {}, {fine_scale:?}, sub-task {subtask}", L::NAME, S::NAME);
        assert_near(&of_large.0, &of_small.0, &what);
        assert_near(&of_large.1, &of_small.1, &what);
    }
}

#[test]
fn a_run_starts_where_that_of_a_smaller_task_left_off() {
    for fine_scale in [[false, false], [true, true], [false, true]] {
        starts_where_it_left_off::<Push, DPush, 1, 2>(fine_scale);
        starts_where_it_left_off::<Push, TPush, 1, 3>(fine_scale);
        starts_where_it_left_off::<DPush, TPush, 2, 3>(fine_scale);
        starts_where_it_left_off::<Pick, Stack, 1, 2>(fine_scale);
        starts_where_it_left_off::<Pick, TStack, 1, 3>(fine_scale);
        starts_where_it_left_off::<Push, ObstaclePush, 1, 1>(fine_scale);
    }
}

#[test]
fn what_was_learned_about_one_block_is_known_of_the_one_whose_turn_it_is() {
    let push = Networks::trained::<Push, 1>(true);
    let dpush = push.begun::<DPush, 2>(true);
    let (push_env, dpush_env) = (Simulation::<Push, 1>::new(), Simulation::<DPush, 2>::new());
    let mut of_both = played::<DPush, 2>();
    let target = of_both.desired.objects()[1];
    // The first block is at its target at every step, so that it is the second one's turn.
    let placed = Position::new(1.2, 0.6, 0.425);
    of_both.desired = Desired::of_task([placed, target]);
    of_both.achieved.iter_mut().for_each(|Achieved(scene)| scene.objects[0] = placed);

    let second: Vec<String> =
        push.names.observation.iter().map(|name| name.replace("block1", "block2")).collect();
    let of_second = Episode {
        desired: Desired::of_task([target]),
        observations: seen(&of_both, &dpush.names.observation, &second),
        achieved: of_both
            .achieved
            .iter()
            .map(|Achieved(Scene { gripper, objects, .. })| {
                Achieved(Scene::new(*gripper, [objects[1]]))
            })
            .collect(),
        actions: of_both.actions.clone(),
        end: of_both.end,
    };
    for subtask in 0..2 {
        let (actions, values) =
            judged(&push, &of_second, push_env.spec(), Stage::from_index(subtask).unwrap());
        let of_dpush =
            judged(&dpush, &of_both, dpush_env.spec(), Stage::from_index(2 + subtask).unwrap());
        assert_near(&of_dpush.0, &actions, "actions");
        assert_near(&of_dpush.1, &values, "values");
    }
}

/// A run with these further arguments.
fn train(rher: &Rher, arguments: &str) {
    rher.ok(&format!("train {arguments} {TINY} --quiet --env-steps 300"));
}

#[test]
fn the_files_of_a_run_say_what_it_started_from() {
    let rher = Rher::new();
    train(&rher, "push --out push --set agent.critic_layer_norm=true");
    train(&rher, "dpush --out dpush --from push");
    train(&rher, "dpush --out alone");
    let config = std::fs::read_to_string(rher.path("dpush/config.toml")).unwrap();
    let first = std::fs::read_to_string(rher.path("push/config.toml")).unwrap();
    let run = first.strip_prefix("# Run ").unwrap().split(',').next().unwrap();
    let expected = format!("\n[from]\ntask = \"push\"\nrun = \"{run}\"\nupdates = 12\n");
    assert!(config.contains(&expected), "{expected} is not in {config}");
    assert!(!std::fs::read_to_string(rher.path("alone/config.toml")).unwrap().contains("from"));

    let said = rher.run("stats dpush alone");
    assert_eq!(said.status, Some(0), "{said}");
    assert!(said.stderr.contains("differ in more than the seed"), "{said}");

    // The other run is not needed any more.
    std::fs::remove_dir_all(rher.path("push")).unwrap();
    let before = rher.metrics("dpush");
    rher.ok("train --resume dpush --env-steps 600 --quiet");
    assert_eq!(rher.metrics("dpush")[..before.len()], before);
    assert!(rher.metrics("dpush").len() > before.len());
    let after = std::fs::read_to_string(rher.path("dpush/config.toml")).unwrap();
    assert!(after.contains(&expected), "{after}");
    rher.ok("eval dpush --episodes 2");
}

#[test]
fn a_run_that_cannot_start_from_another_one_makes_no_folder() {
    let rher = Rher::new();
    train(&rher, "push --out push");
    train(&rher, "pick --out pick");
    train(&rher, "dpush --out dpush");
    train(&rher, "push --out her --method her");
    rher.ok(&format!(
        "train push --out untrained {TINY} --quiet --env-steps 50 --set replay.warmup_episodes=9"
    ));
    let refused = [
        (
            "dpush --from push --set agent.critic_layer_norm=false",
            2,
            "`--set agent.critic_layer_norm=true` makes them fit",
        ),
        ("push --from pick", 2, "fingers.opening), expected (locked_fingers.x"),
        ("slide --from push", 2, "its object 1 is `block1`, expected `puck1`"),
        ("push --from dpush", 2, "it has 2 objects, expected at most 1"),
        ("push --from push --set agent.hidden=[8]", 2, "`--set agent.hidden=[16,16]` makes"),
        ("push --from push --set agent.critics=1", 2, "`--set agent.critics=2` makes"),
        ("push --from push --set relay.goal_frame=absolute", 2, "relay.goal_frame=relative`"),
        ("push --from push --set relay.object_order=relay", 2, "relay.object_order=turn`"),
        ("push --from push --method her", 2, "the `relay.method` of the new run is her"),
        ("push --from her", 2, "its `relay.method` is her"),
        ("push --from untrained", 2, "it has made 0 updates, expected at least 1"),
        ("push --from nowhere", 5, "there is no checkpoint in it"),
        ("push --from push/policy.safetensors", 5, "a policy alone has no critics"),
        ("push --config dpush/config.toml", 3, "the file is for task `dpush`"),
        ("--resume push --from push", 2, "cannot be used with"),
        ("push --set from.task=push", 2, "cannot be set"),
    ];
    for (arguments, status, reason) in refused {
        let settings = if arguments.contains("--resume") { "" } else { TINY_OUT };
        // Of two values for a setting, the last counts.
        let command = format!("train {settings} {arguments}");
        let said = rher.run(&command);
        assert_eq!(said.status, Some(status), "{command}:\n{said}");
        let text = said.stderr.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains(reason), "{command}: {reason} is not in\n{said}");
        assert!(!rher.path("new").exists(), "{command}");
    }

    train(&rher, "dpush --out from --from dpush");
    let said = rher.run("train dpush --out new --config from/config.toml");
    assert_eq!(said.status, Some(3), "{said}");
    assert!(said.stderr.contains("--from RUN"), "{said}");
    assert!(!rher.path("new").exists());
}

/// [`TINY`], and the folder that should not be made.
const TINY_OUT: &str = "--out new --until 0 --env-steps 300 \
    --set agent.hidden=[16,16] --set replay.batch_size=16 --set replay.updates_per_episode=2";
