//! How a pool got to where it is.

use super::step::{Frames, Pool, PoolError, Slot};
use crate::layout::Chosen;
use crate::simulated::Simulated;
use serde::{Deserialize, Serialize};

/// How a [`Pool`] got to where it is: its running episodes can be played again from this, to the
/// last bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoolRecord {
    envs: Vec<EnvRecord>,
    now: Frames,
    last: Frames,
    rewards: Vec<f32>,
    successes: Vec<bool>,
    ended: Vec<bool>,
    clipped: Vec<u32>,
}

/// How one environment got to where it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct EnvRecord {
    /// Seed of its first episode.
    seed: u64,
    /// Episodes started since.
    episodes: u64,
    /// `[steps, action]`: actions of the running episode; None if there is none.
    actions: Option<Vec<f32>>,
    /// What was chosen of how the running episode began.
    #[serde(default)]
    chosen: Chosen,
}

impl<E: Simulated<N>, const N: usize> Pool<E, N> {
    /// How it got to where it is.
    pub fn record(&self) -> PoolRecord {
        let env = |slot: &Slot<E, N>| EnvRecord {
            seed: slot.seed,
            episodes: slot.episodes,
            actions: slot.running.as_ref().map(|_| slot.actions.clone()),
            chosen: slot.chosen.clone(),
        };
        PoolRecord {
            envs: self.slots.iter().map(env).collect(),
            now: self.now.clone(),
            last: self.last.clone(),
            rewards: self.rewards.clone(),
            successes: self.successes.clone(),
            ended: self.ended.clone(),
            clipped: self.clipped.clone(),
        }
    }

    /// Plays the running episodes again, so that it is where the pool was that `record` is of.
    ///
    /// # Errors
    ///
    /// If the record is of another number of environments or of environments of other dimensions,
    /// or if an environment fails.
    pub fn play(&mut self, record: &PoolRecord) -> Result<(), PoolError> {
        let PoolRecord { envs, now, last, rewards, successes, ended, clipped } = record;
        let (count, obs_dim, action_dim) = (self.envs(), self.spec.obs_dim, self.spec.action_dim);
        self.check_length("records of environments", envs.len(), 1)?;
        for frames in [now, last] {
            self.check_length("recorded observations", frames.observations.len(), obs_dim)?;
            self.check_length("recorded goals", frames.achieved.len(), 3 * N)?;
            self.check_length("recorded goals", frames.desired.len(), 3 * N)?;
        }
        for (what, length) in [
            ("recorded rewards", rewards.len()),
            ("recorded successes", successes.len()),
            ("recorded ends", ended.len()),
            ("recorded clips", clipped.len()),
        ] {
            self.check_length(what, length, 1)?;
        }
        for EnvRecord { actions, .. } in envs {
            let got = actions.as_ref().map_or(0, Vec::len);
            let expected = got / action_dim * action_dim;
            if got != expected {
                let what = "recorded actions";
                return Err(PoolError::Length { what, envs: count, expected, got });
            }
        }
        self.each(|env, row| {
            let EnvRecord { seed, episodes, actions, chosen } = &envs[env];
            row.slot.seed = *seed;
            row.slot.episodes = episodes.saturating_sub(1);
            let Some(actions) = actions else {
                row.slot.episodes = *episodes;
                row.slot.running = None;
                return Ok(());
            };
            row.begin(chosen.clone())?;
            actions.chunks_exact(action_dim).try_for_each(|action| row.act(action))
        })?;
        self.now.clone_from(now);
        self.last.clone_from(last);
        self.rewards.clone_from(rewards);
        self.successes.clone_from(successes);
        self.ended.clone_from(ended);
        self.clipped.clone_from(clipped);
        Ok(())
    }
}
