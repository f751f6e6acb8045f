//! What the program says, and the status it ends with.

use crate::support::{Rher, TINY};
use insta::assert_snapshot;
use serde_json::Value;
use std::fs::File;
use std::process::Stdio;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

fn keys(object: &Value) -> Vec<&str> {
    object.as_object().unwrap().keys().map(String::as_str).collect()
}

/// The same text without the names of the tasks, which are many.
fn without_tasks(text: &impl ToString) -> String {
    let text = text.to_string();
    match text.split_once("[possible values: reach") {
        Some((before, after)) => {
            let (_, after) = after.split_once(']').unwrap();
            format!("{before}[possible values: …]{after}")
        }
        None => text,
    }
}

#[test]
#[cfg_attr(feature = "live", ignore = "there is more to help with")]
fn help_names_the_verbs_and_every_exit_status() {
    assert_snapshot!(Rher::new().ok("--help"), @"
    Relay Hindsight Experience Replay: robots that learn to push, pick and stack from sparse rewards

    Usage: rher <COMMAND>

    Commands:
      tasks        List the tasks: what there is to do, and how long it usually takes to learn
      train        Train a policy, or resume a run from its checkpoint
      sweep        Train with every combination of settings and seeds, several runs at a time
      reproduce    Repeat an experiment of the paper
      eval         Measure the success rate of a policy, with a 95 % confidence interval
      play         Play episodes of a policy, and draw or record them
      replay       List the episodes of a recording, or verify that they reproduce bit for bit
      export       Write a policy as an ONNX model, or its episodes as a dataset for Minari or LeRobot
      card         Write a model card: a policy with its numbers, a moving picture and its settings
      runs         List the runs below a folder: how far they are, and whether they go on
      stats        Compare runs: sample efficiency, final success, confidence intervals
      plot         Draw learning curves, with those that the authors published
      report       Write one HTML page about runs: curves, tables, an episode, settings
      config       Print every setting of a run as TOML, for `rher train --config`
      doctor       Say what this machine is, and whether it computes the same bits as every other
      bench        Measure the speed of this machine
      completions  Print what completes commands and options in a shell
      man          Write manual pages, one for each command
      help         Print this message or the help of the given subcommand(s)

    Options:
      -h, --help
              Print help (see a summary with '-h')

      -V, --version
              Print version

    Start with `rher play stack --film stack.gif`, and with `rher train push`.

    Exit status:
        0  success
        1  another error
        2  the command line is wrong: an unknown task or option, or a bad value
        3  a settings file cannot be read, or has a wrong setting
        4  a settings file or a plan has another version
        5  the run folder is in use, already holds a run, or holds none
        6  a file or folder cannot be written
        7  the disk is full
        8  a file of a run, a policy file or a plan is damaged
        9  the environment failed
       10  NaN or infinity in an environment, a policy or the learner
       11  a file is not a recording, or it is cut off or damaged
       12  a recorded episode does not reproduce
       14  the run folder was moved, deleted or replaced during the run
       15  another worker trains the cell of the plan
       16  the time of --max-wall is over; the run is saved
      129  ended by SIGHUP; the run or the recording is saved
      130  interrupted by Ctrl-C; the run or the recording is saved
      143  ended by SIGTERM or SIGUSR1; the run or the recording is saved
    ");
}

#[test]
#[cfg_attr(feature = "live", ignore = "there is more to help with")]
fn training_help_teaches() {
    assert_snapshot!(without_tasks(&Rher::new().ok("train -h")), @"
    Train a policy, or resume a run from its checkpoint

    Usage: rher train [OPTIONS] [TASK]

    Arguments:
      [TASK]  Task to learn; `rher tasks` lists the tasks [possible values: …]

    Options:
      -h, --help     Print help (see more with '--help')
      -V, --version  Print version

    Settings, in increasing order of precedence:
          --preset <PRESET>   Preset to start from; `fast` also applies the recipe of the task [default:
                              fast] [possible values: fast, sample-efficient, paper]
          --config <FILE>     TOML file with settings to change; `rher config` prints all of them
          --set <KEY=VALUE>   A setting to change, as in `--set agent.discount=0.98`; may be repeated;
                              `--set help` lists them
          --method <METHOD>   Training method [default: rher] [possible values: rher, her]
          --seed <N>          Seed of all random numbers of the run
          --env-steps <N>     End after this many environment steps of training; evaluations do not
                              count
          --until <RATE>      End after two consecutive evaluations with at least this success rate; 0
                              never ends the run
          --engine <NAME>     Compute engine of the networks [possible values: burn, fused]
          --precision <NAME>  Precision of the networks' matrix products [possible values: f32, bf16]
          --envs <N>          Number of environments that step side by side between updates; it changes
                              the result
          --workers <N>       Number of threads, which never changes the result [default: one for each
                              core]
          --out <DIR>         Run folder to create; by default `runs/<TASK>-<METHOD>-<PRESET>-<SEED>`
          --from <RUN>        Start with the networks of the run in this folder, which may be of another
                              task
          --record-every <N>  Record every N-th training episode for Foxglove, beginning with the first
          --tensorboard       Write event files for `tensorboard --logdir runs`, with the numbers of
                              `metrics.jsonl`
          --resume <DIR>      Resume the run in this folder, as if it had never stopped
          --max-wall <TIME>   Save the run and end with exit status 16 after this time, as in `90s`,
                              `55m` or `4h`
      -q, --quiet             Print errors only
    ");
}

#[test]
fn tasks_are_listed_for_people_and_for_programs() {
    let rher = Rher::new();
    let tasks = json(&rher.ok("tasks --json"));
    let reach = &tasks[0];
    assert_snapshot!(serde_json::to_string(reach).unwrap(), @r#"{"about":"Bring the gripper to a place in the air.","action":4,"action_names":["locked_fingers.x","locked_fingers.y","locked_fingers.z","locked_fingers.opening"],"encoded_goal":6,"episode_steps":50,"goal":3,"name":"reach","object_names":["target1"],"objects":1,"observation":10,"observation_names":["gripper.position.x","gripper.position.y","gripper.position.z","finger1.opening","finger2.opening","gripper.velocity.x","gripper.velocity.y","gripper.velocity.z","finger1.velocity","finger2.velocity"],"solved":{"runs":[{"env_steps":1000,"wall_s":1}],"until":0.95},"subtasks":1,"tolerance":[0.05,0.05]}"#);
    let listing = rher.ok("tasks");
    for task in tasks.as_array().unwrap() {
        assert!(listing.contains(task["name"].as_str().unwrap()), "{listing}");
        assert!(listing.contains(task["about"].as_str().unwrap()), "{listing}");
    }
    assert!(listing.contains("usually 10,000 to 12,500 steps, 30 s"), "{listing}");
}

#[test]
fn every_configuration_goes_round() {
    let rher = Rher::new();
    for task in json(&rher.ok("tasks --json")).as_array().unwrap() {
        let task = task["name"].as_str().unwrap();
        for preset in ["fast", "sample-efficient", "paper"] {
            let printed = rher.ok(&format!("config {task} --preset {preset}"));
            rher.write("run.toml", &printed);
            assert_eq!(rher.ok(&format!("config {task} --config run.toml")), printed);
        }
    }
}

#[test]
fn settings_explain_themselves() {
    let rher = Rher::new();
    let list = rher.ok("train --set help");
    assert_eq!(rher.ok("sweep push --seeds 1 --set help"), list);
    assert!(list.starts_with("Every setting"), "{list}");
    assert!(list.contains("\n  agent.target_rate "), "{list}");
    let short = rher.ok("config push");
    assert!(
        short.contains("\n# Discount factor: the paper's γ (eq. 1).\ndiscount = 0.95\n"),
        "{short}"
    );
    let full = rher.ok("config push --explain");
    assert!(
        full.contains("\n# Values: a number of at least 0 and below 1.\ndiscount = 0.95\n"),
        "{full}"
    );
    rher.write("run.toml", full);
    assert_eq!(rher.ok("config push --config run.toml"), short);
}

#[test]
fn floats_are_printed_as_they_are_written() {
    let printed = Rher::new().ok("config push --until 0.9");
    assert!(
        printed.contains("\nuntil = 0.9\n") && printed.contains("\nguide = 0.4\n"),
        "{printed}"
    );
}

#[test]
fn later_settings_win() {
    let rher = Rher::new();
    rher.write("run.toml", "seed = 2\nenv_steps = 200\n[agent]\ndiscount = 0.9\nhidden = [8]\n");
    let printed = rher.ok(
        "config push --config run.toml --set agent.hidden=[4,4] --set env_steps=300 --env-steps 400 \
         --method her",
    );
    let config: Vec<&str> = printed.lines().collect();
    for line in
        ["seed = 2", "env_steps = 400", "discount = 0.9", "hidden = [4, 4]", "method = \"her\""]
    {
        assert!(config.contains(&line), "{line} is missing in\n{printed}");
    }
}

#[test]
fn a_file_can_name_its_preset() {
    let rher = Rher::new();
    rher.write("run.toml", "preset = \"paper\"\n");
    assert_eq!(rher.ok("config push --config run.toml"), rher.ok("config push --preset paper"));
}

#[test]
fn unknown_tasks_are_refused_with_the_nearest() {
    let rher = Rher::new();
    assert_snapshot!(without_tasks(&rher.run("train psuh")), @"
    exit 2
    error: invalid value 'psuh' for '[TASK]'
      [possible values: …]

      tip: a similar value exists: 'push'

    For more information, try '--help'.
    ");
    assert_snapshot!(without_tasks(&rher.run("bench env --task psuh")), @"
    exit 2
    error: invalid value 'psuh' for '--task <TASK>'
      [possible values: …]

      tip: a similar value exists: 'push'

    For more information, try '--help'.
    ");
}

#[test]
fn wrong_settings_in_a_file_are_shown_with_their_place() {
    let rher = Rher::new();
    let config = |text: &str| {
        rher.write("run.toml", text);
        rher.run("train push --config run.toml").to_string()
    };
    assert_snapshot!(config("seed = 1\n\n[agent]\n  hiden = [8]\n"), @"
    exit 3
    error: run.toml:4:3: there is no setting `agent.hiden`

    hint: did you mean `agent.hidden`? `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(config("[relay]\nmethd = \"her\"\n"), @"
    exit 3
    error: run.toml:2:1: there is no setting `relay.methd`

    hint: did you mean `relay.method`? `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(config("color = \"red\"\n"), @"
    exit 3
    error: run.toml:1:1: there is no setting `color`

    hint: `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(config("[agent]\ndiscount = \"high\"\n"), @r#"
    exit 3
    error: run.toml:2:1: `agent.discount` is "high", expected a number of at least 0 and below 1

    hint: `rher config <TASK>` prints every setting with its value
    "#);
    assert_snapshot!(config("[agent]\nhidden = [8, -8]\n"), @"
    exit 3
    error: run.toml:2:1: `agent.hidden` is [8, -8], expected a list of 1 to 64 whole numbers in brackets, each from 1 to 65536

    hint: `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(config("[relay]\ngoal_frame = \"relatve\"\n"), @r#"
    exit 3
    error: run.toml:2:1: `relay.goal_frame` is "relatve", expected `absolute` or `relative`

    hint: `rher config <TASK>` prints every setting with its value
    "#);
    assert_snapshot!(config("[agent]\n# Too far.\ndiscount = 1.5\n"), @"
    exit 3
    error: run.toml:3:1: `agent.discount` is 1.5, expected a number of at least 0 and below 1

    hint: `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(config("until = nan\n"), @"
    exit 3
    error: run.toml:1:1: `until` is NaN, expected a number from 0 to 1

    hint: `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(config("agent = 3\n"), @"
    exit 3
    error: run.toml:1:1: `agent` is a section, not a setting

    hint: `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(config("[agnt]\n"), @"
    exit 3
    error: run.toml:1:2: there is no setting `agnt`

    hint: did you mean `agent`? `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(config("seed = \n"), @"
    exit 3
    error: run.toml:1:8: string values must be quoted, expected literal string

    hint: `rher config <TASK>` prints a file to start from
    ");
    assert_snapshot!(config("version = 7\nwhatever = 1\n"), @"
    exit 4
    error: run.toml:1:1: the file has version 7, this program reads version 1

    hint: make a new file with `rher config <TASK>`, and carry your changes over
    ");
    assert_snapshot!(config("task = \"reach\"\n"), @"
    exit 3
    error: run.toml:1:1: the file is for task `reach`, not `push`

    hint: `rher train reach` trains it; or delete that line
    ");
    assert_snapshot!(config("preset = \"slow\"\n"), @r#"
    exit 3
    error: run.toml:1:1: `preset` is "slow", expected `fast`, `sample-efficient` or `paper`

    hint: `rher config <TASK>` prints every setting with its value
    "#);
    rher.write("run.toml", "preset = \"paper\"\n");
    assert_snapshot!(rher.run("train push --preset fast --config run.toml"), @"
    exit 3
    error: run.toml:1:1: the file starts from another preset than --preset

    hint: leave --preset out, or delete that line
    ");
    assert_snapshot!(rher.run("train push --config missing.toml"), @"
    exit 3
    error: cannot read config file `missing.toml`: No such file or directory (os error 2)

    hint: `rher config <TASK> > run.toml` makes a settings file
    ");
    assert!(!rher.path("runs").exists(), "nothing was started");
}

#[test]
fn sizes_that_cannot_be_had_are_refused_before_anything_is_made() {
    let rher = Rher::new();
    for size in [
        "--set agent.hidden=[1000000000]",
        "--set agent.hidden=[65536,65536,65536]",
        "--set replay.capacity=1000000000000",
        "--set replay.capacity=9223372036854775807",
        "--set replay.batch_size=1000000000000",
        "--set evaluation.episodes=1000000000000000",
        "--envs 100000",
        "--workers 1000000000",
    ] {
        for command in ["train push", "train tpush --preset paper"] {
            let ran = rher.run(&format!("{command} {size}"));
            assert_eq!(ran.status, Some(2), "{size}: {ran}");
        }
    }
    let ran = rher.run("sweep push --set replay.capacity=1000000000000");
    assert_eq!(ran.status, Some(2), "{ran}");
    assert!(ran.stderr.contains("the run needs about "), "{ran}");
    assert_eq!(std::fs::read_dir(rher.path(".")).unwrap().count(), 0, "something was made");
    // Settings for a larger machine can be written down on this one.
    rher.ok("config push --set replay.capacity=1000000000000");
}

#[test]
fn files_that_are_too_large_are_refused_at_once() {
    let rher = Rher::new();
    let refused = |name: &str, status: i32, message: &str| {
        let started = std::time::Instant::now();
        let ran = rher.run(&format!("train push --config {name}"));
        assert_eq!(ran.status, Some(status), "{name}: {ran}");
        assert!(ran.stderr.contains(message), "{name}: {ran}");
        assert!(started.elapsed().as_secs() < 10, "{name} took {:?}", started.elapsed());
    };
    rher.write(
        "tables.toml",
        (0..70_000).map(|i| format!("[table{i}]\n")).collect::<Vec<_>>().concat(),
    );
    refused("tables.toml", 3, "there is no setting `table0`");
    rher.write(
        "keys.toml",
        (0..70_000).map(|i| format!("a{i} = 1\n")).collect::<Vec<_>>().concat(),
    );
    refused("keys.toml", 3, "there is no setting `a0`");
    rher.write(
        "line.toml",
        format!(
            "x = {{ {} }}\n",
            (0..70_000).map(|i| format!("a{i} = 1, ")).collect::<Vec<_>>().concat()
        ),
    );
    refused("line.toml", 3, "line.toml:1:");
    rher.write("deep.toml", format!("{} = 1\n", vec!["a"; 400_000].join(".")));
    refused("deep.toml", 3, "deep.toml:1:1");
    rher.write(
        "large.toml",
        (0..300_000).map(|i| format!("[table{i}]\n")).collect::<Vec<_>>().concat(),
    );
    refused("large.toml", 3, "at most 1048576 bytes");
    refused("/dev/zero", 3, "at most 1048576 bytes");
}

#[test]
fn seeds_that_toml_cannot_hold_are_refused_by_their_own_number() {
    let rher = Rher::new();
    rher.write("run.toml", "seed = 9223372036854775808\n");
    for (arguments, status) in [
        ("config push --seed 9223372036854775808", 2),
        ("config push --set seed=9223372036854775808", 2),
        ("config push --config run.toml", 3),
    ] {
        let ran = rher.run(arguments);
        assert_eq!(ran.status, Some(status), "{arguments}: {ran}");
        assert!(ran.stderr.contains("9223372036854775808"), "{arguments}: {ran}");
    }
    assert!(
        rher.ok("config push --seed 9223372036854775807")
            .contains("\nseed = 9223372036854775807\n")
    );
}

#[test]
fn wrong_settings_on_the_command_line_are_refused() {
    let rher = Rher::new();
    assert_snapshot!(rher.run("train push --set batch_sise=3"), @"
    exit 2
    error: --set: there is no setting `batch_sise`

    hint: did you mean `replay.batch_size`? `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(rher.run("train push --set agent.hidden=wide"), @r#"
    exit 2
    error: --set: `agent.hidden` is "wide", expected a list of 1 to 64 whole numbers in brackets, each from 1 to 65536

    hint: `rher config <TASK>` prints every setting with its value
    "#);
    assert_snapshot!(rher.run("train push --set agent.critics=3"), @"
    exit 2
    error: --set: `agent.critics` is 3, expected a whole number from 1 to 2

    hint: `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(rher.run("train push --set exploration.random=0.9"), @"
    exit 2
    error: --set: `exploration.guide` is 0.4, expected at most 1 − `exploration.random`

    hint: `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(rher.run("train push --set preset=paper"), @"
    exit 2
    error: `preset` cannot be changed by --set

    hint: use --preset
    ");
    assert_snapshot!(rher.run("train push --set agent.hidden"), @"
    exit 2
    error: invalid value 'agent.hidden' for '--set <KEY=VALUE>': expected KEY=VALUE, as in `--set agent.discount=0.98`

    For more information, try '--help'.
    ");
    assert_snapshot!(rher.run("train push --set agent.hidden=[8"), @"
    exit 2
    error: invalid value 'agent.hidden=[8' for '--set <KEY=VALUE>': `[8` is not a TOML value: unclosed array, expected `]`

    For more information, try '--help'.
    ");
    assert_snapshot!(rher.run("train push --until 1.5"), @"
    exit 2
    error: invalid value '1.5' for '--until <RATE>': expected a number from 0 to 1

    For more information, try '--help'.
    ");
    assert_snapshot!(rher.run("train push --workers 0"), @"
    exit 2
    error: invalid value '0' for '--workers <N>': expected a whole number from 1 to 1024

    For more information, try '--help'.
    ");
    assert_snapshot!(rher.run("train push --preset quick"), @"
    exit 2
    error: invalid value 'quick' for '--preset <PRESET>'
      [possible values: fast, sample-efficient, paper]

    For more information, try '--help'.
    ");
    assert_snapshot!(rher.run("train"), @"
    exit 2
    error: the following required arguments were not provided:
      <TASK>

      tip: the tasks are reach, push, pick, slide, insert, obstacle-push, drawer, cue-push, dpush, stack, drawer-box, tpush, tstack

    Usage: rher train <TASK>

    For more information, try '--help'.
    ");
}

#[test]
fn a_run_leaves_its_folder_behind() {
    let rher = Rher::new();
    let ran = rher.run(&format!("train reach --env-steps 500 {TINY}"));
    assert_eq!((ran.status, ran.stdout.as_str()), (Some(0), ""), "{ran}");
    assert!(ran.stderr.contains("all steps taken after 500 steps"), "{ran}");
    assert!(ran.stderr.contains("runs/reach-rher-fast-1/policy.safetensors"), "{ran}");

    let run = "runs/reach-rher-fast-1";
    let mut files: Vec<String> = std::fs::read_dir(rher.path(run))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| !name.starts_with('.'))
        .collect();
    files.sort();
    assert_eq!(
        files,
        ["checkpoint", "config.toml", "machine.toml", "metrics.jsonl", "policy.safetensors"]
    );
    let config = std::fs::read_to_string(rher.path(run).join("config.toml")).unwrap();
    let printed = rher.ok(&format!("config reach --env-steps 500 {TINY}"));
    let without_comments: Vec<_> = printed.lines().filter(|line| !line.starts_with('#')).collect();
    let (first, lines) = config.split_once('\n').unwrap();
    assert!(
        first.starts_with("# Run ") && first.contains(", CRC-32 of the lines below "),
        "{first}"
    );
    assert_eq!(lines.lines().collect::<Vec<_>>(), without_comments);

    let metrics = rher.metrics(run);
    assert_eq!(metrics.len(), 2);
    for key in ["env_steps", "episodes", "updates", "success", "success_final", "guide"] {
        assert!(metrics[1].get(key).is_some(), "{key} is missing in {}", metrics[1]);
    }
    assert_snapshot!(rher.run(&format!("train reach {TINY}")), @"
    exit 5
    error: `runs/reach-rher-fast-1` already holds a run

    hint: `rher train --resume runs/reach-rher-fast-1 --env-steps N` continues it; `--out DIR` starts a run elsewhere
    ");
}

#[test]
fn a_policy_is_evaluated_from_its_folder_or_its_file() {
    let rher = Rher::new();
    rher.ok(&format!("train push --quiet --env-steps 250 {TINY} --out run"));
    let report = rher.ok("eval run --episodes 10 --json");
    assert_eq!(report, rher.ok("eval run/policy.safetensors --episodes 10 --seed 1 --json"));
    let report = json(&report);
    assert_eq!(
        keys(&report),
        [
            "ci95",
            "env_seed",
            "episodes",
            "failures",
            "final_distance",
            "held_out",
            "options",
            "success",
            "success_final",
            "task",
            "true_final_distance"
        ]
    );
    assert_eq!((&report["episodes"], &report["env_seed"]), (&Value::from(10), &Value::from(1)));
    assert_eq!(report["success"].as_array().unwrap().len(), 2);
    let text = rher.ok("eval run --episodes 10");
    assert!(text.contains("of 10 episodes (95 % interval"), "{text}");
    assert!(text.contains("of seed 1, not those of training"), "{text}");
    let text = rher.ok("eval run --episodes 10 --seed 0");
    assert!(text.contains("of seed 0, those that training was judged by"), "{text}");
}

#[test]
fn what_is_no_policy_is_not_evaluated() {
    let rher = Rher::new();
    rher.write("noise.safetensors", [7; 100]);
    assert_snapshot!(rher.run("eval noise.safetensors"), @"
    exit 8
    error: `noise.safetensors` is not a policy file of this program: its header has 506381209866536711 bytes, expected at most 1048576

    hint: expected the file `policy.safetensors` of a run folder
    ");
    assert_snapshot!(rher.run("eval missing"), @"
    exit 5
    error: cannot read `missing`: No such file or directory (os error 2)

    hint: give a run folder that has a policy, a policy file, or the name of a task, whose policy ships with the program
    ");
}

#[test]
fn folders_that_cannot_be_written_are_told() {
    let rher = Rher::new();
    rher.write("file", "");
    assert_snapshot!(rher.run("train push --out file/run"), @"
    exit 6
    error: cannot write `file/run`: Not a directory (os error 20)

    hint: choose a place where you have write permission
    ");
    assert_snapshot!(rher.run("train push --out file"), @"
    exit 6
    error: cannot write `file`: File exists (os error 17)

    hint: choose a place where you have write permission
    ");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told_and_the_checkpoint_kept() {
    let rher = Rher::new();
    std::fs::create_dir(rher.path("run")).unwrap();
    std::os::unix::fs::symlink("/dev/full", rher.path("run/metrics.jsonl")).unwrap();
    let ran = rher.run(&format!("train push --quiet --env-steps 500 {TINY} --out run"));
    assert_snapshot!(ran, @"
    exit 7
    error: cannot write `run/metrics.jsonl`: No space left on device (os error 28)

    hint: free some space, and repeat the command; a run that had begun continues from its last checkpoint with `rher train --resume DIR`
    ");
    assert!(rher.path("run/checkpoint/current.ckpt").exists());

    let full = File::options().write(true).open("/dev/full").unwrap();
    let ran = rher.command("tasks").stdout(full).output().unwrap();
    assert_eq!(ran.status.code(), Some(7), "{}", String::from_utf8_lossy(&ran.stderr));
}

#[test]
fn a_gradient_that_is_no_number_ends_the_run_and_its_state_is_kept() {
    let rher = Rher::new();
    let ran = rher.run(&format!(
        "train push --quiet --env-steps 5000 {TINY} --set agent.critic_learning_rate=1e38 --out run"
    ));
    assert_eq!(ran.status, Some(10), "{ran}");
    insta::assert_snapshot!(ran.stderr, @r"
    error: update 1, after 50 environment steps, diverged; its batch has seed 1, count 1: the gradient of critic 1 is not finite, first in `layers.2.bias`

    hint: the state before this update was saved; smaller values of `agent.actor_learning_rate` and `agent.critic_learning_rate` help against divergence
    ");
    rher.ok("eval run --episodes 2");
}

#[test]
fn a_reader_that_has_gone_away_has_read_enough() {
    let rher = Rher::new();
    let mut child =
        rher.command("tasks --json").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let ran = child.wait_with_output().unwrap();
    assert_eq!((ran.status.code(), ran.stderr.as_slice()), (Some(0), b"".as_slice()));
}

#[test]
fn speed_is_measured_for_programs_too() {
    let rher = Rher::new();
    let envs = json(&rher.ok("bench env --task reach --json"));
    assert_eq!(keys(&envs[0]), ["reset_us", "steps_per_cpu_s", "substeps", "task", "together"]);
    let updates =
        json(&rher.ok("bench update --batch 8 --inputs 31 --threads 1 --engine burn --json"));
    assert_eq!(updates.as_array().unwrap().len(), 1);
    assert_eq!(
        keys(&updates[0]),
        [
            "batch",
            "cpu_ms_per_update",
            "engine",
            "gflops",
            "inputs",
            "mean_ms_per_update",
            "ms_per_update",
            "peak_gflops",
            "precision",
            "threads"
        ]
    );
}
