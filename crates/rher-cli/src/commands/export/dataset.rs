//! Episodes as a dataset of demonstrations.

use crate::cli::ExportArgs;
use crate::exit_code::Status;
use crate::host::Stop;
use crate::numbers::thousands;
use crate::printer::Printer;
use crate::running::note_policy;
use crate::trained::{Trained, unfinished};
use rher_core::evaluate::play;
use rher_core::seed::Seed;
use rher_envs::{EnvVisitor, Simulated};
use rher_record::export::{Dataset, DatasetFormat, Demonstration, ExportError};
use rher_record::{Player, Recording, RecordingInfo, Source};
use std::num::NonZeroU64;

/// Episodes to play where nothing is said.
const EPISODES: u64 = 100;

/// The format of a dataset, once it is known what its episodes are.
pub(super) type FormatOf<'a> = &'a dyn Fn(&RecordingInfo) -> DatasetFormat;

pub(super) fn export(
    args: &ExportArgs,
    format: FormatOf<'_>,
    printer: Printer,
) -> anyhow::Result<Status> {
    let stop = Stop::listen(move |line| printer.note(line), "stopping; no dataset is written")?;
    let recorded = args.path.extension().is_some_and(|extension| extension == "mcap");
    let written = if recorded {
        convert(args, format, printer, &stop)?
    } else {
        let trained = Trained::load(&args.path, printer)?;
        note_policy(&args.path, printer);
        let (task, options) = (trained.task, trained.options.clone());
        task.visit_with(&options, PlayAll { trained, args, format, stop: &stop })??
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

/// Makes a dataset of a recording; nothing if it was stopped.
fn convert(
    args: &ExportArgs,
    format: FormatOf<'_>,
    printer: Printer,
    stop: &Stop,
) -> anyhow::Result<Option<Written>> {
    let mut recording = Recording::open(&args.path)?;
    let info = recording.info.clone();
    let mut dataset = Dataset::create(&args.out, format(&info), &info)?;
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
    format: FormatOf<'a>,
    stop: &'a Stop,
}

impl EnvVisitor for PlayAll<'_> {
    type Output = anyhow::Result<Option<Written>>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let Self { trained, args, format, stop } = self;
        let seed = args.seed.unwrap_or(0);
        let policy = &trained.policy;
        let mut env = build();
        policy.check_spec(env.spec())?;
        let reach_distance = policy.info().reach_distance;
        let info = RecordingInfo::new(env.spec(), Source::Policy, seed, reach_distance);
        let mut player = Player::new(build(), reach_distance);
        let stage = policy.info().last_stage::<N>()?;
        let mut dataset = Dataset::create(&args.out, format(&info), &info)?;
        let mut written = Written::default();
        for number in 0..args.episodes.map_or(EPISODES, NonZeroU64::get) {
            if stop.is_asked() {
                return Ok(None);
            }
            let (test_policy, seed) = (trained.test_policy(), Seed(seed));
            let played = play(&mut env, policy, stage, test_policy, seed, number)?;
            let messages = player.messages(&played.script(number, None), 0)?;
            written.add(&mut dataset, &Demonstration::played(&info, &messages))?;
        }
        dataset.finish()?;
        Ok(Some(written))
    }
}
