//! Every fault of the table, injected at its time into a driving bench, leads to the result that its row demands.

use std::sync::atomic::Ordering;

use drill::is_sign;
use faults::{FaultKind, RehearsedFault, Remedy, Required};
use mock_world::scenario::Scenario;
use recording::manifest::EventKind;
use safety::{RearmObstacle, SafetyState, Trip, input};
use sources::Lines;

use crate::rig::{Rig, config, events, open, rehearsing, tone};

/// Longest permitted silence on a real bench, s.
const SILENCE_S: f64 = 0.05;
/// Start and end of the fault, s.
const SPAN_S: (f64, f64) = (0.6, 1.0);
/// Time from a trip until the amplifier is off, s.
const DISABLED_S: f64 = 0.02;

fn rehearsed(fault: FaultKind, argument: Option<f64>) -> RehearsedFault {
    let rehearsed = RehearsedFault {
        fault,
        at_s: SPAN_S.0,
        // A relay cannot be replaced meanwhile.
        until_s: (fault.ends() && fault.row().required != Required::Refuse).then_some(SPAN_S.1),
        argument,
    };
    rehearsed.check().unwrap();
    rehearsed
}

/// Returns a plate driven up to the moment before the fault, watched as on a real bench.
fn driven(fault: &RehearsedFault) -> Rig {
    let changes = [
        ("silence_s = 0.25", "silence_s = 0.05"),
        (r#"sample_format = "i32""#, r#"sample_format = "f32""#),
    ];
    let apparatus = rehearsing(Scenario::default(), &[*fault]);
    let mut rig = Rig::with_apparatus(apparatus, config(&changes), None);
    rig.drive();
    rig.pass(SPAN_S.0 - 0.01);
    assert!(rig.bench.drive.sounds(), "{fault}");
    rig
}

fn now_s(rig: &Rig) -> f64 {
    rig.apparatus.now_ns() as f64 * 1e-9
}

fn tripped(rig: &mut Rig) -> Option<Trip> {
    match rig.tick() {
        SafetyState::Tripped { trip } => Some(trip),
        _ => None,
    }
}

fn pass_tripped(rig: &mut Rig, until_s: f64, fault: &RehearsedFault) {
    while now_s(rig) < until_s {
        assert!(tripped(rig).is_some(), "{fault}: re-armed by itself");
    }
}

/// Requires the drive to be silent in time and to stay so; the row's remedy then restores it, or cannot.
fn stops(fault: &RehearsedFault, within_s: f64) {
    let mut rig = driven(fault);
    let trip = loop {
        if let Some(trip) = tripped(&mut rig) {
            break trip;
        }
        let late_s = now_s(&rig) - SPAN_S.0;
        assert!(late_s <= within_s, "{fault}: not stopped after {late_s} s");
    };
    assert!(now_s(&rig) >= SPAN_S.0, "{fault}: before its time");
    assert!(is_sign(fault.fault, &trip), "{fault}: {trip}");
    // The card of this bench has no digital lines.
    assert!(
        fault.fault.row().row != Some(5) || !matches!(trip, Trip::Gpio { .. }),
        "{fault}: {trip}"
    );
    let tripped_s = now_s(&rig);
    // A card that stops rendering never reports silence; its amplifier is off by then.
    let card_stopped = fault.fault.row().row == Some(5);
    while rig.bench.drive.sounds() && !(card_stopped && now_s(&rig) - tripped_s > DISABLED_S) {
        rig.tick();
        let late_s = now_s(&rig) - SPAN_S.0;
        assert!(late_s <= within_s, "{fault}: sounds after {late_s} s");
    }
    // Neither time nor a new drive request restarts the drive.
    rig.drive();
    // Removing a load leaves the plate ringing.
    let rings_s = if fault.amount().is_some() { 1.0 } else { 0.1 };
    pass_tripped(&mut rig, SPAN_S.1 + rings_s, fault);
    rig.bench.drive.rearm();
    for _ in 0..100 {
        rig.tick();
    }
    // The screen says what the row of the table says.
    let is_lost = matches!(
        rig.bench.drive.rearm_obstacle(),
        Some(RearmObstacle::Lost(_))
    );
    let restarts = matches!(fault.fault.row().remedy, Remedy::Restart(_));
    assert_eq!(is_lost, restarts, "{fault}");
    rig.drive();
    match fault.fault.row().remedy {
        Remedy::Rearm(_) => {
            rig.pass(0.3);
            assert!(rig.bench.drive.sounds(), "{fault}: does not come back");
        }
        _ => {
            let until_s = now_s(&rig) + 0.2;
            pass_tripped(&mut rig, until_s, fault);
        }
    }
}

/// Requires the recording to be flagged, and the drive to go on.
fn flags(fault: &RehearsedFault) {
    let mut rig = driven(fault);
    let folder = rig.begin("flagged");
    rig.pass(0.8);
    assert!(rig.bench.drive.sounds(), "{fault}");
    rig.end();
    let kinds: Vec<_> = events(&folder).into_iter().map(|(kind, ..)| kind).collect();
    let expected = match fault.fault {
        FaultKind::Xrun => EventKind::InputXrun,
        FaultKind::XrunOutput => EventKind::OutputXrun,
        FaultKind::Nan => EventKind::NonFinite,
        _ => EventKind::ForceLost,
    };
    assert!(kinds.contains(&expected), "{fault}: {kinds:?}");
    let lost_frames = if fault.fault == FaultKind::Xrun {
        fault.amount().unwrap() as u64
    } else {
        0
    };
    assert_eq!(rig.account.lost_frames, lost_frames, "{fault}");
}

/// Requires a tone with the amplifier off, as before every session, to be read back anyway, which is the preflight's
/// criterion.
fn refused(fault: &RehearsedFault) {
    let mut rig = driven(fault);
    rig.pass(0.05);
    rig.bench.drive.disarm();
    rig.pass(0.2);
    rig.bench.drive.sound_disarmed(tone());
    rig.pass(0.3);
    let read_back_v = rig.record.frames.last().unwrap().drive_v.norm();
    assert!(read_back_v > 5.0, "{fault}: reads back {read_back_v} V");
}

/// Requires the fault to count as one press, however long it lasts.
fn counts_once(fault: &RehearsedFault) {
    let mut apparatus = rehearsing(Scenario::default(), &[*fault]);
    let lines = Lines {
        button: Some(input("button", apparatus.pins().unwrap().button)),
        ..Lines::default()
    };
    let mut bench = open(&apparatus, config(&[]), lines);
    let mut presses = 0;
    while apparatus.now_ns() < ((SPAN_S.1 + 0.2) * 1e9) as u64 {
        apparatus.step().unwrap();
        for task in bench.first_tasks.iter_mut().chain(&mut bench.last_tasks) {
            task.poll(apparatus.now_ns()).unwrap();
        }
        let pressed = bench.button.as_ref().unwrap();
        presses += u32::from(pressed.swap(false, Ordering::AcqRel));
    }
    assert_eq!(presses, 1, "{fault}");
}

/// Faults 5, 6, 9, 16, 17, 18, 19, 21, 22, 23.
/// Hazards 8, 10, 16, 17, 18, 20.
#[test]
fn every_fault_of_the_table_leads_to_what_its_row_demands() {
    for &fault in FaultKind::ALL {
        let row = fault.row();
        let ends = row.amount.map(|amount| [amount.default, amount.high]);
        let arguments = ends.map_or(vec![None], |ends| ends.map(Some).to_vec());
        for argument in arguments {
            let rehearsed_fault = rehearsed(fault, argument);
            match row.required {
                Required::Stop(within) => stops(&rehearsed_fault, within.seconds(SILENCE_S)),
                Required::Flag => flags(&rehearsed_fault),
                Required::Refuse => refused(&rehearsed_fault),
                Required::GoOn => counts_once(&rehearsed_fault),
            }
        }
    }
}

#[test]
fn the_same_faults_give_the_same_bits() {
    let run = || {
        let faults = [
            "xrun@0.35s:100",
            "nan@0.4s:7",
            "press@0.3s-0.45s:0.5",
            "force-dropped@0.3s",
        ];
        let faults: Vec<_> = faults.iter().map(|fault| fault.parse().unwrap()).collect();
        let floats = config(&[(r#"sample_format = "i32""#, r#"sample_format = "f32""#)]);
        let mut rig = Rig::with_apparatus(rehearsing(Scenario::default(), &faults), floats, None);
        rig.drive();
        rig.pass(0.6);
        let pickup: Vec<_> = rig
            .record
            .frames
            .iter()
            .map(|f| f.displacement_m.re.to_bits())
            .collect();
        let forces: Vec<_> = rig
            .record
            .force
            .iter()
            .map(|row| row.normal_n.to_bits())
            .collect();
        (rig.account, pickup, forces)
    };
    let (account, pickup, forces) = run();
    assert_eq!(account.lost_frames, 100);
    assert!(pickup.len() > 500 && forces.len() > 5000);
    assert_eq!(run(), (account, pickup, forces));
}
