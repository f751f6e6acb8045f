//! An arm behind topics, as in ROS 2: two nodes that share nothing, a network that is late and loses
//! messages, and a watchdog on the arm's side.
//!
//! In ROS 2, [`Publisher`] and [`Subscriber`] are those of its client library, with the profile for
//! sensor data (best effort, keep last), and all else stays.

use super::arm::{Arm, Reading};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{JoinHandle, sleep, spawn};
use std::time::{Duration, Instant};

/// Messages that wait for a subscriber; further ones are lost.
const DEPTH: usize = 16;

/// How often the driver listens and senses.
pub(crate) const TICK: Duration = Duration::from_millis(5);

/// What becomes of messages on their way.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Network {
    pub(crate) late: Duration,
    /// Of how many messages one is lost; 1 loses all of them.
    pub(crate) loses: Option<u32>,
}

struct Message<M> {
    sent: Duration,
    arrives: Duration,
    content: M,
}

/// Where one node speaks.
pub(crate) struct Publisher<M> {
    queue: SyncSender<Message<M>>,
    network: Network,
    published: u32,
}

/// Where another one listens.
pub(crate) struct Subscriber<M> {
    queue: Receiver<Message<M>>,
    /// A message that is still on its way.
    coming: Option<Message<M>>,
}

/// A topic with one publisher and one subscriber, whose clocks agree.
fn topic<M>(network: Network) -> (Publisher<M>, Subscriber<M>) {
    let (sender, receiver) = sync_channel(DEPTH);
    let publisher = Publisher { queue: sender, network, published: 0 };
    (publisher, Subscriber { queue: receiver, coming: None })
}

impl<M> Publisher<M> {
    /// Sends, and never waits: whether anybody listens is not known, as in ROS.
    fn publish(&mut self, sent: Duration, content: M) {
        self.published += 1;
        let Network { late, loses } = self.network;
        if !loses.is_some_and(|of| self.published.is_multiple_of(of)) {
            let _ = self.queue.try_send(Message { sent, arrives: sent + late, content });
        }
    }
}

impl<M> Subscriber<M> {
    /// The newest message that has arrived since the last call. A publisher that is gone is silent,
    /// and nothing else.
    fn newest(&mut self, now: Duration) -> Option<Message<M>> {
        let mut newest = None;
        while let Some(message) = self.coming.take().or_else(|| self.queue.try_recv().ok()) {
            if message.arrives > now {
                self.coming = Some(message);
                break;
            }
            newest = Some(message);
        }
        newest
    }
}

/// What the controller asks of the driver.
pub(crate) enum Command {
    CarryOut(Vec<f32>),
    Hold,
    Stop,
}

/// The node beside the arm.
pub(crate) struct Driver<A> {
    pub(crate) arm: A,
    readings: Publisher<Reading>,
    commands: Subscriber<Command>,
    /// Silence after which the arm is stopped, and the age at which a command is too old.
    watchdog: Duration,
    /// When the last command was sent that was not too old; `None` before the first one.
    heard: Option<Duration>,
    /// When it was stopped; only a person starts it again.
    pub(crate) stopped: Option<Duration>,
}

impl<A: Arm> Driver<A> {
    /// Does what was asked last, stops in silence, and publishes what the arm senses.
    pub(crate) fn tick(&mut self, now: Duration) {
        if self.stopped.is_some() {
            return;
        }
        let now = self.arm.wait_until(now);
        if let Some(Message { sent, content, .. }) = self.commands.newest(now) {
            let is_recent = now.saturating_sub(sent) <= self.watchdog;
            match content {
                Command::Stop => return self.stop(now),
                Command::CarryOut(action) if is_recent => self.arm.carry_out(&action),
                Command::CarryOut(_) | Command::Hold => self.arm.hold(),
            }
            if is_recent {
                self.heard = Some(sent);
            }
        }
        if self.heard.is_some_and(|heard| now.saturating_sub(heard) > self.watchdog) {
            return self.stop(now);
        }
        if let Some(reading) = self.arm.read() {
            self.readings.publish(now, reading);
        }
    }

    fn stop(&mut self, now: Duration) {
        self.arm.stop();
        self.stopped = Some(now);
    }
}

/// The controller's ends of both topics.
pub(crate) struct Ends {
    readings: Subscriber<Reading>,
    commands: Publisher<Command>,
}

/// The driver of `arm`, and the ends of its topics; of the networks, the first carries readings and
/// the second commands.
pub(crate) fn driver<A: Arm>(
    arm: A,
    [of_readings, of_commands]: [Network; 2],
    watchdog: Duration,
) -> (Ends, Driver<A>) {
    let (readings, to_controller) = topic(of_readings);
    let (from_controller, commands) = topic(of_commands);
    let driver = Driver { arm, readings, commands, watchdog, heard: None, stopped: None };
    (Ends { readings: to_controller, commands: from_controller }, driver)
}

/// The arm as the controller knows it.
pub(crate) struct TopicArm<W> {
    ends: Ends,
    now: Duration,
    /// Lets time pass until a moment, and returns the time that it is then.
    wait: W,
}

impl<W: FnMut(Duration) -> Duration> TopicArm<W> {
    pub(crate) fn new(ends: Ends, wait: W) -> Self {
        Self { ends, now: Duration::ZERO, wait }
    }
}

impl<W: FnMut(Duration) -> Duration> Arm for TopicArm<W> {
    fn wait_until(&mut self, due: Duration) -> Duration {
        self.now = (self.wait)(due);
        self.now
    }

    fn read(&mut self) -> Option<Reading> {
        self.ends.readings.newest(self.now).map(|message| message.content)
    }

    fn carry_out(&mut self, action: &[f32]) {
        self.ends.commands.publish(self.now, Command::CarryOut(action.to_vec()));
    }

    fn hold(&mut self) {
        self.ends.commands.publish(self.now, Command::Hold);
    }

    fn stop(&mut self) {
        self.ends.commands.publish(self.now, Command::Stop);
    }
}

/// Both nodes on this computer's clock, the driver in a thread of its own until it is stopped.
pub(crate) fn on_wall_clock<A: Arm + Send + 'static>(
    arm: A,
    watchdog: Duration,
) -> (TopicArm<impl FnMut(Duration) -> Duration>, JoinHandle<Driver<A>>) {
    let start = Instant::now();
    let wait = move |due: Duration| {
        sleep(due.saturating_sub(start.elapsed()));
        start.elapsed()
    };
    let (ends, mut driver) = driver(arm, [Network::default(); 2], watchdog);
    let thread = spawn(move || {
        let mut now = start.elapsed();
        while driver.stopped.is_none() {
            driver.tick(now);
            now = wait(now + TICK);
        }
        driver
    });
    (TopicArm::new(ends, wait), thread)
}
