//! The delay between an action that is chosen and the same action carried out.

use crate::options::Randomize;

/// Actions that are carried out a few steps after they were chosen.
#[derive(Clone, Default)]
pub(super) struct Late {
    pub(super) steps: usize,
    /// The newest first.
    pub(super) chosen: [[f32; 4]; Randomize::LONGEST_DELAY + 1],
}

impl Late {
    /// The action to carry out in the step in which `action` is chosen.
    pub(super) fn after(&mut self, action: [f32; 4]) -> [f32; 4] {
        self.chosen.rotate_right(1);
        self.chosen[0] = action;
        self.chosen[self.steps]
    }
}
