//! Selection of a drill's faults, their order and their times.

use config::{AudioHost, Config, Force, GpioBackend, SampleFormat};
use faults::{FaultKind, Needs, Required};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::TONE_V;

/// Shortest and longest driving time before a fault, s.
const SETTLE_S: (f64, f64) = (1.5, 5.0);

/// Requested fault that cannot be drilled on this bench.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{fault} cannot be drilled {because}")]
pub struct NotDrilledError {
    /// The fault.
    pub fault: FaultKind,
    /// Reason and remedy.
    pub because: String,
}

/// A fault of a drill, and the driving time before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlannedFault {
    pub fault: FaultKind,
    pub settle_s: f64,
}

/// Returns the reason why `fault` cannot be drilled on the bench of `config`; `None` if it can.
fn obstacle(fault: FaultKind, config: &Config, simulated: bool) -> Option<String> {
    let row = fault.row();
    if matches!(row.required, Required::Refuse | Required::GoOn) {
        return Some(format!(
            "while the bench drives: run `friction-bench check --mock --fault {fault}@0s` to see its effect"
        ));
    }
    if simulated {
        if fault == FaultKind::GpioRemoved && config.gpio.backend == GpioBackend::FieldBox {
            return Some(
                "with the lines behind a field box, gpio.backend = \"field-box\" in bench.toml: force-unplugged pulls its cable"
                    .to_owned(),
            );
        }
        let ends_the_card = [
            FaultKind::Xrun,
            FaultKind::XrunOutput,
            FaultKind::InputStops,
            FaultKind::OutputStops,
        ];
        if config.audio.host == AudioHost::Nidaqmx && ends_the_card.contains(&fault) {
            return Some(
                "with an NI card, which such a fault stops for good, audio.host = \"nidaqmx\" in bench.toml: card-lost-input is \
                 like it"
                    .to_owned(),
            );
        }
        let needs_floats =
            fault == FaultKind::Nan && config.audio.sample_format != SampleFormat::F32;
        let needs_force =
            row.row.is_some_and(|row| (21..=23).contains(&row)) && config.force.is_none();
        let needs_frames =
            fault.is_of_frames() && config.force.as_ref().is_some_and(Force::is_on_inputs);
        if needs_frames {
            return Some(
                "with forces from inputs of the card, which have no frames: force.source = \"channels\" in bench.toml"
                    .to_owned(),
            );
        }
        return match (needs_floats, needs_force) {
            (true, _) => Some(
                "with a sound card that sends whole numbers: name a --config with sample_format = \"f32\"".to_owned(),
            ),
            (_, true) => Some("without a force sensor: [force] is not in bench.toml".to_owned()),
            _ => None,
        };
    }
    let safety = &config.safety;
    match row.real.map(|real| real.needs) {
        None => Some("on real hardware: practise it with --mock".to_owned()),
        Some(Needs::Estop) if !config.gpio.has_estop() => {
            Some("without an e-stop: name estop in [gpio]".to_owned())
        }
        Some(Needs::Amplifier)
            if TONE_V * (1.0 - safety.readback_tolerance) <= safety.readback_floor_v =>
        {
            Some(format!(
                "under the faint tone of {TONE_V} V, which safety.readback_floor_v = {} V hides: lower the floor",
                safety.readback_floor_v
            ))
        }
        Some(Needs::ForceSensor) if config.force.is_none() => {
            Some("without a force sensor: [force] is not in bench.toml".to_owned())
        }
        Some(_) => None,
    }
}

/// Returns the faults of a drill, those of `selection` or all that are possible on this bench; `seed` determines order and
/// times.
///
/// # Errors
/// [`NotDrilledError`] if a fault of `selection` cannot be drilled on this bench.
pub(crate) fn draw(
    selection: &[FaultKind],
    config: &Config,
    simulated: bool,
    seed: u64,
) -> Result<Vec<PlannedFault>, NotDrilledError> {
    let mut faults = Vec::new();
    if selection.is_empty() {
        let all = FaultKind::ALL.iter().copied();
        faults.extend(all.filter(|fault| obstacle(*fault, config, simulated).is_none()));
    }
    for &fault in selection {
        if let Some(because) = obstacle(fault, config, simulated) {
            return Err(NotDrilledError { fault, because });
        }
        if !faults.contains(&fault) {
            faults.push(fault);
        }
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    faults.shuffle(&mut rng);
    let settle = |fault| PlannedFault {
        fault,
        settle_s: rng.random_range(SETTLE_S.0..SETTLE_S.1),
    };
    Ok(faults.into_iter().map(settle).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(from: &str, to: &str) -> Config {
        let text = config::rigs::MOCK_BENCH;
        assert!(text.contains(from));
        Config::parse(&text.replacen(from, to, 1), "test").unwrap()
    }

    fn faults(plan: &[PlannedFault]) -> Vec<FaultKind> {
        plan.iter().map(|planned| planned.fault).collect()
    }

    #[test]
    fn a_seed_draws_the_same_order_and_another_seed_another() {
        let config = config("[force]", "[force]");
        let draw = |seed| draw(&[], &config, true, seed).unwrap();
        assert_eq!(draw(1), draw(1));
        assert_ne!(faults(&draw(1)), faults(&draw(2)));
        let sorted_faults = |seed| {
            let mut faults = faults(&draw(seed));
            faults.sort();
            faults
        };
        assert_eq!(sorted_faults(1), sorted_faults(2));
        let drilled = FaultKind::ALL.iter().filter(|fault| fault.is_drilled());
        // A card with integer samples sends no NaN.
        assert_eq!(draw(1).len(), drilled.count() - 1);
        for planned in draw(1) {
            assert!((SETTLE_S.0..SETTLE_S.1).contains(&planned.settle_s));
        }
    }

    #[test]
    fn a_bench_behind_a_field_box_has_no_gpio_to_remove() {
        let on_box = config(
            "backend = \"none\"",
            "backend = \"field-box\"\n[field_box]\nport = \"/dev/ttyACM0\"\n#",
        );
        let faults = faults(&draw(&[], &on_box, true, 1).unwrap());
        assert!(faults.contains(&FaultKind::ForceUnplugged));
        assert!(!faults.contains(&FaultKind::GpioRemoved));
        let refusal = draw(&[FaultKind::GpioRemoved], &on_box, true, 1);
        assert!(refusal.is_err_and(|error| error.to_string().contains("gpio.backend")));
    }

    #[test]
    fn an_undrillable_fault_is_refused_if_it_is_selected() {
        let mock = config("[force]", "[force]");
        let is_refused = |fault, config: &Config, simulated| {
            let plan = draw(&[FaultKind::Press, fault], config, simulated, 1);
            plan.is_err_and(|error| error.fault == fault)
        };
        for fault in [
            FaultKind::RelayWelded,
            FaultKind::ButtonHeld,
            FaultKind::Nan,
        ] {
            assert!(is_refused(fault, &mock, true), "{fault}");
        }
        let floats = config("sample_format = \"i32\"", "sample_format = \"f32\"");
        assert!(!is_refused(FaultKind::Nan, &floats, true));
        for fault in [FaultKind::Xrun, FaultKind::Estop] {
            assert!(is_refused(fault, &mock, false), "{fault}");
        }
        assert!(!is_refused(FaultKind::AmplifierOff, &mock, false));
        let floor = config("readback_floor_v = 1.0", "readback_floor_v = 1.6");
        assert!(is_refused(FaultKind::AmplifierOff, &floor, false));
        assert!(!is_refused(FaultKind::AmplifierOff, &floor, true));
    }

    #[test]
    fn a_fault_that_is_named_twice_comes_once() {
        let mock = config("[force]", "[force]");
        let plan = draw(&[FaultKind::Estop, FaultKind::Estop], &mock, true, 1).unwrap();
        assert_eq!(faults(&plan), [FaultKind::Estop]);
    }
}
