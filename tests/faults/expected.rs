//! What is expected of every fault in every call: the one table that docs/faults.md shows.

use crate::preload::{Call, Fault};
use crate::work::{Place, Verb};
use std::fmt::{self, Write as _};

/// How the program ends, and what is true afterward.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Outcome {
    /// Exit 0 without a warning, and all results.
    Same,
    /// Exit 0 with a warning, and all results.
    Warned,
    /// Exit 0 with a warning; all results but for recordings, which are whole or absent.
    Unrecorded,
    /// This exit status with an error; the next command leads to all results.
    Ends(i32),
    /// Killed; the next command leads to all results.
    Killed,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Same => f.write_str("the same result"),
            Self::Warned => f.write_str("the same result, with a warning"),
            Self::Unrecorded => {
                f.write_str("the same result without its recording, with a warning")
            }
            Self::Ends(status) => write!(f, "exit {status}"),
            Self::Killed => f.write_str("killed"),
        }
    }
}

/// A rule of the table; an empty list stands for all.
pub(crate) struct Row {
    verbs: &'static [Verb],
    calls: &'static [Call],
    places: &'static [Place],
    faults: &'static [Fault],
    outcome: Outcome,
    because: &'static str,
}

const KILLS: &[Fault] = &[Fault::Torn, Fault::KillBefore, Fault::KillAfter];
const ERRORS: &[Fault] = &[
    Fault::NoSpace,
    Fault::Io,
    Fault::Invalid,
    Fault::NoCall,
    Fault::NotSupported,
    Fault::OtherDevice,
];
const FULL: &[Fault] = &[Fault::NoSpace, Fault::Full];
const SAVING: &[Verb] =
    &[Verb::Train, Verb::Record, Verb::Resume, Verb::ResumeRecorded, Verb::Plan, Verb::Cell];

/// The first row that fits holds.
pub(crate) const TABLE: &[Row] = &[
    Row {
        verbs: &[Verb::SweptRun],
        calls: &[],
        places: &[],
        faults: KILLS,
        outcome: Outcome::Ends(130),
        because: "a run that someone ends from outside interrupts its sweep; the same command continues",
    },
    Row {
        verbs: &[],
        calls: &[],
        places: &[],
        faults: KILLS,
        outcome: Outcome::Killed,
        because: "`--resume` continues from the last checkpoint; where there is none, and for all other commands, the same command starts again",
    },
    Row {
        verbs: &[],
        calls: &[Call::Write],
        places: &[],
        faults: &[Fault::Short],
        outcome: Outcome::Same,
        because: "the rest is written by the next call",
    },
    Row {
        verbs: &[Verb::Play, Verb::PlayAgain, Verb::Minari, Verb::Lerobot],
        calls: &[Call::OpenToRead, Call::Lock],
        places: &[Place::Lock],
        faults: &[],
        outcome: Outcome::Same,
        because: "whether a process still trains the run is only worth a note",
    },
    Row {
        verbs: &[],
        calls: &[Call::Lock],
        places: &[Place::Lock, Place::Worker, Place::Unnamed],
        faults: &[Fault::NoCall, Fault::NoLocks, Fault::NotSupported],
        outcome: Outcome::Warned,
        because: "a file system without locks only takes the protection against a second process",
    },
    Row {
        verbs: &[],
        calls: &[Call::Lock],
        places: &[Place::Recording, Place::EndOfRecording, Place::Dataset],
        faults: &[],
        outcome: Outcome::Same,
        because: "the temporary name alone keeps others out",
    },
    Row {
        verbs: &[],
        calls: &[Call::Lock],
        places: &[Place::Worker, Place::Unnamed],
        faults: &[],
        outcome: Outcome::Same,
        because: "without its lock the count of a worker says that it lives",
    },
    Row {
        verbs: &[],
        calls: &[Call::Remove],
        places: &[Place::Unnamed],
        faults: ERRORS,
        outcome: Outcome::Same,
        because: "a file that has its name by then is removed in a second attempt",
    },
    Row {
        verbs: &[],
        calls: &[Call::Sync],
        places: &[],
        faults: &[Fault::Invalid, Fault::NoCall, Fault::NotSupported],
        outcome: Outcome::Same,
        because: "some file systems cannot sync, or not a folder, and nothing can be done about it",
    },
    Row {
        verbs: &[Verb::Record, Verb::ResumeRecorded],
        calls: &[
            Call::OpenToRead,
            Call::OpenToWrite,
            Call::Write,
            Call::Sync,
            Call::Rename,
            Call::Remove,
        ],
        places: &[Place::Recording, Place::EndOfRecording],
        faults: ERRORS,
        outcome: Outcome::Unrecorded,
        because: "training is worth more than its recording",
    },
    Row {
        verbs: &[],
        calls: &[],
        places: &[Place::EndOfRecording],
        faults: &[Fault::Full],
        outcome: Outcome::Unrecorded,
        because: "nothing else is written any more",
    },
    Row {
        verbs: &[Verb::Minari, Verb::Lerobot],
        calls: &[Call::OpenToRead],
        places: &[Place::Dataset],
        faults: &[],
        outcome: Outcome::Same,
        because: "the folder is opened for its lock, and its temporary name alone keeps others out",
    },
    Row {
        verbs: &[Verb::Resume, Verb::ResumeRecorded],
        calls: &[Call::OpenToRead],
        places: &[Place::Policy],
        faults: &[],
        outcome: Outcome::Same,
        because: "a policy that cannot be read is written again from its checkpoint",
    },
    Row {
        verbs: SAVING,
        calls: &[Call::OpenToRead],
        places: &[Place::Folder],
        faults: &[Fault::NoSpace],
        outcome: Outcome::Ends(7),
        because: "the folder is opened to sync what was written",
    },
    Row {
        verbs: SAVING,
        calls: &[Call::OpenToRead],
        places: &[Place::Folder],
        faults: &[],
        outcome: Outcome::Ends(6),
        because: "the folder is opened to sync what was written",
    },
    Row {
        verbs: &[Verb::SweptRun],
        calls: &[],
        places: &[],
        faults: &[],
        outcome: Outcome::Ends(1),
        because: "the run failed and said why; the other runs are done, and the same command continues this one",
    },
    Row {
        verbs: &[],
        calls: &[Call::OpenToRead],
        places: &[],
        faults: &[],
        outcome: Outcome::Ends(1),
        because: "what is there and cannot be read is never passed over",
    },
    Row {
        verbs: &[],
        calls: &[],
        places: &[],
        faults: FULL,
        outcome: Outcome::Ends(7),
        because: "the disk is full",
    },
    Row {
        verbs: &[],
        calls: &[],
        places: &[],
        faults: &[],
        outcome: Outcome::Ends(6),
        because: "a file or a folder cannot be written",
    },
];

impl Row {
    fn fits(&self, verb: Verb, call: Call, place: Place, fault: Fault) -> bool {
        fn has<T: PartialEq>(all: &[T], one: &T) -> bool {
            all.is_empty() || all.contains(one)
        }
        has(self.verbs, &verb)
            && has(self.calls, &call)
            && has(self.places, &place)
            && has(self.faults, &fault)
    }
}

/// The number of the row that holds, and what is expected.
pub(crate) fn expected(verb: Verb, call: Call, place: Place, fault: Fault) -> (usize, Outcome) {
    let at = TABLE.iter().position(|row| row.fits(verb, call, place, fault));
    let at = at.expect("the last row fits everything");
    (at, TABLE[at].outcome)
}

/// The table in Markdown.
pub(crate) fn page() -> String {
    fn list<T: fmt::Display>(all: &[T], none: &str) -> String {
        let names: Vec<String> = all.iter().map(T::to_string).collect();
        if names.is_empty() { none.to_owned() } else { names.join(", ") }
    }
    let mut page = String::from("| command | call | file | fault | expected | because |\n");
    page.push_str("|---|---|---|---|---|---|\n");
    for Row { verbs, calls, places, faults, outcome, because } in TABLE {
        let (verbs, calls) = (list(verbs, "every"), list(calls, "every"));
        let (places, faults) = (list(places, "every"), list(faults, "every other"));
        let _ =
            writeln!(page, "| {verbs} | {calls} | {places} | {faults} | {outcome} | {because} |");
    }
    page
}
