//! One Rapier world around one gripper, and how it is stepped.

use super::body::{Body, Loose, Motion};
use super::camera::Camera;
use super::convert::{glam, nalgebra, point};
use super::edges::RoundedEdges;
use super::gripper::{Fingers, Grip, Gripper, HandRange};
use super::late::Late;
use super::look::Look;
use super::scenery::Scenery;
use ::nalgebra::{ComplexField, Quaternion, UnitQuaternion, Vector3};
use rapier3d::prelude::{
    BroadPhaseBvh, CCDSolver, ColliderSet, FrictionModel, ImpulseJointSet, IntegrationParameters,
    IslandManager, MultibodyJointSet, NarrowPhase, PhysicsPipeline, Pose, RigidBodySet, Rotation,
    SoftBodySet, SpringCoefficients, Vector,
};
use rher_core::goal::Position;

/// Duration of an environment step, in seconds: 20 `MuJoCo` steps of 2 ms in the Fetch environments.
pub const STEP_SECONDS: f32 = 0.04;

/// Version of the physics engine: another one may move things in other ways.
pub const RAPIER_VERSION: &str = rapier3d::VERSION;

/// Collision detections in an environment step.
const SUBSTEPS: u8 = 4;

/// Collision detections in a step, and solver substeps in each.
pub const DETECTIONS_AND_SOLVER_SUBSTEPS: [u8; 2] = [SUBSTEPS, SOLVER_ITERATIONS];

/// Seconds between collision detections.
const SUBSTEP_SECONDS: f32 = STEP_SECONDS / SUBSTEPS as f32;

/// Solver substeps between collision detections.
const SOLVER_ITERATIONS: u8 = 4;

/// Stiffness of contacts, in hertz: stacks jitter above a quarter of the solver's own frequency.
const CONTACT_FREQUENCY: f32 = 0.25 * SUBSTEPS as f32 * SOLVER_ITERATIONS as f32 / STEP_SECONDS;

/// Damping ratio of contacts.
const CONTACT_DAMPING: f32 = 10.0;

/// Typical size of things, in meters.
///
/// With Rapier's default of 1 m a block hovers when its center is past the table's edge: contact
/// points are re-used until a pair has moved by a twentieth of this.
const LENGTH_UNIT: f32 = 0.1;

/// Meters per second squared.
const GRAVITY: f32 = 9.81;

/// A gripper and the things around it.
pub struct World {
    /// Scratch memory of the solver, without influence on what it computes.
    pub(super) pipeline: PhysicsPipeline,
    pub(super) parameters: IntegrationParameters,
    pub(super) multibody_joints: MultibodyJointSet,
    pub(super) soft_bodies: SoftBodySet,
    pub(super) fingers: Fingers,
    /// What can be seen, besides the palm above the fingers.
    pub(super) looks: Vec<Look>,
    /// What looks at hand and objects; where there is none they are seen where they are.
    pub(super) watch: Option<Watch>,
    /// Whether everything is told as it is, and not as it is seen.
    pub(super) is_bare: bool,
    pub(super) state: State,
    pub(super) initial: State,
}

/// How well a camera sees.
#[derive(Clone, Copy)]
pub(super) struct Watch {
    /// Standard deviation of each coordinate, in meters.
    pub(super) noise: f32,
    /// Steps by which it is late.
    pub(super) delay: usize,
}

/// Everything that changes in a [`World`]: equal states have bitwise equal futures.
#[derive(Clone)]
pub(crate) struct State {
    pub(super) islands: IslandManager,
    pub(super) broad_phase: BroadPhaseBvh,
    pub(super) narrow_phase: NarrowPhase,
    pub(super) bodies: RigidBodySet,
    pub(super) colliders: ColliderSet,
    pub(super) joints: ImpulseJointSet,
    pub(super) continuous: CCDSolver,
    pub(super) gripper: Gripper,
    pub(super) loose: Vec<Loose>,
    pub(super) camera: Option<Camera>,
    pub(super) late: Late,
}

impl World {
    /// A gripper with its grip center at `home`, over a floor at height 0, with what `furnish`
    /// adds to it.
    pub fn new<T>(
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
            loose: Vec::new(),
            looks: gripper.looks(),
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
            loose: scenery.loose,
            camera: None,
            late: Late::default(),
        };
        let world = Self {
            fingers,
            pipeline: PhysicsPipeline::new(),
            parameters: parameters(),
            multibody_joints: MultibodyJointSet::new(),
            soft_bodies: SoftBodySet::new(),
            looks: scenery.looks,
            watch: None,
            is_bare: false,
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
    ///
    /// One that is larger than usual is put higher by as much as keeps its underside in place.
    pub fn place(&mut self, body: Body, mut position: Position, turn: f32) {
        let loose = self.state.loose.iter().find(|loose| loose.body == body);
        position.z += loose.map_or(0.0, |loose| loose.raised);
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
            late,
            ..
        } = &mut self.state;
        gripper.aim(late.after(action), bodies);
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
                &RoundedEdges,
                &(),
            );
        }
        self.look();
    }

    /// What its fingers can do.
    pub(crate) fn fingers(&self) -> Fingers {
        self.fingers
    }

    /// Whether actions can bring the grip center to within `tolerance` meters of `place`.
    pub(crate) fn can_reach(&self, place: &Position, tolerance: f32) -> bool {
        self.state.gripper.can_reach(glam(place.coords), tolerance)
    }

    /// How far an action of 1 moves the point that the hand is after, in meters.
    pub(crate) fn hand_step(&self) -> f32 {
        self.state.gripper.hand_step()
    }

    /// The gripper now, as it is seen.
    pub fn grip(&self) -> Grip {
        let mut grip = self.state.gripper.grip(&self.state.bodies);
        if let (Some(camera), Some(_), false) = (&self.state.camera, self.watch, self.is_bare) {
            let (position, step) = camera.sees(0);
            grip.position = point(position);
            grip.velocity = nalgebra(step) / STEP_SECONDS;
        }
        grip
    }

    /// A body now, as it is seen.
    pub fn motion(&self, body: Body) -> Motion {
        let thing = self.state.loose.iter().position(|loose| loose.body == body);
        let body = &self.state.bodies[body.0];
        let [x, y, z, w] = body.rotation().to_array();
        let mut motion = Motion {
            position: nalgebra(body.translation()).into(),
            rotation: UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)),
            velocity: nalgebra(body.linvel()),
            spin: nalgebra(body.angvel()),
        };
        if let (Some(camera), Some(thing), false) = (&self.state.camera, thing, self.is_bare) {
            let (position, step) = camera.sees(1 + thing);
            motion.position = point(position);
            if self.watch.is_some() {
                motion.velocity = nalgebra(step) / STEP_SECONDS;
            }
        }
        motion
    }

    /// What `tell` says of a world without a camera; nothing if it has none.
    pub(crate) fn bare<T>(&mut self, tell: impl FnOnce(&Self) -> T) -> Option<T> {
        self.state.camera.as_ref()?;
        self.is_bare = true;
        let told = tell(self);
        self.is_bare = false;
        Some(told)
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

fn parameters() -> IntegrationParameters {
    let softness = SpringCoefficients::new(CONTACT_FREQUENCY, CONTACT_DAMPING);
    IntegrationParameters {
        dt: SUBSTEP_SECONDS,
        num_solver_iterations: usize::from(SOLVER_ITERATIONS),
        contact_softness: softness,
        static_contact_softness: softness,
        length_unit: LENGTH_UNIT,
        max_ccd_substeps: 0,
        // `Coulomb` turns a block that is pushed off its center three times as far as MuJoCo does.
        friction_model: FrictionModel::Simplified,
        ..IntegrationParameters::default()
    }
}
