//! Plans: the cells of a sweep, for any number of machines.

use crate::support::{Rher, shell};
use insta::assert_snapshot;
use serde_json::Value;
use std::fs;
use std::path::Path;

const CELLS: &str = "--until 0 --env-steps 200 --seeds 1-2 --config tiny.toml \
    --set relay.mirror=0,0.5";

fn tiny() -> Rher {
    let rher = Rher::new();
    rher.write(
        "tiny.toml",
        "[agent]\nhidden = [8]\n[replay]\nbatch_size = 8\nupdates_per_episode = 1\n\
         [evaluation]\nevery_episodes = 1\nepisodes = 2\nsubtask_episodes = 2\n",
    );
    rher
}

/// A plan with eight cells, of two tasks.
fn planned() -> Rher {
    let rher = tiny();
    let ran = rher.run(&format!("sweep reach push {CELLS} --plan plan.jsonl"));
    assert_eq!(ran.status, Some(0), "{ran}");
    rher
}

/// A plan with two cells that nobody waits for.
fn endless() -> Rher {
    let rher = tiny();
    rher.ok("sweep reach --until 0 --env-steps 100000000 --seeds 1-2 --config tiny.toml \
         --plan plan.jsonl --out cells");
    rher
}

fn lines(rher: &Rher) -> Vec<Value> {
    let text = fs::read_to_string(rher.path("plan.jsonl")).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Replaces the first `from` in the plan.
fn edit(rher: &Rher, from: &str, to: &str) {
    let text = fs::read_to_string(rher.path("plan.jsonl")).unwrap();
    assert!(text.contains(from), "{from}");
    rher.write("plan.jsonl", text.replacen(from, to, 1));
}

/// The states of the cells, as `--status` says.
fn states(rher: &Rher) -> Vec<String> {
    let status: Value = serde_json::from_str(&rher.ok("sweep --status plan.jsonl --json")).unwrap();
    let states = status["list"].as_array().unwrap().iter();
    states.map(|row| row["state"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn a_plan_says_what_is_to_be_trained_and_nothing_is() {
    let rher = planned();
    let lines = lines(&rher);
    assert_eq!(lines[0]["plan"], 1);
    assert!(lines[0]["made_by"].as_str().unwrap().starts_with("rher "));
    assert_eq!((lines.len(), &lines[0]["cells"]), (9, &8.into()));
    let cell = &lines[7];
    assert_eq!(
        (&cell["cell"], &cell["task"], &cell["seed"]),
        (&6.into(), &"push".into(), &1.into())
    );
    assert_eq!(cell["group"], "push relay.mirror=0.5");
    assert_eq!(cell["folder"], "runs/sweep-reach-push/push,relay.mirror=0.5,seed=1");
    assert_eq!(cell["settings"]["relay"]["mirror"], 0.5);
    assert!(!rher.path("runs").exists());
    assert_eq!(states(&rher), ["waiting"; 8]);

    // The same again is the same plan, and another one is refused.
    let before = fs::read(rher.path("plan.jsonl")).unwrap();
    rher.ok(&format!("sweep reach push {CELLS} --plan plan.jsonl"));
    assert_snapshot!(rher.run(&format!("sweep push {CELLS} --plan plan.jsonl")), @"
    exit 6
    error: `plan.jsonl` is there already, and it is not the plan that would be written

    hint: choose another file, or remove this one
    ");
    assert_eq!(fs::read(rher.path("plan.jsonl")).unwrap(), before);
}

#[test]
fn cells_one_by_one_or_all_at_once_are_the_runs_of_the_sweep() {
    let rher = planned();
    rher.ok(&format!("sweep reach push {CELLS} --out straight"));
    for cell in [6, 0] {
        let ran = rher.run(&format!("sweep --plan plan.jsonl --cell {cell}"));
        assert_eq!(ran.status, Some(0), "{ran}");
    }
    assert_eq!(states(&rher).iter().filter(|state| *state == "done").count(), 2);
    assert_snapshot!(rher.run("sweep --plan plan.jsonl --cell 6"), @"
    exit 0
    cell 6 is done already: runs/sweep-reach-push/push,relay.mirror=0.5,seed=1
    ");
    let folders: Vec<String> =
        lines(&rher)[1..].iter().map(|line| line["folder"].as_str().unwrap().to_owned()).collect();
    let attempt = fs::read(rher.path(&folders[6]).join("worker-0.jsonl")).unwrap();
    // From another folder, the plan is where it is.
    fs::create_dir(rher.path("elsewhere")).unwrap();
    let mut all = rher.command("sweep --plan ../plan.jsonl --jobs 2");
    let output = all.current_dir(rher.path("elsewhere")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(states(&rher), ["done"; 8]);
    assert_eq!(fs::read(rher.path(&folders[6]).join("worker-0.jsonl")).unwrap(), attempt);
    for folder in &folders {
        let straight = Path::new("straight").join(Path::new(folder).file_name().unwrap());
        let file = |run: &Path| fs::read(rher.path(run).join("policy.safetensors")).unwrap();
        assert_eq!(file(Path::new(folder)), file(&straight), "{folder}");
        assert_eq!(rher.metrics(folder), rher.metrics(straight.to_str().unwrap()));
    }
}

#[test]
fn a_cell_comes_from_an_environment_variable() {
    let rher = planned();
    let mut command = rher.command("sweep --plan plan.jsonl --cell-from JOB_COMPLETION_INDEX");
    let output = command.env("JOB_COMPLETION_INDEX", "5").output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(states(&rher)[5], "done");
    assert_snapshot!(rher.run("sweep --plan plan.jsonl --cell-from NOT_SET"), @"
    exit 2
    error: the environment variable `NOT_SET` is not set, expected the number of a cell

    hint: Slurm sets SLURM_ARRAY_TASK_ID in the jobs of an array, Kubernetes JOB_COMPLETION_INDEX in those of an Indexed Job; `--cell K` names a cell itself
    ");
    let mut command = rher.command("sweep --plan plan.jsonl --cell-from JOB_COMPLETION_INDEX");
    let output = command.env("JOB_COMPLETION_INDEX", "five").output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("`JOB_COMPLETION_INDEX` is `five`, expected the number"), "{said}");
}

#[test]
fn of_two_workers_one_runs_and_the_other_says_who_has_the_cell() {
    let rher = endless();
    let first = rher.spawn("sweep --plan plan.jsonl --cell 0");
    rher.wait_for_metrics("cells/seed=1");
    assert_eq!(states(&rher), ["running", "waiting"]);
    let second = rher.run("sweep --plan plan.jsonl --cell 0");
    assert_eq!(second.status, Some(15), "{second}");
    assert!(second.stderr.contains("cell 0 is being trained by process "), "{second}");
    // A sweep of all cells leaves it to the worker, too.
    let all = rher.spawn("sweep --plan plan.jsonl --jobs 2");
    rher.wait_for_metrics("cells/seed=2");
    all.send("TERM");
    assert_eq!(all.end().status, Some(143));
    assert_eq!(states(&rher), ["running", "stopped"]);
    first.send("TERM");
    let first = first.end();
    assert_eq!(first.status, Some(143), "{first}");
    assert!(first.stderr.ends_with("the same command continues the cell\n"), "{first}");
    assert_eq!(states(&rher), ["stopped", "stopped"]);
}

#[test]
fn a_cell_that_was_killed_or_stopped_goes_on_and_ends_with_the_same_bits() {
    let rher = tiny();
    let sweep = "sweep push --until 0 --env-steps 5000 --seeds 1 --config tiny.toml";
    rher.ok(&format!("{sweep} --out straight"));
    rher.ok(&format!("{sweep} --plan plan.jsonl --out cells"));
    let cell = "sweep --plan plan.jsonl --cell 0";
    let running = rher.spawn(cell);
    rher.wait_for_metrics("cells/seed=1");
    running.kill();
    assert_eq!(states(&rher), ["stopped"]);
    for signal in ["USR1", "TERM", "HUP"] {
        let running = rher.spawn(cell);
        std::thread::sleep(std::time::Duration::from_millis(120));
        running.send(signal);
        // The signal may come before it is listened to.
        let ran = running.end();
        assert!(ran.status != Some(1) && ran.status != Some(15), "{signal}: {ran}");
    }
    rher.ok(cell);
    assert_eq!(states(&rher), ["done"]);
    assert_eq!(rher.metrics("cells/seed=1"), rher.metrics("straight/seed=1"));
}

#[test]
fn a_budget_of_time_ends_in_a_checkpoint() {
    let rher = endless();
    let ran = rher.run("sweep --plan plan.jsonl --cell 1 --max-wall 1s");
    assert_eq!(ran.status, Some(16), "{ran}");
    assert!(ran.stderr.ends_with("the same command continues the cell\n"), "{ran}");
    assert_eq!(states(&rher), ["waiting", "stopped"]);
    let ran = rher.run("train --resume cells/seed=2 --max-wall 0.5s");
    assert_eq!(ran.status, Some(16), "{ran}");
    assert!(
        ran.stderr.ends_with("`rher train --resume cells/seed=2` continues the run\n"),
        "{ran}"
    );
}

#[test]
fn a_failed_cell_says_why_and_may_be_tried_again() {
    let rher = planned();
    let folder = lines(&rher)[1]["folder"].as_str().unwrap().to_owned();
    fs::create_dir_all(rher.path(&folder)).unwrap();
    rher.write(&format!("{folder}/policy.safetensors"), "not one of ours");
    let ran = rher.run("sweep --plan plan.jsonl --jobs 2");
    assert_eq!(ran.status, Some(1), "{ran}");
    let status: Value = serde_json::from_str(&rher.ok("sweep --status plan.jsonl --json")).unwrap();
    assert_eq!((&status["done"], &status["failed"]), (&7.into(), &1.into()));
    let why = status["list"][0]["why"].as_str().unwrap();
    assert!(why.contains("already holds a run"), "{why}");
    assert_eq!(status["list"][0]["status"], 5);
    fs::remove_file(rher.path(&folder).join("policy.safetensors")).unwrap();
    rher.ok("sweep --plan plan.jsonl --cell 0");
    assert_eq!(states(&rher), ["done"; 8]);
}

#[test]
fn a_plan_that_is_not_what_was_written_is_refused() {
    let rher = planned();
    let good = fs::read(rher.path("plan.jsonl")).unwrap();
    let with = |from: &str, to: &str| {
        rher.write("plan.jsonl", &good);
        edit(&rher, from, to);
        rher.run("sweep --plan plan.jsonl --cell 3")
    };
    assert_snapshot!(with("{\"plan\":1", "{\"plan\":2"), @"
    exit 4
    error: `plan.jsonl` is a plan of version 2, made by rher 0.1.0; expected version 1

    hint: use it with the version of `rher` that made it, or write a new plan in another file
    ");
    assert_snapshot!(with("{\"cell\":3", "{\"cell\":4"), @"
    exit 8
    error: `plan.jsonl` is damaged: line 5: it is cell 4, expected cell 3

    hint: restore the file, or write the plan again in another file; a plan is not edited
    ");
    assert_snapshot!(with("\"folder\":\"runs/", "\"folder\":\"../runs/"), @"
    exit 8
    error: `plan.jsonl` is damaged: line 2: `../runs/sweep-reach-push/reach,relay.mirror=0,seed=1` is no folder of a cell

    hint: restore the file, or write the plan again in another file; a plan is not edited
    ");
    for (from, to, problem) in [
        ("{\"cell\":2", "{\"cell:2", "line 4: unknown field `cell:2,`"),
        ("\"folder\":\"runs/", "\"folder\":\"cuns/", "the hash of its cells is "),
        (
            "\"discount\":0.",
            "\"discount\":0.1",
            "the settings of cell 0 in `plan.jsonl` do not match",
        ),
    ] {
        let ran = with(from, to);
        assert_eq!(ran.status, Some(8), "{ran}");
        assert!(ran.stderr.contains(problem) && ran.stderr.contains("hint: restore the "), "{ran}");
    }
    let whole = String::from_utf8(good.clone()).unwrap();
    let (head, _) = whole.trim_end().rsplit_once('\n').unwrap();
    rher.write("plan.jsonl", format!("{head}\n"));
    assert_snapshot!(rher.run("sweep --plan plan.jsonl"), @"
    exit 8
    error: `plan.jsonl` is damaged: it has 7 cells, expected 8

    hint: restore the file, or write the plan again in another file; a plan is not edited
    ");
    rher.write("plan.jsonl", "no plan\n");
    assert_snapshot!(rher.run("sweep --status plan.jsonl"), @"
    exit 3
    error: `plan.jsonl` is no plan: its first line is not the JSON that begins a plan

    hint: `rher sweep TASK... --plan FILE` writes a plan
    ");
    assert!(!rher.path("runs").exists());
    rher.write("plan.jsonl", &good);
    assert_snapshot!(rher.run("sweep --plan plan.jsonl --cell 8"), @"
    exit 2
    error: `plan.jsonl` has no cell 8: its cells are 0 to 7

    hint: cells are counted from 0
    ");
    assert_snapshot!(rher.run("sweep --plan nowhere.jsonl"), @"
    exit 3
    error: cannot read `nowhere.jsonl`: No such file or directory (os error 2)

    hint: `rher sweep TASK... --plan FILE` writes a plan
    ");
    assert!(!rher.path("runs").exists());
}

#[test]
fn a_folder_that_another_plan_owns_is_left_alone() {
    let rher = endless();
    let ran = rher.run("sweep --plan plan.jsonl --cell 0 --max-wall 1s");
    assert_eq!(ran.status, Some(16), "{ran}");
    let before = fs::read(rher.path("cells/seed=1/checkpoint/current.ckpt")).unwrap();
    rher.ok(
        "sweep reach --until 0 --env-steps 100 --seeds 1-2 --config tiny.toml --plan other.jsonl \
         --out cells",
    );
    let ran = rher.run("sweep --plan other.jsonl --cell 0");
    assert_eq!(ran.status, Some(5), "{ran}");
    assert!(ran.stderr.contains("`cells/seed=1` belongs to cell 0 of plan "), "{ran}");
    assert_eq!(fs::read(rher.path("cells/seed=1/checkpoint/current.ckpt")).unwrap(), before);
    // A run that no plan owns is taken for the cell if it is that run.
    rher.ok("sweep reach --until 0 --env-steps 50 --seeds 2 --config tiny.toml --out cells");
    rher.ok("sweep --plan other.jsonl --cell 1");
    assert_eq!(rher.metrics("cells/seed=2").last().unwrap()["env_steps"], 100);
}

#[test]
fn options_of_a_grid_need_tasks() {
    let rher = planned();
    for options in [
        "--seeds 1-5",
        "--set relay.mirror=1",
        "--out cells",
        "--env-steps 5",
        "--workers 2",
        "--max-wall 1h",
    ] {
        let ran = rher.run(&format!("sweep --plan plan.jsonl {options}"));
        assert_eq!(ran.status, Some(2), "{options}: {ran}");
    }
    for options in [
        "reach --plan plan.jsonl --cell 1",
        "--cell 1",
        "reach --max-wall 1h",
        "--status plan.jsonl --cell 1",
        "",
    ] {
        let ran = rher.run(&format!("sweep {options}"));
        assert_eq!(ran.status, Some(2), "{options}: {ran}");
    }
}

#[test]
fn results_show_the_cells_that_are_missing_or_failed() {
    let rher = planned();
    for cell in [0, 1, 2, 4] {
        rher.ok(&format!("sweep --plan plan.jsonl --cell {cell}"));
    }
    let failed = lines(&rher)[6]["folder"].as_str().unwrap().to_owned();
    fs::create_dir_all(rher.path(&failed)).unwrap();
    rher.write(&format!("{failed}/policy.safetensors"), "not one of ours");
    assert_eq!(rher.run("sweep --plan plan.jsonl --cell 5").status, Some(5));

    let stats: Value = serde_json::from_str(&rher.ok("stats plan.jsonl --json")).unwrap();
    let groups = stats["groups"].as_array().unwrap();
    let groups: Vec<_> =
        groups.iter().map(|it| (&it["task"], &it["preset"], &it["seeds"])).collect();
    let expected: Value = serde_json::json!([
        ["reach", "fast relay.mirror=0", [1, 2]],
        ["reach", "fast relay.mirror=0.5", [1]],
        ["push", "fast relay.mirror=0", [1]],
    ]);
    assert_eq!(serde_json::to_value(groups).unwrap(), expected);
    let unfinished = stats["unfinished"].as_array().unwrap().iter();
    let states: Vec<_> = unfinished.map(|row| (&row["cell"], &row["state"])).collect();
    let expected =
        serde_json::json!([[3, "waiting"], [5, "failed"], [6, "waiting"], [7, "waiting"]]);
    assert_eq!(serde_json::to_value(states).unwrap(), expected);

    let text = rher.ok("stats plan.jsonl");
    assert!(text.contains("Cells that are not done") && text.contains("already holds a run"));
    let ran = rher.run("plot plan.jsonl -o curves.svg");
    assert_eq!(ran.status, Some(0), "{ran}");
    assert!(ran.stderr.contains("4 cells are not done"), "{ran}");
    rher.ok("report plan.jsonl -o report.html");
    let page = fs::read_to_string(rher.path("report.html")).unwrap();
    assert!(page.contains("already holds a run") && page.contains("fast relay.mirror=0.5"));

    // Nothing is unfinished where everything is done, and a plan is as good as its folders.
    fs::remove_file(rher.path(&failed).join("policy.safetensors")).unwrap();
    rher.ok("sweep --plan plan.jsonl");
    let stats: Value = serde_json::from_str(&rher.ok("stats plan.jsonl --json")).unwrap();
    assert_eq!(stats.get("unfinished"), None);
}

#[test]
fn a_thousand_cells_are_read_in_no_time() {
    let rher = tiny();
    let cells = "reach --env-steps 50 --until 0 --config tiny.toml --plan plan.jsonl";
    rher.ok(&format!("sweep {cells} --seeds 1-1000 --out cells"));
    rher.ok("sweep --plan plan.jsonl --cell 0");
    let [config, metrics, worker] = ["config.toml", "metrics.jsonl", "worker-0.jsonl"]
        .map(|name| fs::read_to_string(rher.path("cells/seed=1").join(name)).unwrap());
    // Runs of an earlier version have no checksums, so that they can be made here.
    let settings = config.split_once('\n').unwrap().1;
    let (metrics, _) = metrics.split_once(",\"run\"").unwrap();
    for seed in 2..=990 {
        let folder = format!("cells/seed={seed}");
        fs::create_dir(rher.path(&folder)).unwrap();
        let settings = settings.replacen("seed = 1\n", &format!("seed = {seed}\n"), 1);
        rher.write(&format!("{folder}/config.toml"), settings);
        rher.write(&format!("{folder}/metrics.jsonl"), format!("{metrics}}}\n").repeat(100));
        let worker = worker.replacen("\"cell\":0", &format!("\"cell\":{}", seed - 1), 1);
        rher.write(&format!("{folder}/worker-0.jsonl"), worker);
    }
    for command in ["sweep --status plan.jsonl --json", "stats plan.jsonl --json"] {
        // Processor time, because other tests run beside this one.
        let ran = shell(&rher, &format!("$RHER {command} > read.json && times"));
        assert_eq!(ran.status, Some(0), "{ran}");
        let times: Vec<&str> = ran.stdout.split_whitespace().collect();
        let seconds = |time: &str| -> f64 {
            let (minutes, seconds) = time.trim_end_matches('s').split_once('m').unwrap();
            60.0 * minutes.parse::<f64>().unwrap() + seconds.parse::<f64>().unwrap()
        };
        let time = seconds(times[2]) + seconds(times[3]);
        assert!(0.0 < time && time < 3.0, "{command}: {time} s");
        let read = fs::read(rher.path("read.json")).unwrap();
        let read: Value = serde_json::from_slice(&read).unwrap();
        if command.starts_with("sweep") {
            assert_eq!((&read["done"], &read["waiting"]), (&990.into(), &10.into()));
        } else {
            assert_eq!(read["groups"][0]["seeds"].as_array().unwrap().len(), 990);
            assert_eq!(read["unfinished"].as_array().unwrap().len(), 10);
        }
    }
}

#[test]
fn a_finished_run_of_other_settings_in_the_folder_of_a_cell_is_not_the_cell() {
    let rher = endless();
    let folder = lines(&rher)[1]["folder"].as_str().unwrap().to_owned();
    rher.ok(&format!(
        "train reach --seed 7 --until 0 --env-steps 50 --config tiny.toml --quiet \
         --out {folder}"
    ));
    assert_eq!(states(&rher), ["failed", "waiting"]);
    assert_eq!(rher.run("sweep --plan plan.jsonl --cell 0").status, Some(5));
}
