//! One fault: the program is hit, what it left is looked at, and the next command must mend it.

use crate::expected::{Outcome, expected};
use crate::preload::{Call, Fault, Injection, Noted};
use crate::program::{Ended, NoStatus, Program, Room};
use crate::work::{Place, Results, Verb, is_recording_of_training, results};
use rand::seq::{IndexedRandom as _, IteratorRandom as _};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::time::Duration;

/// A command, what it finds, and what it does where nothing disturbs it.
pub(crate) struct Bench {
    pub(crate) verb: Verb,
    room: Room,
    before: Results,
    good: Results,
    pub(crate) calls: Vec<Noted>,
    pub(crate) took: Duration,
}

/// What disturbs the command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Disturbance {
    Fault {
        call: Call,
        at: usize,
        place: Place,
        fault: Fault,
    },
    KillAfter(Duration),
    /// Faults one after the other, in the command and in what should lead on: a seed of them.
    Chain(u64),
}

/// Faults in a chain.
const LINKS: usize = 3;

impl Bench {
    pub(crate) fn new(verb: Verb, program: &Program) -> Self {
        let room = Room::new();
        verb.prepare(program, &room);
        let before = results(&room.work());
        let trial = room.copy();
        let Ended { status, stderr, log, took, .. } =
            program.run_watched(&trial, verb.arguments(), verb.watched(), None);
        let is_silent = !stderr.contains("warning: ") && !stderr.contains("error: ");
        assert!(status == Ok(0) && is_silent, "{verb} ended with {status:?}: {stderr}");
        let calls = log.into_iter().filter(|noted| noted.command == verb.hit()).collect();
        Self { verb, room, before, good: results(&trial.work()), calls, took }
    }

    /// Every fault in every call.
    pub(crate) fn faults(&self) -> impl Iterator<Item = Disturbance> {
        let last_save = self.calls.iter().rposition(Noted::is_save);
        self.calls.iter().enumerate().flat_map(move |(index, noted)| {
            let &Noted { call, at, ref path, .. } = noted;
            let place = match Place::of(path) {
                Place::Recording if last_save.is_some_and(|save| save < index) => {
                    Place::EndOfRecording
                }
                place => place,
            };
            call.faults().map(move |fault| Disturbance::Fault { call, at, place, fault })
        })
    }

    /// Disturbs the command; what is wrong afterward, if anything is.
    pub(crate) fn try_out(&self, disturbance: Disturbance, program: &Program) -> Option<String> {
        let room = self.room.copy();
        let (arguments, watched) = (self.verb.arguments(), self.verb.watched());
        let (hit, outcome) = match disturbance {
            Disturbance::Chain(seed) => return self.try_chain(seed, program),
            Disturbance::Fault { call, at, place, fault } => {
                let injection = Injection { command: self.verb.hit(), call, at, fault };
                let hit = program.run_watched(&room, arguments, watched, Some(&injection));
                (hit, Some(expected(self.verb, call, place, fault).1))
            }
            Disturbance::KillAfter(delay) => {
                (program.run_killed(&room, arguments, watched, delay), None)
            }
        };
        let mut wrong: Vec<String> = crashes(&hit).into_iter().collect();
        match outcome {
            Some(_) if !hit.log.iter().any(|noted| noted.is_hit) => {
                wrong.push("the call was not made".to_owned());
            }
            Some(outcome) => wrong.extend(ends_otherwise(&hit, outcome)),
            None => {
                // It may have been faster than the kill.
                let ends = [Err(NoStatus::Killed), Ok(0)];
                let is_known = ends.contains(&hit.status);
                wrong.extend((!is_known).then(|| format!("ended with {:?}", hit.status)));
            }
        }
        let unrecorded = outcome == Some(Outcome::Unrecorded);
        if hit.status == Ok(0) {
            wrong.extend(self.differs(&room, "at the end", unrecorded));
        } else {
            wrong.extend(self.tears_its_target(&room));
            wrong.extend(self.fails_to_mend(&room, Some(&hit), program));
        }
        wrong.extend(self.has_bad_recordings(&room, unrecorded, program));
        (!wrong.is_empty()).then(|| self.describe(disturbance, &hit, &wrong))
    }

    /// Several faults in a row; what is wrong after the next command, if anything is.
    fn try_chain(&self, seed: u64, program: &Program) -> Option<String> {
        let room = self.room.copy();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut text = format!("{}: chain {seed}\n", self.verb);
        let mut wrong = Vec::new();
        for link in 0..LINKS {
            let Noted { call, .. } = *self.calls.choose(&mut rng)?;
            let count = self.calls.iter().filter(|noted| noted.call == call).count();
            let at = rng.random_range(1..=count);
            // Without locks nobody can know that a file was left by a process that is gone.
            let fault = call.faults().filter(|fault| !fault.is_missing(call)).choose(&mut rng)?;
            let injection = Injection { command: self.verb.hit(), call, at, fault };
            let arguments = if link == 0 { self.verb.arguments() } else { self.verb.next(&room) };
            let hit = program.run_watched(&room, arguments, self.verb.watched(), Some(&injection));
            let _ = writeln!(text, "  rher {arguments}");
            let _ = writeln!(text, "  {fault} in {call} {at}: {:?}: {}", hit.status, hit.stderr);
            wrong.extend(crashes(&hit));
            wrong.extend(self.tears_its_target(&room));
        }
        wrong.extend(self.fails_to_mend(&room, None, program));
        wrong.extend(self.has_bad_recordings(&room, true, program));
        for wrong in &wrong {
            let _ = writeln!(text, "  WRONG {wrong}");
        }
        (!wrong.is_empty()).then_some(text)
    }

    /// How the results differ from those of an undisturbed command.
    fn differs(&self, room: &Room, when: &str, unrecorded: bool) -> Option<String> {
        let mut found = results(&room.work());
        // Whole episodes stay readable under the temporary name.
        found.retain(|name, _| !(unrecorded && name.ends_with(".part.mcap")));
        let names: BTreeSet<&String> = found.keys().chain(self.good.keys()).collect();
        let wrong: Vec<String> = names
            .into_iter()
            .filter_map(|name| match (found.get(name), self.good.get(name)) {
                (Some(found), Some(good)) if found == good => None,
                (Some(_), Some(_)) => Some(format!("`{name}` differs")),
                (None, _) => Some(format!("`{name}` is missing")),
                (Some(_), None) => Some(format!("`{name}` is left behind")),
            })
            .collect();
        (!wrong.is_empty()).then(|| format!("{when}: {}", wrong.join(", ")))
    }

    /// Whether the recording or the dataset is neither complete, nor as it was before.
    fn tears_its_target(&self, room: &Room) -> Option<String> {
        let target = self.verb.target()?;
        let of = |results: &Results| -> Results {
            let name = |name: &str| {
                let rest = name.strip_prefix('/').and_then(|name| name.strip_prefix(target));
                // Not those with temporary names.
                rest.is_some_and(|rest| !rest.contains(".part"))
            };
            results.iter().filter(|(it, _)| name(it)).map(|(a, b)| (a.clone(), b.clone())).collect()
        };
        let (found, good, before) = (of(&results(&room.work())), of(&self.good), of(&self.before));
        let is_known = if self.verb.is_one_folder() {
            found == good || found == before
        } else {
            let is_known = |(name, bytes): (&String, &Vec<u8>)| {
                good.get(name) == Some(bytes) || before.get(name) == Some(bytes)
            };
            found.iter().all(is_known) && before.keys().all(|name| found.contains_key(name))
        };
        (!is_known).then(|| format!("what is at `{target}` is torn"))
    }

    /// Whether the next command does not lead to the results; after one fault it must save exactly
    /// the checkpoints that are still to be saved.
    fn fails_to_mend(&self, room: &Room, hit: Option<&Ended>, program: &Program) -> Option<String> {
        let target = self.verb.target().filter(|_| self.verb.is_one_folder());
        let is_there = target.is_some_and(|target| room.work().join(target).exists());
        let next = program.run_watched(room, self.verb.next(room), self.verb.watched(), None);
        // A dataset that is complete is not written again.
        let status = if is_there { 6 } else { 0 };
        let mut wrong = Vec::new();
        if next.status != Ok(status) {
            let stderr = next.stderr.trim_end();
            wrong.push(format!("the next command ended with {:?}: {stderr}", next.status));
        }
        if is_there {
            return wrong.pop();
        }
        wrong.extend(self.differs(room, "after the next command", false));
        if let Some(hit) = hit.filter(|_| self.verb.saves()) {
            let saves = |log: &[Noted]| log.iter().filter(|noted| noted.is_save()).count();
            let (all, done, more) = (saves(&self.calls), saves(&hit.log), saves(&next.log));
            // A run that has not begun to play saves once more before it does.
            let is_first = !self.verb.resumes() && done == 1;
            // A kill from outside may fall between a call and its note.
            let is_from_outside = !hit.log.iter().any(|noted| noted.is_hit);
            let is_unnoted = is_from_outside && done + more + 1 == all;
            if done + more != all && !(is_first && more == all) && !is_unnoted {
                let text = format!("{done} checkpoints and then {more}, expected {all} in all");
                wrong.push(text);
            }
        }
        (!wrong.is_empty()).then(|| wrong.join("; "))
    }

    /// Whether recordings of training cannot be verified, or lack episodes.
    fn has_bad_recordings(
        &self,
        room: &Room,
        unrecorded: bool,
        program: &Program,
    ) -> Option<String> {
        if !self.verb.records() {
            return None;
        }
        let names = fs::read_dir(room.work().join("run")).unwrap();
        let names = names.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
        let names = names.filter(|name| is_recording_of_training(name));
        let mut episodes = Vec::new();
        for name in names.filter(|name| name.strip_suffix(".mcap").is_some()) {
            for verify in [" --verify", ""] {
                let ended = program.run(room, &format!("replay run/{name}{verify}"));
                if ended.status != Ok(0) {
                    return Some(format!("`{name}`: {}", ended.stderr.trim_end()));
                }
                let first = |line: &str| line.split_whitespace().next()?.parse::<u64>().ok();
                if verify.is_empty() {
                    episodes.extend(ended.stdout.lines().skip(2).filter_map(first));
                }
            }
        }
        let is_missing = |episode: &u64| !episodes.contains(episode);
        let missing: Vec<u64> = [0, 2].into_iter().filter(is_missing).collect();
        (!unrecorded && !missing.is_empty())
            .then(|| format!("episodes {missing:?} are not recorded"))
    }

    fn describe(&self, disturbance: Disturbance, hit: &Ended, wrong: &[String]) -> String {
        let mut text = format!("{}: ", self.verb);
        match disturbance {
            Disturbance::Fault { call, at, place, fault } => {
                let outcome = expected(self.verb, call, place, fault).1;
                let path = self.calls.iter().find(|noted| noted.call == call && noted.at == at);
                let path = path.map_or("", |noted| &noted.path);
                let _ = writeln!(text, "{fault} in {call} {at} (`{path}`), expected: {outcome}");
                let injection = Injection { command: self.verb.hit(), call, at, fault };
                for (name, value) in injection.environment() {
                    let _ = write!(text, "{name}={value} ");
                }
                let _ = writeln!(text, "rher {}", self.verb.arguments());
            }
            Disturbance::KillAfter(delay) => {
                let _ = writeln!(text, "killed after {delay:?}");
            }
            Disturbance::Chain(seed) => {
                let _ = writeln!(text, "chain {seed}");
            }
        }
        let _ = writeln!(text, "  ended with {:?}: {}", hit.status, hit.stderr.trim_end());
        for wrong in wrong {
            let _ = writeln!(text, "  WRONG {wrong}");
        }
        text
    }
}

/// Whether the program panicked, crashed or hung, which nothing may lead to.
fn crashes(Ended { status, stderr, .. }: &Ended) -> Option<String> {
    let is_crashed = matches!(status, Err(NoStatus::Crashed(_) | NoStatus::Hung) | Ok(101 | 134));
    (is_crashed || stderr.contains("panicked")).then(|| format!("it crashed: {status:?}"))
}

/// How the end of the program differs from what is expected.
fn ends_otherwise(ended: &Ended, outcome: Outcome) -> Option<String> {
    let Ended { status, stderr, .. } = ended;
    let warned = stderr.contains("warning: ");
    let failed = stderr.contains("error: ");
    let is_expected = match outcome {
        Outcome::Same => *status == Ok(0) && !warned && !failed,
        Outcome::Warned | Outcome::Unrecorded => *status == Ok(0) && warned && !failed,
        Outcome::Ends(130) => *status == Ok(130),
        Outcome::Ends(code) => *status == Ok(code) && failed,
        Outcome::Killed => *status == Err(NoStatus::Killed),
    };
    (!is_expected).then(|| "it ended otherwise".to_owned())
}
