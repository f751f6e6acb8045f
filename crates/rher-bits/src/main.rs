//! Prints every hash, and ends with 1 if one of them is not the one that every machine must find.
#![expect(clippy::print_stdout, reason = "it prints, for whoever has no other program of ours")]

use rher_bits::{MeasureError, Part, known, measure};
use rher_core::learner::simd::Simd;
use std::process::ExitCode;

fn main() -> Result<ExitCode, MeasureError> {
    let simd = Simd::chosen().map_err(|error| MeasureError::Engine(error.into()))?;
    println!("{} with {}", std::env::consts::ARCH, simd.name());
    let mut same = true;
    for task in known::TASKS {
        for &part in Part::ALL {
            let (found, expected) = (measure(task, part)?, known::hash(task, part));
            let verdict = if expected == Some(&*found) { "same" } else { "DIFFERENT" };
            println!("{task:10}  {part:11}  {found}  {verdict}");
            same &= expected == Some(&*found);
        }
    }
    Ok(if same { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
