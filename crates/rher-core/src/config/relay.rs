//! Settings of the relay and of hindsight.

use super::declare::settings;
use crate::choice::choices;
use crate::env::EnvSpec;
use crate::goal::{LaterObjects, Tolerances};
use crate::setting::Range;

choices! {
    /// Training method.
    pub enum Method {
        /// Relay hindsight experience replay: trains every sub-task, with guided exploration.
        Rher = "rher",
        /// Plain hindsight experience replay, the baseline: trains the last sub-task only, without
        /// a guide.
        Her = "her",
    }
}

choices! {
    /// How goals enter the networks.
    pub enum GoalFrame {
        /// World positions, normalized; an unused goal slot is (−5, −5, −5). This is the paper's.
        Absolute = "absolute",
        /// Differences to the goal (goal − object, goal − gripper), normalized; an unused goal slot
        /// is 0, and one flag for each slot says whether it is used.
        Relative = "relative",
    }
}

choices! {
    /// Order in which the networks see interchangeable objects.
    pub enum ObjectOrder {
        /// Always in relay order. This is the paper's.
        Relay = "relay",
        /// The current object first, then those after it, then those before it. The current object
        /// is the first that is not where the sub-task wants it, so that the next thing to do looks
        /// the same whichever object it is done with.
        Turn = "turn",
    }
}

settings! {
    /// The relay of sub-tasks, and hindsight relabeling.
    pub struct RelayConfig in "relay.", from start {
        /// Training method.
        pub method: Method {
            paper: Method::Rher,
        }
        /// Distance in meters between gripper and object within which the object counts as reached
        /// when the stage is determined: the paper's d (eq. 6, Section VI.C).
        pub reach_distance: f32 {
            range: Range::NonNegative,
            paper: if start.single { 0.03 } else { 0.05 },
            fast: 0.03,
        }
        /// Fraction of the task's tolerance within which training counts an object as placed. It
        /// applies to rewards, stages and the order of objects; evaluations use the whole
        /// tolerance, so below 1 training demands more precision than evaluation. Not in the paper.
        #[serde(default = "whole")]
        pub tolerance: f32 {
            range: Range::PositiveShare,
            paper: 1.0,
        }
        /// Probability that a transition is relabeled with a goal that was achieved later in its
        /// episode: hindsight experience replay with the `future` strategy (eq. 4).
        pub hindsight: f32 {
            range: Range::Share,
            paper: 0.8,
        }
        /// Probability that a transition is drawn again when its hindsight goal is already met
        /// before it, up to four times: most transitions move nothing, and teach little. Not in
        /// the paper.
        #[serde(default, with = "crate::since_6")]
        pub redraw_met: f32 {
            range: Range::Share,
            paper: 0.0,
            fast: 0.8,
        }
        /// Hindsight goal of the objects that a sub-task does not touch (eq. 9).
        pub later_objects: LaterObjects {
            paper: LaterObjects::Now,
        }
        /// How goals enter the networks (eq. 8).
        pub goal_frame: GoalFrame {
            paper: GoalFrame::Absolute,
            fast: GoalFrame::Relative,
        }
        /// Whether the networks also see distances on a finer scale: in units of the tolerance,
        /// clipped to what is near, from objects and gripper to their goals, from the gripper to
        /// the objects, and between objects. Not in the paper.
        #[serde(default, with = "crate::since_6")]
        pub fine_scale: bool {
            paper: false,
            fast: true,
        }
        /// Order in which the networks see interchangeable objects. Not in the paper.
        #[serde(default = "relay_order")]
        pub object_order: ObjectOrder {
            paper: ObjectOrder::Relay,
            fast: ObjectOrder::Turn,
        }
        /// Whether evaluations and deployed policies choose in which order objects are placed, in
        /// tasks that allow every order: a linear model of distances, fitted to how the latest
        /// episodes ended, predicts which order succeeds. Not in the paper.
        #[serde(default, with = "crate::since_6")]
        pub choose_order: bool {
            paper: false,
            fast: true,
        }
        /// Probability that a transition is replayed as its mirror image, in scenes that have
        /// planes of symmetry: data augmentation. Not in the paper.
        pub mirror: f32 {
            range: Range::Share,
            paper: 0.0,
            fast: 0.5,
        }
        /// Probability that a transition of a later object is replayed as one of an earlier,
        /// interchangeable object: data augmentation, by which what is learned about one object is
        /// learned about all. Not in the paper.
        #[serde(default)]
        pub exchange: f32 {
            range: Range::Share,
            paper: 0.0,
            fast: 0.5,
        }
    }
}

/// The tolerance of runs from before it was a setting.
fn whole() -> f32 {
    1.0
}

/// The order of runs from before it was a setting.
fn relay_order() -> ObjectOrder {
    ObjectOrder::Relay
}

impl RelayConfig {
    /// The tolerances of training in environments like `spec`.
    pub fn tolerances<const N: usize>(&self, spec: &EnvSpec<N>) -> Tolerances<N> {
        spec.tolerances.scaled(self.tolerance)
    }
}
