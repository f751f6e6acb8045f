//! One episode of every task, as it is on every machine and in every build.

use crate::support::random_action;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Achieved;
use rher_envs::{EnvVisitor, Simulated, Task};
use std::fmt::Write as _;

/// Of the episode with seed 1 and random actions. A change that moves one of these numbers changes
/// what was learned and measured before: say so in the change log.
const HASHES: &[(Task, u64)] = &[
    (Task::REACH, 0x6436_fffa_684f_2ac8),
    (Task::PUSH, 0x0f28_8f85_6556_4296),
    (Task::PICK, 0xdd1a_c71f_2638_d257),
    (Task::SLIDE, 0x9ca2_863a_1ce6_0474),
    (Task::INSERT, 0x700c_7359_fb9f_5ca2),
    (Task::OBSTACLE_PUSH, 0x162a_682a_8cb5_1d96),
    (Task::CUE_PUSH, 0xa93a_30f7_2036_5f68),
    (Task::DPUSH, 0x961b_404b_843f_21e9),
    (Task::STACK, 0xbed2_fa58_e79d_9fc3),
    (Task::TPUSH, 0x0de5_6f06_48f9_19a2),
    (Task::TSTACK, 0x565c_4258_c0e6_8bad),
    (Task::DRAWER, 0xe1c9_565b_54aa_8120),
    (Task::DRAWER_BOX, 0xe3c1_a153_645d_b734),
];

#[test]
fn episodes_are_what_they_were_on_every_machine() {
    let known = |task: &Task| HASHES.iter().find(|(known, _)| known == task);
    let mut wrong = String::new();
    for task in Task::ALL {
        let hash = task.visit(EpisodeHash);
        if known(task).is_none_or(|(_, known)| *known != hash) {
            writeln!(wrong, "    (Task::{task:?}, {hash:#018x}),").unwrap();
        }
    }
    assert!(wrong.is_empty(), "missing from HASHES or changed:\n{wrong}");
}

struct EpisodeHash;

impl EnvVisitor for EpisodeHash {
    type Output = u64;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> u64 {
        let mut env = build();
        let spec = env.spec().clone();
        let mut observation = vec![0.0; spec.obs_dim];
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let start = env.reset(1, &mut observation).unwrap();
        let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
        hash.add(&observation);
        hash.add_scene(start.achieved);
        for _ in 0..spec.episode_steps {
            let action = &random_action(&mut rng)[..spec.action_dim];
            let achieved = env.step(action, &mut observation).unwrap();
            hash.add(&observation);
            hash.add_scene(achieved);
        }
        hash.0
    }
}

/// FNV-1a, byte by byte.
struct Fnv(u64);

impl Fnv {
    fn add(&mut self, numbers: &[f32]) {
        for byte in numbers.iter().flat_map(|x| x.to_le_bytes()) {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn add_scene<const N: usize>(&mut self, Achieved(scene): Achieved<N>) {
        self.add(scene.gripper.coords.as_slice());
        for object in scene.objects {
            self.add(object.coords.as_slice());
        }
    }
}
