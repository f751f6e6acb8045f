//! `rher replay`: what a recording holds, and whether it reproduces.

use crate::cli::ReplayArgs;
use crate::errors::{ForeignTask, NotReal};
use crate::numbers::thousands;
use crate::printer::Printer;
use crate::tables::{table, text};
use crate::trained::{made_with, unfinished};
use rher_envs::{EnvVisitor, Simulated, Task};
use rher_record::verify::verify;
use rher_record::{Player, ReadError, Recording, RecordingInfo};
use std::path::Path;

pub(crate) fn replay(args: &ReplayArgs, printer: Printer) -> anyhow::Result<()> {
    let ReplayArgs { path, verify } = args;
    let mut recording = Recording::open(path)?;
    let name = recording.info.task.clone();
    let task: Task = name.parse().map_err(|_| ForeignTask { name })?;
    let options = made_with(&recording.info.options, task)?;
    if *verify {
        let verify = Verify { recording: &mut recording, path };
        let [episodes, steps] = task.visit_with(&options, verify)??;
        printer.data(&format!(
            "verified: {episodes} episodes, {} steps of `{task}` reproduce bit for bit",
            thousands(steps)
        ))?;
    } else {
        printer.data(&list(&mut recording)?)?;
    }
    if recording.is_cut_off() {
        printer.warn(unfinished(path));
    }
    Ok(())
}

/// Verifies that every episode of a recording reproduces; the numbers of episodes and of steps.
struct Verify<'a> {
    recording: &'a mut Recording,
    path: &'a Path,
}

impl EnvVisitor for Verify<'_> {
    type Output = anyhow::Result<[u64; 2]>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let Self { recording, path } = self;
        let RecordingInfo { reach_distance, rher, rapier, .. } = recording.info.clone();
        let mut player = Player::new(build(), reach_distance);
        let [mut episodes, mut steps] = [0; 2];
        for episode in recording {
            let episode = episode?;
            if let Some(difference) = verify(&mut player, &episode)? {
                let ours = [env!("CARGO_PKG_VERSION"), rher_envs::RAPIER_VERSION];
                let made_by = (ours != [&*rher, &*rapier])
                    .then(|| format!("rher {rher} with Rapier {rapier}"));
                let path = path.to_owned();
                return Err(NotReal { path, difference, made_by }.into());
            }
            episodes += 1;
            steps += episode.script.decisions.len() as u64;
        }
        Ok([episodes, steps])
    }
}

fn list(recording: &mut Recording) -> Result<String, ReadError> {
    let mut lines = table();
    lines.set_header(["episode", "seed", "steps", "success", "distance"]);
    let mut count = 0;
    for episode in recording.by_ref() {
        let episode = episode?;
        let end = episode.end();
        lines.add_row([
            episode.script.number.to_string(),
            episode.script.seed.to_string(),
            episode.script.decisions.len().to_string(),
            if end.success { "yes" } else { "no" }.to_owned(),
            format!("{:.1} cm", 100.0 * end.distance),
        ]);
        count += 1;
    }
    let RecordingInfo { source, task, rher, .. } = &recording.info;
    let source = match source {
        rher_record::Source::Training => "training",
        rher_record::Source::Policy => "a policy",
    };
    let of = format!("{count} episodes of {source} on `{task}`, recorded by rher {rher}");
    Ok(format!("{of}\n{}", text(&lines)))
}
