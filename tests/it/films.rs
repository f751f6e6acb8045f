//! `rher play`: its pictures and its films.

use crate::figures::{count, pixels};
use crate::support::{Ran, Rher, TINY};
use insta::assert_snapshot;
use std::process::Command;

#[test]
fn play_draws_every_step_and_a_moving_picture() {
    let rher = Rher::new();
    rher.ok(&format!("train cue-push {TINY} --env-steps 500 --out run --quiet"));
    let ran = rher.run("play run --episodes 2 --film two.gif --png-dir steps");
    assert_eq!(ran.status, Some(0), "{ran}");
    for text in
        ["film  two.gif (400 × 300 pixels, 42 pictures, ", "steps (400 × 300 pixels, 42 files)"]
    {
        assert!(ran.stderr.contains(text), "{ran}");
    }
    let gif = std::fs::read(rher.path("two.gif")).unwrap();
    assert!(gif.starts_with(b"GIF89a") && gif.ends_with(b";"), "{} bytes", gif.len());
    assert!(gif.len() < 400_000, "{} bytes", gif.len());
    let files = std::fs::read_dir(rher.path("steps")).unwrap().count();
    assert_eq!(files, 2 * (20 + 1));
    let (width, height, colors) =
        pixels(&std::fs::read(rher.path("steps/episode-001-step-020.png")).unwrap());
    assert_eq!((width, height), (400, 300));
    assert!(count(&colors, |[r, g, b]| *r > 120 && *g < 90 && *b < 90) > 50, "a red cylinder");
    // What is said of the step and of the sub-task is in white and in the color of the object.
    let caption = &colors[..20 * 400];
    assert!(count(caption, |[r, g, b]| *r > 200 && *g > 200 && *b > 200) > 100, "white letters");
    assert!(count(caption, |[r, g, b]| *r > 150 && *g < 150 && *b < 150) > 20, "red letters");
    for wrong in ["--gif nowhere/x.gif", "--film nowhere/x.mp4"] {
        let ran = rher.run(&format!("play run {wrong}"));
        assert_eq!(ran.status, Some(6), "{ran}");
    }
}

#[test]
fn cameras_and_sizes_are_chosen() {
    let rher = Rher::new();
    rher.ok(&format!("train reach {TINY} --env-steps 500 --out run --quiet"));
    let picture = |options: &str| {
        rher.ok(&format!("play run --png-dir steps {options}"));
        pixels(&std::fs::read(rher.path("steps/episode-000-step-000.png")).unwrap())
    };
    let default = picture("");
    assert_eq!(default, picture("--camera corner --size 400x300"));
    for camera in ["front", "side", "top", "close"] {
        assert_ne!(default.2, picture(&format!("--camera {camera}")).2, "{camera}");
    }
    let (width, height, _) = picture("--size 120x640");
    assert_eq!((width, height), (120, 640));
    for (wrong, says) in [
        ("--film x.gif --camera nose", "corner, front, side, top, close"),
        ("--film x.gif --size 400", "each from 64 to 3840, as in `400x300`"),
        ("--film x.gif --size 400x9000", "each from 64 to 3840, as in `400x300`"),
        ("--film x.avi", "expected a name that ends in `.gif`, `.mp4` or `.webm`"),
        ("--film x", "expected a name that ends in `.gif`, `.mp4` or `.webm`"),
        ("--camera top", "--film <FILE>|--png-dir <DIR>"),
        ("--trim --png-dir steps", "--film <FILE>"),
    ] {
        let ran = rher.run(&format!("play run {wrong}"));
        assert_eq!(ran.status, Some(2), "{ran}");
        assert!(ran.stderr.contains(says), "{ran}");
    }
    assert!(!rher.path("x.gif").exists() && !rher.path("x.avi").exists());
}

#[test]
fn films_are_piped_through_ffmpeg() {
    let rher = Rher::new();
    rher.ok(&format!("train cue-push {TINY} --env-steps 500 --out run --quiet"));
    let play = |file: &str, path: &str| -> Ran {
        let mut command = rher.command(&format!("play run --film {file} --size 64x65"));
        command.env("PATH", path).output().unwrap().into()
    };
    let path = std::env::var("PATH").unwrap();
    let with = |script: &str| {
        rher.write("bin/ffmpeg", format!("#!/bin/sh\n{script}\n"));
        let executable = std::os::unix::fs::PermissionsExt::from_mode(0o755);
        std::fs::set_permissions(rher.path("bin/ffmpeg"), executable).unwrap();
        format!("{}:{path}", rher.path("bin").display())
    };
    std::fs::create_dir(rher.path("bin")).unwrap();

    // Instead of encoding, writes its arguments and what comes in.
    let copies =
        with("printf '%s ' \"$@\" > arguments; cat > frames; for out; do :; done; cp frames $out");
    for (file, format) in [("a.mp4", "-f mp4"), ("a.webm", "-f webm")] {
        let ran = play(file, &copies);
        assert_eq!(ran.status, Some(0), "{ran}");
        assert!(
            ran.stderr.contains(&format!("film  {file} (64 × 65 pixels, 21 pictures")),
            "{ran}"
        );
        let frames = std::fs::read(rher.path(file)).unwrap();
        // The last of 21 pictures is shown for a second.
        assert_eq!(frames.len(), 3 * 64 * 65 * (21 + 24));
        let arguments = std::fs::read_to_string(rher.path("arguments")).unwrap();
        for part in [format, "-video_size 64x65", "-pixel_format rgb24", "-framerate 25"] {
            assert!(arguments.contains(part), "{arguments}");
        }
    }

    let before = std::fs::read(rher.path("a.mp4")).unwrap();
    let fails = with("echo 'Unknown encoder' >&2; exit 1");
    assert_snapshot!(play("a.mp4", &fails), @"
    exit 6
    error: cannot write `a.mp4`: `ffmpeg` failed: Unknown encoder

    hint: try another format; a name that ends in `.gif` needs no other program
    ");
    assert_snapshot!(play("a.mp4", "nowhere"), @"
    exit 6
    error: cannot write `a.mp4`: `ffmpeg`, which makes such files, is not on PATH

    hint: install `ffmpeg`, or choose a name that ends in `.gif`, which needs no other program
    ");
    assert_eq!(std::fs::read(rher.path("a.mp4")).unwrap(), before, "the file is as it was");
    let names = std::fs::read_dir(rher.path("")).unwrap();
    let names = names.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    assert!(names.into_iter().all(|name| !name.starts_with('.')), "nothing is left behind");

    // What the real one writes, where there is one.
    if Command::new("ffmpeg").arg("-version").output().is_ok() {
        for (file, start) in [("b.mp4", "....ftyp"), ("b.webm", "\u{1a}E")] {
            let ran = play(file, &path);
            assert_eq!(ran.status, Some(0), "{ran}");
            let film = std::fs::read(rher.path(file)).unwrap();
            let begins = film.iter().zip(start.bytes()).all(|(a, b)| b == b'.' || *a == b);
            assert!(begins && film.len() > 1000, "{file}: {:?}", &film[..12]);
        }
    }
}
