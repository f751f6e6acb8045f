//! `rher doctor`: what this machine is, and whether it computes the same bits as every other.

use crate::cli::DoctorArgs;
use crate::errors::OtherBits;
use crate::host::Again;
use crate::printer::Printer;
use crate::surroundings::{Folder, Python};
use crate::tables::{table, text};
use rher_bits::{Part, known, measure};
use rher_core::learner::simd::Simd;
use rher_runs::Machine;
use serde::Serialize;
use std::path::Path;

/// What is printed.
#[derive(Serialize)]
struct Findings {
    program: String,
    system: String,
    processor: String,
    /// Threads that a run has if nobody says otherwise.
    threads: usize,
    /// The vector instructions that are used.
    instructions: &'static str,
    /// All that `RHER_SIMD` can choose on this machine.
    available: Vec<&'static str>,
    /// Where runs are made unless another folder is named.
    working_folder: Folder,
    /// Where what ships with the program is unpacked.
    temporary_folder: Folder,
    /// The one that runs this program, or the first that is found.
    python: Option<Python>,
    /// What may be a mistake, in sentences.
    odd: Vec<String>,
    /// With `--bits`.
    #[serde(skip_serializing_if = "Option::is_none")]
    bits: Option<Vec<Hash>>,
}

/// The hash of a part of a task.
#[derive(Serialize)]
struct Hash {
    task: &'static str,
    part: &'static str,
    found: String,
    expected: &'static str,
    same: bool,
}

pub(crate) fn doctor(args: &DoctorArgs, again: &Again, printer: Printer) -> anyhow::Result<()> {
    let Machine { program, system, processor, cores } = Machine::here();
    let (chosen, every) = (Simd::chosen()?, Simd::every());
    let mut findings = Findings {
        program,
        system,
        processor,
        threads: cores,
        instructions: chosen.name(),
        available: every.into_iter().map(Simd::name).collect(),
        working_folder: Folder::working(),
        temporary_folder: Folder::temporary(),
        python: Python::of(again.interpreter().unwrap_or(Path::new("python3"))),
        odd: Vec::new(),
        bits: args.bits.then(|| hashes(printer)).transpose()?,
    };
    findings.odd = odd(&findings);
    let shown = if args.json { serde_json::to_string_pretty(&findings)? } else { show(&findings) };
    printer.data(&shown)?;
    // The parts are in the order in which they depend on each other.
    let other = findings.bits.iter().flatten().find(|hash| !hash.same);
    other.map_or(Ok(()), |hash| Err(OtherBits { task: hash.task, part: hash.part }.into()))
}

/// What may be a mistake.
fn odd(findings: &Findings) -> Vec<String> {
    let Findings { instructions, available, working_folder, temporary_folder, python, .. } =
        findings;
    let mut odd = Vec::new();
    if *instructions != available[0] {
        odd.push(format!(
            "RHER_SIMD chooses {instructions}, although this machine has {}, which is faster",
            available[0]
        ));
    }
    odd.extend([working_folder, temporary_folder].into_iter().filter_map(Folder::odd));
    odd.extend(python.as_ref().and_then(|python| python.odd(env!("CARGO_PKG_VERSION"))));
    odd
}

fn hashes(printer: Printer) -> anyhow::Result<Vec<Hash>> {
    let mut hashes = Vec::new();
    for task in known::TASKS {
        printer.note(format_args!("measuring {task}"));
        for &part in Part::ALL {
            let found = measure(task, part)?;
            let expected = known::hash(task, part).expect("every part of these tasks is known");
            let same = found == expected;
            hashes.push(Hash { task: task.name(), part: part.name(), found, expected, same });
        }
    }
    Ok(hashes)
}

fn show(findings: &Findings) -> String {
    let Findings { program, system, processor, threads, instructions, available, .. } = findings;
    let python = findings.python.as_ref().map_or("none".to_owned(), Python::describe);
    let odd = if findings.odd.is_empty() {
        "nothing".to_owned()
    } else {
        findings.odd.join("\n              ")
    };
    let mut shown = format!(
        "program       {program}\n\
         system        {system}\n\
         processor     {processor}\n\
         threads       {threads}\n\
         instructions  {instructions}, of {}\n\
         runs          {}\n\
         temporary     {}\n\
         Python        {python}\n\
         odd           {odd}\n",
        available.join(", "),
        findings.working_folder.describe(),
        findings.temporary_folder.describe(),
    );
    if let Some(hashes) = &findings.bits {
        let mut listing = table();
        listing.set_header(["task", "part", "found", "expected", ""]);
        for Hash { task, part, found, expected, same } in hashes {
            let verdict = if *same { "same" } else { "DIFFERENT" };
            listing.add_row([task, part, found.as_str(), expected, verdict]);
        }
        shown.push('\n');
        shown.push_str(&text(&listing));
    }
    shown
}
