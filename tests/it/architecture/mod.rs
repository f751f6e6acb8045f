//! What ARCHITECTURE.md and the documents beside it say of the code, checked in the source.

mod documents;
mod source;

use source::{Crate, circle, rust_files, words_of};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

/// Every crate, and the crates of this repository that it may use.
const CRATES: [(&str, &[&str]); 7] = [
    ("rher-core", &[]),
    ("rher-envs", &["rher_core"]),
    ("rher-bits", &["rher_core", "rher_envs"]),
    ("rher-runs", &["rher_core", "rher_envs"]),
    ("rher-record", &["rher_core", "rher_envs"]),
    ("rher-cli", &["rher_bits", "rher_core", "rher_envs", "rher_runs", "rher_record"]),
    ("rher-py", &["rher_core", "rher_envs", "rher_runs", "rher_record", "rher_cli"]),
];

/// The only files with `unsafe` code.
const UNSAFE: [&str; 4] = [
    "crates/rher-core/src/learner/fused/dot.rs",
    "crates/rher-core/src/learner/fused/gemm.rs",
    "crates/rher-core/src/replay/prefetch.rs",
    "crates/rher-core/tests/allocations.rs",
];

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// A crate by its name, read once for all tests.
fn read(name: &str) -> &'static Crate {
    static READ: LazyLock<BTreeMap<&str, Crate>> =
        LazyLock::new(|| CRATES.map(|(name, _)| (name, Crate::read(root(), name))).into());
    &READ[name]
}

#[test]
fn crates_depend_on_each_other_in_one_direction() {
    for (name, allowed) in CRATES {
        let read = read(name);
        for (other, _) in CRATES {
            let other = other.replace('-', "_");
            let naming = read.naming(&other);
            let is_allowed = allowed.contains(&other.as_str()) || other == name.replace('-', "_");
            assert!(is_allowed || naming.is_empty(), "{name} must not use {other}: {naming:?}");
        }
    }
}

#[test]
fn files_of_a_crate_do_not_import_each_other_in_a_circle() {
    let mut circles = vec![];
    for (name, _) in CRATES {
        let read = read(name);
        circles.extend(circle(&read.imports()).map(|files| files.join("\n  → ")));
    }
    assert!(circles.is_empty(), "files import each other:\n  {}", circles.join("\n\n  "));
}

#[test]
fn nothing_in_the_learner_knows_how_many_objects_there_are() {
    let core = read("rher-core");
    let learner = "crates/rher-core/src/learner/";
    let above = ["goal", "env", "episode", "input", "replay", "relabel", "policy", "train"];
    for (file, imports) in core.imports() {
        if !file.starts_with(learner) {
            continue;
        }
        for import in imports {
            let room = import.trim_start_matches("crates/rher-core/src/");
            let room = room.split(['/', '.']).next().unwrap();
            assert!(!above.contains(&room), "{file} must not use {import}");
        }
    }
    for file in core.files.values().filter(|file| file.path.starts_with(learner)) {
        let generic = file.words.windows(3).any(|words| words == ["const", "N", "usize"]);
        assert!(!generic, "{} must not be generic in N", file.path);
    }
}

#[test]
fn goals_are_pure_functions_of_positions() {
    let core = read("rher-core");
    for file in core.files.values().filter(|file| file.path.contains("/src/goal/")) {
        for word in ["fs", "io", "rand", "burn", "time", "rayon"] {
            assert!(!file.words.iter().any(|it| it == word), "{} names `{word}`", file.path);
        }
    }
    for name in ["in_hindsight", "reward", "is_met"] {
        let defines = |words: &[String]| words.windows(2).any(|pair| pair == ["fn", name]);
        let homes = core.files.values().filter(|file| defines(&file.words));
        let homes: Vec<&str> = homes.map(|file| file.path.as_str()).collect();
        let [home] = homes[..] else { panic!("`{name}` is defined in {homes:?}") };
        assert!(home.starts_with("crates/rher-core/src/goal/"), "`{name}` is defined in {home}");
    }
}

#[test]
fn libraries_are_named_in_their_rooms_only() {
    let rooms = [
        ("burn", "crates/rher-core/src/learner/burn"),
        ("rapier3d", "crates/rher-envs/src/sim/"),
        ("clap", "crates/rher-cli/src/"),
        ("pyo3", "crates/rher-py/src/"),
    ];
    for (library, room) in rooms {
        let files: Vec<&str> =
            CRATES.iter().flat_map(|(name, _)| read(name).naming(library)).collect();
        assert!(!files.is_empty(), "nothing uses {library}");
        for file in files {
            assert!(file.starts_with(room), "{file} must not use {library}");
        }
    }
}

#[test]
fn the_core_prints_nothing() {
    for file in read("rher-core").files.values() {
        for name in ["println", "print", "eprintln", "eprint", "dbg"] {
            assert!(!file.words.iter().any(|it| it == name), "{} names `{name}`", file.path);
        }
    }
}

#[test]
fn random_streams_of_the_core_come_from_the_seed() {
    for file in read("rher-core").files.values() {
        let makes = file.words.iter().any(|word| word == "seed_from_u64" || word == "from_seed");
        let allowed = file.path.ends_with("/seed.rs") || file.path.ends_with("/testing.rs");
        assert!(allowed || !makes, "{} makes a random generator without `Seed`", file.path);
    }
}

#[test]
fn unsafe_code_is_where_the_architecture_says() {
    let architecture = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    for folder in ["crates", "tests"] {
        for path in rust_files(&root().join(folder)) {
            let file = path.strip_prefix(root()).unwrap().display().to_string();
            let has = words_of(&path).iter().any(|word| word == "unsafe");
            assert_eq!(has, UNSAFE.contains(&file.as_str()), "`unsafe` in {file}");
        }
    }
    for file in UNSAFE {
        assert!(architecture.contains(file), "ARCHITECTURE.md must name {file}");
    }
}
