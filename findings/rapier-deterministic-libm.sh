#!/usr/bin/env bash
# rapier3d 0.36.1 with its feature `enhanced-determinism`: a program that steps one body of two boxes
# still takes functions of the C library, whose last bits differ between systems: for the principal
# axes of the body, and for how much of a tree of boxes is rebuilt.
#
# A good guess: the feature, which is there for the same results on every machine, takes all of them
# from the crate libm.
#
# Seen, on x86-64 Linux, among the undefined symbols of the program:
#   acosf cosf log2f
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/src"
cat > "$folder/Cargo.toml" <<'TOML'
[package]
name = "boxes"
version = "0.0.0"
edition = "2024"

[dependencies]
rapier3d = { version = "=0.36.1", default-features = false, features = ["dim3", "f32", "std", "enhanced-determinism"] }

[profile.release]
lto = true
TOML
cat > "$folder/src/main.rs" <<'RUST'
use rapier3d::prelude::*;

fn main() {
    let mut world = PhysicsWorld::new();
    let cuboid = |x: f32| ColliderBuilder::cuboid(0.1, 0.2, 0.3).translation(Vector::new(x, 0.0, 0.0));
    let body = world.insert_body(RigidBodyBuilder::dynamic());
    world.insert_collider(cuboid(0.0), Some(body));
    world.insert_collider(cuboid(0.3), Some(body));
    for _ in 0..100 {
        world.step();
    }
    println!("{:?}", world.bodies[body].translation());
}
RUST
cargo build --quiet --release --manifest-path "$folder/Cargo.toml"
found=$(nm --dynamic --undefined-only "$folder/target/release/boxes" \
  | grep --only-matching --extended-regexp '\b(acosf|cosf|log2f)\b' | sort --unique | xargs)
echo "functions of the C library: $found"
if [ "$found" != "acosf cosf log2f" ]; then
  echo "error: Rapier behaves differently now" >&2
  exit 1
fi
