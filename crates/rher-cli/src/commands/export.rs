//! `rher export`: episodes as a dataset of demonstrations.

use crate::cli::{ExportArgs, FormatName};
use crate::errors::NoDatasetId;
use crate::exit_code::Status;
use crate::host::Stop;
use crate::numbers::thousands;
use crate::printer::Printer;
use crate::running::note_policy;
use crate::trained::{Trained, unfinished};
use rher_core::evaluate::play;
use rher_core::seed::Seed;
use rher_envs::{EnvVisitor, Simulated};
use rher_record::export::{Dataset, DatasetFormat, DatasetId, Demonstration, ExportError};
use rher_record::{Player, Recording, RecordingInfo, Source};
use std::num::NonZeroU64;

/// Episodes to play where nothing is said.
const EPISODES: u64 = 100;

pub(crate) fn export(args: &ExportArgs, printer: Printer) -> anyhow::Result<Status> {
    if args.dataset_id.is_some() && matches!(args.format, FormatName::Lerobot) {
        return Err(NoDatasetId.into());
    }
    let stop = Stop::listen(move |line| printer.note(line), "stopping; no dataset is written")?;
    let recorded = args.path.extension().is_some_and(|extension| extension == "mcap");
    let written = if recorded {
        convert(args, printer, &stop)?
    } else {
        let trained = Trained::load(&args.path, printer)?;
        note_policy(&args.path, printer);
        let (task, options) = (trained.task, trained.options.clone());
        task.visit_with(&options, PlayAll { trained, args, stop: &stop })??
    };
    let Some(Written { episodes, steps }) = written else { return Ok(stop.status()) };
    let (steps, out) = (thousands(steps), args.out.display());
    printer.note(format_args!("{episodes} episodes, {steps} steps, in `{out}`"));
    Ok(Status::Success)
}

/// What is in a dataset.
#[derive(Default)]
struct Written {
    episodes: u64,
    steps: u64,
}

impl Written {
    fn add(
        &mut self,
        dataset: &mut Dataset,
        demonstration: &Demonstration,
    ) -> Result<(), ExportError> {
        dataset.add(demonstration)?;
        self.episodes += 1;
        self.steps += demonstration.steps as u64;
        Ok(())
    }
}

fn start(args: &ExportArgs, info: &RecordingInfo) -> Result<Dataset, ExportError> {
    let format = match args.format {
        FormatName::Minari => {
            let id = args.dataset_id.clone();
            DatasetFormat::Minari(id.unwrap_or_else(|| DatasetId::of_task(&info.task)))
        }
        FormatName::Lerobot => DatasetFormat::Lerobot,
    };
    Dataset::create(&args.out, format, info)
}

/// Makes a dataset of a recording; nothing if it was stopped.
fn convert(args: &ExportArgs, printer: Printer, stop: &Stop) -> anyhow::Result<Option<Written>> {
    let mut recording = Recording::open(&args.path)?;
    let info = recording.info.clone();
    let mut dataset = start(args, &info)?;
    let mut written = Written::default();
    let first = args.episodes.map_or(u64::MAX, NonZeroU64::get);
    while written.episodes < first
        && let Some(recorded) = recording.next()
    {
        if stop.is_asked() {
            return Ok(None);
        }
        written.add(&mut dataset, &Demonstration::recorded(&info, &recorded?))?;
    }
    dataset.finish()?;
    if recording.is_cut_off() {
        printer.warn(unfinished(&args.path));
    }
    Ok(Some(written))
}

/// Makes a dataset of a policy's episodes on a task that is known at run time; nothing if it was
/// stopped.
struct PlayAll<'a> {
    trained: Trained,
    args: &'a ExportArgs,
    stop: &'a Stop,
}

impl EnvVisitor for PlayAll<'_> {
    type Output = anyhow::Result<Option<Written>>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let Self { trained, args, stop } = self;
        let policy = &trained.policy;
        let mut env = build();
        policy.check_spec(env.spec())?;
        let reach_distance = policy.info().reach_distance;
        let info = RecordingInfo::new(env.spec(), Source::Policy, args.seed, reach_distance);
        let mut player = Player::new(build(), reach_distance);
        let stage = policy.info().last_stage::<N>()?;
        let mut dataset = start(args, &info)?;
        let mut written = Written::default();
        for number in 0..args.episodes.map_or(EPISODES, NonZeroU64::get) {
            if stop.is_asked() {
                return Ok(None);
            }
            let (test_policy, seed) = (trained.test_policy(), Seed(args.seed));
            let played = play(&mut env, policy, stage, test_policy, seed, number)?;
            let messages = player.messages(&played.script(number, None), 0)?;
            written.add(&mut dataset, &Demonstration::played(&info, &messages))?;
        }
        dataset.finish()?;
        Ok(Some(written))
    }
}
