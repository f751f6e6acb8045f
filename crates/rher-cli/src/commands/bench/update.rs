//! `rher bench update`: milliseconds per update of the networks.

use crate::cli::{BenchUpdateArgs, EngineName};
use crate::commands::{table, text};
use crate::printer::Printer;
use clap::ValueEnum as _;
use rand::RngExt as _;
use rand_distr::StandardNormal;
use rher_core::agent;
use rher_core::agent::config::AgentConfig;
use rher_core::agent::learner::LearnerState;
use rher_core::agent::network::Shape;
use rher_core::batch::Batch;
use rher_core::config::Preset;
use rher_core::seed::{Purpose, Seed};
use serde::Serialize;
use std::num::NonZeroUsize;
use std::time::{Duration, Instant};

const BATCHES: [usize; 4] = [128, 256, 1024, 2048];
/// One object, and three.
const INPUTS: [usize; 2] = [31, 81];
const THREADS: [usize; 2] = [1, 2];
const ACTION: usize = 4;
const WARM_UP: Duration = Duration::from_millis(100);
const MEASURED: Duration = Duration::from_secs(1);

/// What is printed of a case.
#[derive(Serialize)]
struct UpdateSpeed {
    batch: usize,
    inputs: usize,
    engine: String,
    threads: usize,
    ms_per_update: f64,
    /// Matrix products alone, forward and backward.
    gflops: f64,
}

pub(crate) fn bench_update(args: &BenchUpdateArgs, printer: Printer) -> anyhow::Result<()> {
    let BenchUpdateArgs { batches, inputs, threads, engine, json } = args;
    let engines = engine.as_ref().map_or(EngineName::value_variants(), std::slice::from_ref);
    let mut speeds = Vec::new();
    for &engine in engines {
        for batch in chosen(batches, &BATCHES) {
            for inputs in chosen(inputs, &INPUTS) {
                for threads in chosen(threads, &THREADS) {
                    speeds.push(measure(engine, batch, inputs, threads)?);
                }
            }
        }
    }
    if *json {
        printer.data(&serde_json::to_string_pretty(&speeds)?)?;
        return Ok(());
    }
    let mut listing = table();
    listing.set_header(["engine", "batch", "inputs", "threads", "ms/update", "GFLOP/s"]);
    for UpdateSpeed { batch, inputs, engine, threads, ms_per_update, gflops } in speeds {
        listing.add_row([
            engine,
            batch.to_string(),
            inputs.to_string(),
            threads.to_string(),
            format!("{ms_per_update:.3}"),
            format!("{gflops:.1}"),
        ]);
    }
    printer.data(&text(&listing))?;
    Ok(())
}

fn chosen(asked: &[NonZeroUsize], default: &[usize]) -> Vec<usize> {
    if asked.is_empty() {
        default.to_vec()
    } else {
        asked.iter().map(|number| number.get()).collect()
    }
}

/// Times updates of the `fast` preset's networks on random rows.
fn measure(
    engine: EngineName,
    batch: usize,
    inputs: usize,
    threads: usize,
) -> anyhow::Result<UpdateSpeed> {
    let config = AgentConfig { engine: engine.into(), ..Preset::Fast.config("bench", 1).agent };
    let state = LearnerState::new(&config, inputs, ACTION, &mut Seed(0).stream(Purpose::Init, 0));
    let flops = flops(&config, &state.actor.shape, &state.critics[0].shape, batch);

    let mut rng = Seed(0).stream(Purpose::Batch, 0);
    let mut rows = Batch::zeros(batch, inputs, ACTION);
    rows.inputs.fill_with(|| rng.sample(StandardNormal));
    rows.next_inputs.fill_with(|| rng.sample(StandardNormal));
    rows.actions.fill_with(|| rng.random_range(-1.0..=1.0));
    rows.rewards.fill_with(|| if rng.random() { 0.0 } else { -1.0 });
    let mut noise = vec![0.0; batch * ACTION];
    noise.fill_with(|| rng.sample(StandardNormal));

    let mut learner = agent::engine(&config, state, threads)?;
    let mut time = |least: Duration| {
        let started = Instant::now();
        let mut updates = 0_u32;
        while started.elapsed() < least {
            learner.update(&rows, &noise);
            updates += 1;
        }
        started.elapsed().as_secs_f64() / f64::from(updates)
    };
    time(WARM_UP);
    let seconds_per_update = time(MEASURED);
    Ok(UpdateSpeed {
        batch,
        inputs,
        engine: engine.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned()),
        threads,
        ms_per_update: 1e3 * seconds_per_update,
        gflops: flops / seconds_per_update / 1e9,
    })
}

/// Floating-point operations of the matrix products in one update, two for each multiply-add.
///
/// ```text
/// target actor     forward
/// target critics   forward
/// critics          forward, gradients of weights and of layers: three products for each layer
/// actor            the same, and the first critic forward and back, every `policy_delay` updates
/// ```
fn flops(config: &AgentConfig, actor: &Shape, critic: &Shape, batch: usize) -> f64 {
    let product = |shape: &Shape| {
        let widths: Vec<usize> = std::iter::once(shape.inputs)
            .chain(shape.hidden.iter().copied())
            .chain([shape.outputs])
            .collect();
        let weights: usize = widths.windows(2).map(|pair| pair[0] * pair[1]).sum();
        2.0 * (batch * weights) as f64
    };
    let (actor, critic) = (product(actor), product(critic));
    let critics = config.critics as f64;
    actor + 4.0 * critics * critic + (3.0 * actor + 2.0 * critic) / config.policy_delay as f64
}
