//! `rher bench update`: milliseconds per update of the networks, beside what the machine could do.

use crate::cli::BenchUpdateArgs;
use crate::flops;
use crate::numbers::percent;
use crate::printer::Printer;
use crate::tables::{table, text};
use anyhow::bail;
use cpu_time::ProcessTime;
use rand::RngExt as _;
use rayon::ThreadPoolBuilder;
use rher_core::batch::Batch;
use rher_core::config::{AgentConfig, EngineKind, Precision, Preset};
use rher_core::learner::engines;
use rher_core::learner::state::LearnerState;
use rher_core::normal::StandardNormal;
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
/// Updates that are timed together: as many with the actor as without.
const TOGETHER: u32 = 2;

/// What is printed of a case.
#[derive(Serialize)]
struct UpdateSpeed {
    batch: usize,
    inputs: usize,
    engine: &'static str,
    precision: &'static str,
    threads: usize,
    /// Median on the wall clock.
    ms_per_update: f64,
    /// Mean over the same updates: with what else ran on the machine meanwhile.
    mean_ms_per_update: f64,
    /// Mean over the same updates, all threads added up.
    cpu_ms_per_update: f64,
    /// Of the matrix products alone, at the median.
    gflops: f64,
    /// Of the fused engine's best matrix products on as many threads, just before; `None` in a
    /// program without that engine.
    peak_gflops: Option<f64>,
}

pub(crate) fn bench_update(args: &BenchUpdateArgs, printer: Printer) -> anyhow::Result<()> {
    let BenchUpdateArgs { batches, inputs, threads, engine, precisions, json } = args;
    let engines = match engine {
        Some(engine) => vec![*engine],
        None => EngineKind::AVAILABLE.to_vec(),
    };
    if precisions.contains(&Precision::Bf16) && engines.contains(&EngineKind::Burn) {
        bail!("the engine `burn` has no precision `bf16`: choose `--engine fused`");
    }
    let precisions = if precisions.is_empty() { &[Precision::F32][..] } else { precisions };
    let mut speeds = Vec::new();
    for engine in engines {
        for batch in chosen(batches, &BATCHES) {
            for inputs in chosen(inputs, &INPUTS) {
                for threads in chosen(threads, &THREADS) {
                    for &precision in precisions {
                        let agent = Agent { engine, precision };
                        speeds.push(measure(agent, batch, inputs, threads)?);
                    }
                }
            }
        }
    }
    if *json {
        printer.data(&serde_json::to_string_pretty(&speeds)?)?;
        return Ok(());
    }
    let mut listing = table();
    listing.set_header([
        "engine",
        "precision",
        "batch",
        "inputs",
        "threads",
        "ms/update",
        "CPU ms",
        "GFLOP/s",
        "peak",
        "share",
    ]);
    for speed in speeds {
        listing.add_row([
            speed.engine.to_owned(),
            speed.precision.to_owned(),
            speed.batch.to_string(),
            speed.inputs.to_string(),
            speed.threads.to_string(),
            format!("{:.3}", speed.ms_per_update),
            format!("{:.3}", speed.cpu_ms_per_update),
            format!("{:.1}", speed.gflops),
            speed.peak_gflops.map_or("-".to_owned(), |peak| format!("{peak:.1}")),
            speed.peak_gflops.map_or("-".to_owned(), |peak| percent(speed.gflops / peak)),
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

/// What computes an update.
#[derive(Clone, Copy)]
struct Agent {
    engine: EngineKind,
    precision: Precision,
}

/// Times updates of the `fast` preset's learner, with networks of the published size, on random
/// rows.
fn measure(
    Agent { engine, precision }: Agent,
    batch: usize,
    inputs: usize,
    threads: usize,
) -> anyhow::Result<UpdateSpeed> {
    let preset = Preset::Fast.config("bench", 1).agent;
    let config = AgentConfig { engine, precision, hidden: vec![256; 3], ..preset };
    let state = LearnerState::new(&config, inputs, ACTION, &mut Seed(0).stream(Purpose::Init, 0));

    let mut rng = Seed(0).stream(Purpose::Batch, 0);
    let mut rows = Batch::zeros(batch, inputs, ACTION);
    rows.inputs.fill_with(|| rng.sample(StandardNormal));
    rows.next_inputs.fill_with(|| rng.sample(StandardNormal));
    rows.actions.fill_with(|| rng.random_range(-1.0..=1.0));
    rows.rewards.fill_with(|| if rng.random() { 0.0 } else { -1.0 });
    let mut noise = vec![0.0; batch * ACTION];
    noise.fill_with(|| rng.sample(StandardNormal));

    let mut learner = engines::build(&config, state)?;
    let mut time = |least: Duration| -> anyhow::Result<Vec<f64>> {
        let started = Instant::now();
        let mut seconds = Vec::new();
        while started.elapsed() < least {
            let updating = Instant::now();
            for _ in 0..TOGETHER {
                learner.update(&rows, &noise)?;
            }
            seconds.push(updating.elapsed().as_secs_f64() / f64::from(TOGETHER));
        }
        Ok(seconds)
    };
    let peak = peak(precision, threads);
    let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
    let (mut seconds, cpu) = pool.install(|| -> anyhow::Result<_> {
        time(WARM_UP)?;
        let cpu = ProcessTime::now();
        Ok((time(MEASURED)?, cpu))
    })?;
    let cpu = cpu.elapsed().as_secs_f64() / (seconds.len() as f64 * f64::from(TOGETHER));
    let mean = seconds.iter().sum::<f64>() / seconds.len() as f64;
    seconds.sort_by(f64::total_cmp);
    let median = seconds[seconds.len() / 2];
    Ok(UpdateSpeed {
        batch,
        inputs,
        engine: engine.name(),
        precision: precision.name(),
        threads,
        ms_per_update: 1e3 * median,
        mean_ms_per_update: 1e3 * mean,
        cpu_ms_per_update: 1e3 * cpu,
        gflops: flops::of_update(&config, batch, inputs, ACTION) / median / 1e9,
        peak_gflops: peak.map(|peak| peak / 1e9),
    })
}

/// Floating-point operations per second of the fused engine's matrix products on `threads` threads
/// at a time.
#[cfg(feature = "fused")]
fn peak(precision: Precision, threads: usize) -> Option<f64> {
    use rher_core::learner::fused::gemm_peak;
    // The shape, `[rows, width] · [width, width]`, of the products of hidden layers of this width.
    const ROWS: usize = 256;
    const WIDTH: usize = 256;
    let peak: f64 = std::thread::scope(|scope| {
        let probes: Vec<_> =
            (0..threads).map(|_| scope.spawn(|| gemm_peak(precision, ROWS, WIDTH))).collect();
        probes.into_iter().filter_map(|probe| probe.join().ok()).sum()
    });
    (peak > 0.0).then_some(peak)
}

#[cfg(not(feature = "fused"))]
fn peak(_precision: Precision, _threads: usize) -> Option<f64> {
    None
}
