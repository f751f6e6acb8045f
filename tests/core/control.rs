//! The control loop of the examples, on an arm that breaks.

#[expect(dead_code, reason = "an example has a main function")]
#[path = "../../crates/rher-core/examples/control_loop/main.rs"]
mod control_loop;

use crate::policies::trained;
use control_loop::{Fault, Limits, SimulatedArm, Stopped, control};
use rher_core::{Desired, EnvSpec, Position};
use std::time::Duration;

const LIMITS: Limits = Limits {
    period: Duration::from_millis(1),
    // A busy machine may be late by itself.
    latest: Duration::from_millis(500),
    patience: 3,
    action: 0.5,
    change: 0.2,
};

fn run(fault: Fault, spec: &EnvSpec<1>) -> (SimulatedArm, Result<(), Stopped>) {
    let policy = trained();
    let desired = Desired::of_task([Position::new(0.4, 0.4, 0.0)]);
    let mut arm = SimulatedArm::new(4, fault);
    let outcome = control(&mut arm, spec, &policy, &desired, &LIMITS);
    assert!(arm.stopped, "{fault:?}: the arm is stopped whatever happens");
    (arm, outcome)
}

#[test]
fn an_arm_is_moved_within_limits_and_stopped_when_something_breaks() {
    let spec = EnvSpec::new("arm", 4, 3, 20);
    for fault in [Fault::None, Fault::Flickering] {
        let (arm, outcome) = run(fault, &spec);
        outcome.unwrap();
        assert_eq!(arm.carried_out.len() + arm.holds as usize, 20, "{fault:?}");
        assert_eq!(arm.holds, if fault == Fault::None { 0 } else { 5 });
        let mut last = vec![0.0; 3];
        for action in arm.carried_out {
            for (number, last) in action.iter().zip(&last) {
                assert!(number.abs() <= 0.5 && (number - last).abs() <= 0.2 + 1e-6, "{action:?}");
            }
            last = action;
        }
    }
    for fault in [Fault::Late, Fault::Frozen, Fault::Blinded] {
        let (arm, outcome) = run(fault, &spec);
        assert!(matches!(outcome, Err(Stopped::Blind(3))), "{fault:?}: {outcome:?}");
        assert_eq!((arm.carried_out.len(), arm.holds), (4, 3), "{fault:?}");
    }
    let (arm, outcome) = run(Fault::Rewired, &spec);
    assert!(matches!(outcome, Err(Stopped::Wiring(_))), "{outcome:?}");
    assert_eq!(arm.readings, 5, "it stops at once");

    let (arm, outcome) = run(Fault::None, &EnvSpec::new("arm", 4, 2, 20));
    assert!(matches!(outcome, Err(Stopped::OtherArm(_))), "{outcome:?}");
    assert_eq!(arm.readings, 0);
}
