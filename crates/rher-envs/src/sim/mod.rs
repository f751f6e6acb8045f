//! The physics: one Rapier world around one gripper.
//!
//! Rapier and its math stay inside this module; what leaves it speaks nalgebra.

mod cabinet;
mod gripper;
mod scenery;

pub(crate) use cabinet::Cabinet;
pub(crate) use gripper::{Fingers, Grip};
pub(crate) use scenery::{BLOCK_EDGE, OBSTACLE_HALF, PLATE_HEIGHT, PUCK_HEIGHT};

use gripper::{Gripper, HandRange};
use nalgebra::{ComplexField, Point3, Quaternion, UnitQuaternion, Vector3};
use rapier3d::prelude::{
    BroadPhaseBvh, CCDSolver, ColliderSet, FrictionModel, ImpulseJointSet, IntegrationParameters,
    IslandManager, MultibodyJointSet, NarrowPhase, PhysicsPipeline, Pose, RigidBodyHandle,
    RigidBodySet, Rotation, SoftBodySet, SpringCoefficients, Vector,
};
use rher_core::goal::Position;

/// Duration of an environment step, in seconds: 20 `MuJoCo` steps of 2 ms in the Fetch environments.
pub(crate) const STEP_SECONDS: f32 = 0.04;

/// Collision detections in an environment step.
const SUBSTEPS: u8 = 4;

/// Seconds between collision detections.
const SUBSTEP_SECONDS: f32 = STEP_SECONDS / SUBSTEPS as f32;

/// Solver substeps between collision detections.
const SOLVER_ITERATIONS: u8 = 4;

/// Stiffness of contacts, in hertz: stacks jitter above a quarter of the solver's own frequency.
const CONTACT_FREQUENCY: f32 = 0.25 * SUBSTEPS as f32 * SOLVER_ITERATIONS as f32 / STEP_SECONDS;

/// Damping ratio of contacts.
const CONTACT_DAMPING: f32 = 10.0;

/// Typical size of things, in metres.
///
/// With Rapier's default of 1 m a block hovers when its centre is past the table's edge: contact
/// points are re-used until a pair has moved by a twentieth of this.
const LENGTH_UNIT: f32 = 0.1;

/// Metres per second squared.
const GRAVITY: f32 = 9.81;

/// A gripper and the things around it.
pub struct World {
    /// Scratch memory of the solver, without influence on what it computes.
    pipeline: PhysicsPipeline,
    parameters: IntegrationParameters,
    multibody_joints: MultibodyJointSet,
    soft_bodies: SoftBodySet,
    state: State,
    initial: State,
}

/// Everything that changes in a [`World`]: equal states have bitwise equal futures.
#[derive(Clone)]
pub(crate) struct State {
    islands: IslandManager,
    broad_phase: BroadPhaseBvh,
    narrow_phase: NarrowPhase,
    bodies: RigidBodySet,
    colliders: ColliderSet,
    joints: ImpulseJointSet,
    continuous: CCDSolver,
    gripper: Gripper,
}

/// A thing in a [`World`] that is placed when an episode begins.
#[derive(Clone, Copy)]
pub(crate) struct Body(RigidBodyHandle);

/// Where a [`Body`] is and how it moves, in the world frame.
#[derive(Clone, Copy)]
pub(crate) struct Motion {
    /// Centre, in metres.
    pub(crate) position: Position,
    /// Orientation; a block starts with none.
    pub(crate) rotation: UnitQuaternion<f32>,
    /// Metres per second.
    pub(crate) velocity: Vector3<f32>,
    /// Radians per second.
    pub(crate) spin: Vector3<f32>,
}

impl World {
    /// A gripper with its grip centre at `home`, over a floor at height 0, with what `furnish`
    /// adds to it.
    pub(crate) fn new<T>(
        fingers: Fingers,
        home: Position,
        furnish: impl FnOnce(&mut Scenery) -> T,
    ) -> (Self, T) {
        let mut bodies = RigidBodySet::new();
        let mut colliders = ColliderSet::new();
        let mut joints = ImpulseJointSet::new();
        let mut gripper =
            Gripper::new(fingers, glam(home.coords), &mut bodies, &mut colliders, &mut joints);
        let mut scenery = Scenery {
            bodies,
            colliders,
            joints,
            robot: Vector3::zeros(),
            hand_range: HandRange::default(),
        };
        scenery.floor();
        let furniture = furnish(&mut scenery);
        gripper.stand_at(glam(scenery.robot));
        gripper.confine(scenery.hand_range);
        let initial = State {
            islands: IslandManager::new(),
            broad_phase: BroadPhaseBvh::new(),
            narrow_phase: NarrowPhase::new(),
            bodies: scenery.bodies,
            colliders: scenery.colliders,
            joints: scenery.joints,
            continuous: CCDSolver::new(),
            gripper,
        };
        let world = Self {
            pipeline: PhysicsPipeline::new(),
            parameters: parameters(),
            multibody_joints: MultibodyJointSet::new(),
            soft_bodies: SoftBodySet::new(),
            state: initial.clone(),
            initial,
        };
        (world, furniture)
    }

    /// Returns to the initial state.
    ///
    /// Setting poses back is not enough: the solver starts from the impulses of its last step.
    pub(crate) fn reset(&mut self) {
        self.state.clone_from(&self.initial);
    }

    /// Moves a body that no step has moved yet, and turns it about the vertical, by radians.
    pub(crate) fn place(&mut self, body: Body, position: Position, turn: f32) {
        // nalgebra's, since those of std differ between platforms.
        let (sine, cosine) = ComplexField::sin_cos(turn / 2.0);
        let rotation = Rotation::from_xyzw(0.0, 0.0, sine, cosine);
        let pose = Pose::from_parts(glam(position.coords), rotation);
        self.state.bodies[body.0].set_position(pose, true);
    }

    /// Acts for one environment step: the hand's displacement and the fingers' opening, each in
    /// [−1, 1].
    pub(crate) fn step(&mut self, action: [f32; 4]) {
        let State {
            islands,
            broad_phase,
            narrow_phase,
            bodies,
            colliders,
            joints,
            continuous,
            gripper,
        } = &mut self.state;
        gripper.aim(action, bodies);
        for _ in 0..SUBSTEPS {
            gripper.drive(bodies, joints, SUBSTEP_SECONDS);
            self.pipeline.step(
                Vector::new(0.0, 0.0, -GRAVITY),
                &self.parameters,
                islands,
                broad_phase,
                narrow_phase,
                bodies,
                colliders,
                joints,
                &mut self.multibody_joints,
                &mut self.soft_bodies,
                continuous,
                &(),
                &(),
            );
        }
    }

    /// The gripper now.
    pub(crate) fn grip(&self) -> Grip {
        self.state.gripper.grip(&self.state.bodies)
    }

    /// A body now.
    pub(crate) fn motion(&self, body: Body) -> Motion {
        let body = &self.state.bodies[body.0];
        let [x, y, z, w] = body.rotation().to_array();
        Motion {
            position: nalgebra(body.translation()).into(),
            rotation: UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)),
            velocity: nalgebra(body.linvel()),
            spin: nalgebra(body.angvel()),
        }
    }

    /// The state now.
    pub(crate) fn state(&self) -> &State {
        &self.state
    }

    /// Goes on from a state of this world or of one that was built alike.
    pub(crate) fn restore(&mut self, state: &State) {
        self.state.clone_from(state);
    }
}

/// A [`World`] that is being furnished.
pub(crate) struct Scenery {
    bodies: RigidBodySet,
    colliders: ColliderSet,
    joints: ImpulseJointSet,
    /// From where the robot stands in `FetchPush` to where it stands here, in metres.
    robot: Vector3<f32>,
    hand_range: HandRange,
}

fn parameters() -> IntegrationParameters {
    let softness = SpringCoefficients::new(CONTACT_FREQUENCY, CONTACT_DAMPING);
    IntegrationParameters {
        dt: SUBSTEP_SECONDS,
        num_solver_iterations: usize::from(SOLVER_ITERATIONS),
        contact_softness: softness,
        static_contact_softness: softness,
        length_unit: LENGTH_UNIT,
        max_ccd_substeps: 0,
        // `Coulomb` turns a block that is pushed off its centre three times as far as MuJoCo does.
        friction_model: FrictionModel::Simplified,
        ..IntegrationParameters::default()
    }
}

fn glam(v: Vector3<f32>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn nalgebra(v: Vector) -> Vector3<f32> {
    Vector3::new(v.x, v.y, v.z)
}

/// The same for a point.
fn point(v: Vector) -> Point3<f32> {
    nalgebra(v).into()
}
