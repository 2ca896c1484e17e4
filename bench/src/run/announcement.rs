//! The operator's screen before the first step of a session: bench, earlier trials, notices.

use config::Config;
use contact::AssumedConstants;
use devices::loudspeaker::Loudspeaker;
use devices::{Bench, Life};
use drill::rehearsed;
use live::past_trials::past_trials;
use operator_ui::console::Front;
use protocols::{NOT_STATED, PersonDetail, Protocol};
use recording::disk_limit;
use tui::Event;
use tui::event::LogLevel::{self, Info, Warning};
use tui::event::{BenchFacts, SessionHeader};

use super::files::EarlierPart;
use super::lost_recordings;
use super::participant_session::ParticipantSession;
use super::plan::SessionPlan;

/// Shows the bench and the session; `left` is the driving time left, in words.
pub(super) fn show_bench(
    front: &mut dyn Front,
    plan: &SessionPlan,
    session: &ParticipantSession,
    (bench, facts, simulated): (&Bench, BenchFacts, bool),
    (earlier, left): (EarlierPart, String),
) {
    let (config, protocol) = (plan.bench.config(), &plan.protocol.protocol);
    let calibration = plan.bench.calibration();
    front.show(Event::Session(SessionHeader {
        replayed: false,
        participant: Some(plan.participant.to_string()),
        protocol: Some(protocol.name.clone()),
        study: Some(plan.study.display().to_string()),
        calibration_label: calibration.map(|calibration| calibration.label().to_owned()),
        uncalibrated: calibration.is_none(),
        simulated,
        plate_length_m: config.plate.length_m,
        kept_m: Some(central_section_m(config, protocol)),
    }));
    let (records, fits) = (session.machine.records(), &session.history.fits);
    let past_trials = past_trials(records, fits, protocol);
    let crops = earlier.crops.into_iter().map(Event::Crop);
    for event in past_trials.into_iter().chain(crops) {
        front.show(event);
    }
    front.show(Event::Bench(facts));
    front.show(Event::ForceBand {
        min_n: protocol.force.min_n,
        max_n: protocol.force.max_n,
    });
    let mut log = |level, text: String| front.show(Event::Log { level, text });
    if let Some((text, is_intact)) = earlier.last_trial {
        log(if is_intact { Info } else { Warning }, text);
    }
    for recording in &earlier.losses {
        log(Warning, lost_recordings::warning(recording));
    }
    for text in disk_limit::take_notices() {
        log(Warning, text);
    }
    for text in config.safety.dead_man_in_words().into_iter().chain([left]) {
        log(Info, text);
    }
    // A simulated room has the pressure that is assumed.
    if let Some(text) = pressure_reminder(config, plan.headless).filter(|_| !simulated) {
        log(Info, text);
    }
    let warnings = rehearsed::notice(&plan.rehearsed)
        .into_iter()
        .chain(config.safety_notices(plan.carrier_hz, plan.pace))
        .chain(plan.unverified.clone())
        .chain(plan.bench.wavelength_contradiction());
    for notice in warnings {
        log(Warning, notice);
    }
    if !bench.has_position {
        let text = "no encoder: positions are not recorded, and no stretch can be selected live";
        log(Warning, text.to_owned());
    }
    if bench.button.is_none() {
        let text = "no button: a finger at rest on the plate for a second counts as ready";
        log(Warning, text.to_owned());
    }
}

/// Returns a notice if no ambient pressure is stated; for an operator at a terminal, with the remedy.
fn pressure_reminder(config: &Config, headless: bool) -> Option<String> {
    if config.room.pressure_hpa.is_some() {
        return None;
    }
    let assumed_hpa = 1e-2 * AssumedConstants::ESTIMATION.ambient_pressure_pa;
    let remedy = if headless {
        ""
    } else {
        "; read a barometer at the bench, and state it: --pressure-hpa 998, or pressure_hpa in [room] of bench.toml"
    };
    Some(format!(
        "ambient pressure not stated: {assumed_hpa:.2} hPa is assumed{remedy}"
    ))
}

/// Opens the participant's loudspeaker; a session without it goes on, with a warning.
pub(super) fn open_sound(
    front: &mut dyn Front,
    life: &Life,
    config: &Config,
) -> Option<Loudspeaker> {
    Loudspeaker::open(life.host(), &config.sound).unwrap_or_else(|error| {
        let text = format!(
            "no sound for the participant: {}; the session goes on without",
            bounded_files::cause_line(error.as_ref())
        );
        show(front, Warning, text);
        None
    })
}

/// Shows the participant's details that are not stated or not taken, and the skin of earlier trials.
pub(super) fn show_participant(
    front: &mut dyn Front,
    plan: &SessionPlan,
    session: &ParticipantSession,
) {
    if plan.headless && !session.ask.is_empty() {
        let unstated: Vec<_> = session.ask.iter().map(ToString::to_string).collect();
        show(front, Info, format!("not stated: {}", unstated.join(", ")));
    }
    for detail in PersonDetail::ALL {
        let (typed, recorded) = (plan.person.text(detail), session.person.text(detail));
        if typed != NOT_STATED && typed != recorded {
            show(
                front,
                Warning,
                format!(
                    "participants.tsv already has {detail} {recorded} for {}: {typed} is ignored",
                    plan.participant
                ),
            );
        }
    }
    let skin = session
        .resumed
        .skin
        .used(&AssumedConstants::ESTIMATION, None);
    if skin.trials > 0 {
        for line in skin.lines() {
            show(front, Info, line);
        }
    }
}

fn show(front: &mut dyn Front, level: LogLevel, text: String) {
    front.show(Event::Log { level, text });
}

fn central_section_m(config: &Config, protocol: &Protocol) -> (f64, f64) {
    let half_m = protocol.selection.central_m / 2.0;
    (
        config.plate.centre_m - half_m,
        config.plate.centre_m + half_m,
    )
}

#[cfg(test)]
mod tests {
    use config::Room;

    use super::*;

    #[test]
    fn a_pressure_that_is_not_stated_is_mentioned_with_the_remedy_on_a_terminal() {
        let mut config = Config::parse(config::rigs::MOCK_BENCH, "bench.toml").unwrap();
        let unattended = pressure_reminder(&config, true).unwrap();
        assert!(
            unattended.ends_with("1013.25 hPa is assumed"),
            "{unattended}"
        );
        let attended = pressure_reminder(&config, false).unwrap();
        assert!(attended.contains("--pressure-hpa"), "{attended}");
        config.room = Room {
            pressure_hpa: Some(998.0),
        };
        assert_eq!(pressure_reminder(&config, false), None);
    }
}
