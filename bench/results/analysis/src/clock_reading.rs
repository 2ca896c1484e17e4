//! The clock of a recording's forces, read from the recording itself.

use force_alignment::{Alignment, CurvePoint, Film, ForceSample, Unaligned, align, friction_curve};
use plausibility::Implausible;

use crate::consistency::samples;
use crate::demodulation::DemodulatedRecording;
use crate::explorations::spans_s;
use crate::force_clock::{ForceClock, Measured, ResidualPoint};
use crate::plate_reading::PlateReading;

/// Delay of the forces, s, beyond its 95 % interval, from which it is corrected: fits allow a lag of 5 ms.
const SMALLEST_DELAY_S: f64 = 1e-3;
/// Delay beyond which one of several is no agreement, s.
const UNCLEAR_DELAY_S: f64 = 5e-3;
/// Slip of the forces at either end of the slides, s, beyond the rate's 95 % interval, and standard errors of the rate, beyond
/// which it is corrected.
const SMALLEST_SLIP_S: f64 = 1e-3;
const CERTAIN_ERRORS: f64 = 4.0;

/// Reads the clock of a recording's forces; `None` if it cannot be told.
///
/// # Errors
/// The forces are off by one of several delays.
pub(super) fn read(
    reading: &DemodulatedRecording,
    plate: Option<PlateReading>,
) -> Result<Option<ForceClock>, Implausible> {
    let Some((plate, modulation)) = plate.zip(reading.manifest.modulation()) else {
        return Ok(None);
    };
    let DemodulatedRecording {
        manifest, record, ..
    } = reading;
    let slides_s = plausibility::moving_s(&record.position, &spans_s(manifest));
    let film = Film {
        frames: &record.frames,
        z_p_n_s_per_m: plate.corrected_n_s_per_m,
        modulation_hz: modulation.frequency_hz,
        slides_s: &slides_s,
    };
    let forces = samples(&record.force);
    let is_off = |delay_s: f64| delay_s.abs() > UNCLEAR_DELAY_S;
    match align(&film, &forces) {
        Ok(alignment) => Ok(Some(force_clock(&film, &forces, &alignment))),
        Err(Unaligned::Ambiguous { first_s, second_s }) if is_off(first_s) && is_off(second_s) => {
            Err(Implausible::ForcesUnclear { first_s, second_s })
        }
        Err(_) => Ok(None),
    }
}

fn force_clock(film: &Film<'_>, forces: &[ForceSample], alignment: &Alignment) -> ForceClock {
    let (delay_s, rate) = (alignment.delay_s, alignment.rate);
    let certain_rate = rate.value.abs() - rate.half_width95();
    let slip_s = 0.5 * alignment.length_s * certain_rate;
    let point = |point: CurvePoint| ResidualPoint {
        shift_s: point.delay_s,
        residual: point.residual,
    };
    let residual = friction_curve(film, forces, alignment).into_iter();
    ForceClock {
        at_s: alignment.centre_s,
        length_s: alignment.length_s,
        offset_s: Measured {
            value: -delay_s.value,
            std: delay_s.std,
        },
        ppm: alignment.ppm().into(),
        is_offset_corrected: delay_s.value.abs() > SMALLEST_DELAY_S + delay_s.half_width95(),
        is_rate_corrected: rate.value.abs() > CERTAIN_ERRORS * rate.std && slip_s > SMALLEST_SLIP_S,
        residual: residual.map(point).collect(),
    }
}
