//! Tests of `rher-core` through its public interface, on worlds small enough to know the answer.

mod checkpoints;
mod goals;
mod learning;
mod policies;
mod relabelling;
mod replays;
mod toy;
