//! Offset and rate of the forces' clock, found in the recording.

use force_alignment::{Alignment, Curves, Estimate, Film, ForceSample, align, curves};
use impedance::ZmFrame;
use import_map::{Clock, Quantity};
use num_complex::Complex64;
use recording::manifest::FoundValue;

use crate::refusal::ImportRefusal;
use crate::series::Samples;

/// Found clock of the forces.
#[derive(Debug, Clone)]
pub(crate) struct FoundClock {
    /// Offset, s.
    pub offset_s: f64,
    /// Excess of the rate, parts per million.
    pub ppm: f64,
    /// Excess of the rate that this recording alone shows, if it was to be found, parts per million.
    pub own_ppm: Option<Estimate>,
    /// Values for the recording's description.
    pub found: Vec<FoundValue>,
    /// Evidence to be drawn.
    pub curves: Option<Curves>,
    /// Sentences for a user.
    pub notes: Vec<String>,
}

impl FoundClock {
    /// Requires that each found value has an error.
    pub fn require_errors(&self) -> Result<(), ImportRefusal> {
        let has_none = |value: &&FoundValue| value.error.is_none_or(|error| !error.is_finite());
        match self.found.iter().find(has_none) {
            None => Ok(()),
            Some(value) => Err(ImportRefusal::NotFound {
                key: if value.name == PPM { PPM } else { OFFSET },
                reason: "friction and impedance agree nowhere so sharply that the time of the forces has an error: too few of the \
                         slides are covered by both, or they are not where the position has them"
                    .to_owned(),
            }),
        }
    }
}

/// Keys of the values.
const OFFSET: &str = "normal.offset_s";
const PPM: &str = "normal.ppm";
/// Greatest deviation of a clock that may be uncertain, ppm, and the standard errors that a greater one must exceed.
const GREATEST_PPM: f64 = 10_000.0;
const FEWEST_ERRORS: f64 = 10.0;

/// Returns whether the clock's offset or rate is to be found.
pub(crate) fn is_to_be_found(clock: Clock) -> bool {
    clock.offset_s == Quantity::Found || clock.ppm == Quantity::Found
}

/// Finds the clock of the forces, which `normal` and `lateral` have with provisional values; the drive's first sample is at
/// `drive_first_s`.
pub(crate) fn find(
    (normal, lateral): (&Samples, &Samples),
    (clock, drive_first_s): (Clock, f64),
    (frames, z_p_n_s_per_m): (&[ZmFrame], Complex64),
    (modulation_hz, slides_s): (f64, &[(f64, f64)]),
    common_ppm: Option<Estimate>,
) -> Result<FoundClock, ImportRefusal> {
    let key = match clock.offset_s {
        Quantity::Found => OFFSET,
        Quantity::Stated(_) => PPM,
    };
    let provisional = normal.clock;
    let lateral_at = lateral.at_samples_of(normal);
    let forces: Vec<ForceSample> = (0..normal.len())
        .map(|index| ForceSample {
            time_s: normal.drive_s(index),
            normal: normal.values[index],
            lateral: lateral_at(index),
        })
        .collect();
    let film = Film {
        frames,
        z_p_n_s_per_m,
        modulation_hz,
        slides_s,
    };
    let alignment: Alignment = align(&film, &forces).map_err(|error| ImportRefusal::NotFound {
        key,
        reason: error.to_string(),
    })?;
    let own_ppm = alignment.ppm();
    let ppm = common_ppm.unwrap_or(own_ppm);
    let used_ppm = match clock.ppm {
        Quantity::Found => ppm.value,
        Quantity::Stated(_) => 0.0,
    };
    let offset = alignment.offset_s(used_ppm);
    let offset_value = match clock.offset_s {
        Quantity::Found => offset.value,
        Quantity::Stated(_) => 0.0,
    };
    // The forces had the provisional clock: t_drive = o + (1 + p)(o₀ + (1 + p₀) t).
    let growth = 1.0 + used_ppm * 1e-6;
    let total_offset_s = offset_value + growth * provisional.offset_s;
    let total_ppm = 1e6 * (growth * (1.0 + provisional.ppm * 1e-6) - 1.0);
    let is_guess = total_ppm.abs() > GREATEST_PPM && total_ppm.abs() < FEWEST_ERRORS * ppm.std;
    if clock.ppm == Quantity::Found && is_guess {
        return Err(ImportRefusal::NotFound {
            key: PPM,
            reason: format!(
                "it would be {total_ppm:.0} ± {:.0} ppm, which no clock of a sensor is: rows may be missing; compare the number of rows \
                 with rate_hz, and state ppm",
                ppm.std
            ),
        });
    }
    let evidence = curves(&film, &forces, &alignment);
    let mut notes = Vec::new();
    if let Some(minima) = evidence.as_ref().map(|curves| &curves.false_minima)
        && !minima.is_empty()
    {
        let places: Vec<String> = minima
            .iter()
            .map(|minimum| format!("{:+.3} s", minimum.delay_s))
            .collect();
        notes.push(format!(
            "the friction's residual has further minima at a delay of {}, which the contact excludes: they lie one period of the modulation away",
            places.join(" and ")
        ));
    }
    let mut found = Vec::new();
    if clock.offset_s == Quantity::Found {
        found.push(FoundValue {
            name: OFFSET.to_owned(),
            value: total_offset_s + normal.origin_s(drive_first_s),
            error: Some(offset.std),
            unit: "s".to_owned(),
            evidence: "contact and the plate's impedance, then the least residual of the friction"
                .to_owned(),
        });
    }
    if clock.ppm == Quantity::Found {
        found.push(FoundValue {
            name: PPM.to_owned(),
            value: total_ppm,
            error: Some(ppm.std),
            unit: "ppm".to_owned(),
            evidence: match common_ppm {
                None => format!(
                    "the least residual of the friction over {:.1} s",
                    alignment.length_s
                ),
                Some(_) => "the least residual of the friction, over all recordings of the session"
                    .to_owned(),
            },
        });
    }
    Ok(FoundClock {
        offset_s: total_offset_s,
        ppm: total_ppm,
        own_ppm: (clock.ppm == Quantity::Found).then_some(own_ppm),
        found,
        curves: evidence,
        notes,
    })
}
