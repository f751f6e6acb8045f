#!/usr/bin/env bash
# rapier3d-urdf 0.36.1: a link whose mesh is not found gets no collider, and nothing says so: no error
# and no warning in the log. `package://` is joined to the folder as it stands, so this is what becomes
# of every robot of ROS, and of the Panda that PyBullet ships.
#
# A good guess: `from_file` fails, or leaves an error in the log, as it does where meshes are disabled; or `package://` is resolved.
#
# Seen:
#   meshes/box.obj: 1 colliders, log: []
#   package://meshes/box.obj: 0 colliders, log: []
#   meshes/missing.obj: 0 colliders, log: []
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/src" "$folder/meshes"
cat > "$folder/meshes/box.obj" <<'OBJ'
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
OBJ
cat > "$folder/Cargo.toml" <<'TOML'
[package]
name = "meshes"
version = "0.0.0"
edition = "2024"

[dependencies]
log = "0.4"
rapier3d = { version = "=0.36.1", features = ["enhanced-determinism"] }
rapier3d-urdf = { version = "=0.36.1", features = ["wavefront"] }
TOML
cat > "$folder/src/main.rs" <<'RUST'
use rapier3d_urdf::{UrdfLoaderOptions, UrdfRobot};
use std::sync::Mutex;

static LOG: Mutex<Vec<String>> = Mutex::new(Vec::new());

struct Keep;

impl log::Log for Keep {
    fn enabled(&self, _: &log::Metadata) -> bool {
        true
    }

    fn log(&self, record: &log::Record) {
        LOG.lock().unwrap().push(record.args().to_string());
    }

    fn flush(&self) {}
}

fn main() {
    log::set_logger(&Keep).unwrap();
    log::set_max_level(log::LevelFilter::Warn);
    let folder = std::env::args().nth(1).unwrap();
    let names = ["meshes/box.obj", "package://meshes/box.obj", "meshes/missing.obj"];
    let found = names.map(|name| {
        let link = format!(
            r#"<robot name="one"><link name="base"><collision><geometry>
               <mesh filename="{name}"/></geometry></collision></link></robot>"#
        );
        let file = format!("{folder}/one.urdf");
        std::fs::write(&file, link).unwrap();
        let (robot, _) = UrdfRobot::from_file(&file, UrdfLoaderOptions::default(), None).unwrap();
        let colliders = robot.links[0].colliders.len();
        let log = std::mem::take(&mut *LOG.lock().unwrap());
        println!("{name}: {colliders} colliders, log: {log:?}");
        (colliders, log.len())
    });
    assert_eq!(found, [(1, 0), (0, 0), (0, 0)], "rapier3d-urdf behaves differently now");
}
RUST
cargo run --quiet --release --manifest-path "$folder/Cargo.toml" -- "$folder"
