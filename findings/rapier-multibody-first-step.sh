#!/usr/bin/env bash
# Rapier 0.36.1: a multibody whose root is a fixed body has six degrees of freedom too many until the
# first step, those of a free root: `apply_displacements` moves the root by the angles that were meant
# for the joints. And later a motor of a multibody that is asleep can be given a new target without
# effect: `MultibodyJointSet::get_mut` wakes nobody, unlike `ImpulseJointSet::get_mut` with its
# `wake_up_connected_bodies`.
#
# A good guess: a fixed root has no degree of freedom from the beginning, and an arm that is given a
# new target moves.
#
# Seen:
#   degrees of freedom: 7 before the first step, 1 after it
#   an angle of 1 rad is set before it: the joint is at 0.00 rad
#   asleep: true; a second after the new target of 1 rad the joint is at 0.00 rad
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/src"
cat > "$folder/Cargo.toml" <<'TOML'
[package]
name = "first"
version = "0.0.0"
edition = "2024"

[dependencies]
rapier3d = { version = "=0.36.1", features = ["enhanced-determinism"] }
TOML
cat > "$folder/src/main.rs" <<'RUST'
use rapier3d::prelude::*;

fn main() {
    let (mut bodies, mut colliders) = (RigidBodySet::new(), ColliderSet::new());
    let root = bodies.insert(RigidBodyBuilder::fixed());
    let rod = bodies.insert(RigidBodyBuilder::dynamic().translation(Vector::new(0.5, 0.0, 0.0)));
    colliders.insert_with_parent(ColliderBuilder::cuboid(0.4, 0.05, 0.05), rod, &mut bodies);
    let hinge = RevoluteJointBuilder::new(Vector::Z)
        .local_anchor2(Vector::new(-0.5, 0.0, 0.0))
        .motor_position(0.0, 100.0, 20.0);
    let mut multibodies = MultibodyJointSet::new();
    let hinge = multibodies.insert(root, rod, hinge, true).unwrap();

    let (arm, link) = multibodies.get_mut(hinge).unwrap();
    let before = arm.ndofs();
    let mut angles = vec![0.0; before];
    angles[0] = 1.0;
    arm.apply_displacements(&angles);
    let set = arm.link(link).unwrap().joint.coords()[3];
    // Back, to go on from the rest.
    angles[0] = -1.0;
    arm.apply_displacements(&angles);

    let parameters = IntegrationParameters::default();
    let mut pipeline = PhysicsPipeline::new();
    let mut islands = IslandManager::new();
    let (mut broad, mut narrow) = (BroadPhaseBvh::new(), NarrowPhase::new());
    let (mut joints, mut soft, mut ccd) =
        (ImpulseJointSet::new(), SoftBodySet::new(), CCDSolver::new());
    let mut steps = |count, bodies: &mut RigidBodySet, multibodies: &mut MultibodyJointSet| {
        for _ in 0..count {
            pipeline.step(
                Vector::ZERO,
                &parameters,
                &mut islands,
                &mut broad,
                &mut narrow,
                bodies,
                &mut colliders,
                &mut joints,
                multibodies,
                &mut soft,
                &mut ccd,
                &(),
                &(),
            );
        }
    };
    steps(1, &mut bodies, &mut multibodies);
    let after = multibodies.get(hinge).unwrap().0.ndofs();
    println!("degrees of freedom: {before} before the first step, {after} after it");
    println!("an angle of 1 rad is set before it: the joint is at {set:.2} rad");

    steps(600, &mut bodies, &mut multibodies);
    let asleep = bodies[rod].is_sleeping();
    let (arm, link) = multibodies.get_mut(hinge).unwrap();
    let data = &mut arm.link_mut(link).unwrap().joint.data;
    data.set_motor_position(JointAxis::AngX, 1.0, 100.0, 20.0);
    steps(60, &mut bodies, &mut multibodies);
    let angle = bodies[rod].rotation().to_scaled_axis().z;
    println!(
        "asleep: {asleep}; a second after the new target of 1 rad the joint is at {angle:.2} rad"
    );
    let seen = (before, after, set == 0.0, asleep, angle.abs() < 0.01);
    assert_eq!(seen, (7, 1, true, true, true), "Rapier behaves differently now");

    // The same target moves it once it is awake.
    bodies[rod].wake_up(true);
    steps(60, &mut bodies, &mut multibodies);
    assert!(bodies[rod].rotation().to_scaled_axis().z > 0.5, "the motor is set wrongly");
}
RUST
cargo run --quiet --release --manifest-path "$folder/Cargo.toml"
