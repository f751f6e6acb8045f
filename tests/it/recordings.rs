//! Recordings: readable by others, whole whenever a program ends, and provably real.

use crate::python::{self, python};
use crate::support::{Rher, TINY, shell};
use mcap::records::MessageHeader;
use mcap::{MessageStream, Summary};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// A recording of three episodes of an untrained policy.
fn recorded(task: &str, settings: &str) -> Rher {
    let rher = Rher::new();
    rher.ok(&format!("train {task} --env-steps 1 --out run {settings} {TINY}"));
    rher.ok("play run --episodes 3 --mcap out.mcap");
    rher
}

fn read(python: &Path, path: &Path, options: &[&str]) -> Value {
    let options = options.iter().map(Path::new);
    let arguments: Vec<&Path> = std::iter::once(path).chain(options).collect();
    serde_json::from_str(&python::run(python, "recording.py", &arguments)).unwrap()
}

#[test]
fn others_read_what_was_recorded() {
    let Some(python) = python() else { return };
    let rher = recorded("tpush", "");
    let path = rher.path("out.mcap");
    let file = read(python, &path, &[]);
    assert_eq!(
        file["schemas"],
        json!({
            "/tf": ["foxglove.FrameTransforms", "protobuf", "protobuf"],
            "/scene": ["foxglove.SceneUpdate", "protobuf", "protobuf"],
            "/episode": ["rher.Episode", "jsonschema", "json"],
            "/frame": ["rher.Frame", "jsonschema", "json"],
            "/action": ["rher.Action", "jsonschema", "json"],
        })
    );
    let counts = json!({ "/tf": 213, "/scene": 3, "/episode": 3, "/frame": 213, "/action": 210 });
    assert_eq!(file["counts"], counts);
    assert_eq!(file["first_frames"], file["frames"]);
    assert_eq!(file["parents"], json!(["world"]));
    let entities = file["entities"].as_array().unwrap();
    assert_eq!(file["entities"], file["frames"]);
    for name in [
        "table",
        "hand",
        "fingers",
        "block_1",
        "block_3",
        "goal_1",
        "goal_3",
        "stage_goal",
        "hindsight_goal_1",
        "hindsight_goal_3",
        "hindsight_gripper",
    ] {
        assert!(entities.contains(&name.into()), "{name} is not in {entities:?}");
    }
    let about = &file["metadata"]["rher"];
    assert_eq!((&about["task"], &about["source"]), (&"tpush".into(), &"policy".into()));
    assert_eq!(about["policy_sha256"].as_str().map(str::len), Some(64));
    let config = std::fs::read_to_string(rher.path("run/config.toml")).unwrap();
    let (first, settings) = config.split_once('\n').unwrap();
    assert!(first.contains(about["run"].as_str().unwrap()), "{first}");
    assert_eq!(about["config"], Value::from(settings));

    let bytes = std::fs::metadata(&path).unwrap().len();
    assert!(bytes / 3 < 300_000, "{} bytes an episode", bytes / 3);

    let layout = std::fs::read(rher.path("out.layout.json")).unwrap();
    let layout: Value = serde_json::from_slice(&layout).unwrap();
    let panels = layout["configById"].as_object().unwrap();
    assert!(panels.keys().any(|panel| panel.starts_with("3D!")));
    assert!(panels.keys().filter(|panel| panel.starts_with("Plot!")).count() >= 4);
}

#[test]
fn every_task_can_be_played_recorded_and_proved() {
    let tasks: Value = serde_json::from_str(&Rher::new().ok("tasks --json")).unwrap();
    for task in tasks.as_array().unwrap() {
        let task = task["name"].as_str().unwrap();
        let proof = recorded(task, "").ok("replay out.mcap --verify");
        assert!(proof.starts_with("verified: 3 episodes"), "{task}: {proof}");
    }
}

#[test]
fn a_proof_knows_the_options_and_what_was_randomized() {
    let settings = "--set randomize.friction=[0.5,1.5] --set randomize.sensor_noise=[0.001,0.002] \
        --set randomize.action_delay=[0,2] --set task.observe_obstacle=false";
    let rher = recorded("obstacle-push", settings);
    assert!(rher.ok("replay out.mcap --verify").starts_with("verified: 3 episodes"));
}

/// Writes `from` again, with every message changed by `change`.
fn rewrite(from: &Path, to: &Path, change: impl Fn(&str, &mut Value)) {
    let bytes = std::fs::read(from).unwrap();
    let mut writer = mcap::Writer::new(std::fs::File::create(to).unwrap()).unwrap();
    let summary = Summary::read(&bytes).unwrap().unwrap();
    let metadata = mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).unwrap();
    writer.write_metadata(&metadata).unwrap();
    for message in MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let channel = &message.channel;
        let schema = channel.schema.as_ref().unwrap();
        let schema = writer.add_schema(&schema.name, &schema.encoding, &schema.data).unwrap();
        let encoding = &channel.message_encoding;
        let id = writer.add_channel(schema, &channel.topic, encoding, &BTreeMap::new()).unwrap();
        let mut data = message.data.to_vec();
        if encoding == "json" {
            let mut value: Value = serde_json::from_slice(&data).unwrap();
            let before = value.clone();
            change(&channel.topic, &mut value);
            if value != before {
                data = serde_json::to_vec(&value).unwrap();
            }
        }
        let header = MessageHeader {
            channel_id: id,
            sequence: message.sequence,
            log_time: message.log_time,
            publish_time: message.publish_time,
        };
        writer.write_to_known_channel(&header, &data).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn what_is_not_real_is_located() {
    let rher = recorded("push", "");
    let (from, to) = (rher.path("out.mcap"), rher.path("changed.mcap"));

    rewrite(&from, &to, |_, _| ());
    assert!(rher.ok("replay changed.mcap --verify").starts_with("verified: 3 episodes"));

    rewrite(&from, &to, |topic, message| {
        if topic == "/frame" && message["episode"] == 1 && message["step"] == 7 {
            message["observation"][2] = json!(0.5);
        }
    });
    let ran = rher.run("replay changed.mcap --verify");
    assert_eq!(ran.status, Some(12), "{ran}");
    assert!(ran.stderr.contains("episode 1, step 7, `/frame observation[2]` is 0.5 in"), "{ran}");

    // An action that was not taken leads elsewhere.
    rewrite(&from, &to, |topic, message| {
        if topic == "/action" && message["episode"] == 2 && message["step"] == 4 {
            message["action"] = json!([1.0, 1.0, 0.0, 0.0]);
        }
    });
    let ran = rher.run("replay changed.mcap --verify");
    assert_eq!(ran.status, Some(12), "{ran}");
    assert!(ran.stderr.contains("episode 2, step 5, `/frame "), "{ran}");

    // Another seed is another beginning.
    rewrite(&from, &to, |topic, message| {
        if topic == "/episode" && message["episode"] == 0 {
            message["seed"] = json!("5");
        }
    });
    let ran = rher.run("replay changed.mcap --verify");
    assert_eq!(ran.status, Some(12), "{ran}");
    assert!(ran.stderr.contains("episode 0, step 0, `/episode targets"), "{ran}");
}

#[test]
fn training_is_recorded_and_not_changed_by_it() {
    let rher = Rher::new();
    let train = format!("train push --env-steps 500 {TINY}");
    rher.ok(&format!("{train} --out plain"));
    rher.ok(&format!("{train} --out recorded --record-every 3"));
    assert_eq!(rher.metrics("plain"), rher.metrics("recorded"));
    let policy = |run: &str| std::fs::read(rher.path(run).join("policy.safetensors")).unwrap();
    assert!(policy("plain") == policy("recorded"));

    let list = rher.ok("replay recorded/episodes-0.mcap");
    let episodes: Vec<&str> =
        list.lines().skip(2).filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(episodes, ["0", "3", "6", "9"], "{list}");
    let proof = rher.ok("replay recorded/episodes-0.mcap --verify");
    assert!(proof.starts_with("verified: 4 episodes, 200 steps"), "{proof}");
    assert!(!rher.path("recorded/episodes-0.part.mcap").exists());

    // A run that goes on has another file.
    let before = std::fs::read(rher.path("recorded/episodes-0.mcap")).unwrap();
    rher.ok("train --resume recorded --env-steps 1000 --record-every 3");
    assert!(before == std::fs::read(rher.path("recorded/episodes-0.mcap")).unwrap());
    assert!(
        rher.ok("replay recorded/episodes-12.mcap --verify").starts_with("verified: 3 episodes")
    );
}

/// Starts a training that would go on for long, and waits for some episodes.
fn long_run(rher: &Rher) -> crate::support::Running {
    let running = rher.spawn(&format!("train push --out run --record-every 1 {TINY}"));
    let part = rher.path("run/episodes-0.part.mcap");
    let started = Instant::now();
    while std::fs::metadata(&part).map_or(0, |file| file.len()) < 100_000 {
        assert!(started.elapsed() < Duration::from_mins(1), "nothing recorded after a minute");
        std::thread::sleep(Duration::from_millis(2));
    }
    running
}

#[test]
fn a_recording_is_whole_after_ctrl_c() {
    let rher = Rher::new();
    let running = long_run(&rher);
    running.interrupt();
    let ran = running.end();
    assert_eq!(ran.status, Some(130), "{ran}");
    assert!(rher.ok("replay run/episodes-0.mcap --verify").starts_with("verified: "));
    assert!(!rher.path("run/episodes-0.part.mcap").exists());

    let running = rher.spawn("play run --episodes 1000000 --mcap played.mcap");
    let part = rher.path("played.part.mcap");
    while std::fs::metadata(&part).map_or(0, |file| file.len()) < 100_000 {
        std::thread::sleep(Duration::from_millis(2));
    }
    running.interrupt();
    let ran = running.end();
    assert_eq!(ran.status, Some(130), "{ran}");
    assert!(rher.ok("replay played.mcap --verify").starts_with("verified: "));
}

#[test]
fn finished_episodes_survive_a_kill() {
    let rher = Rher::new();
    long_run(&rher).kill();
    let part = rher.path("run/episodes-0.part.mcap");
    assert!(!rher.path("run/episodes-0.mcap").exists());
    let ran = rher.run("replay run/episodes-0.part.mcap --verify");
    assert_eq!(ran.status, Some(0), "{ran}");
    assert!(ran.stderr.contains("warning: `run/episodes-0.part.mcap` is not finished"), "{ran}");
    let whole = episodes_of(&ran.stdout);
    assert!(whole >= 3, "{ran}");
    rher.ok("export run/episodes-0.part.mcap --format minari --out dataset");
    let episodes = std::fs::read_dir(rher.path("dataset/data")).unwrap().count() - 1;
    assert_eq!(episodes, whole);

    if let Some(python) = python() {
        let file = read(python, &part, &["--cut-off"]);
        let steps = file["steps"].as_array().unwrap();
        for episode in 0..whole {
            for step in 0..=50 {
                assert!(steps.contains(&json!([episode, step])), "episode {episode}, step {step}");
            }
        }
    }

    // Whoever resumes the run finishes the recording, also without `--record-every`.
    rher.ok("train --resume run --env-steps 1");
    assert!(!part.exists());
    let proof = rher.ok("replay run/episodes-0.mcap --verify");
    assert_eq!(episodes_of(&proof), whole, "{proof}");
}

/// How many episodes a proof is about.
fn episodes_of(proof: &str) -> usize {
    let number = proof.split_whitespace().nth(1).and_then(|number| number.parse().ok());
    number.unwrap_or_else(|| panic!("{proof}"))
}

/// Recordings of earlier versions stay readable; `README.md` beside them says how they were made.
#[test]
fn recordings_of_earlier_versions_are_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/recordings-0.1.0");
    let rher = Rher::new();
    for (name, task, steps, seed, widths) in [
        ("reach.mcap", "reach", 50, 14_696_778_235_840_051_812, [10, 4]),
        ("cue-push.mcap", "cue-push", 20, 14_696_778_235_840_051_812, [18, 3]),
        ("push.part.mcap", "push", 50, 7_875_952_635_008_868_715, [25, 4]),
    ] {
        let path = folder.join(name);
        let mut recording = rher_record::Recording::open(&path).unwrap();
        assert_eq!(recording.info.task, task);
        assert_eq!(recording.info.rher, "0.1.0");
        let episode = recording.next().unwrap().unwrap();
        assert_eq!((episode.script.number, episode.script.seed), (0, seed));
        let found = [episode.end().observation.len(), episode.actions[0].action.len()];
        assert_eq!((episode.actions.len(), found), (steps, widths), "{name}");
        assert!(recording.next().is_none());

        let list = rher.ok(&format!("replay {}", path.display()));
        assert!(list.contains(&format!("on `{task}`, recorded by rher 0.1.0")), "{list}");
        for format in ["minari", "lerobot"] {
            let (path, out) = (path.display(), format!("{task}-{format}"));
            rher.ok(&format!("export {path} --format {format} --out {out}"));
        }
    }
}

#[test]
fn two_recordings_of_one_name_do_not_disturb_each_other() {
    let rher = recorded("push", "");
    let play = "play run --episodes 200 --mcap both.mcap";
    for ran in [rher.spawn(play), rher.spawn(play)].map(crate::support::Running::end) {
        assert_eq!(ran.status, Some(0), "{ran}");
    }
    let list = rher.ok("replay both.mcap");
    assert!(list.starts_with("200 episodes"), "{list}");
    let left = std::fs::read_dir(rher.path("")).unwrap();
    let left = left
        .filter(|entry| entry.as_ref().unwrap().file_name().to_string_lossy().contains(".part."));
    assert_eq!(left.count(), 0);

    // What a killed process leaves behind is gone after the next one.
    rher.write("again.part.mcap", "left behind");
    rher.ok("play run --episodes 1 --mcap again.mcap");
    assert!(!rher.path("again.part.mcap").exists());
    assert!(rher.ok("replay again.mcap").starts_with("1 episodes"));
}

#[test]
fn training_continues_without_a_recording_that_cannot_be_written() {
    let rher = Rher::new();
    // 100 kB in blocks of 512 bytes: less than the recording, more than every other file.
    let ran = shell(
        &rher,
        &format!(
            "trap '' XFSZ; ulimit -f 200; \
             exec \"$RHER\" train reach --env-steps 1000 --record-every 1 --out run {TINY}"
        ),
    );
    assert_eq!(ran.status, Some(0), "{ran}");
    assert!(ran.stderr.contains("warning: recording has stopped, training continues"), "{ran}");
    assert_eq!(rher.metrics("run").last().unwrap()["env_steps"], 1000);
    // Whole episodes are kept, and finished by the next run in the folder.
    assert!(rher.ok("replay run/episodes-0.part.mcap --verify").starts_with("verified: "), "{ran}");
    rher.ok("train --resume run --env-steps 1500");
    assert!(rher.ok("replay run/episodes-0.mcap --verify").starts_with("verified: "));
}

#[test]
fn a_full_disk_has_its_own_exit_status() {
    let rher = recorded("push", "");
    std::fs::create_dir(rher.path("full")).unwrap();
    let full = "mount -t tmpfs -o size=100k none full";
    if shell(&rher, &format!("unshare -m sh -c '{full}'")).status != Some(0) {
        python::ignored("a full disk takes the right to mount one");
        return;
    }
    for command in [
        "play run --episodes 20 --mcap full/out.mcap",
        "export run --format minari --episodes 20 --out full/minari",
        "export run --format lerobot --episodes 20 --out full/lerobot",
    ] {
        let left = "ls full | wc -l";
        let script = format!(
            "unshare -m sh -c '{full}; \"$RHER\" {command}; status=$?; {left}; exit $status'"
        );
        let ran = shell(&rher, &script);
        assert_eq!(ran.status, Some(7), "{command}: {ran}");
        assert!(ran.stderr.contains("free some space, and repeat the command"), "{command}: {ran}");
        assert_eq!(ran.stdout.trim(), "0", "{command} left something behind");
    }
}

/// Changes the length of the first text in the metadata record to one beyond everything.
fn with_a_long_text(bytes: &[u8]) -> Vec<u8> {
    let text = b"reach_distance";
    let at = bytes.windows(text.len()).position(|window| window == text).unwrap();
    let mut changed = bytes.to_vec();
    changed[at - 4..at].copy_from_slice(&0xffff_fff0_u32.to_le_bytes());
    changed
}

#[test]
fn lengths_in_a_file_ask_for_no_more_memory_than_the_file_has() {
    let rher = recorded("push", "");
    let bytes = std::fs::read(rher.path("out.mcap")).unwrap();
    rher.write("text.mcap", with_a_long_text(&bytes));
    // A record of 255 MB, behind the magic and the opcode of the header.
    let mut record = bytes;
    record[9..17].copy_from_slice(&0x0ff0_0000_u64.to_le_bytes());
    rher.write("record.mcap", record);
    for file in ["text.mcap", "record.mcap"] {
        let ran = shell(&rher, &format!("ulimit -v 200000; exec \"$RHER\" replay {file}"));
        assert_eq!(ran.status, Some(11), "{file}: {ran}");
        assert!(ran.stderr.contains(&format!("`{file}` is damaged")), "{ran}");
    }
}

/// The least address space, in kB, in which a command succeeds, to 8 MB.
fn needs(rher: &Rher, command: &str) -> usize {
    let fits = |kilobytes: usize| {
        let script = format!("ulimit -v {kilobytes}; exec \"$RHER\" {command} 2>/dev/null");
        shell(rher, &script).status == Some(0)
    };
    let steps = (1..200).map(|step| 8_000 * step);
    steps.into_iter().find(|kilobytes| fits(*kilobytes)).unwrap_or_else(|| panic!("{command}"))
}

#[test]
fn long_recordings_take_no_more_memory_than_short_ones() {
    let rher = recorded("tpush", "");
    rher.ok("play run --episodes 300 --mcap long.mcap");
    for command in ["replay", "replay --verify", "export --format lerobot --out FOLDER"] {
        let on = |file: &str| {
            let command = command.replace("FOLDER", &format!("{file}.dataset"));
            let kilobytes = needs(&rher, &format!("{command} {file}"));
            let _ = std::fs::remove_dir_all(rher.path(format!("{file}.dataset")));
            kilobytes
        };
        let [short, long] = ["out.mcap", "long.mcap"].map(on);
        // The file has 15 MB; as objects its messages take 90.
        assert!(long <= short + 32_000, "{command}: {short} kB for 3 episodes, {long} kB for 300");
    }
}

#[test]
fn bad_recordings_are_told_apart() {
    let rher = recorded("push", "");
    let bytes = std::fs::read(rher.path("out.mcap")).unwrap();
    rher.write("text.mcap", "not a recording");
    rher.write("empty.mcap", "");
    rher.write("cut.mcap", &bytes[..bytes.len() / 2]);
    let mut damaged = bytes.clone();
    damaged[bytes.len() / 2] ^= 0x40;
    rher.write("damaged.mcap", damaged);
    let mut writer = mcap::Writer::new(std::fs::File::create(rher.path("foreign.mcap")).unwrap());
    writer.as_mut().unwrap().finish().unwrap();
    for (file, problem, hint) in [
        ("missing.mcap", "cannot read `missing.mcap`", "rher play RUN --mcap FILE"),
        ("text.mcap", "`text.mcap` is not an MCAP file", "rher play RUN --mcap FILE"),
        ("empty.mcap", "`empty.mcap` is not an MCAP file", "rher play RUN --mcap FILE"),
        (
            "cut.mcap",
            "`cut.mcap` is cut off after 1 whole episodes",
            "if it is named `cut.part.mcap`",
        ),
        ("damaged.mcap", "`damaged.mcap` is damaged: ", "record it again"),
        ("foreign.mcap", "`foreign.mcap` was not recorded by this program", "rher play RUN"),
    ] {
        for command in ["replay", "replay --verify"] {
            let ran = rher.run(&format!("{command} {file}"));
            assert_eq!(ran.status, Some(11), "{ran}");
            assert!(ran.stderr.contains(problem) && ran.stderr.contains(hint), "{ran}");
        }
    }
}

/// Whatever a flipped bit says, be it how long a record is, it is told and not obeyed.
#[test]
fn no_flipped_bit_brings_the_reader_down() {
    let rher = recorded("push", "");
    let path = rher.path("out.mcap");
    let bytes = std::fs::read(&path).unwrap();
    let mut told = 0;
    let places = (8..bytes.len()).step_by(bytes.len() / 150);
    for place in places.clone() {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x40;
        std::fs::write(&path, damaged).unwrap();
        let read = rher_record::Recording::open(&path);
        told += usize::from(!read.is_ok_and(|mut episodes| episodes.all(|it| it.is_ok())));
    }
    assert!(told > places.len() / 2, "{told} of {}", places.len());
}

#[test]
fn a_recording_that_cannot_be_made_leaves_nothing_behind() {
    let rher = recorded("push", "");
    let files = || std::fs::read_dir(rher.path("")).unwrap().count();
    let before = files();
    for (arguments, status) in [
        ("play run --mcap nowhere/out.mcap", 6),
        ("play run --mcap out.txt", 2),
        ("play run --mcap out.mcap --episodes 0", 2),
        ("play nowhere --mcap new.mcap", 5),
        ("train push --out other --record-every 0", 2),
    ] {
        let ran = rher.run(arguments);
        assert_eq!(ran.status, Some(status), "{arguments}: {ran}");
        assert_eq!(files(), before, "{arguments}");
    }
}
