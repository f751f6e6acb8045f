//! How much memory a run needs, before any of it is asked for.

use crate::config::{Method, TrainConfig};
use crate::env::EnvSpec;
use crate::goal::Desired;
use crate::input::InputEncoder;
use crate::replay::frame_width;
use std::fmt;

/// A run needs more memory than there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the run needs about {} of memory ({} for the replay buffer, {} for the networks, {} for \
     batches and evaluations), and there are {}; smaller `replay.capacity`, `agent.hidden`, \
     `replay.batch_size` or `evaluation.episodes` need less",
    Bytes(self.needed.total()), Bytes(self.needed.replay), Bytes(self.needed.networks),
    Bytes(self.needed.rows), Bytes(self.available)
)]
pub struct MemoryError {
    /// Estimate of what the run needs.
    pub needed: Memory,
    /// What this process can have, in bytes.
    pub available: u64,
}

/// Memory that a run needs, in bytes, without its environments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// The replay buffer, once it is full.
    pub replay: u64,
    /// Parameters, their targets, moments and gradients, and the copies that a checkpoint makes.
    pub networks: u64,
    /// Rows of batches, and episodes of evaluations.
    pub rows: u64,
}

impl Memory {
    /// All of it; the largest number if it is more than that.
    pub fn total(self) -> u64 {
        self.replay.saturating_add(self.networks).saturating_add(self.rows)
    }
}

/// Bytes of a number.
const NUMBER: u64 = 4;

/// Copies of the parameters while a checkpoint is written: trained, target and two moments, the
/// same in the checkpoint's state, and its bytes in a vector that grows and in the file's.
const COPIES: u64 = 4 + 4 + 8 + 4;

/// Slices of a batch, each with gradients of its own, and the rows from which on there are more.
const SLICES: [u64; 2] = [16, 512];

/// Bytes for each episode of an evaluation: its number, its result and copies of both.
const EPISODE: u64 = 96;

/// Estimates the memory that a run with these settings needs in environments like `spec`.
pub fn needed<const N: usize>(config: &TrainConfig, spec: &EnvSpec<N>) -> Memory {
    let wide = |number: usize| number as u64;
    let sum = |numbers: &[u64]| numbers.iter().fold(0_u64, |sum, n| sum.saturating_add(*n));
    let times = |a: u64, b: u64| a.saturating_mul(b);

    let steps = wide(spec.episode_steps).max(1);
    let goal = Desired::<N>::width(spec.tolerances.tail.numbers());
    let episode = NUMBER * ((steps + 1) * wide(frame_width(spec)) + wide(goal));
    let replay = times((wide(config.replay.capacity) / steps).max(1), episode);

    let (input, action) =
        (wide(InputEncoder::new(&config.relay, spec).width()), wide(spec.action_dim));
    let parameters = |inputs: u64, outputs: u64, norms: u64| {
        let mut inputs = inputs;
        let mut count = 0_u64;
        for width in config.agent.hidden.iter().copied().map(wide) {
            count = sum(&[count, times(inputs, width), times(1 + norms, width)]);
            inputs = width;
        }
        sum(&[count, times(inputs, outputs), outputs])
    };
    let norms = 2 * u64::from(config.agent.critic_layer_norm);
    let critics = times(wide(config.agent.critics), parameters(input + action, 1, norms));
    let parameters = sum(&[parameters(input, action, 0), critics]);

    let subtasks = match config.relay.method {
        Method::Rher => wide(spec.subtasks),
        Method::Her => 1,
    };
    let rows = times(wide(config.replay.batch_size), subtasks);
    let [most, slice] = SLICES;
    let gradients = rows.div_ceil(slice).clamp(1, most);
    let networks = times(NUMBER * (COPIES + gradients), parameters);

    let row = NUMBER * (4 * input + 5 * action + 4);
    let evaluation = &config.evaluation;
    let episodes = sum(&[
        wide(evaluation.episodes),
        times(subtasks.saturating_sub(1), wide(evaluation.subtask_episodes)),
    ]);
    let rows = sum(&[times(row, rows), times(EPISODE, episodes)]);
    Memory { replay, networks, rows }
}

/// Refuses settings with which a run needs more memory than there is.
pub fn check<const N: usize>(config: &TrainConfig, spec: &EnvSpec<N>) -> Result<(), MemoryError> {
    let needed = needed(config, spec);
    match available() {
        Some(available) if needed.total() > available => Err(MemoryError { needed, available }),
        _ => Ok(()),
    }
}

/// The memory that this process can have, in bytes: that of the machine or of its control group.
///
/// `None` where the system does not say, which is anywhere but on Linux.
fn available() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let machine = read("/proc/meminfo").and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
        let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
        Some(kilobytes.saturating_mul(1024))
    });
    let limits = ["/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"];
    let limits = limits.into_iter().filter_map(|path| read(path)?.trim().parse().ok());
    machine.into_iter().chain(limits).min()
}

/// A number of bytes for people.
struct Bytes(u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const UNITS: [(u64, &str); 3] = [(1 << 30, "GB"), (1 << 20, "MB"), (1 << 10, "kB")];
        let unit = UNITS.into_iter().find(|(unit, _)| self.0 >= *unit);
        match unit {
            Some((unit, name)) => write!(f, "{:.1} {name}", self.0 as f64 / unit as f64),
            None => write!(f, "{} bytes", self.0),
        }
    }
}
