//! `rher replay`: what a recording holds, and the proof that it was real.

use super::{made_with, table, text};
use crate::cli::ReplayArgs;
use crate::error::ForeignTask;
use crate::observe::thousands;
use crate::printer::Printer;
use rher_envs::{EnvVisitor, Simulated, Task};
use rher_record::verify::{Difference, verify};
use rher_record::{Player, Recording};
use std::path::{Path, PathBuf};

/// A recording is not what happens.
#[derive(Debug, thiserror::Error)]
#[error(
    "`{}` is not what happens: in episode {}, step {}, `{}` is {} in the recording, and {} when \
     it is played again",
    path.display(),
    difference.episode,
    difference.step,
    difference.field,
    difference.recorded,
    difference.simulated
)]
pub(crate) struct NotReal {
    path: PathBuf,
    difference: Difference,
    /// Versions of this program and its physics that made the recording, where they are others.
    pub(crate) made_by: Option<String>,
}

pub(crate) fn replay(args: &ReplayArgs, printer: Printer) -> anyhow::Result<()> {
    let ReplayArgs { path, verify } = args;
    let recording = Recording::read(path)?;
    let name = recording.about.task.clone();
    let task: Task = name.parse().map_err(|_| ForeignTask { name })?;
    let options = made_with(&recording.about.options, task)?;
    if *verify {
        let steps = task.visit_with(&options, Verify { recording: &recording, path })??;
        printer.data(&format!(
            "real: {} episodes, {} steps of `{task}`, played again bit for bit",
            recording.episodes.len(),
            thousands(steps)
        ))?;
    } else {
        printer.data(&list(&recording))?;
    }
    Ok(())
}

/// Proof that every episode of a recording was real; the number of their steps.
struct Verify<'a> {
    recording: &'a Recording,
    path: &'a Path,
}

impl EnvVisitor for Verify<'_> {
    type Output = anyhow::Result<u64>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let Self { recording: Recording { about, episodes }, path } = self;
        let mut player = Player::new(build(), about.reach_distance);
        let mut steps = 0;
        for episode in episodes {
            if let Some(difference) = verify(&mut player, episode)? {
                let ours = [env!("CARGO_PKG_VERSION"), rher_envs::RAPIER_VERSION];
                let theirs = [&*about.rher, &*about.rapier];
                let made_by = (ours != theirs)
                    .then(|| format!("rher {} with Rapier {}", about.rher, about.rapier));
                let path = path.to_owned();
                return Err(NotReal { path, difference, made_by }.into());
            }
            steps += episode.script.decisions.len() as u64;
        }
        Ok(steps)
    }
}

fn list(Recording { about, episodes }: &Recording) -> String {
    let mut lines = table();
    lines.set_header(["episode", "seed", "steps", "success", "distance"]);
    for episode in episodes {
        let end = episode.end();
        lines.add_row([
            episode.script.number.to_string(),
            episode.script.seed.to_string(),
            episode.script.decisions.len().to_string(),
            if end.success { "yes" } else { "no" }.to_owned(),
            format!("{:.1} cm", 100.0 * end.distance),
        ]);
    }
    let source = match about.source {
        rher_record::Source::Training => "training",
        rher_record::Source::Policy => "a policy",
    };
    format!(
        "{} episodes of {source} on `{}`, recorded by rher {}\n{}",
        episodes.len(),
        about.task,
        about.rher,
        text(&lines)
    )
}
