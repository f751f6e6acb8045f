//! Training as it goes on, on a local WebSocket for Foxglove.

use crate::message::{Timed, Topic};
use crate::player::Player;
use crate::schemas;
use foxglove::{Context, PartialMetadata, RawChannel, Schema, WebSocketServerHandle};
use rher_core::event::Metrics;
use rher_core::explore::ActionLog;
use rher_envs::Simulated;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, SyncSender};
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// How long the end of an episode is shown.
const PAUSE: Duration = Duration::from_millis(500);

/// The server cannot be started.
#[derive(Debug, thiserror::Error)]
#[error("cannot serve on {address}")]
pub struct LiveError {
    /// Where it should listen.
    pub address: SocketAddr,
    /// What the system said.
    pub source: foxglove::FoxgloveError,
}

/// Shows episodes at the speed at which they happen, one after the other, and metrics at once.
///
/// Whoever joins in the middle of an episode sees the scene when the next one begins.
pub struct Live {
    metrics: Arc<RawChannel>,
    scripts: SyncSender<ActionLog>,
    idle: Arc<AtomicBool>,
    server: WebSocketServerHandle,
    /// Channels end with it.
    _context: Arc<Context>,
}

impl Live {
    /// Starts to serve on `address`, with nothing to see yet; port 0 is any that is free.
    pub fn start<const N: usize, E: Simulated<N>>(
        address: SocketAddr,
        player: Player<E, N>,
    ) -> Result<Self, LiveError> {
        let failed = |source| LiveError { address, source };
        let context = Context::new();
        let channel = |name: &str, encoding: &str, schema: Schema| {
            let builder = context.channel_builder(name).message_encoding(encoding).schema(schema);
            builder.build_raw().map_err(failed)
        };
        let mut channels = Vec::new();
        for topic in Topic::ALL {
            channels.push(channel(topic.name(), topic.encoding(), topic.schema())?);
        }
        let schema = Schema::new("rher.Metrics", "jsonschema", schemas::METRICS.as_bytes());
        let metrics = channel("/metrics", "json", schema)?;
        let server = context
            .websocket_server()
            .name("rher train")
            .bind(address.ip().to_string(), address.port())
            .start_blocking()
            .map_err(failed)?;
        let (scripts, to_show) = mpsc::sync_channel::<ActionLog>(1);
        let idle = Arc::new(AtomicBool::new(true));
        let shown = Arc::clone(&idle);
        thread::spawn(move || {
            let mut player = player;
            for script in to_show {
                let begin = now();
                if let Ok(messages) = player.messages(&script, begin) {
                    show(&channels, &messages, begin);
                    thread::sleep(PAUSE);
                }
                shown.store(true, Ordering::Release);
            }
        });
        Ok(Self { metrics, scripts, idle, server, _context: context })
    }

    /// Where it listens.
    pub fn port(&self) -> u16 {
        self.server.port()
    }

    /// Whether nothing is being shown.
    pub fn is_idle(&self) -> bool {
        self.idle.load(Ordering::Acquire)
    }

    /// Shows an episode, unless another one is being shown.
    pub fn show(&self, script: &ActionLog) {
        if self.is_idle() {
            self.idle.store(false, Ordering::Release);
            // There is room for one, and nobody else sends.
            let _ = self.scripts.try_send(script.clone());
        }
    }

    /// Sends what an evaluation found.
    pub fn send(&self, metrics: &Metrics) {
        if let Ok(bytes) = serde_json::to_vec(metrics) {
            self.metrics.log(&bytes);
        }
    }
}

/// Sends messages when their time has come.
fn show(channels: &[Arc<RawChannel>], messages: &[Timed], begin: u64) {
    let started = Instant::now();
    for Timed { time, message } in messages {
        let due = Duration::from_nanos(time - begin);
        thread::sleep(due.saturating_sub(started.elapsed()));
        let metadata = PartialMetadata { log_time: Some(*time) };
        channels[message.topic() as usize].log_with_meta(&message.to_bytes(), metadata);
    }
}

/// Nanoseconds since 1970.
fn now() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    since.as_nanos() as u64
}
