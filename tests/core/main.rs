//! Laws of `rher-core` through its public interface, on worlds small enough to know the answer: all of
//! them take seconds. What needs training to show is in the target `learning`.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![expect(clippy::float_cmp, reason = "what should be the same is the same to the last bit")]

mod causes;
#[cfg(feature = "train")]
mod checkpoints;
#[cfg(feature = "train")]
mod control;
mod draws;
mod ends;
mod environments;
#[cfg(feature = "train")]
mod evaluation;
mod exploration;
mod fixed;
mod goals;
#[cfg(feature = "train")]
mod memory;
#[cfg(feature = "train")]
mod orders;
#[cfg(feature = "train")]
mod policies;
#[cfg(feature = "train")]
mod pretrained;
mod relabeling;
mod replays;
#[cfg(feature = "train")]
mod spelled_out;
mod tails;
mod toy;
#[cfg(feature = "train")]
mod training;
