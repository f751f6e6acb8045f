//! The gripper: two fingers that an arm moves about without turning them.
//!
//! The Fetch environments drag the whole arm behind a point by a soft weld, and the hand answers
//! like a critically damped spring. Here a [`Lead`] is that spring, and the fingers are driven
//! after it by a force with an upper limit, so that whatever is in the way stays in one piece.

use super::convert::{nalgebra, point};
use super::look::{Look, METAL, Solid};
use super::material::rough;
use ::nalgebra::{ComplexField, Vector3};
use rapier3d::prelude::{
    CoefficientCombineRule, ColliderBuilder, ColliderSet, ImpulseJointHandle, ImpulseJointSet,
    JointAxis, MotorModel, PrismaticJointBuilder, RigidBody, RigidBodyBuilder, RigidBodyHandle,
    RigidBodySet, Vector,
};
use rher_core::goal::Position;
use std::f32::consts::FRAC_PI_2;

/// Half the edges of a finger, in meters: thick, wide along the closing axis y, long.
const FINGER_HALF: Vector = Vector::new(0.0135, 0.007, 0.0385);

/// Kilograms.
const FINGER_MASS: f32 = 1.5;

/// From the middle of the gripper to a closed finger's center, along y, in meters.
const FINGER_OFFSET: f32 = 0.0079;

/// From the grip center up to the fingers' center, in meters.
const FINGER_HEIGHT: f32 = 0.019;

/// How far a finger opens, in meters.
const FINGER_RANGE: f32 = 0.05;

/// Radius of a cue, in meters.
pub(crate) const CUE_RADIUS: f32 = 0.005;

/// Half the length of a cue, in meters.
const CUE_HALF_LENGTH: f32 = 0.05;

/// Coefficient of friction of a cue: smooth metal.
const CUE_FRICTION: f32 = 0.1;

/// Angular frequency of the hand's answer, in radians per second.
const HAND_FREQUENCY: f32 = 50.5;

/// Stiffness with which the hand follows its lead, per second squared.
const HAND_STIFFNESS: f32 = 12_000.0;

/// Damping with which the hand follows its lead, per second.
const HAND_DAMPING: f32 = 220.0;

/// The most that the arm pushes each finger, in newtons.
const HAND_FORCE: f32 = 150.0;

/// The most that the arm presses each finger down, in newtons.
const HAND_PRESS: f32 = 75.0;

/// What a stretched arm takes back of where the hand should go.
const STRETCHED: Recoil = Recoil {
    center: Vector::new(0.65, 0.7491, 0.37),
    radius: 0.87,
    inside: false,
    strength: 0.092,
};

/// The same for an arm that is folded.
const FOLDED: Recoil = Recoil {
    center: Vector::new(0.45, 0.7491, 0.95),
    radius: 0.826,
    inside: true,
    strength: 0.067,
};

/// How far the lead is ahead of the hand at most when a step begins, in meters.
///
/// It carries the load of what is held: without it the hand would sink a little each step.
const HAND_SLACK: f32 = 0.0025;

/// Stiffness of the fingers' actuators, in newtons per meter.
const ACTUATOR_STIFFNESS: f32 = 30_000.0;

/// The most an actuator can be asked to open a finger, in meters.
const ACTUATOR_RANGE: f32 = 0.2;

/// Square of the angular frequency with which an actuator moves its finger: stiffness over
/// armature and mass.
const ACTUATOR_FREQUENCY_SQUARED: f32 = ACTUATOR_STIFFNESS / 104.0;

/// Damping over armature and mass, per second.
const ACTUATOR_DAMPING: f32 = 1000.0 / 104.0;

/// The most that a finger squeezes, in newtons.
const GRIP_FORCE: f32 = 150.0;

/// Damping of the joint between the fingers, in newton seconds per meter.
const GRIP_DAMPING: f32 = 400.0;

/// What the fingers can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fingers {
    /// They stay closed, as one box.
    Locked,
    /// They open and close.
    Free,
    /// In their place a thin upright rod, smooth, of metal.
    Cue,
}

/// The gripper at one moment, in the world frame.
#[derive(Clone, Copy, Debug)]
pub struct Grip {
    /// Grip center, in meters.
    pub position: Position,
    /// Meters per second.
    pub velocity: Vector3<f32>,
    /// How far each finger is open, that on the side of +y first, in meters.
    pub opening: [f32; 2],
    /// Meters per second.
    pub opening_velocity: [f32; 2],
}

/// The bodies of the gripper and the state of what drives them.
#[derive(Clone)]
pub(super) struct Gripper {
    hand: Hand,
    lead: Lead,
    opening: Opening,
    /// From the hand's center down to the grip center, in meters.
    height: f32,
    /// Half the length of the fingers or the cue, in meters.
    half_length: f32,
    /// From where the robot stands in `FetchPush` to where it stands.
    robot: Vector,
    range: HandRange,
}

/// Where actions can bring the hand.
#[derive(Clone, Copy)]
pub(super) struct HandRange {
    /// How far an action of 1 moves the point that the hand is after, in meters.
    pub(super) per_step: f32,
    /// The box that actions keep the grip center in, from its lowest corner to its highest.
    pub(super) corners: [Vector; 2],
}

impl Default for HandRange {
    fn default() -> Self {
        let everywhere = [Vector::splat(f32::NEG_INFINITY), Vector::splat(f32::INFINITY)];
        Self { per_step: 0.05, corners: everywhere }
    }
}

/// The bodies that make up the gripper.
#[derive(Clone, Copy)]
enum Hand {
    Closed(RigidBodyHandle),
    /// The finger on the side of +y, the other, and the joint between them.
    Fingers([RigidBodyHandle; 2], ImpulseJointHandle),
}

/// Where the arm would have brought an unloaded hand.
#[derive(Clone, Copy)]
struct Lead {
    position: Vector,
    velocity: Vector,
    target: Vector,
}

/// A sphere that the hand leaves against resistance.
struct Recoil {
    center: Vector,
    radius: f32,
    /// Whether the resistance is inside of it.
    inside: bool,
    /// Share of what the hand is beyond the sphere by which its target is drawn back.
    strength: f32,
}

/// How far the actuators would have opened unloaded fingers.
#[derive(Clone, Copy)]
struct Opening {
    position: f32,
    velocity: f32,
    target: f32,
}

impl Gripper {
    /// Fingers closed, grip center at `home`.
    pub(super) fn new(
        fingers: Fingers,
        home: Vector,
        bodies: &mut RigidBodySet,
        colliders: &mut ColliderSet,
        joints: &mut ImpulseJointSet,
    ) -> Self {
        let (height, half_length) = match fingers {
            Fingers::Locked | Fingers::Free => (FINGER_HEIGHT, FINGER_HALF.z),
            Fingers::Cue => (CUE_HALF_LENGTH, CUE_HALF_LENGTH),
        };
        let center = home + Vector::Z * height;
        let mut add = |y: f32, shape: ColliderBuilder, mass: f32| {
            let body = RigidBodyBuilder::dynamic()
                .translation(center + Vector::Y * y)
                .lock_rotations()
                .gravity_scale(0.0)
                .can_sleep(false);
            let body = bodies.insert(body);
            colliders.insert_with_parent(shape.mass(mass), body, bodies);
            body
        };
        let finger = |half: Vector| rough(ColliderBuilder::cuboid(half.x, half.y, half.z));
        let hand = match fingers {
            Fingers::Locked => {
                let half = Vector::new(FINGER_HALF.x, FINGER_OFFSET + FINGER_HALF.y, FINGER_HALF.z);
                Hand::Closed(add(0.0, finger(half), 2.0 * FINGER_MASS))
            }
            Fingers::Free => {
                let fingers = [FINGER_OFFSET, -FINGER_OFFSET]
                    .map(|y| add(y, finger(FINGER_HALF), FINGER_MASS));
                let joint = PrismaticJointBuilder::new(Vector::Y)
                    .local_anchor1(Vector::Y * (2.0 * FINGER_OFFSET))
                    .limits([0.0, 2.0 * FINGER_RANGE])
                    .motor_model(MotorModel::ForceBased)
                    .set_motor(0.0, 0.0, ACTUATOR_STIFFNESS / 2.0, GRIP_DAMPING)
                    .motor_max_force(GRIP_FORCE)
                    .contacts_enabled(false);
                Hand::Fingers(fingers, joints.insert(fingers[1], fingers[0], joint, true))
            }
            Fingers::Cue => {
                let rod = ColliderBuilder::cylinder(CUE_HALF_LENGTH, CUE_RADIUS)
                    // The axis of Rapier's cylinders is y.
                    .rotation(Vector::X * FRAC_PI_2)
                    .friction(CUE_FRICTION)
                    .friction_combine_rule(CoefficientCombineRule::Min);
                Hand::Closed(add(0.0, rod, 2.0 * FINGER_MASS))
            }
        };
        Self {
            hand,
            lead: Lead { position: center, velocity: Vector::ZERO, target: center },
            opening: Opening { position: 0.0, velocity: 0.0, target: 0.0 },
            height,
            half_length,
            robot: Vector::ZERO,
            range: HandRange::default(),
        }
    }

    /// Moves the robot, by an offset from where it stands in `FetchPush`.
    pub(super) fn stand_at(&mut self, robot: Vector) {
        self.robot = robot;
    }

    /// Sets where actions can bring the hand.
    pub(super) fn confine(&mut self, range: HandRange) {
        self.range = range;
    }

    /// How far an action of 1 moves the point that the hand is after, in meters.
    pub(super) fn hand_step(&self) -> f32 {
        self.range.per_step
    }

    /// Turns an action into targets for the rest of the step.
    pub(super) fn aim(&mut self, action: [f32; 4], bodies: &RigidBodySet) {
        let [x, y, z, opening] = action;
        let (position, velocity) = self.hand.center(bodies);
        let reach = position - self.robot - Vector::Z * self.height;
        self.lead.aim(Vector::new(x, y, z) * self.range.per_step, position, velocity);
        self.lead.target = self.lead.target + STRETCHED.at(reach) + FOLDED.at(reach);
        let [lowest, highest] = self.range.corners.map(|corner| corner + Vector::Z * self.height);
        self.lead.target = self.lead.target.clamp(lowest, highest);
        if let Hand::Fingers(fingers, _) = self.hand {
            self.opening.aim(opening, gap(fingers, bodies).0);
        }
    }

    /// Sets the forces for the next `seconds`.
    pub(super) fn drive(
        &mut self,
        bodies: &mut RigidBodySet,
        joints: &mut ImpulseJointSet,
        seconds: f32,
    ) {
        let (position, velocity) = self.hand.center(bodies);
        let acceleration = self.lead.advance(seconds);
        // Implicit: what brings the hand to its lead by the end of this time, not what would
        // have been right at its beginning.
        let slower = self.lead.velocity - (velocity + acceleration * seconds);
        let behind =
            self.lead.position - (position + (velocity + acceleration * seconds) * seconds);
        let catch_up = (behind * HAND_STIFFNESS + slower * HAND_DAMPING)
            / (1.0 + HAND_DAMPING * seconds + HAND_STIFFNESS * seconds * seconds);
        let mut effort = (catch_up * FINGER_MASS).clamp_length_max(HAND_FORCE);
        effort.z = effort.z.max(-HAND_PRESS);
        let force = acceleration * FINGER_MASS + effort;
        match self.hand {
            Hand::Closed(body) => push(&mut bodies[body], force * 2.0),
            Hand::Fingers(fingers, joint) => {
                for finger in fingers {
                    push(&mut bodies[finger], force);
                }
                self.opening.advance(seconds);
                if let Some(joint) = joints.get_mut(joint, false) {
                    joint.data.set_motor(
                        JointAxis::LinX,
                        2.0 * self.opening.position,
                        2.0 * self.opening.velocity,
                        ACTUATOR_STIFFNESS / 2.0,
                        GRIP_DAMPING,
                    );
                }
            }
        }
    }

    /// The fingers or the cue, as they are seen.
    pub(super) fn looks(&self) -> Vec<Look> {
        let look = |name: &str, body| Look::new(name, Solid::Body(body), &[METAL]);
        match self.hand {
            Hand::Closed(body) => vec![look("fingers", body)],
            Hand::Fingers([left, right], _) => {
                vec![look("finger_left", left), look("finger_right", right)]
            }
        }
    }

    /// Whether actions can bring the grip center to within `tolerance` meters of `place`: it is near
    /// the box that they keep the hand in, and there the arm takes back less than an action moves
    /// the hand along an axis.
    pub(super) fn can_reach(&self, place: Vector, tolerance: f32) -> bool {
        let [lowest, highest] = self.range.corners;
        let nearest = place.clamp(lowest, highest);
        let arm = nearest - self.robot;
        let taken_back = (STRETCHED.at(arm) + FOLDED.at(arm)).length();
        nearest.distance(place) <= tolerance && taken_back <= self.range.per_step
    }

    /// From the grip center to the upper end of the fingers or the cue, in meters.
    pub(super) fn top(&self) -> f32 {
        self.height + self.half_length
    }

    /// The gripper now.
    pub(super) fn grip(&self, bodies: &RigidBodySet) -> Grip {
        let (center, velocity) = self.hand.center(bodies);
        let (opening, opening_velocity) = match self.hand {
            Hand::Closed(_) => (0.0, 0.0),
            Hand::Fingers(fingers, _) => gap(fingers, bodies),
        };
        Grip {
            position: point(center - Vector::Z * self.height),
            velocity: nalgebra(velocity),
            opening: [opening; 2],
            opening_velocity: [opening_velocity; 2],
        }
    }
}

impl Hand {
    /// Position and velocity of the fingers' common center.
    fn center(self, bodies: &RigidBodySet) -> (Vector, Vector) {
        match self {
            Self::Closed(body) => (bodies[body].translation(), bodies[body].linvel()),
            Self::Fingers([a, b], _) => {
                let (a, b) = (&bodies[a], &bodies[b]);
                ((a.translation() + b.translation()) / 2.0, (a.linvel() + b.linvel()) / 2.0)
            }
        }
    }
}

/// How far each finger is open and how fast it opens.
fn gap([a, b]: [RigidBodyHandle; 2], bodies: &RigidBodySet) -> (f32, f32) {
    let (a, b) = (&bodies[a], &bodies[b]);
    let opening = (a.translation() - b.translation()).y / 2.0 - FINGER_OFFSET;
    (opening, (a.linvel() - b.linvel()).y / 2.0)
}

/// Replaces the force on a body.
fn push(body: &mut RigidBody, force: Vector) {
    body.reset_forces(false);
    body.add_force(force, false);
}

impl Lead {
    /// Starts a step towards `offset` from where the hand really is.
    fn aim(&mut self, offset: Vector, position: Vector, velocity: Vector) {
        let ahead =
            (self.position - position).clamp(-Vector::splat(HAND_SLACK), Vector::splat(HAND_SLACK));
        self.position = position + ahead;
        self.velocity = velocity;
        self.target = self.position + offset;
    }

    /// Moves on and returns the mean acceleration.
    fn advance(&mut self, seconds: f32) -> Vector {
        let before = self.velocity;
        // nalgebra's, since that of std differs between platforms.
        let decay = ComplexField::exp(-HAND_FREQUENCY * seconds);
        let from_target = self.position - self.target;
        let drift = self.velocity + from_target * HAND_FREQUENCY;
        self.position = self.target + (from_target + drift * seconds) * decay;
        self.velocity = (self.velocity - drift * (HAND_FREQUENCY * seconds)) * decay;
        (self.velocity - before) / seconds
    }
}

impl Recoil {
    /// How far the target of a hand with its grip center at `hand` is drawn back.
    fn at(&self, hand: Vector) -> Vector {
        let arm = hand - self.center;
        let length = arm.length();
        let beyond = length - self.radius;
        if (beyond < 0.0) == self.inside {
            arm * (-self.strength * beyond / length)
        } else {
            Vector::ZERO
        }
    }
}

impl Opening {
    /// Starts a step; `action` is what the actuators add to how far the fingers really are open.
    fn aim(&mut self, action: f32, opening: f32) {
        let slack = GRIP_FORCE / ACTUATOR_STIFFNESS;
        if (self.position - opening).abs() > slack {
            self.position = self.position.clamp(opening - slack, opening + slack);
            self.velocity = 0.0;
        }
        self.target = (opening + action).clamp(0.0, ACTUATOR_RANGE);
    }

    /// Moves on.
    fn advance(&mut self, seconds: f32) {
        let pull = ACTUATOR_FREQUENCY_SQUARED * (self.target - self.position);
        self.velocity += seconds * (pull - ACTUATOR_DAMPING * self.velocity);
        self.position += seconds * self.velocity;
        if !(0.0..=FINGER_RANGE).contains(&self.position) {
            self.position = self.position.clamp(0.0, FINGER_RANGE);
            self.velocity = 0.0;
        }
    }
}
