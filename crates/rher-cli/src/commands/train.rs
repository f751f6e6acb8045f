//! `rher train`: a new run, or one that is resumed.

use crate::cli::{SettingsArgs, TrainArgs};
use crate::errors::ForeignTask;
use crate::exit_code::Status;
use crate::flops;
use crate::host::{Stop, end_with_parent, threads};
use crate::jobs::{Job, holds_run};
use crate::numbers::{duration, percent, thousands};
use crate::observe::{Course, ProgressView, Watch};
use crate::printer::Printer;
use crate::running::note_policy;
use crate::shell::word;
use crate::trained::made_with;
use rher_core::config::{EngineKind, Precision, TrainConfig};
use rher_core::event::{Event, Metrics, Progress, Seconds};
use rher_core::files::FileError;
use rher_core::train::checkpoint;
use rher_core::train::{Finish, Pretrained, Trainer};
use rher_envs::{EnvVisitor, Simulated, Task};
#[cfg(feature = "live")]
use rher_record::{Live, Player};
use rher_record::{Recorder, RecordingFile, RecordingInfo, Source};
use rher_runs::sweep::{Claim, Guard, Pulse};
use rher_runs::{
    EventFile, RunDir, RunFiles, Settings, read_evaluations, read_pretrained, settings,
};
use std::num::{NonZeroU64, NonZeroUsize};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

const STOPPING: &str = "saving; Ctrl-C again exits at once, with the last checkpoint";

pub(crate) fn train(args: &TrainArgs, printer: Printer) -> anyhow::Result<Status> {
    let TrainArgs { task, settings, workers, out, resume, record_every, parent, .. } = args;
    if parent.is_some_and(|parent| !end_with_parent(parent)) {
        return Ok(Status::Terminated);
    }
    let how = How {
        workers: threads(*workers),
        record_every: *record_every,
        tensorboard: args.tensorboard,
        #[cfg(feature = "live")]
        live: args.live,
        max_wall: args.max_wall,
        claim: None,
        printer,
    };
    match (resume, task) {
        (Some(path), _) => {
            let SettingsArgs { env_steps, until, engine, precision, .. } = *settings;
            go_on(path, Changes { env_steps, until, engine, precision }, how)
        }
        (None, Some(task)) => {
            let settings = settings::resolve_here(*task, &settings.into())?;
            let path = out.clone().unwrap_or_else(|| RunDir::default_path(&settings.config));
            let pretrained = args.from.as_deref().map(read_pretrained).transpose()?;
            if let Some(from) = &args.from {
                note_policy(from, printer);
            }
            let start = Start::New { path, pretrained: pretrained.map(Box::new) };
            begin(*task, settings, start, how)
        }
        (None, None) => unreachable!("clap asks for a task where there is nothing to resume"),
    }
}

/// What bounds the training of a cell.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    pub(super) workers: NonZeroUsize,
    pub(super) max_wall: Option<Duration>,
}

/// Begins the run of a cell of a plan, or goes on with it.
pub(super) fn train_cell(
    job: &Job,
    claim: &Claim,
    limits: Limits,
    printer: Printer,
) -> anyhow::Result<Status> {
    let how = How {
        workers: limits.workers.get(),
        record_every: None,
        tensorboard: false,
        #[cfg(feature = "live")]
        live: None,
        max_wall: limits.max_wall,
        claim: Some((claim.guard(), claim.pulse())),
        printer,
    };
    let Job { task, settings, folder, .. } = job;
    if holds_run(folder)? {
        let (env_steps, until) = (settings.config.env_steps, settings.config.until);
        let changes = Changes {
            env_steps: Some(env_steps),
            until: Some(until),
            engine: None,
            precision: None,
        };
        return go_on(folder, changes, how);
    }
    begin(*task, settings.clone(), Start::New { path: folder.clone(), pretrained: None }, how)
}

/// What is no part of the experiment.
struct How {
    workers: usize,
    record_every: Option<NonZeroU64>,
    tensorboard: bool,
    #[cfg(feature = "live")]
    live: Option<std::net::SocketAddr>,
    max_wall: Option<Duration>,
    /// What the cell of a plan is claimed by.
    claim: Option<(Guard, Pulse)>,
    printer: Printer,
}

/// What a resumed run may have otherwise than before.
struct Changes {
    env_steps: Option<u64>,
    until: Option<f32>,
    engine: Option<EngineKind>,
    precision: Option<Precision>,
}

/// Starts a run in a folder of its own.
fn begin(
    task: Task,
    Settings { config, options }: Settings,
    start: Start,
    how: How,
) -> anyhow::Result<Status> {
    task.visit_with(&options, Session { config, start, how })?
}

/// Goes on with the run in a folder.
fn go_on(path: &Path, changes: Changes, how: How) -> anyhow::Result<Status> {
    let folder = RunDir::open(path)?;
    let config = checkpoint::read_config(path)?;
    let name = config.task.clone();
    let task: Task = name.parse().map_err(|_| ForeignTask { name })?;
    let start = Start::Resumed { folder, changes };
    let options = made_with(&checkpoint::read_variant(path)?, task)?;
    task.visit_with(&options, Session { config, start, how })?
}

/// Training on a task that is known at run time.
struct Session {
    config: TrainConfig,
    start: Start,
    how: How,
}

enum Start {
    /// In a folder that is not there yet, perhaps from another run.
    New { path: PathBuf, pretrained: Option<Box<Pretrained>> },
    /// From the checkpoint, with what is changed.
    Resumed { folder: RunDir, changes: Changes },
}

impl EnvVisitor for Session {
    type Output = anyhow::Result<Status>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let Self { config, start, how } = self;
        let started = Instant::now();
        let How { workers, record_every, tensorboard, printer, max_wall, claim, .. } = how;
        let envs: Vec<E> = (0..config.envs.max(workers)).map(|_| build()).collect();
        let is_visible = !envs[0].things().is_empty();
        let (folder, mut trainer) = match start {
            Start::New { path, pretrained } => {
                let trainer = match pretrained {
                    Some(pretrained) => Trainer::new_from(&pretrained, config, envs, workers)?,
                    None => Trainer::new(config, envs, workers)?,
                };
                // Nothing is made for a run that cannot begin.
                (RunDir::create(&path)?, trainer)
            }
            Start::Resumed { folder, changes } => {
                let Changes { env_steps, until, engine, precision } = changes;
                let before = config.agent.precision;
                let path = folder.path();
                let mut trainer = Trainer::resume_on(engine, precision, path, envs, workers)?;
                let after = trainer.config().agent.precision;
                if after != before {
                    printer.note(format_args!(
                        "from here on the precision is `{}`; the run had `{}`, with which it would \
                         not learn the same",
                        after.name(),
                        before.name()
                    ));
                }
                change_end(&mut trainer, env_steps, until, printer);
                (folder, trainer)
            }
        };
        if !folder.is_guarded() {
            printer.warn(format_args!(
                "the file system of `{}` has no locks: make sure that no other process trains there",
                folder.path().display()
            ));
        }
        let files = RunFiles::new(folder, &trainer)?;
        let (folder, settings) = (files.folder(), files.settings());
        let evaluations = match trainer.evaluations() {
            0 => Vec::new(),
            _ => read_evaluations(folder.path(), Some(trainer.id()))?,
        };
        finish_recordings(folder, printer)?;
        if let Some(finish) = trainer.finished() {
            // Its last policy may be missing, where a stop fell between two files.
            trainer.run(Some(folder.path()), &mut |_: &Event| Ok(()), &AtomicBool::new(false))?;
            printer.note(already_finished(finish, folder, trainer.progress()));
            return Ok(Status::Success);
        }
        let recorder = match record_every {
            Some(every) => {
                let (env, TrainConfig { seed, relay, .. }) = (build(), &settings.config);
                let mut info =
                    RecordingInfo::new(env.spec(), Source::Training, *seed, relay.reach_distance);
                info.run = Some(trainer.id());
                info.config = settings::to_toml(settings)?;
                Some(Recorder::new(every, folder.path(), info, env))
            }
            None => None,
        };
        #[cfg(feature = "live")]
        let live = match how.live {
            Some(address) => {
                let player = Player::new(build(), settings.config.relay.reach_distance);
                let live = Live::start(address, player)?;
                let address = std::net::SocketAddr::new(address.ip(), live.port());
                printer.note(format_args!("live: in Foxglove, open the connection ws://{address}"));
                Some(live)
            }
            None => None,
        };
        let names = settings.config.task.parse().map_or_else(|_| Vec::new(), Task::subtasks);
        let course = Course::new(trainer.config(), names, trainer.spec().episode_steps);
        let progress = ProgressView::new(printer, course, trainer.progress(), &evaluations);
        let started_at = trainer.progress().env_steps;
        let events = tensorboard.then(|| EventFile::create(folder.path(), started_at));
        if let Some((_, pulse)) = &claim {
            pulse.report(started_at);
        }
        let watch = Watch {
            files,
            claim,
            events: events.transpose()?,
            progress,
            recorder,
            #[cfg(feature = "live")]
            live,
            last: None,
        };
        let left = max_wall.map(|time| time.saturating_sub(started.elapsed()));
        run(trainer, watch, left, is_visible, printer)
    }
}

/// Changes when a run ends. One that was solved goes on to the steps that are asked for, unless a
/// success rate is asked for as well.
fn change_end<const N: usize, E: Simulated<N>>(
    trainer: &mut Trainer<N, E>,
    env_steps: Option<u64>,
    until: Option<f32>,
    printer: Printer,
) {
    let is_solved = trainer.finished() == Some(Finish::Solved);
    if let Some(env_steps) = env_steps {
        trainer.set_env_steps(env_steps);
        let taken = trainer.progress().env_steps;
        if env_steps < taken {
            printer.note(format_args!(
                "the run has taken {} steps, more than the {} that it is to end after: it ends here",
                thousands(taken),
                thousands(env_steps)
            ));
        }
        if is_solved && until.is_none() && env_steps > trainer.progress().env_steps {
            printer.note(format_args!(
                "the run reached its success rate before; it continues to {} steps",
                thousands(env_steps)
            ));
            trainer.set_until(0.0);
        }
    }
    if let Some(until) = until {
        trainer.set_until(until);
    }
}

/// Finishes what a killed process was recording.
fn finish_recordings(folder: &RunDir, printer: Printer) -> Result<(), FileError> {
    for recovered in RecordingFile::recover(folder.path())? {
        match recovered {
            Ok(path) => {
                printer.note(format_args!("finished the recording `{}`", path.display()));
            }
            Err(error) => printer.warn(format_args!(
                "an unfinished recording stays as it is: {:#}",
                anyhow::Error::from(error)
            )),
        }
    }
    Ok(())
}

fn run<const N: usize, E: Simulated<N>>(
    mut trainer: Trainer<N, E>,
    mut watch: Watch<E, N>,
    left: Option<Duration>,
    is_visible: bool,
    printer: Printer,
) -> anyhow::Result<Status> {
    let path = watch.files.path().to_owned();
    let is_cell = watch.claim.is_some();
    printer.note(format_args!("run folder: {}", path.display()));
    let stop = Stop::listen(watch.progress.teller(), STOPPING)?;
    if let Some(left) = left {
        stop.after(left)?;
    }
    let finish = trainer.run(Some(&path), &mut watch, stop.flag());
    watch.progress.finish();
    let recorded = watch.recorder.map(Recorder::finish).transpose();
    if finish.is_err() {
        // Whatever failed, failed because of it.
        watch.files.folder().check()?;
    }
    let finish = finish?;
    match recorded {
        Ok(Some(Some((episodes, path)))) => {
            printer.note(format_args!("recorded {episodes} episodes in `{}`", path.display()));
        }
        Ok(_) => {}
        Err(error) => printer.warn(format_args!(
            "the recording is not finished: {error}: {}; its whole episodes can still be read",
            error.source
        )),
    }
    printer.note(summary(finish, &trainer, watch.last.as_ref(), watch.files.folder()));
    if finish != Finish::Stopped && !is_cell {
        let film = if is_visible { " --film policy.gif" } else { "" };
        printer.note(format_args!("`rher play {}{film}` shows it", word(&path)));
    }
    if finish == Finish::Stopped {
        printer.note(if is_cell {
            "the same command continues the cell".to_owned()
        } else {
            format!("`rher train --resume {}` continues the run", word(&path))
        });
    }
    Ok(match finish {
        Finish::Solved | Finish::StepsSpent => Status::Success,
        Finish::Stopped => stop.status(),
    })
}

fn already_finished(finish: Finish, folder: &RunDir, progress: Progress) -> String {
    let steps = thousands(progress.env_steps);
    let end = match finish {
        Finish::Solved => "it reached its success rate",
        Finish::StepsSpent | Finish::Stopped => "it took all of its steps",
    };
    let path = folder.path().display();
    format!(
        "`{path}` is finished: {end}, after {steps} steps\n\n\
         hint: `rher train --resume {} --env-steps N` with more steps continues it",
        word(folder.path())
    )
}

/// How a run ended, where its time went, and where its policy is.
fn summary<const N: usize, E: Simulated<N>>(
    finish: Finish,
    trainer: &Trainer<N, E>,
    last: Option<&Metrics>,
    folder: &RunDir,
) -> String {
    let episodes = trainer.config().evaluation.episodes;
    let end = match finish {
        Finish::Solved => "solved",
        Finish::StepsSpent => "all steps taken",
        Finish::Stopped => "stopped",
    };
    let mut lines = vec![format!("{end} after {} steps", thousands(trainer.progress().env_steps))];
    if let Some(Metrics { success_final, final_distance, wall_s, time, .. }) = last {
        lines.push(format!(
            "success {} of {episodes} evaluation episodes, objects {:.1} cm from their targets at \
             the end",
            percent((*success_final).into()),
            100.0 * final_distance
        ));
        lines.push(format!("time    {}: {}", duration(*wall_s), shares(time)));
    }
    let Progress { updates, .. } = trainer.progress();
    lines.push(format!(
        "updates {}: {:.1} TFLOP in matrix products",
        thousands(updates),
        flops::of_run(trainer.config(), trainer.spec(), updates) / 1e12
    ));
    lines.push(format!("policy  {}", folder.policy().display()));
    lines.join("\n")
}

fn shares(time: &Seconds) -> String {
    let Seconds { environment, inference, relabel, update, evaluate, save } = *time;
    let total = environment + inference + relabel + update + evaluate + save;
    let parts = [
        ("environment", environment),
        ("inference", inference),
        ("relabel", relabel),
        ("update", update),
        ("evaluate", evaluate),
        ("save", save),
    ];
    let parts = parts.map(|(name, seconds)| format!("{name} {}", percent(seconds / total)));
    parts.join(", ")
}
