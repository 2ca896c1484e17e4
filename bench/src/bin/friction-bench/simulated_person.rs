//! The simulated person at the bench: sees the participant's screen, and does the requests of a calibration.
//!
//! The tests of whole benches include this file: they simulate the same person as the program.

use calibration_rig::operator::{self, Cabling, Hands, Request};
use devices::loudspeaker::Tone;
use friction_bench::apparatus::Watcher;
use mock_hw::apparatus::{MassSet, Patchbay, Senses, VibrometerAim};
use mock_world::person::{Cue, Instruction, Percept};
use mock_world::plant::{Axis, InputWiring};

/// Passes the participant's view, button and tones to the simulated person.
pub fn participant(senses: Senses) -> Watcher {
    Box::new(move |view, button, tone| {
        let instruction = match view.instruction {
            protocols::Instruction::Welcome | protocols::Instruction::Rest if button => {
                Instruction::PressButton
            }
            protocols::Instruction::Wait
            | protocols::Instruction::Welcome
            | protocols::Instruction::ReleaseSwitch
            | protocols::Instruction::HoldSwitch => Instruction::Wait,
            protocols::Instruction::LiftFinger => Instruction::LiftFinger,
            protocols::Instruction::PlaceFinger => Instruction::PlaceFinger,
            protocols::Instruction::GetReady => Instruction::GetReady,
            protocols::Instruction::FollowSlider => Instruction::FollowSlider,
            protocols::Instruction::Feedback => Instruction::Feedback,
            protocols::Instruction::Rest => Instruction::Rest,
            protocols::Instruction::Paused | protocols::Instruction::SwitchReleased => {
                Instruction::Paused
            }
            protocols::Instruction::Finished => Instruction::Finished,
        };
        senses.show(Percept {
            instruction,
            slider_m: view.slider_m,
            countdown: view.countdown,
            mean_force_n: view.mean_force_n,
            force_band_n: view.force_band_n,
            cue: tone.map(|tone| match tone {
                Tone::Start => Cue::Start,
                Tone::End => Cue::End,
            }),
        });
    })
}

/// Returns the hands that perform a calibration's requests to its operator at the apparatus.
pub fn hands(masses: MassSet, patchbay: Patchbay, senses: Senses, aim: VibrometerAim) -> Hands {
    Box::new(move |request| match *request {
        Request::Load { axis, mass_kg } => {
            let axis = match axis {
                operator::ForceAxis::Normal => Axis::Normal,
                operator::ForceAxis::Lateral => Axis::Lateral,
            };
            masses.place(axis, mass_kg);
        }
        Request::Unload => {
            masses.remove();
            senses.show(Percept::default());
        }
        Request::MoveVibrometer { position_m } => aim.at(position_m),
        Request::RestFinger { least_n, most_n } => senses.show(Percept {
            instruction: Instruction::GetReady,
            force_band_n: Some((least_n, most_n)),
            ..Percept::default()
        }),
        Request::Connect(cabling) => patchbay.wire(match cabling {
            Cabling::AllInputs => InputWiring::AllInputs,
            Cabling::DriveOnly => InputWiring::DriveOnly,
            Cabling::Bench => InputWiring::Bench,
        }),
        Request::NameMass { .. }
        | Request::KnownAmplitude { .. }
        | Request::MeterReading { .. }
        | Request::GoOn
        | Request::Review => {}
    })
}
