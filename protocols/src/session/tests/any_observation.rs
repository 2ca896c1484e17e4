//! Sessions under arbitrary observations.

use super::rig::*;
use crate::session::*;
use proptest::prelude::*;

/// One step of an arbitrary participant, operator and bench.
#[derive(Clone, Debug)]
enum Move {
    /// The participant follows the screen for a while; the operator ends a pause or does not.
    Follow {
        steps: u8,
        resume: bool,
    },
    Anything {
        dt_s: f64,
        normal_n: Option<f64>,
        button: bool,
        command: Option<OperatorCommand>,
    },
    Trip,
    LoseDisplay,
    /// The dead-man switch is not held, or the hour's driving time is used up, for a while.
    Delay {
        steps: u16,
        hold: Option<DeadManAction>,
        drive_wait_s: f64,
    },
    Analyse {
        normal_n: f64,
    },
    /// The recorder reports the recording that ended last, possibly again, or stops reporting.
    Record {
        fails: bool,
        tells: bool,
        lag_s: f64,
    },
}

/// A command about one of the first attempts.
fn attempt_command(
    command: fn(u32, u32) -> OperatorCommand,
) -> impl Strategy<Value = OperatorCommand> {
    (1u32..4, 1u32..3).prop_map(move |(number, attempt)| command(number, attempt))
}

fn a_move() -> impl Strategy<Value = Move> {
    let command = prop_oneof![
        Just(consent()),
        Just(OperatorCommand::Continue),
        Just(OperatorCommand::Pause),
        Just(OperatorCommand::Resume),
        attempt_command(|number, attempt| OperatorCommand::PauseNow { number, attempt }),
        attempt_command(|number, attempt| OperatorCommand::Redo { number, attempt }),
        attempt_command(|number, attempt| OperatorCommand::AcceptAnyway { number, attempt }),
    ];
    // Aborts are rare, or few sessions would get far.
    let command = prop_oneof![100 => command, 1 => Just(OperatorCommand::Abort)];
    let hold = prop::option::of(prop_oneof![
        Just(DeadManAction::Release),
        Just(DeadManAction::Press),
        Just(DeadManAction::Held)
    ]);
    let dt_s = prop_oneof![Just(0.0), -1.0..3.0, Just(40.0), Just(f64::NAN)];
    let normal_n = prop::option::of(prop_oneof![Just(0.0), -0.1..1.5, Just(f64::NAN)]);
    prop_oneof![
        12 => (1u8..200, any::<bool>()).prop_map(|(steps, resume)| Move::Follow { steps, resume }),
        4 => (dt_s, normal_n, any::<bool>(), prop::option::of(command))
            .prop_map(|(dt_s, normal_n, button, command)| Move::Anything { dt_s, normal_n, button, command }),
        1 => Just(Move::Trip),
        1 => Just(Move::LoseDisplay),
        2 => (1u16..8000, hold, prop_oneof![Just(0.0), Just(700.0), Just(f64::NAN)])
            .prop_map(|(steps, hold, drive_wait_s)| Move::Delay { steps, hold, drive_wait_s }),
        2 => (0.1..1.5).prop_map(|normal_n| Move::Analyse { normal_n }),
        2 => (any::<bool>(), any::<bool>(), prop_oneof![Just(0.0), Just(3.0), Just(f64::NAN)])
            .prop_map(|(fails, tells, lag_s)| Move::Record { fails, tells, lag_s }),
    ]
}

proptest! {
    #[test]
    fn invariants_hold_for_any_observations(
        consented: bool, moves in prop::collection::vec(a_move(), 1..150),
    ) {
        let mut rig = Rig::new(demo());
        if consented {
            rig.tell(consent());
        }
        for a_move in moves {
            match a_move {
                Move::Follow { steps, resume } => {
                    if resume {
                        rig.tell(OperatorCommand::Resume);
                    }
                    for _ in 0..steps {
                        rig.step(|_| {});
                    }
                }
                Move::Anything { dt_s, normal_n, button, command } => {
                    rig.step(|o| {
                        o.t_s += dt_s;
                        o.normal_n = normal_n;
                        o.button_pressed = button;
                        o.command = command;
                    });
                    if rig.t_s.is_nan() {
                        rig.t_s = 1e3;
                    }
                }
                Move::Trip => {
                    rig.step(|o| o.safety = SafetyChain::Tripped("any".to_owned()));
                }
                Move::LoseDisplay => {
                    rig.step(|o| o.display_lost = Some("gone".to_owned()));
                }
                Move::Delay { steps, hold, drive_wait_s } => {
                    for _ in 0..steps {
                        rig.step(|o| {
                            o.hold = hold;
                            o.drive_wait_s = drive_wait_s;
                        });
                    }
                }
                Move::Analyse { normal_n } => rig.normal_n = normal_n,
                Move::Record { fails, tells, lag_s } => {
                    rig.saves = tells;
                    rig.step(|o| o.recorder_lag_s = lag_s);
                    if let Some(key) = rig.session.current().cloned().filter(|_| fails) {
                        rig.fail(&key);
                    }
                }
            }
        }
        rig.check();
        let records = records_from_events(&rig.events());
        let session_records = rig.session.records();
        prop_assert_eq!(&records[..session_records.len()], session_records);
        let result = Session::resume(demo(), sub("sub-01"), 7, &records);
        prop_assert!(result.is_ok(), "{:?}", result);
    }
}
