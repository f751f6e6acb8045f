//! `rher doctor`: what this machine is, and whether it computes the same bits as every other.

use crate::cli::DoctorArgs;
use crate::errors::OtherBits;
use crate::printer::Printer;
use crate::tables::{table, text};
use rher_bits::{Part, known, measure};
use rher_core::learner::simd::Simd;
use rher_runs::Machine;
use serde::Serialize;

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

pub(crate) fn doctor(args: &DoctorArgs, printer: Printer) -> anyhow::Result<()> {
    let Machine { program, system, processor, cores } = Machine::here();
    let findings = Findings {
        program,
        system,
        processor,
        threads: cores,
        instructions: Simd::chosen()?.name(),
        available: Simd::every().into_iter().map(Simd::name).collect(),
        bits: args.bits.then(|| hashes(printer)).transpose()?,
    };
    let shown = if args.json { serde_json::to_string_pretty(&findings)? } else { show(&findings) };
    printer.data(&shown)?;
    // The parts are in the order in which they depend on each other.
    let other = findings.bits.iter().flatten().find(|hash| !hash.same);
    other.map_or(Ok(()), |hash| Err(OtherBits { task: hash.task, part: hash.part }.into()))
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
    let Findings { program, system, processor, threads, instructions, available, bits } = findings;
    let mut shown = format!(
        "program       {program}\n\
         system        {system}\n\
         processor     {processor}\n\
         threads       {threads}\n\
         instructions  {instructions}, of {}\n",
        available.join(", ")
    );
    if let Some(hashes) = bits {
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
