//! The fused engine does not allocate once it has seen a batch.
#![cfg(feature = "fused")]
#![expect(unsafe_code, reason = "an allocator that counts is unsafe to write")]

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rayon::{ThreadPool, ThreadPoolBuilder};
use rher_core::batch::Batch;
use rher_core::config::AgentConfig;
use rher_core::learner::engine::Engine as _;
use rher_core::learner::fused::FusedEngine;
use rher_core::learner::state::LearnerState;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: everything is passed on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Updates of either kind: with the actor and without.
const UPDATES: usize = 200;

fn allocations_of_updates(pool: &ThreadPool, critic_layer_norm: bool) -> usize {
    let config = AgentConfig {
        hidden: vec![48, 40],
        critic_layer_norm,
        imitation: 1.0,
        ..AgentConfig::td3()
    };
    let (rows, input, action) = (300, 31, 4);
    let state = LearnerState::new(&config, input, action, &mut ChaCha8Rng::seed_from_u64(0));
    let mut engine = FusedEngine::from_state(&config, state);
    let mut batch = Batch::zeros(rows, input, action);
    batch.imitates.fill(true);
    let noise = vec![0.5; rows * action];
    pool.install(|| {
        // A thread of the pool sets itself up when it takes its first job from another.
        let wait_and_tell = || {
            thread::sleep(Duration::from_millis(1));
            rayon::current_thread_index()
        };
        let alone = || {
            let (here, there) = rayon::join(wait_and_tell, rayon::current_thread_index);
            here == there
        };
        while pool.current_num_threads() > 1 && alone() {}
        engine.update(&batch, &noise).expect("finite gradients");
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        for _ in 0..UPDATES {
            engine.update(&batch, &noise).expect("finite gradients");
        }
        ALLOCATIONS.load(Ordering::Relaxed) - before
    })
}

#[test]
fn updates_after_the_first_do_not_allocate() {
    // Threads that start or end allocate too, so both pools start first and live to the end.
    let pools = [1, 2].map(|threads| ThreadPoolBuilder::new().num_threads(threads).build());
    let pools = pools.map(|pool| pool.expect("threads start"));
    for pool in &pools {
        pool.broadcast(|_| ());
    }
    for pool in &pools {
        for critic_layer_norm in [false, true] {
            assert_eq!(allocations_of_updates(pool, critic_layer_norm), 0);
        }
    }
}
