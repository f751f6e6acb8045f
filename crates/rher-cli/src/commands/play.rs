//! `rher play`: what a policy does, episode by episode, and recordings of it.

use crate::cli::PlayArgs;
use crate::exit_code::Status;
use crate::film::{Pictures, solved};
use crate::host::Stop;
use crate::printer::Printer;
use crate::running::note_policy;
use crate::tables::{table, text};
use crate::trained::Trained;
use rher_core::evaluate::{Played, final_distance, play as play_episode};
use rher_core::goal::Tolerances;
use rher_core::seed::Seed;
use rher_envs::{EnvVisitor, Simulated};
use rher_record::{Player, RecordingFile, RecordingInfo, Source, layout_beside};

pub(crate) fn play(args: &PlayArgs, printer: Printer) -> anyhow::Result<Status> {
    let trained = Trained::load(&args.path, printer)?;
    note_policy(&args.path, printer);
    let (task, options) = (trained.task, trained.options.clone());
    task.visit_with(&options, Play { trained, args, printer })?
}

/// Episodes of a task that is known at run time.
struct Play<'a> {
    trained: Trained,
    args: &'a PlayArgs,
    printer: Printer,
}

impl EnvVisitor for Play<'_> {
    type Output = anyhow::Result<Status>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let Self { trained, args, printer } = self;
        let env = build();
        trained.policy.check_spec(env.spec())?;
        let reach_distance = trained.policy.info().reach_distance;
        let mut info = RecordingInfo::new(env.spec(), Source::Policy, args.seed, reach_distance);
        trained.describe(&mut info)?;
        let recording = args.mcap.as_ref().map(|path| RecordingFile::create(path, &info));
        let mut recording = recording.transpose()?;
        let mut pictures = Pictures::new(&args.pictures, build(), trained.task, reach_distance)?;
        let mut player = Player::new(build(), reach_distance);
        let stop = Stop::listen(
            move |line| printer.note(line),
            "finishing the episode; press Ctrl-C again to exit at once",
        )?;
        let critic = trained.critic()?;
        let mut show = |number, played: &Played<N>| -> anyhow::Result<()> {
            if let Some(recording) = &mut recording {
                let script = played.script(number, critic.as_ref());
                recording.add(&player.messages(&script, recording.next())?)?;
            }
            if let Some(pictures) = &mut pictures {
                pictures.add(number, played)?;
            }
            Ok(())
        };
        let lines = play_all(env, &trained, args, &mut show, &stop);
        match (recording, &lines) {
            (Some(recording), Ok(_)) => {
                let path = recording.finish()?;
                let layout = layout_beside(&path);
                printer.note(format_args!(
                    "recorded in `{}`; `{}` is a layout to import in Foxglove",
                    path.display(),
                    layout.display()
                ));
            }
            (Some(recording), Err(_)) => recording.discard()?,
            (None, _) => {}
        }
        let lines = lines?;
        if let Some(pictures) = pictures {
            pictures.finish(printer)?;
        }
        printer.data(&lines)?;
        Ok(if stop.is_asked() { stop.status() } else { Status::Success })
    }
}

/// Plays every episode that was asked for, and shows it; what became of each, as a table.
fn play_all<const N: usize, E: Simulated<N>>(
    mut env: E,
    trained: &Trained,
    args: &PlayArgs,
    show: &mut impl FnMut(u64, &Played<N>) -> anyhow::Result<()>,
    stop: &Stop,
) -> anyhow::Result<String> {
    let policy = &trained.policy;
    let stage = policy.info().last_stage::<N>()?;
    let tolerances = env.spec().tolerances;
    let mut lines = table();
    lines.set_header(["episode", "success", "distance", "steps to success"]);
    for number in 0..args.episodes.get() {
        if stop.is_asked() {
            break;
        }
        let (test_policy, seed) = (trained.test_policy(), Seed(args.seed));
        let played = play_episode(&mut env, policy, stage, test_policy, seed, number)?;
        show(number, &played)?;
        let [success, steps] = success(&played, &tolerances);
        lines.add_row([number.to_string(), success, distance(&played, &tolerances), steps]);
    }
    Ok(text(&lines))
}

/// Whether an episode ended well, and from which step on all was well.
fn success<const N: usize>(played: &Played<N>, tolerances: &Tolerances<N>) -> [String; 2] {
    let solved = solved(played, tolerances);
    match solved.iter().rposition(|solved| !solved) {
        Some(unsolved) if unsolved + 1 == solved.len() => ["no".to_owned(), "–".to_owned()],
        unsolved => ["yes".to_owned(), unsolved.map_or(0, |step| step + 1).to_string()],
    }
}

fn distance<const N: usize>(
    Played { stage, episode, .. }: &Played<N>,
    tolerances: &Tolerances<N>,
) -> String {
    let end = &episode.achieved[episode.achieved.len() - 1];
    format!("{:.1} cm", 100.0 * final_distance(*stage, end, &episode.desired, tolerances))
}
