//! `rher card`: a policy with all that is known of it, in the form of the Hugging Face Hub.

use super::eval::{EvalReport, describe, judge};
use super::report::{film, train_command};
use crate::cli::CardArgs;
use crate::host::threads;
use crate::numbers::thousands;
use crate::printer::Printer;
use crate::running::note_policy;
use crate::shipped;
use crate::trained::{Trained, sha256};
use rher_core::files::{self, FileError};
use rher_core::train::checkpoint::POLICY_FILE;
use rher_record::export::ExportError;
use rher_runs::{CONFIG_FILE, METRICS_FILE, Machine, Run};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// The moving picture.
const FILM_FILE: &str = "episode.gif";

/// Files of the run that go along, so that the folder is one that every command takes.
const FILES: [&str; 3] = [POLICY_FILE, CONFIG_FILE, METRICS_FILE];

pub(crate) fn card(args: &CardArgs, printer: Printer) -> anyhow::Result<()> {
    if args.out.exists() {
        return Err(ExportError::Exists { path: args.out.clone() }.into());
    }
    let folder = shipped::folder(&args.run, printer)?;
    let run = Run::read(&folder)?;
    let trained = Trained::load(&folder, printer)?;
    note_policy(&args.run, printer);
    let files = FILES.map(|name| {
        let path = folder.join(name);
        fs::read(&path).map(|bytes| (name, bytes)).map_err(FileError::read(&path))
    });
    let mut files = files.into_iter().collect::<Result<Vec<_>, _>>()?;
    let env_seed = trained.training_seed().unwrap_or(0).wrapping_add(1);
    let report = judge(&trained, &trained.options, args.episodes.get(), env_seed, threads(None))?;
    let film = film(&trained)?;
    let has_film = film.is_some();
    files.extend(film.map(|film| (FILM_FILE, film)));
    let machine = Machine::of_run(&folder).ok().flatten();
    let page = page(args, &run, &trained, &report, machine, &files, has_film);
    files.push(("README.md", page.into_bytes()));
    fs::create_dir_all(&args.out).map_err(FileError::write(&args.out))?;
    for (name, bytes) in &files {
        files::replace(&args.out.join(name), bytes)?;
    }
    printer.note(format_args!("card  {}", args.out.join("README.md").display()));
    Ok(())
}

fn page(
    args: &CardArgs,
    run: &Run,
    trained: &Trained,
    report: &EvalReport,
    machine: Option<Machine>,
    files: &[(&str, Vec<u8>)],
    has_film: bool,
) -> String {
    let name = name(&args.run);
    let mut page = head(&name, run, report);
    let mut add = |text: &str| {
        page.push('\n');
        page.push_str(text.trim_end());
        page.push('\n');
    };
    add(&format!("# {name}"));
    add(&format!(
        "A policy for the task `{}` of `rher`, Relay Hindsight Experience Replay. {}.",
        run.group.task,
        trained.task.about().trim_end_matches('.')
    ));
    if has_film {
        add(&format!("![The first evaluation episode]({FILM_FILE})"));
    }
    add("## How well it does");
    add(&code("text", &describe(report, &trained.task.subtasks(), &[])));
    add("The interval is Wilson's. In this folder, this command measures the same:");
    let EvalReport { episodes, env_seed, .. } = report;
    add(&code("console", &format!("$ rher eval . --episodes {episodes} --seed {env_seed}")));
    add("## How to use it");
    add(&code(
        "python",
        "import rher\n\npolicy = rher.Policy.load(\"policy.safetensors\")\naction = policy(observation)",
    ));
    add("`observation` is the dictionary that the environment returns. For other runtimes, \
         `rher export . --format onnx` writes an ONNX model, and what its numbers are.");
    add("## How it was trained");
    if let Some(command) = train_command(run) {
        add(&code("console", &format!("$ {command}")));
        add("The same command gives the same policy, bit for bit, on every machine.");
    }
    let mut training = format!(
        "{} environment steps of the method `{}` with the preset `{}` and the seed {}",
        thousands(run.last().env_steps),
        run.group.method,
        run.group.preset,
        run.seed
    );
    if let Some(Machine { program, system, processor, cores }) = machine {
        let _ = write!(training, ", by {program} on {system} ({processor}, {cores} cores)");
    }
    add(&format!(
        "{training}, on sparse rewards, without demonstrations. `{METRICS_FILE}` has every \
         evaluation."
    ));
    add("<details><summary>All settings</summary>");
    let settings = files.iter().find(|(name, _)| *name == CONFIG_FILE);
    let settings = settings.map(|(_, bytes)| String::from_utf8_lossy(bytes)).unwrap_or_default();
    add(&code("toml", &settings));
    add("</details>");
    add("## Files");
    let mut table = "| file | SHA-256 |\n|---|---|\n".to_owned();
    for (name, bytes) in files {
        let _ = writeln!(table, "| `{name}` | `{}` |", sha256(bytes));
    }
    add(&table);
    if let Some(id) = trained.policy.run() {
        add(&format!("Identity of the run: `{id}`"));
    }
    page
}

/// The metadata that the Hub reads. Strings of JSON are strings of YAML, too.
fn head(name: &str, run: &Run, report: &EvalReport) -> String {
    let quoted = |text: &str| serde_json::Value::from(text).to_string();
    let task = &run.group.task;
    format!(
        "---\n\
         library_name: rher\n\
         pipeline_tag: reinforcement-learning\n\
         tags:\n\
         - reinforcement-learning\n\
         - robotics\n\
         - goal-conditioned\n\
         - {tag}\n\
         model-index:\n\
         - name: {name}\n  \
           results:\n  \
           - task:\n      \
               type: reinforcement-learning\n      \
               name: reinforcement-learning\n    \
             dataset:\n      \
               type: {data}\n      \
               name: {data}\n    \
             metrics:\n    \
             - type: success_rate\n      \
               name: success rate in {episodes} episodes, 95 % interval {low:.4} to {high:.4}\n      \
               value: {success}\n\
         ---\n",
        tag = quoted(task),
        name = quoted(name),
        data = quoted(&format!("rher/{task}")),
        episodes = report.episodes,
        low = report.ci95[0],
        high = report.ci95[1],
        success = report.success_final,
    )
}

fn code(language: &str, text: &str) -> String {
    format!("```{language}\n{}\n```", text.trim_end())
}

/// What a run is called.
fn name(run: &Path) -> String {
    let absolute = fs::canonicalize(run);
    let path = absolute.as_deref().unwrap_or(run);
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
