#!/usr/bin/env bash
# Rapier 0.36.1 (Parry 0.31.1): a box that slides over two flush cuboids is stopped where they meet,
# for as long as it is pushed. `CompoundFlags::FIX_INTERNAL_EDGES` changes nothing about a compound
# of the two, because contacts of cuboids with cuboids ignore what it computes. On a closed triangle
# mesh with `TriMeshFlags::ORIENTED | TriMeshFlags::FIX_INTERNAL_EDGES` fewer strokes are stopped,
# but some are: a triangle with an edge of the mesh on one side accepts sideways contacts at its flat
# sides, too.
#
# A good guess: each of the two flags makes flush parts flat.
#
# Seen:
#   of 162 strokes stop
#   one cuboid: 0
#   two flush cuboids: 162
#   compound of two: 72
#   the same, internal edges fixed: 72
#   mesh, internal edges fixed: 27
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/src"
cat > "$folder/Cargo.toml" <<'TOML'
[package]
name = "flush"
version = "0.0.0"
edition = "2024"

[dependencies]
rapier3d = { version = "=0.36.1", features = ["enhanced-determinism"] }
parry3d = "=0.31.1"
TOML
cat > "$folder/src/main.rs" <<'RUST'
use rapier3d::parry::shape::{Compound, CompoundFlags};
use rapier3d::prelude::*;

/// Half the edges of each of two boxes, which meet at x = 0; their top is at z = 0.
const HALF: Vector = Vector::new(0.1, 0.1, 0.04);

fn main() {
    println!("of {} strokes stop", strokes().len());
    let count = |name, ground: fn() -> Vec<ColliderBuilder>| {
        let stopped = strokes().iter().filter(|stroke| stops(ground(), stroke)).count();
        println!("{name}: {stopped}");
        stopped
    };
    assert_eq!(count("one cuboid", one), 0, "the strokes are wrong");
    let flush = count("two flush cuboids", two);
    let plain = count("compound of two", || compound(CompoundFlags::empty()));
    let fixed = count("the same, internal edges fixed", || {
        compound(CompoundFlags::FIX_INTERNAL_EDGES)
    });
    let mesh = count("mesh, internal edges fixed", mesh);
    let as_seen = flush > 0 && fixed > 0 && fixed == plain && mesh > 0;
    assert!(as_seen, "Rapier behaves differently now");
}

/// Where the middle of a box is aside of the middle of the ground, the direction in which it goes,
/// the force that presses on it, and the force that pulls it as multiple of its friction.
fn strokes() -> Vec<[f32; 4]> {
    let mut strokes = Vec::new();
    for aside in [-0.08, -0.06, -0.04, -0.02, 0.0, 0.02, 0.04, 0.06, 0.08] {
        for way in [-1.0, 1.0] {
            for press in [5.0, 10.0, 20.0] {
                for pull in [1.5, 2.0, 3.0] {
                    strokes.push([aside, way, press, pull]);
                }
            }
        }
    }
    strokes
}

fn cuboid(middle: f32, half: f32) -> ColliderBuilder {
    ColliderBuilder::cuboid(half, HALF.y, HALF.z).translation(Vector::new(middle, 0.0, -HALF.z))
}

fn one() -> Vec<ColliderBuilder> {
    vec![cuboid(0.0, 2.0 * HALF.x)]
}

fn two() -> Vec<ColliderBuilder> {
    vec![cuboid(-HALF.x, HALF.x), cuboid(HALF.x, HALF.x)]
}

fn compound(flags: CompoundFlags) -> Vec<ColliderBuilder> {
    let part = |x| {
        let place = Pose::from_translation(Vector::new(x, 0.0, -HALF.z));
        (place, SharedShape::cuboid(HALF.x, HALF.y, HALF.z))
    };
    let parts = vec![part(-HALF.x), part(HALF.x)];
    let shape = Compound::with_flags(parts, flags, None);
    vec![ColliderBuilder::new(SharedShape::new(shape))]
}

/// The surface of both boxes: every quad is two triangles.
fn mesh() -> Vec<ColliderBuilder> {
    let corner = |x: i32, y: i32, z: i32| {
        Vector::new(x as f32 * 2.0 * HALF.x, y as f32 * HALF.y, (z - 1) as f32 * HALF.z)
    };
    let mut quads = Vec::new();
    for x in [-1, 0] {
        let next = x + 1;
        quads.push([corner(x, -1, 1), corner(next, -1, 1), corner(next, 1, 1), corner(x, 1, 1)]);
        quads.push([corner(x, 1, -1), corner(next, 1, -1), corner(next, -1, -1), corner(x, -1, -1)]);
        quads.push([corner(x, -1, -1), corner(next, -1, -1), corner(next, -1, 1), corner(x, -1, 1)]);
        quads.push([corner(x, 1, 1), corner(next, 1, 1), corner(next, 1, -1), corner(x, 1, -1)]);
    }
    quads.push([corner(-1, -1, -1), corner(-1, -1, 1), corner(-1, 1, 1), corner(-1, 1, -1)]);
    quads.push([corner(1, -1, 1), corner(1, -1, -1), corner(1, 1, -1), corner(1, 1, 1)]);
    let vertices: Vec<Vector> = quads.iter().flatten().copied().collect();
    let firsts = (0..vertices.len() as u32).step_by(4);
    let triangles = firsts.flat_map(|a| [[a, a + 1, a + 2], [a, a + 2, a + 3]]).collect();
    let flags = TriMeshFlags::ORIENTED | TriMeshFlags::FIX_INTERNAL_EDGES;
    vec![ColliderBuilder::trimesh_with_flags(vertices, triangles, flags).unwrap()]
}

/// Whether a box of 3 kg that cannot turn is at rest before it is half a box past the seam.
fn stops(ground: Vec<ColliderBuilder>, [aside, way, press, pull]: &[f32; 4]) -> bool {
    let (mut bodies, mut colliders) = (RigidBodySet::new(), ColliderSet::new());
    for part in ground {
        colliders.insert(part.friction(1.0));
    }
    let half = Vector::new(0.0135, 0.0149, 0.0385);
    let start = Vector::new(-0.08 * way, *aside, half.z);
    let body = RigidBodyBuilder::dynamic().translation(start).lock_rotations().gravity_scale(0.0);
    let body = bodies.insert(body.can_sleep(false));
    let shape = ColliderBuilder::cuboid(half.x, half.y, half.z).mass(3.0).friction(1.0);
    colliders.insert_with_parent(shape, body, &mut bodies);
    let parameters = IntegrationParameters { dt: 0.01, length_unit: 0.1, ..Default::default() };
    let mut pipeline = PhysicsPipeline::new();
    let mut islands = IslandManager::new();
    let (mut broad, mut narrow) = (BroadPhaseBvh::new(), NarrowPhase::new());
    let (mut joints, mut multibodies) = (ImpulseJointSet::new(), MultibodyJointSet::new());
    let (mut soft, mut ccd) = (SoftBodySet::new(), CCDSolver::new());
    for step in 0..1000 {
        let moving = &mut bodies[body];
        moving.reset_forces(true);
        // Against friction, and so damped that it creeps.
        let drag = -moving.linvel() * 20.0;
        let force = Vector::new(press * pull * way, 0.0, -press);
        moving.add_force(force + Vector::new(drag.x, 0.0, 0.0), true);
        pipeline.step(
            Vector::ZERO,
            &parameters,
            &mut islands,
            &mut broad,
            &mut narrow,
            &mut bodies,
            &mut colliders,
            &mut joints,
            &mut multibodies,
            &mut soft,
            &mut ccd,
            &(),
            &(),
        );
        let moving = &bodies[body];
        if moving.translation().x * way > 2.0 * half.x {
            return false;
        }
        if step > 20 && moving.linvel().x * way < 1e-4 {
            return true;
        }
    }
    panic!("a stroke has no end: {aside} {way} {press} {pull} at {:?}", bodies[body].translation());
}
RUST
cargo run --quiet --release --manifest-path "$folder/Cargo.toml"
