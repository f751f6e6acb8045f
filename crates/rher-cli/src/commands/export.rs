//! `rher export`: episodes as a dataset of demonstrations.

use super::stop_on_interrupt;
use crate::cli::{DatasetFormat, ExportArgs};
use crate::exit_code::Status;
use crate::observe::thousands;
use crate::printer::Printer;
use crate::trained::Trained;
use rher_core::evaluate::play;
use rher_core::seed::Seed;
use rher_envs::{EnvVisitor, Simulated};
use rher_record::export::{Demonstration, lerobot, minari};
use rher_record::{About, Player, Recording, Source};
use std::num::NonZeroU64;
use std::sync::atomic::{AtomicBool, Ordering};

/// Episodes to play where nothing is said.
const EPISODES: u64 = 100;

pub(crate) fn export(args: &ExportArgs, printer: Printer) -> anyhow::Result<Status> {
    let ExportArgs { path, format, out, episodes, .. } = args;
    let stop = stop_on_interrupt(move |line| printer.note(line), "stopping; nothing is written")?;
    let recorded = path.extension().is_some_and(|extension| extension == "mcap");
    let (about, demonstrations) = if recorded {
        let Recording { about, episodes: all } = Recording::read(path)?;
        let first = episodes.map_or(all.len(), |episodes| episodes.get() as usize);
        let demonstrations =
            all.iter().take(first).map(|episode| Demonstration::recorded(&about, episode));
        let demonstrations = demonstrations.collect();
        (about, demonstrations)
    } else {
        let trained = Trained::load(path)?;
        let (task, options) = (trained.task, trained.options.clone());
        let episodes = episodes.map_or(EPISODES, NonZeroU64::get);
        let seed = args.seed;
        task.visit_with(&options, PlayAll { trained, episodes, seed, stop: &stop })??
    };
    if stop.load(Ordering::Relaxed) {
        return Ok(Status::Interrupted);
    }
    match format {
        DatasetFormat::Minari => minari(out, &about, &demonstrations)?,
        DatasetFormat::Lerobot => lerobot(out, &about, &demonstrations)?,
    }
    let steps: usize = demonstrations.iter().map(|demonstration| demonstration.steps).sum();
    printer.note(format_args!(
        "{} episodes, {} steps, in `{}`",
        demonstrations.len(),
        thousands(steps as u64),
        out.display()
    ));
    Ok(Status::Success)
}

/// Episodes of a policy on a task that is known at run time.
struct PlayAll<'a> {
    trained: Trained,
    episodes: u64,
    seed: u64,
    stop: &'a AtomicBool,
}

impl EnvVisitor for PlayAll<'_> {
    type Output = anyhow::Result<(About, Vec<Demonstration>)>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let Self { trained, episodes, seed, stop } = self;
        let policy = &trained.policy;
        let mut env = build();
        policy.info().check_spec(env.spec())?;
        let reach_distance = policy.info().reach_distance;
        let about = About::new(env.spec(), Source::Policy, seed, reach_distance);
        let mut player = Player::new(build(), reach_distance);
        let stage = policy.info().last_stage::<N>()?;
        let mut demonstrations = Vec::new();
        for number in 0..episodes {
            if stop.load(Ordering::Relaxed) {
                break;
            }
            let seed = Seed(seed);
            let played = play(&mut env, policy, stage, trained.test_policy(), seed, number)?;
            let messages = player.tell(&played.script(number, None), 0)?;
            demonstrations.push(Demonstration::told(&about, &messages));
        }
        Ok((about, demonstrations))
    }
}
