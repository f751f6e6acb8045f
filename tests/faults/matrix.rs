//! All faults, or some of each kind, on all cores.

use crate::expected::{TABLE, expected};
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

/// Kills and chains where there is no more time, for each command.
const FEW: usize = 4;

/// A line of a report.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Fault(Call, Place, Fault),
    Kill,
    Chain,
}

impl Kind {
    const fn of(disturbance: Disturbance) -> Self {
        match disturbance {
            Disturbance::Fault { call, place, fault, .. } => Self::Fault(call, place, fault),
            Disturbance::KillAfter(_) => Self::Kill,
            Disturbance::Chain(_) => Self::Chain,
        }
    }
}

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
    /// How many faults in how many calls there are.
    different: usize,
    /// Trials and failures of each kind.
    counts: BTreeMap<(Verb, Kind), [usize; 2]>,
    pub(crate) failures: Vec<String>,
    /// Rows of the table, counted from 0, that hold for no fault.
    pub(crate) idle: Vec<usize>,
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
    let different = benches.iter().map(|bench| bench.faults().count()).sum();
    let idle = idle(&queue, &benches);
    let report = Mutex::new(Report { seed, different, idle, ..Report::default() });
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

/// Every fault in every call, and as many kills and chains as a twentieth of them each, in any
/// order.
fn all(benches: &[Bench], rng: &mut ChaCha8Rng) -> Vec<Trial> {
    let faults = |(bench, it): (usize, &Bench)| -> Vec<Trial> {
        it.faults().map(|disturbance| Trial { bench, disturbance }).collect()
    };
    let mut trials: Vec<Trial> = benches.iter().enumerate().flat_map(faults).collect();
    let count = trials.len() / benches.len() / 20;
    trials.extend(at_random(benches, count, rng));
    trials.shuffle(rng);
    trials
}

/// One fault of every kind, and a few kills and chains.
fn sample(benches: &[Bench], rng: &mut ChaCha8Rng) -> Vec<Trial> {
    let mut trials = all(benches, rng);
    let mut kinds = BTreeSet::new();
    trials.retain(|trial| {
        let kind = Kind::of(trial.disturbance);
        matches!(kind, Kind::Fault(..)) && kinds.insert((benches[trial.bench].verb, kind))
    });
    trials.extend(at_random(benches, FEW, rng));
    trials
}

/// For each command, `count` kills at any moment, or just after its end, and as many chains.
fn at_random(benches: &[Bench], count: usize, rng: &mut ChaCha8Rng) -> Vec<Trial> {
    let mut trials = Vec::new();
    for (bench, Bench { verb, took, .. }) in benches.iter().enumerate() {
        for _ in 0..count {
            let delay = took.mul_f64(rng.random_range(0.0..1.2));
            let chain = Disturbance::Chain(rng.random());
            trials.push(Trial { bench, disturbance: chain });
            // What is started here is the sweep, not one of its runs.
            if *verb != Verb::SweptRun {
                trials.push(Trial { bench, disturbance: Disturbance::KillAfter(delay) });
            }
        }
    }
    trials
}

/// Rows of the table that hold for none of these trials.
fn idle(trials: &[Trial], benches: &[Bench]) -> Vec<usize> {
    let row = |trial: &Trial| match trial.disturbance {
        Disturbance::Fault { call, place, fault, .. } => {
            Some(expected(benches[trial.bench].verb, call, place, fault).0)
        }
        _ => None,
    };
    let used: BTreeSet<usize> = trials.iter().filter_map(row).collect();
    (0..TABLE.len()).filter(|row| !used.contains(row)).collect()
}

impl Report {
    fn add(&mut self, verb: Verb, disturbance: Disturbance, wrong: Option<String>) {
        let count = self.counts.entry((verb, Kind::of(disturbance))).or_default();
        count[0] += 1;
        count[1] += usize::from(wrong.is_some());
        self.failures.extend(wrong);
    }

    /// All in one line.
    pub(crate) fn sums(&self) -> String {
        let sum = |of: &dyn Fn(Kind) -> bool| -> usize {
            self.counts.iter().filter(|((_, kind), _)| of(*kind)).map(|(_, count)| count[0]).sum()
        };
        let faults = sum(&|kind| matches!(kind, Kind::Fault(..)));
        let (kills, chains) = (sum(&|kind| kind == Kind::Kill), sum(&|kind| kind == Kind::Chain));
        let minutes = self.seconds / 60.0;
        format!(
            "{faults} faults (there are {} different ones), {kills} kills at random moments and \
             {chains} chains of faults in {minutes:.1} minutes, {:.0} per minute, seed {}: {} \
             failures",
            self.different,
            (faults + kills + chains) as f64 / minutes,
            self.seed,
            self.failures.len()
        )
    }

    /// A table of all kinds, and every failure.
    pub(crate) fn page(&self) -> String {
        let mut page = format!("{}\n\n", self.sums());
        page.push_str("| command | call | file | fault | expected | tried | failed |\n");
        page.push_str("|---|---|---|---|---|---|---|\n");
        for ((verb, kind), [tried, failed]) in &self.counts {
            let cells = match kind {
                Kind::Fault(call, place, fault) => {
                    let outcome = expected(*verb, *call, *place, *fault).1;
                    format!("{call} | {place} | {fault} | {outcome}")
                }
                Kind::Kill => "any | any | killed at a random moment | killed".to_owned(),
                Kind::Chain => "any | any | three faults one after the other | any".to_owned(),
            };
            let _ = writeln!(page, "| {verb} | {cells} | {tried} | {failed} |");
        }
        for failure in &self.failures {
            let _ = write!(page, "\n```text\n{failure}```\n");
        }
        page
    }
}
