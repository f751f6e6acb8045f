//! The tasks, one file each.

mod blocks;
mod cue_push;
mod dpush;
mod drawer;
mod drawer_box;
mod insert;
mod obstacle_push;
mod pick;
mod push;
mod reach;
mod slide;
mod stack;
mod tpush;
mod tstack;

pub use cue_push::CuePush;
pub use dpush::DPush;
pub use drawer::Drawer;
pub use drawer_box::DrawerBox;
pub use insert::Insert;
pub use obstacle_push::ObstaclePush;
pub use pick::Pick;
pub use push::Push;
pub use reach::Reach;
pub use slide::Slide;
pub use stack::Stack;
pub use tpush::TPush;
pub use tstack::TStack;
