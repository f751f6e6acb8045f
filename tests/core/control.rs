//! The control loop of the examples, on an arm that breaks and on a network that loses messages.

#[expect(dead_code, reason = "an example has a main function")]
#[path = "../../crates/rher-core/examples/control_loop/main.rs"]
mod control_loop;

use crate::policies::trained;
use control_loop::topics::{Network, TICK, TopicArm, driver, on_wall_clock};
use control_loop::{Arm as _, Fault, Limits, SimulatedArm, Stopped, control};
use rher_core::{Control, Desired, EnvSpec, Position};
use std::time::Duration;

const PERIOD: Duration = Duration::from_millis(50);

const LIMITS: Limits =
    Limits { latest: Duration::from_millis(120), patience: 3, action: 0.5, change: 0.2 };

/// An arm for which the policy was trained, for 20 steps at 20 Hz.
fn spec() -> EnvSpec<1> {
    let mut spec = EnvSpec::new("arm", 4, 3, 20);
    spec.control = Control { rate_hz: Some(20.0), ..Control::default() };
    spec
}

fn desired() -> Desired<1> {
    Desired::of_task([Position::new(0.4, 0.4, 0.0)])
}

fn run(fault: Fault, spec: &EnvSpec<1>) -> (SimulatedArm, Result<(), Stopped>) {
    let policy = trained().of_env(&self::spec());
    let mut arm = SimulatedArm::new(4, fault);
    let outcome = control(&mut arm, spec, policy, &desired(), LIMITS);
    assert!(arm.stopped, "{fault:?}: the arm is stopped whatever happens");
    (arm, outcome)
}

fn assert_is_within_limits(actions: &[Vec<f32>]) {
    let mut last = &vec![0.0; 3];
    for action in actions {
        for (number, last) in action.iter().zip(last) {
            assert!(number.abs() <= 0.5 && (number - last).abs() <= 0.2 + 1e-6, "{action:?}");
        }
        last = action;
    }
}

#[test]
fn an_arm_is_moved_within_limits_and_stopped_when_something_breaks() {
    let (arm, outcome) = run(Fault::None, &spec());
    outcome.unwrap();
    assert_eq!((arm.carried_out.len(), arm.holds), (20, 0));
    assert_is_within_limits(&arm.carried_out);

    let (arm, outcome) = run(Fault::Flickering, &spec());
    outcome.unwrap();
    assert_eq!((arm.carried_out.len(), arm.holds), (15, 5));
    // Where it held, the arm is at rest and starts again from there.
    for (moments, action) in arm.moments.windows(2).zip(&arm.carried_out[1..]) {
        let after_a_hold = moments[1] > moments[0] + PERIOD;
        assert!(!after_a_hold || action.iter().all(|number| number.abs() <= 0.2), "{action:?}");
    }

    for fault in [Fault::Late, Fault::Frozen, Fault::Blinded] {
        let (arm, outcome) = run(fault, &spec());
        assert!(matches!(outcome, Err(Stopped::Blind(3))), "{fault:?}: {outcome:?}");
        assert_eq!((arm.carried_out.len(), arm.holds), (4, 3), "{fault:?}");
    }
    let (arm, outcome) = run(Fault::Rewired, &spec());
    assert!(matches!(outcome, Err(Stopped::Wiring(_))), "{outcome:?}");
    assert_eq!(arm.readings, 5, "it stops at once");
}

#[test]
fn a_policy_for_another_arm_never_moves_this_one() {
    let narrow = EnvSpec { action_dim: 2, ..spec() };
    let (arm, outcome) = run(Fault::None, &narrow);
    assert!(matches!(outcome, Err(Stopped::OtherArm(_))), "{outcome:?}");
    assert_eq!(arm.readings, 0);

    let mut faster = spec();
    faster.control.rate_hz = Some(100.0);
    let (arm, outcome) = run(Fault::None, &faster);
    assert!(matches!(outcome, Err(Stopped::OtherControl { .. })), "{outcome:?}");
    assert_eq!(arm.readings, 0);

    let unknown = EnvSpec::new("arm", 4, 3, 20);
    let mut arm = SimulatedArm::new(4, Fault::None);
    let outcome = control(&mut arm, &unknown, trained(), &desired(), LIMITS);
    assert!(matches!(outcome, Err(Stopped::NoRate)), "{outcome:?}");
    assert!(arm.stopped && arm.readings == 0);
}

#[test]
fn what_a_stall_has_missed_is_not_made_up_for_in_a_burst() {
    let (arm, outcome) = run(Fault::Stalled, &spec());
    outcome.unwrap();
    assert_eq!(arm.carried_out.len(), 20);
    let gaps = arm.moments.windows(2).map(|pair| pair[1].saturating_sub(pair[0]));
    let gaps: Vec<Duration> = gaps.collect();
    assert!(gaps.iter().all(|gap| *gap >= PERIOD), "{gaps:?}");
    assert!(gaps.contains(&(PERIOD + Duration::from_secs(1))), "{gaps:?}");
}

/// What became of an arm behind topics, in simulated time, after its controller had ended and
/// another second had passed.
fn run_behind_topics(
    networks: [Network; 2],
    watchdog: Duration,
) -> (SimulatedArm, Option<Duration>, Result<(), Stopped>) {
    let policy = trained().of_env(&spec());
    let (ends, mut driver) = driver(SimulatedArm::new(4, Fault::None), networks, watchdog);
    let mut now = Duration::ZERO;
    let mut arm = TopicArm::new(ends, |due| {
        while now < due {
            now += TICK;
            driver.tick(now);
        }
        now
    });
    let outcome = control(&mut arm, &spec(), policy, &desired(), LIMITS);
    arm.wait_until(20 * PERIOD + Duration::from_secs(1));
    (driver.arm, driver.stopped, outcome)
}

#[test]
fn an_arm_behind_topics_moves_although_messages_are_late_and_some_are_lost() {
    let watchdog = 6 * PERIOD;
    let (arm, stopped, outcome) = run_behind_topics([Network::default(); 2], watchdog);
    outcome.unwrap();
    // Nothing was sensed before the first command was due.
    assert_eq!((arm.carried_out.len(), arm.holds), (19, 1));
    assert_is_within_limits(&arm.carried_out);
    assert_eq!(stopped, Some(20 * PERIOD + TICK), "the controller stopped it");

    let late = Network { late: Duration::from_millis(80), loses: Some(4) };
    let (arm, stopped, outcome) = run_behind_topics([late; 2], watchdog);
    outcome.unwrap();
    // Every fourth command of 21 is lost, and the readings of the first two come too late for them.
    assert_eq!(arm.carried_out.len() as u32 + arm.holds, 15);
    assert!(arm.carried_out.len() >= 13, "{}", arm.carried_out.len());
    assert!(arm.carried_out.iter().flatten().all(|number| number.abs() <= 0.5));
    assert!(stopped.is_some_and(|at| at > 20 * PERIOD), "{stopped:?}");
}

#[test]
fn an_arm_behind_topics_stops_when_a_direction_is_lost() {
    let [whole, cut] = [None, Some(1)].map(|loses| Network { loses, ..Network::default() });
    let (arm, stopped, outcome) = run_behind_topics([cut, whole], 6 * PERIOD);
    assert!(matches!(outcome, Err(Stopped::Blind(3))), "{outcome:?}");
    assert_eq!((arm.carried_out.len(), arm.holds), (0, 3));
    assert!(arm.stopped && stopped.is_some());

    // No command has ever arrived: the arm is at rest, and stays there.
    let (arm, stopped, outcome) = run_behind_topics([whole, cut], 6 * PERIOD);
    outcome.unwrap();
    assert_eq!((arm.carried_out.len(), arm.holds, stopped), (0, 0, None));
}

#[test]
fn the_watchdog_stops_an_arm_whose_controller_has_ended() {
    let watchdog = 6 * PERIOD;
    let arm = SimulatedArm::new(4, Fault::None);
    let (ends, mut driver) = driver(arm, [Network::default(); 2], watchdog);
    let mut controller = TopicArm::new(ends, |due| due);
    controller.carry_out(&[0.1, 0.0, 0.0]);
    drop(controller);
    let ticks = (1..).map(|tick| TICK * tick);
    for now in ticks.take_while(|now| *now <= Duration::from_secs(10)) {
        driver.tick(now);
    }
    assert_eq!(driver.arm.carried_out.len(), 1);
    assert_eq!(driver.stopped, Some(watchdog + TICK));
}

#[test]
fn commands_that_are_too_old_do_not_move_an_arm() {
    let arm = SimulatedArm::new(4, Fault::None);
    let slow = Network { late: Duration::from_secs(1), loses: None };
    let (ends, mut driver) = driver(arm, [slow; 2], 6 * PERIOD);
    let mut controller = TopicArm::new(ends, |due| due);
    controller.carry_out(&[0.1, 0.0, 0.0]);
    driver.tick(Duration::from_secs(1));
    assert_eq!((driver.arm.carried_out.len(), driver.arm.holds), (0, 1));
    // A stop is never too old.
    controller.stop();
    driver.tick(Duration::from_secs(3));
    assert!(driver.arm.stopped);
}

#[test]
fn both_nodes_run_in_threads_of_their_own() {
    let mut spec = spec();
    spec.control.rate_hz = Some(200.0);
    let policy = trained().of_env(&spec);
    // A busy machine may be late by itself.
    let limits = Limits { latest: Duration::from_secs(5), patience: 20, ..LIMITS };
    let arm = SimulatedArm::new(4, Fault::None);
    let (mut arm, driver) = on_wall_clock(arm, Duration::from_secs(5));
    let outcome = control(&mut arm, &spec, policy, &desired(), limits);
    let driver = driver.join().unwrap();
    assert!(driver.arm.stopped, "{outcome:?}");
    assert!(driver.arm.readings > 0);
}
