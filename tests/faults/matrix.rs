//! All faults, or some of each kind, on all cores.

use crate::expected::expected;
use crate::preload::{Call, Fault};
use crate::program::Program;
use crate::trial::{Bench, Disturbance};
use crate::work::{Place, Verb};
use rand::seq::SliceRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Kills at random moments where there is no more time, for each command.
const KILLS: usize = 4;

/// One kind of fault: the lines of a report.
type Kind = (Verb, Option<(Call, Place, Fault)>);

/// One trial.
#[derive(Clone, Copy)]
struct Trial {
    bench: usize,
    disturbance: Disturbance,
}

/// What was tried, and what failed.
#[derive(Default)]
pub(crate) struct Report {
    seed: u64,
    seconds: f64,
    /// Trials and failures of each kind.
    counts: BTreeMap<Kind, [usize; 2]>,
    pub(crate) failures: Vec<String>,
}

/// Tries faults: one of every kind, or as many as there is time for.
pub(crate) fn run(program: &Program, seed: u64, time: Option<Duration>) -> Report {
    let started = Instant::now();
    let benches: Vec<Bench> = Verb::ALL.iter().map(|&verb| Bench::new(verb, program)).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut queue = match time {
        None => sample(&benches, &mut rng),
        Some(_) => all(&benches, &mut rng),
    };
    let next = AtomicUsize::new(0);
    let is_over = AtomicBool::new(false);
    let report = Mutex::new(Report { seed, ..Report::default() });
    let work = |queue: &[Trial]| {
        while let Some(&Trial { bench, disturbance }) =
            queue.get(next.fetch_add(1, Ordering::Relaxed))
        {
            if time.is_some_and(|time| started.elapsed() > time) {
                is_over.store(true, Ordering::Relaxed);
                return;
            }
            let wrong = benches[bench].try_out(disturbance, program);
            report.lock().unwrap().add(benches[bench].verb, disturbance, wrong);
        }
    };
    let cores = thread::available_parallelism().map_or(1, NonZeroUsize::get);
    loop {
        thread::scope(|scope| {
            for _ in 0..cores {
                scope.spawn(|| work(&queue));
            }
        });
        if time.is_none() || is_over.load(Ordering::Relaxed) {
            break;
        }
        // All have been tried; the next round has other moments for its kills.
        queue = all(&benches, &mut rng);
        next.store(0, Ordering::Relaxed);
    }
    let mut report = report.into_inner().unwrap();
    report.seconds = started.elapsed().as_secs_f64();
    report
}

/// Every fault in every call, and as many kills as a twentieth of them, in any order.
fn all(benches: &[Bench], rng: &mut ChaCha8Rng) -> Vec<Trial> {
    let faults = |(bench, it): (usize, &Bench)| -> Vec<Trial> {
        it.faults().map(|disturbance| Trial { bench, disturbance }).collect()
    };
    let mut trials: Vec<Trial> = benches.iter().enumerate().flat_map(faults).collect();
    for bench in 0..benches.len() {
        let kills = trials.len() / benches.len() / 20;
        trials.extend(kills_of(benches, bench, kills, rng));
    }
    trials.shuffle(rng);
    trials
}

/// One fault of every kind.
fn sample(benches: &[Bench], rng: &mut ChaCha8Rng) -> Vec<Trial> {
    let mut trials = all(benches, rng);
    let mut kinds = BTreeSet::new();
    trials.retain(|trial| {
        let (kind, _) = kind(benches[trial.bench].verb, trial.disturbance);
        kind.1.is_some() && kinds.insert(kind)
    });
    for bench in 0..benches.len() {
        trials.extend(kills_of(benches, bench, KILLS, rng));
    }
    trials
}

/// Kills at any moment of a command, or just after it.
fn kills_of(benches: &[Bench], bench: usize, count: usize, rng: &mut ChaCha8Rng) -> Vec<Trial> {
    let Bench { verb, took, .. } = benches[bench];
    // The process that the sweep itself is.
    let count = if verb == Verb::SweptRun { 0 } else { count };
    let mut delay = || took.mul_f64(rng.random_range(0.0..1.2));
    let kill = |_| Trial { bench, disturbance: Disturbance::KillAfter(delay()) };
    (0..count).map(kill).collect()
}

/// The kind of a disturbance, and what is expected of it.
fn kind(verb: Verb, disturbance: Disturbance) -> (Kind, String) {
    match disturbance {
        Disturbance::Fault { call, place, fault, .. } => {
            let outcome = expected(verb, call, place, fault).1;
            ((verb, Some((call, place, fault))), outcome.to_string())
        }
        Disturbance::KillAfter(_) => ((verb, None), "killed".to_owned()),
    }
}

impl Report {
    fn add(&mut self, verb: Verb, disturbance: Disturbance, wrong: Option<String>) {
        let count = self.counts.entry(kind(verb, disturbance).0).or_default();
        count[0] += 1;
        count[1] += usize::from(wrong.is_some());
        self.failures.extend(wrong);
    }

    /// All in one line.
    pub(crate) fn sums(&self) -> String {
        let sum = |of: &dyn Fn(&Kind) -> bool| -> usize {
            self.counts.iter().filter(|(kind, _)| of(kind)).map(|(_, count)| count[0]).sum()
        };
        let (faults, kills) = (sum(&|kind| kind.1.is_some()), sum(&|kind| kind.1.is_none()));
        let minutes = self.seconds / 60.0;
        format!(
            "{faults} faults and {kills} kills at random moments in {minutes:.1} minutes, {:.0} per \
             minute, seed {}: {} failures",
            (faults + kills) as f64 / minutes,
            self.seed,
            self.failures.len()
        )
    }

    /// A table of all kinds, and every failure.
    pub(crate) fn page(&self) -> String {
        let mut page = format!("{}\n\n", self.sums());
        page.push_str("| command | call | file | fault | expected | tried | failed |\n");
        page.push_str("|---|---|---|---|---|---|---|\n");
        for ((verb, fault), [tried, failed]) in &self.counts {
            let cells = match fault {
                Some((call, place, fault)) => {
                    let outcome = expected(*verb, *call, *place, *fault).1;
                    format!("{call} | {place} | {fault} | {outcome}")
                }
                None => "any | any | killed at a random moment | killed".to_owned(),
            };
            let _ = writeln!(page, "| {verb} | {cells} | {tried} | {failed} |");
        }
        for failure in &self.failures {
            let _ = write!(page, "\n```text\n{failure}```\n");
        }
        page
    }
}
