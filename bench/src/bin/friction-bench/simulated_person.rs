//! The simulated person at the bench: sees the participant's screen, and does the requests of a calibration.
//!
//! The tests of whole benches include this file: they simulate the same person as the program.

use calibration_rig::operator::{self, Cabling, Hands, Request};
use devices::loudspeaker::Tone;
use friction_bench::apparatus::Watcher;
use mock_hw::apparatus::{MassSet, Patchbay, Senses, VibrometerAim};
use mock_world::person::{HeardCue, PerceivedInstruction, Percept};
use mock_world::plant::{InputWiring, LoadedAxis};

/// Passes the participant's view, button and tones to the simulated person.
pub fn participant(senses: Senses) -> Watcher {
    Box::new(move |view, button, tone| {
        let instruction = match view.instruction {
            protocols::Instruction::Welcome | protocols::Instruction::Rest if button => {
                PerceivedInstruction::PressButton
            }
            protocols::Instruction::Wait
            | protocols::Instruction::Welcome
            | protocols::Instruction::ReleaseSwitch
            | protocols::Instruction::HoldSwitch => PerceivedInstruction::Wait,
            protocols::Instruction::LiftFinger => PerceivedInstruction::LiftFinger,
            protocols::Instruction::PlaceFinger => PerceivedInstruction::PlaceFinger,
            protocols::Instruction::GetReady => PerceivedInstruction::GetReady,
            protocols::Instruction::FollowSlider => PerceivedInstruction::FollowSlider,
            protocols::Instruction::Feedback => PerceivedInstruction::Feedback,
            protocols::Instruction::Rest => PerceivedInstruction::Rest,
            protocols::Instruction::Paused | protocols::Instruction::SwitchReleased => {
                PerceivedInstruction::Paused
            }
            protocols::Instruction::Finished => PerceivedInstruction::Finished,
        };
        senses.show(Percept {
            instruction,
            slider_m: view.slider_m,
            countdown: view.countdown,
            mean_force_n: view.mean_force_n,
            force_band_n: view.force_band_n,
            cue: tone.map(|tone| match tone {
                Tone::Start => HeardCue::Start,
                Tone::End => HeardCue::End,
            }),
        });
    })
}

/// Returns the hands that perform a calibration's requests to its operator at the apparatus.
pub fn hands(masses: MassSet, patchbay: Patchbay, senses: Senses, aim: VibrometerAim) -> Hands {
    Box::new(move |request| match *request {
        Request::Load { axis, mass_kg } => {
            let axis = match axis {
                operator::ForceAxis::Normal => LoadedAxis::Normal,
                operator::ForceAxis::Lateral => LoadedAxis::Lateral,
            };
            masses.place(axis, mass_kg);
        }
        Request::Unload => {
            masses.remove();
            senses.show(Percept::default());
        }
        Request::MoveVibrometer { position_m } => aim.set_position(position_m),
        Request::MoveVibrometerAcross {
            position_m,
            across_m,
        } => {
            aim.set_position(position_m);
            aim.set_across(across_m);
        }
        Request::RestFinger { least_n, most_n } => senses.show(Percept {
            instruction: PerceivedInstruction::GetReady,
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
