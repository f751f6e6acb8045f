//! The tasks, one file each.

mod blocks;
mod pick;
mod push;
mod reach;

pub use pick::Pick;
pub use push::Push;
pub use reach::Reach;
