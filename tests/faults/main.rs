//! Faults of the file system, and kills, in every call that the program makes for its files.
//!
//! A small C library is preloaded into the program, lets one call fail and writes down all of them;
//! `inject.c` says how. docs/faults.md has the outcome that is expected of every fault.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![expect(clippy::print_stderr, reason = "the tests are a command, too: scripts/faults")]

mod expected;
mod matrix;
mod preload;
mod program;
mod trial;
mod work;

use std::fs;
use std::path::Path;
use std::time::Duration;

/// Without more time one fault of every kind is tried; `scripts/faults` gives more.
#[test]
fn every_fault_has_the_outcome_that_the_table_says() {
    let Some(library) = preload::library() else {
        eprintln!("left out: there is no C compiler, or this is not Linux with glibc");
        return;
    };
    let number = |name: &str| -> Option<u64> {
        std::env::var(name).ok().map(|text| text.parse().expect("a number"))
    };
    let time = number("FAULTS_MINUTES").map(Duration::from_mins);
    let seed = number("FAULTS_SEED").unwrap_or(1);
    let report = matrix::run(&program::Program { library }, seed, time);
    if let Some(path) = std::env::var_os("FAULTS_REPORT") {
        fs::write(path, report.page()).unwrap();
    }
    eprintln!("{}", report.sums());
    assert!(report.idle.is_empty(), "rows of the table that hold for no fault: {:?}", report.idle);
    assert!(
        report.failures.is_empty(),
        "{} failures:\n\n{}",
        report.failures.len(),
        report.failures.join("\n")
    );
}

#[test]
fn the_document_has_the_table() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/faults.md");
    let document = fs::read_to_string(path).unwrap();
    for table in [expected::page(), work::page()] {
        assert!(document.contains(&table), "docs/faults.md must contain this table:\n\n{table}");
    }
}
