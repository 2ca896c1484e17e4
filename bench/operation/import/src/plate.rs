//! Constants of the plate: stated, or fitted to a sweep that was measured elsewhere.

use import_map::{Centre, Plate, PlateConstants};
use metrology::FittedValue;
use plate_sweep::{ModalScale, Sweep, SweepFit};
use recording::manifest::{FoundValue, RecordedPlate};

use crate::checks;
use crate::readings::Readings;
use crate::refusal::ImportRefusal;
use crate::sources::Sources;

/// Returns the plate of a recording.
pub(crate) fn recorded(
    plate: &Plate,
    carrier_hz: f64,
    sources: &mut Sources<'_>,
    readings: &Readings,
    found: &mut Vec<FoundValue>,
    notes: &mut Vec<String>,
) -> Result<RecordedPlate, ImportRefusal> {
    let (resonance_hz, force_factor_n_per_v) = match &plate.constants {
        PlateConstants::Stated {
            resonance_hz,
            force_factor_n_per_v,
            ..
        } => (*resonance_hz, *force_factor_n_per_v),
        PlateConstants::Sweep {
            file,
            force_factor_n_per_v,
        } => {
            let text = sources.text(file, "text-tables")?;
            let fault = |reason: String| ImportRefusal::Table {
                file: file.clone(),
                reason,
            };
            let sweep = Sweep::read(&text, None, None).map_err(|error| fault(error.to_string()))?;
            let fit = SweepFit::new(&sweep, Some(carrier_hz))
                .map_err(|error| fault(error.to_string()))?;
            notes.extend(
                sweep
                    .notes()
                    .iter()
                    .chain(fit.notes())
                    .map(|note| format!("{file}: {note}")),
            );
            let evidence = format!("the resonance in {file} nearest to the carrier");
            let mut add = |name: &str, fitted: FittedValue, unit: &str| {
                found.push(FoundValue {
                    name: name.to_owned(),
                    value: fitted.value,
                    error: Some(fitted.standard_error),
                    unit: unit.to_owned(),
                    evidence: evidence.clone(),
                });
                fitted.value
            };
            let resonance_hz = add("plate.resonance_hz", fit.resonance_hz(), "Hz");
            add("plate.quality", fit.quality(), "");
            let mass = FittedValue {
                value: plate.modal_mass_kg,
                standard_error: 0.0,
            };
            let constants = fit.constants(ModalScale::ModalMass(mass));
            let force_factor = match force_factor_n_per_v {
                Some(stated) => *stated,
                None => add(
                    "plate.force_factor_n_per_v",
                    constants.force_factor_n_per_v,
                    "N/V",
                ),
            };
            (resonance_hz, force_factor)
        }
    };
    let centre_m = match plate.centre {
        Centre::Stated(metres) => metres,
        Centre::MiddleOfTravel => checks::middle_of_travel(readings, notes),
    };
    Ok(RecordedPlate {
        resonance_hz,
        modal_mass_kg: plate.modal_mass_kg,
        force_factor_n_per_v,
        centre_m,
        profile: None,
        across: None,
    })
}
