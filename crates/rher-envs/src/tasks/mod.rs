//! The tasks, one file each.

mod blocks;
mod dpush;
mod pick;
mod push;
mod reach;
mod stack;
mod tpush;
mod tstack;

pub use dpush::DPush;
pub use pick::Pick;
pub use push::Push;
pub use reach::Reach;
pub use stack::Stack;
pub use tpush::TPush;
pub use tstack::TStack;
