//! A plate with recordings in closed form, and its demodulation.
#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot go on should stop with the error"
)]

use impedance::{
    ChannelScales, Demodulator, EnvelopeFrame, Filter, FilterSettings, InputChannel,
    OUTPUT_RATE_HZ, PlateConstants,
};
use num_complex::Complex64;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

const I: Complex64 = Complex64::I;
pub const PLATE: PlateConstants = PlateConstants {
    resonance_hz: 35_000.0,
    modal_mass_kg: 0.008,
    force_factor_n_per_v: 0.13,
};
pub const DAMPING_N_S_PER_M: f64 = 7.01;
pub const CHANNELS: ChannelScales = ChannelScales {
    drive_volts_per_unit: 20.0,
    pickup_metres_per_unit: 2e-6,
    pickup_phase_rad: 0.3,
};

/// The demodulation filter at the usual frame rate.
pub fn filter(sample_rate_hz: u32, carrier_hz: f64) -> Filter {
    Filter::new(FilterSettings {
        sample_rate_hz,
        carrier_hz,
        output_rate_hz: OUTPUT_RATE_HZ,
    })
    .unwrap()
}

/// A channel that clips at full scale.
pub fn input(channel: usize) -> InputChannel {
    InputChannel {
        channel,
        clip_level: 1.0,
    }
}

/// Returns exp(2πi·turns) for a whole number of samples, with the turns reduced before rounding.
pub fn turn(hz: f64, rate: u32, n: u64) -> Complex64 {
    let seconds = n / u64::from(rate);
    let rest = (n % u64::from(rate)) as f64 / f64::from(rate);
    Complex64::cis(TAU * ((hz.fract() * seconds as f64).fract() + hz * rest).fract())
}

/// Returns all frames of drive and pickup in a stereo recording.
pub fn demodulate(filter: &Filter, interleaved: &[f32]) -> Vec<EnvelopeFrame<2>> {
    let mut frames = vec![];
    Demodulator::drive_and_pickup(filter.clone(), 2, input(0), input(1))
        .unwrap()
        .push(interleaved, |frame| frames.push(*frame))
        .unwrap();
    frames
}

/// Exact recording of the unloaded plate: a displacement envelope Σ aₖ exp(iΩₖt) needs the drive Σ Fₖ/γ with
/// Fₖ = i(ω+Ωₖ)·Z_p(ω+Ωₖ)·aₖ at each of its sidebands.
pub fn plate_recording(
    carrier_hz: f64,
    rate: u32,
    seconds: f64,
    index: f64,
    noise: f64,
    seed: u64,
) -> Vec<f32> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let omega = TAU * carrier_hz;
    let stiffness = PLATE.stiffness_n_per_m();
    let lines: Vec<(f64, Complex64, Complex64)> =
        [(0.0, 1.0), (6.0, index / 2.0), (-6.0, -index / 2.0)]
            .into_iter()
            .map(|(hz, weight)| {
                let x = 2e-6 * 0.4 * weight * if hz == 0.0 { Complex64::ONE } else { -I };
                let w = omega + TAU * hz;
                let z = DAMPING_N_S_PER_M + I * (w * PLATE.modal_mass_kg - stiffness / w);
                let drive =
                    I * w * z * x / PLATE.force_factor_n_per_v / CHANNELS.drive_volts_per_unit;
                let pickup = x / Complex64::from_polar(
                    CHANNELS.pickup_metres_per_unit,
                    CHANNELS.pickup_phase_rad,
                );
                (carrier_hz + hz, drive, pickup)
            })
            .collect();
    (0..(seconds * f64::from(rate)) as u64)
        .flat_map(|n| {
            let sum = |pick: fn(&(f64, Complex64, Complex64)) -> Complex64| -> f64 {
                lines
                    .iter()
                    .map(|line| (pick(line) * turn(line.0, rate, n)).re)
                    .sum()
            };
            let mut jitter = || -> f64 {
                let normal: f64 = StandardNormal.sample(&mut random);
                noise * normal
            };
            [
                (sum(|l| l.1) + jitter()) as f32,
                (sum(|l| l.2) + jitter()) as f32,
            ]
        })
        .collect()
}
