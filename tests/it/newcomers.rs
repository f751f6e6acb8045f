//! What people meet in their first minutes.

use crate::support::{Rher, TINY, shell as shell_in};
use serde_json::Value;

#[test]
fn options_of_other_programs_are_explained() {
    let rher = Rher::new();
    for (command, tip) in [
        ("train push --total-timesteps=1000", "`--env-steps N` is the budget"),
        ("train push --lr 0.1", "agent.actor_learning_rate"),
        ("train push --device cuda", "computed on the CPU"),
        ("train push --seeds 1-3", "rher sweep push"),
        ("train", "the tasks are reach, push, pick"),
    ] {
        let ran = rher.run(command).to_string();
        assert!(ran.starts_with("exit 2") && ran.contains(tip), "{ran}");
    }
}

#[test]
#[cfg(not(feature = "live"))]
fn a_program_without_the_live_view_says_how_to_build_one_with_it() {
    for option in ["--live", "--live=127.0.0.1:0"] {
        let ran = Rher::new().run(&format!("train push {option}")).to_string();
        assert!(ran.starts_with("exit 2") && ran.contains("--features live"), "{ran}");
    }
}

#[test]
fn an_evaluation_names_the_sub_tasks_and_says_how_long_it_will_take() {
    let rher = Rher::new();
    let log = rher.run(&format!("train push --env-steps 500 {TINY} --out run")).stderr;
    assert!(log.contains("reach ") && log.contains(" · push "), "{log}");
    assert!(log.contains("to go"), "{log}");
    let log = rher.run("train --resume run --env-steps 1k").stderr;
    assert!(log.contains("resumed at 500 steps: reach "), "{log}");
}

#[test]
fn tasks_have_the_names_of_their_gymnasium_environments_too() {
    let rher = Rher::new();
    for name in ["rher/PickAndPlace-v0", "FetchPickAndPlace-v4"] {
        assert_eq!(rher.ok(&format!("config {name}")), rher.ok("config pick"));
    }
}

#[test]
fn runs_are_listed_with_their_state() {
    let rher = Rher::new();
    assert!(rher.run("runs").to_string().starts_with("exit 0\nthere is no run in `runs`"));
    rher.ok(&format!("train push --quiet --env-steps 500 {TINY}"));
    rher.ok(&format!(
        "train reach --quiet --env-steps 500 {TINY} --method her --out runs/a/b --seed 2"
    ));
    let running = rher.spawn(&format!("train push --quiet --env-steps 100k {TINY} --out runs/c"));
    rher.wait_for_metrics("runs/c");
    let runs: Vec<Value> = serde_json::from_str(&rher.ok("runs --json")).unwrap();
    let facts =
        |run: &Value| ["folder", "task", "state"].map(|key| run[key].as_str().unwrap().to_owned());
    assert_eq!(
        runs.iter().map(facts).collect::<Vec<_>>(),
        [
            ["runs/a/b", "reach", "spent"],
            ["runs/c", "push", "running"],
            ["runs/push-rher-fast-1", "push", "spent"],
        ]
    );
    for reads in ["stats runs/c", "plot runs/c -o c.svg", "report runs/c -o c.html"] {
        let says = rher.run(reads).stderr;
        assert!(
            says.contains("`runs/c` is still running; this is what it did until step "),
            "{says}"
        );
    }
    for reads in ["eval runs/c --episodes 1", "play runs/c", "eval runs/c/policy.safetensors"] {
        let says = rher.run(reads).stderr;
        assert!(says.contains("`runs/c` is still running; this is its policy of step "), "{says}");
    }
    running.interrupt();
    running.end();
    assert_eq!(rher.run("eval runs/c --episodes 1").stderr, "");
    for wrong in ["eval runs/d", "stats runs/d", "train --resume runs/d", "train push --from d"] {
        let says = rher.run(wrong).stderr;
        assert!(says.contains("there are `runs/a/b`, `runs/c`, `runs/push-rher-fast-1`"), "{says}");
    }
    let says = rher.run("train push").stderr;
    assert!(says.contains("`rher train --resume runs/push-rher-fast-1 --env-steps N`"), "{says}");
    let listing = rher.ok("runs");
    assert!(listing.contains("stopped") && listing.contains("her fast"), "{listing}");
    assert!(rher.run("runs nowhere").to_string().contains("`nowhere`"));
    std::fs::create_dir(rher.path("empty")).unwrap();
    assert!(rher.run("runs empty").stderr.contains("there is no run in `empty`"));
}

#[test]
fn robustness_is_one_command() {
    let rher = Rher::new();
    rher.ok(&format!("train push --quiet --env-steps 500 {TINY} --out run"));
    let eval = |options: &str| -> Value {
        let report = rher.ok(&format!("eval run --episodes 20 --json {options}"));
        serde_json::from_str(&report).unwrap()
    };
    let as_trained = eval("");
    let late = eval("--set randomize.sensor_noise=[0.02,0.05] --set randomize.mass=[4,5]");
    assert_ne!(as_trained["final_distance"], late["final_distance"]);
    assert_eq!(as_trained["options"]["randomize"]["mass"], Value::from(vec![1.0, 1.0]));
    assert_eq!(late["options"]["randomize"]["mass"], Value::from(vec![4.0, 5.0]));
    for report in [as_trained, late] {
        let failed: u64 =
            report["failures"].as_object().unwrap().values().map(|it| it.as_u64().unwrap()).sum();
        let succeeded = 20.0 * report["success_final"].as_f64().unwrap();
        assert_eq!(failed, 20 - succeeded.round() as u64, "{report}");
    }
    let text = rher.ok("eval run --episodes 5 --set randomize.friction=[0.2,0.3]");
    assert!(text.contains("failures") && text.contains("randomize.friction"), "{text}");
    for (key, says) in [
        ("agent.discount=0.9", "`agent.discount` is no setting of the environments"),
        ("randomize.fiction=[1,2]", "did you mean `randomize.friction`?"),
        ("randomize.friction=[1,9]", "expected [low, high]"),
        ("task.observe_obstacle=false", "a setting of `obstacle-push`, not of `push`"),
    ] {
        let ran = rher.run(&format!("eval run --set {key}")).to_string();
        assert!(ran.starts_with("exit 2") && ran.contains(says), "{ran}");
    }
}

#[test]
fn help_fits_terminals_of_any_width() {
    let rher = Rher::new();
    for command in ["", "train", "sweep", "eval", "play", "export", "stats", "plot", "report"] {
        for (columns, widest) in [(60, 60), (80, 80), (200, 100)] {
            let mut help = rher.command(&format!("{command} --help"));
            let help = String::from_utf8(
                help.env("COLUMNS", columns.to_string()).output().unwrap().stdout,
            );
            // Clap does not break the line of the usage.
            for line in help.unwrap().lines().filter(|line| !line.starts_with("Usage:")) {
                let fits = line.chars().count() <= widest || line.split_whitespace().count() == 1;
                assert!(fits, "`rher {command} --help` at {columns}: {line}");
            }
        }
    }
}

#[test]
fn shells_complete_commands_and_man_explains_them() {
    let rher = Rher::new();
    for (shell, check) in [("bash", "bash -n"), ("zsh", "zsh -n"), ("fish", "fish --no-execute")] {
        let script = rher.ok(&format!("completions {shell}"));
        assert!(script.contains("obstacle-push") && script.contains("reproduce"), "{shell}");
        rher.write(shell, script);
        let command = format!("command -v {shell} >/dev/null || exit 0; {check} {shell}");
        let ran = shell_in(&rher, &command);
        assert_eq!(ran.status, Some(0), "{shell}: {ran}");
    }
    rher.ok("man pages");
    let page = std::fs::read_to_string(rher.path("pages/rher-train.1")).unwrap();
    assert!(page.contains("env\\-steps"), "{page}");
    assert!(rher.path("pages/rher.1").exists());
}

/// The wheel installs them; where they differ, the same commands renew them.
#[test]
fn the_wheel_has_the_pages_and_completions_of_this_program() {
    let rher = Rher::new();
    let share =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../rher-py/rher.data/data/share");
    let read = |path: &std::path::Path| std::fs::read_to_string(path).unwrap_or_default();
    rher.ok("man pages");
    let pages = std::fs::read_dir(rher.path("pages")).unwrap();
    let names: Vec<_> = pages.map(|page| page.unwrap().file_name()).collect();
    assert_eq!(names.len(), std::fs::read_dir(share.join("man/man1")).unwrap().count());
    for name in names {
        let ours = read(&share.join("man/man1").join(&name));
        assert!(ours == read(&rher.path("pages").join(&name)), "`rher man` renews {name:?}");
    }
    for (shell, file) in [
        ("bash", "bash-completion/completions/rher"),
        ("zsh", "zsh/site-functions/_rher"),
        ("fish", "fish/vendor_completions.d/rher.fish"),
    ] {
        let script = rher.ok(&format!("completions {shell}"));
        assert!(read(&share.join(file)) == script, "`rher completions {shell}` renews {file}");
    }
}

#[test]
fn a_policy_file_knows_by_which_episodes_it_was_judged_only_beside_its_run() {
    let rher = Rher::new();
    let train = format!("train reach --quiet --env-steps 500 {TINY} --set evaluation.env_seed=1");
    rher.ok(&format!("{train} --out run"));
    let judged = |path: &str| -> Value {
        serde_json::from_str(&rher.ok(&format!("eval {path} --episodes 2 --json"))).unwrap()
    };
    assert_eq!(judged("run/policy.safetensors")["env_seed"], 2);
    std::fs::copy(rher.path("run/policy.safetensors"), rher.path("alone.safetensors")).unwrap();
    assert_eq!(judged("alone.safetensors")["held_out"], Value::Null);
}
