//! Plans that are damaged, half written, or written by several processes.

use super::*;
use crate::settings::Asked;
use proptest::prelude::*;
use proptest::sample::{Index, subsequence};
use rher_envs::Task;
use tempfile::TempDir;

fn cell(task: Task, seed: u64) -> Cell {
    let asked = Asked { seed: Some(seed), ..Asked::default() };
    let settings = settings::resolve(task, &asked).unwrap();
    let folder = format!("cells/{},seed={seed}", task.name()).into();
    Cell { group: task.name().to_owned(), folder, settings }
}

/// A plan of up to four cells.
fn written(count: usize) -> (TempDir, Plan, Vec<u8>) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("plan.jsonl");
    let cells = [(Task::REACH, 1), (Task::REACH, 2), (Task::PUSH, 1), (Task::PUSH, 2)];
    let cells = cells[..count].iter().map(|&(task, seed)| cell(task, seed)).collect();
    let plan = Plan::write(&path, cells).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    (folder, plan, bytes)
}

/// Everything that a plan says.
fn content(plan: &Plan) -> Vec<String> {
    let lines = plan.cells.iter().enumerate().map(|(number, cell)| line(number, cell).unwrap());
    [plan.id.to_string()].into_iter().chain(lines).collect()
}

/// The bytes of the name of the program that made the plan. It is for the error of another
/// version alone.
fn made_by(bytes: &[u8]) -> std::ops::Range<usize> {
    let text = std::str::from_utf8(bytes).unwrap();
    let (before, after) = text.split_once("\"made_by\":\"").unwrap();
    let start = text.len() - after.len();
    assert!(before.len() < 20);
    start..start + after.find('"').unwrap()
}

/// Something that happens to a plan.
#[derive(Clone, Debug)]
enum Damage {
    Flip(Index, u8),
    Byte(Index, u8),
    Cut(Index),
    LineTwice(Index, Index),
    LinesSwapped(Index, Index),
    LinesLost(Vec<usize>),
    Added(Vec<u8>),
}

impl Damage {
    fn to(&self, bytes: &[u8]) -> Vec<u8> {
        let mut damaged = bytes.to_vec();
        let mut lines: Vec<&[u8]> = bytes.split_inclusive(|byte| *byte == b'\n').collect();
        match self {
            Self::Flip(at, bit) => damaged[at.index(bytes.len())] ^= 1 << bit,
            Self::Byte(at, byte) => damaged[at.index(bytes.len())] = *byte,
            Self::Cut(at) => damaged.truncate(at.index(bytes.len())),
            Self::Added(more) => damaged.extend(more),
            Self::LineTwice(from, to) => {
                lines.insert(to.index(lines.len() + 1), lines[from.index(lines.len())]);
                damaged = lines.concat();
            }
            Self::LinesSwapped(a, b) => {
                let [a, b] = [a, b].map(|line| line.index(lines.len()));
                lines.swap(a, b);
                damaged = lines.concat();
            }
            Self::LinesLost(kept) => {
                let kept = kept.iter().filter_map(|&line| lines.get(line).copied());
                damaged = kept.collect::<Vec<_>>().concat();
            }
        }
        damaged
    }
}

fn damage() -> impl Strategy<Value = Damage> {
    prop_oneof![
        (any::<Index>(), 0..8_u8).prop_map(|(at, bit)| Damage::Flip(at, bit)),
        any::<(Index, u8)>().prop_map(|(at, byte)| Damage::Byte(at, byte)),
        any::<Index>().prop_map(Damage::Cut),
        any::<(Index, Index)>().prop_map(|(from, to)| Damage::LineTwice(from, to)),
        any::<(Index, Index)>().prop_map(|(a, b)| Damage::LinesSwapped(a, b)),
        subsequence((0..5).collect::<Vec<usize>>(), 0..5).prop_map(Damage::LinesLost),
        proptest::collection::vec(any::<u8>(), 1..4).prop_map(Damage::Added),
    ]
}

#[test]
fn a_damaged_plan_is_the_same_plan_or_an_error_that_says_where() {
    let (_folder, plan, bytes) = written(4);
    let made_by = made_by(&bytes);
    let damages = proptest::collection::vec(damage(), 1..3);
    proptest!(ProptestConfig::with_cases(2000), |(damages in damages)| {
        let apply = |bytes: Vec<u8>, damage: &Damage| {
            if bytes.is_empty() { bytes } else { damage.to(&bytes) }
        };
        let damaged = damages.iter().fold(bytes.clone(), apply);
        match Plan::parse(plan.path(), damaged.clone()) {
            Ok(read) => {
                prop_assert_eq!(content(&read), content(&plan));
                let start = damaged.len() - (bytes.len() - made_by.end);
                prop_assert_eq!(&damaged[..made_by.start], &bytes[..made_by.start]);
                prop_assert_eq!(&damaged[start..], &bytes[made_by.end..]);
            }
            Err(error) => {
                let error = error.to_string();
                prop_assert!(error.contains("plan.jsonl"), "{}", error);
            }
        }
    });
}

#[test]
fn every_flipped_bit_is_noticed_or_changes_nothing() {
    let (_folder, plan, bytes) = written(1);
    let made_by = made_by(&bytes);
    let read = Plan::parse(plan.path(), bytes.clone()).unwrap();
    assert_eq!(content(&read), content(&plan));
    for bit in 0..8 * bytes.len() {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        if let Ok(read) = Plan::parse(plan.path(), damaged) {
            assert!(made_by.contains(&(bit / 8)), "bit {bit}");
            assert_eq!(content(&read), content(&plan));
        }
    }
}

#[test]
fn what_is_there_stays_and_what_a_killed_process_left_does_not() {
    let (folder, plan, bytes) = written(4);
    let again = || Plan::write(plan.path(), plan.cells().to_vec());
    let others = [".plan.jsonl-old", ".plan.jsonl-1-2.txt", ".plan.jsonl-more-1-2", "notes"];
    let left = folder.path().join(".plan.jsonl-4711-0");
    for name in others {
        std::fs::write(folder.path().join(name), "").unwrap();
    }
    for is_there in [true, false] {
        std::fs::write(&left, &bytes[..100]).unwrap();
        if !is_there {
            std::fs::remove_file(plan.path()).unwrap();
        }
        again().unwrap();
        assert_eq!(std::fs::read(plan.path()).unwrap(), bytes);
        assert!(!left.exists());
    }
    assert!(others.iter().all(|name| folder.path().join(name).exists()));
    // Also one whose cells are right and whose first line is not.
    let damaged = [b"{}".as_slice(), &bytes[bytes.iter().position(|b| *b == b'\n').unwrap()..]];
    std::fs::write(plan.path(), damaged.concat()).unwrap();
    assert!(matches!(again(), Err(PlanError::Exists { .. })));
    assert_eq!(std::fs::read(plan.path()).unwrap(), damaged.concat());
}

#[test]
fn many_processes_may_write_the_same_plan() {
    let (_folder, plan, bytes) = written(4);
    for _ in 0..20 {
        std::fs::remove_file(plan.path()).unwrap();
        std::thread::scope(|scope| {
            let write = || Plan::write(plan.path(), plan.cells().to_vec()).map(|_| ());
            let threads: Vec<_> = (0..4).map(|_| scope.spawn(write)).collect();
            for thread in threads {
                thread.join().unwrap().unwrap();
            }
        });
        assert_eq!(std::fs::read(plan.path()).unwrap(), bytes);
        let folder = plan.path().parent().unwrap();
        assert_eq!(std::fs::read_dir(folder).unwrap().count(), 1);
    }
}

#[test]
fn a_folder_above_the_plan_is_written_from_the_root() {
    let folder = TempDir::new().unwrap();
    let root = folder.path().canonicalize().unwrap();
    std::fs::create_dir_all(root.join("deep/plans")).unwrap();
    std::os::unix::fs::symlink(root.join("deep/plans"), root.join("link")).unwrap();
    for (plan, to, expected) in [
        ("plan.jsonl", "cells", PathBuf::from("cells")),
        ("plan.jsonl", "./new/../cells", PathBuf::from("cells")),
        ("deep/plan.jsonl", "deep/../cells", root.join("cells")),
        ("deep/../plan.jsonl", "cells", PathBuf::from("cells")),
        ("plan.jsonl", "link/../cells", PathBuf::from("deep/cells")),
    ] {
        let found = from_plan(&root.join(plan), &root.join(to)).unwrap();
        assert_eq!(found, expected, "{plan} {to}");
    }
}
