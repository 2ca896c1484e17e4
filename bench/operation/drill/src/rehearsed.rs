//! Checks and notices for injected faults; the notices keep a rehearsal from being taken for data.

use anyhow::bail;
use config::{Config, Force, GpioBackend, SampleFormat};
use faults::{FaultKind, RehearsedFault, require_apart};

/// Requires that the faults can be injected into the hardware of `config`, simulated or real.
///
/// # Errors
/// On real hardware, for simultaneous faults of the same kind, and for faults that the configured hardware cannot show.
pub fn require_possible(
    faults: &[RehearsedFault],
    config: &Config,
    simulated: bool,
) -> anyhow::Result<()> {
    if !simulated && !faults.is_empty() {
        bail!(
            "--fault injects faults into simulated hardware, and this is real: practise with --mock; `friction-bench drill` \
             asks for the real action (press, unplug, switch off) and times it"
        );
    }
    require_apart(faults)?;
    let floats = config.audio.sample_format == SampleFormat::F32;
    if !floats && faults.iter().any(|fault| fault.fault == FaultKind::Nan) {
        bail!(
            "{} cannot be injected: the sound card sends whole numbers; name a --config with sample_format = \"f32\"",
            FaultKind::Nan
        );
    }
    if config.force.as_ref().is_some_and(Force::is_on_inputs)
        && let Some(fault) = faults.iter().find(|fault| fault.fault.is_of_frames())
    {
        bail!(
            "{} cannot be injected: forces come from inputs of the card, which have no frames (force.source = \"channels\")",
            fault.fault
        );
    }
    let on_box = config.gpio.backend == GpioBackend::FieldBox;
    if on_box
        && faults
            .iter()
            .any(|fault| fault.fault == FaultKind::GpioRemoved)
    {
        bail!(
            "{} cannot be injected: the lines are the field box's (gpio.backend = \"field-box\"); {} pulls its cable",
            FaultKind::GpioRemoved,
            FaultKind::ForceUnplugged
        );
    }
    Ok(())
}

/// Returns the faults in the form of `--fault`, for files and screens.
#[must_use]
pub fn words(faults: &[RehearsedFault]) -> Vec<String> {
    faults.iter().map(ToString::to_string).collect()
}

/// Returns the warning that faults are injected; `None` if `rehearsed` is empty.
#[must_use]
pub fn notice(rehearsed: &[String]) -> Option<String> {
    (!rehearsed.is_empty()).then(|| {
        format!(
            "REHEARSAL, not data: faults are injected: {}",
            rehearsed.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn possible(faults: &[&str], format: &str, simulated: bool) -> bool {
        let text = config::rigs::MOCK_BENCH.replace("\"i32\"", format);
        let config = Config::parse(&text, "test").unwrap();
        let faults: Vec<_> = faults.iter().map(|fault| fault.parse().unwrap()).collect();
        require_possible(&faults, &config, simulated).is_ok()
    }

    #[test]
    fn faults_are_injected_where_they_can_be() {
        assert!(possible(&["estop@1s", "xrun@1s"], "\"i32\"", true));
        assert!(!possible(&["estop@1s"], "\"i32\"", false), "real hardware");
        assert!(possible(&[], "\"i32\"", false));
        assert!(!possible(&["estop@1s", "estop@2s"], "\"i32\"", true));
        assert!(!possible(&["nan@1s"], "\"i32\"", true));
        assert!(possible(&["nan@1s"], "\"f32\"", true));
    }

    #[test]
    fn a_notice_names_the_faults_as_they_are_typed() {
        assert_eq!(notice(&[]), None);
        let fault: RehearsedFault = "press@500ms-2s:4N".parse().unwrap();
        let notice = notice(&words(&[fault])).unwrap();
        assert!(notice.contains("press@0.5s-2s:4"), "{notice}");
    }
}
