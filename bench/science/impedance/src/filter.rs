//! Demodulation filter of all channels.

use crate::carrier_phase::CarrierPhase;
use crate::kernel::LANES;
use crate::window::Kaiser;
use num_complex::Complex64;
use statistics::significant;
use std::f64::consts::TAU;

/// Usual rate of the envelope frames, Hz.
pub const OUTPUT_RATE_HZ: u32 = 2000;

/// Frame rates for a sample rate that is not a multiple of the usual one, Hz.
const OUTPUT_RATES_HZ: std::ops::RangeInclusive<u32> = 1500..=2500;

/// Returns the whole divisor of a sample rate that is closest to [`OUTPUT_RATE_HZ`]; `None` if none is near it.
///
/// ```
/// assert_eq!(impedance::output_rate_hz(192_000), Some(2000));
/// assert_eq!(impedance::output_rate_hz(125_000), Some(2500));
/// ```
#[must_use]
pub fn output_rate_hz(sample_rate_hz: u32) -> Option<u32> {
    OUTPUT_RATES_HZ
        .filter(|rate| sample_rate_hz.is_multiple_of(*rate))
        .min_by_key(|rate| rate.abs_diff(OUTPUT_RATE_HZ))
}

/// Returns the number of samples per frame at a sample rate: that of [`output_rate_hz`] if there is one, else a multiple of 8 near
/// the usual frame rate. Frames then have a rate that is not a whole number, and exact times all the same.
///
/// ```
/// assert_eq!(impedance::samples_per_frame(192_000.0), 96);
/// assert_eq!(impedance::samples_per_frame(156_250.0), 80);
/// ```
#[must_use]
pub fn samples_per_frame(sample_rate_hz: f64) -> u32 {
    let whole_rate_hz = sample_rate_hz as u32;
    let whole_output_rate_hz = (f64::from(whole_rate_hz) == sample_rate_hz)
        .then(|| output_rate_hz(whole_rate_hz))
        .flatten();
    match whole_output_rate_hz {
        Some(output_rate_hz) => whole_rate_hz / output_rate_hz,
        None => {
            let first_stage_rate_hz = f64::from(SMALLEST_SECOND_DECIMATION * OUTPUT_RATE_HZ);
            let first_decimation = (sample_rate_hz / first_stage_rate_hz).round().max(1.0);
            SMALLEST_SECOND_DECIMATION * first_decimation as u32
        }
    }
}

/// Minimum number of samples per output frame after the first stage, so that the noise can be
/// observed at two and three output rates from the carrier, well outside the envelope's band.
const SMALLEST_SECOND_DECIMATION: u32 = 8;
/// Fewest envelopes a second: the plate follows its drive within 2 ms.
pub const LEAST_ENVELOPE_RATE_HZ: f64 = 500.0;
/// Length of the first stage in its own output samples, and its Kaiser β: 105 dB from 14.3 to 17.7 kHz.
const FIRST_SPAN: f64 = 5.0;
const FIRST_BETA: f64 = 13.8;
/// Length of the second stage in output frames, and its Kaiser β.
const SECOND_SPAN_HOPS: u32 = 10;
const SECOND_BETA: f64 = 11.2;
/// Cut-off (−6 dB) of the second stage relative to the output rate.
const CUTOFF: f64 = 0.5;
/// Offset from the carrier, relative to the output rate, from which on everything is rejected by 100 dB.
const STOPBAND: f64 = 0.86;
/// Offsets of the noise probes in output rates, each to either side of the carrier.
const PROBE_OFFSETS: [f64; PROBE_PAIRS] = [2.0, 3.0];
pub(crate) const PROBE_PAIRS: usize = 2;

/// Settings of a demodulation filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterSettings {
    /// Rate of the audio samples, Hz.
    pub sample_rate_hz: u32,
    /// Frequency of the carrier, Hz; not necessarily a whole number.
    pub carrier_hz: f64,
    /// Rate of the envelope frames, Hz; must divide the sample rate. Usually [`OUTPUT_RATE_HZ`].
    pub output_rate_hz: u32,
}

/// Reasons why no demodulation filter can be designed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FilterError {
    /// The sample rate is not a multiple of the frame rate, so that frames would fall between samples.
    #[error(
        "sample rate {sample_rate_hz} Hz is not an integer multiple of the output rate {output_rate_hz} Hz"
    )]
    RatioNotInteger {
        /// Rate of the audio samples.
        sample_rate_hz: u32,
        /// Rate of the frames.
        output_rate_hz: u32,
    },
    /// Envelopes are too far apart to follow the modulation.
    #[error(
        "{} envelopes a second are too few: at least {LEAST_ENVELOPE_RATE_HZ} are needed", significant(*.rate_hz)
    )]
    SlowEnvelopes {
        /// Rate of the envelopes, Hz.
        rate_hz: f64,
    },
    /// Too few samples per frame.
    #[error(
        "sample rate {} Hz is under {SMALLEST_SECOND_DECIMATION} times the output rate {} Hz",
        significant(*.sample_rate_hz), significant(*.output_rate_hz)
    )]
    TooFewSamplesPerFrame {
        /// Rate of the audio samples.
        sample_rate_hz: f64,
        /// Rate of the frames.
        output_rate_hz: f64,
    },
    /// The carrier or its filter does not fit between zero and half the sample rate.
    #[error(
        "carrier {} Hz is outside {}..{} Hz, the range at a sample rate of {} Hz{}",
        significant(*.carrier_hz), significant(*.lowest_hz), significant(*.highest_hz), significant(*.sample_rate_hz),
        if (*.lowest_hz..=*.highest_hz).contains(&(1e3 * .carrier_hz)) {
            ": the number is that of kilohertz; state it in Hz"
        } else { "" }
    )]
    CarrierOutOfBand {
        /// Requested carrier.
        carrier_hz: f64,
        /// Lowest carrier at these rates.
        lowest_hz: f64,
        /// Highest carrier at these rates.
        highest_hz: f64,
        /// Rate of the audio samples.
        sample_rate_hz: f64,
    },
}

/// The demodulation filter: linear phase, immutable, shared by all channels of a [`Demodulator`](crate::Demodulator).
///
/// Two stages of windowed FIR, both f64: a short Kaiser window times the carrier that decimates to 8 or more samples
/// per frame, then a Kaiser-windowed low-pass that compensates the first one's droop and decimates to the frame rate.
/// The envelope's time derivatives come from the second stage's analytic derivative.
///
/// The first stage is g₁(n) = w₁(n)/Σw₁ with the real gain G₁(f) = Σ g₁(n) cos(2πfn/rate), w₁ a Kaiser window. The second is
/// g₂(t) = w₂(t) s(t), the window w₂ times the ideal low-pass s(t) = ∫₀^f_c 2 cos(2πft)/G₁(f) df, which has the gain 1/G₁ up to
/// the cut-off f_c. Both together have the gain G₁/G₁ = 1 in the pass-band, and w₂ smooths the edge.
///
/// Measured at the default 2 kHz by `tests/integration/filter.rs` (96, 100 and 192 kHz):
///
/// | | |
/// | --- | --- |
/// | gain error at 6 / 100 / 300 Hz from the carrier | < 1e-7 / < 1e-5 / < 5e-5 |
/// | −6 dB | 1 kHz from the carrier |
/// | rejection from 1.72 kHz from the carrier on | ≥ 105 dB |
/// | the same of DC and mains hum under a carrier of 35 kHz | ≥ 160 dB |
/// | slope that a tone in the stopband leaks (`dc_hum_and_foreign_tones_are_rejected`) | < 0.03/s of its amplitude |
/// | aliases into ±280 Hz | ≥ 100 dB down |
/// | support | ±2.6 ms |
///
/// A low-pass that is flat to 300 Hz follows the contact (gap lag about 1 ms, a corner at 160 Hz) without the bias from
/// the droop of a shorter smooth window (2 ms Hann: 9e-5 at 6 Hz, 2.5 % at 100 Hz); the cost is 5 ms of samples
/// around a gap.
#[derive(Clone, Debug)]
pub struct Filter {
    rates: Rates,
    pub(crate) phase: CarrierPhase,
    pub(crate) first: FirstStage,
    pub(crate) second: SecondStage,
    impulse: Impulse,
}

/// Rates of a filter: a whole number of samples per frame.
#[derive(Clone, Copy, Debug)]
struct Rates {
    sample_rate_hz: f64,
    carrier_hz: f64,
    output_rate_hz: f64,
}

/// Carrier and window in one complex FIR from −`lead` to `half` around its centre, zero before −`half`.
#[derive(Clone, Debug)]
pub(crate) struct FirstStage {
    pub(crate) decimation: usize,
    pub(crate) half: usize,
    pub(crate) lead: usize,
    pub(crate) re: Vec<f64>,
    pub(crate) im: Vec<f64>,
    /// exp(−iω·j·decimation / rate) for j within a hop.
    pub(crate) rotation_re: Vec<f64>,
    pub(crate) rotation_im: Vec<f64>,
}

/// Real FIR for the value and its first and second time derivative, and real and imaginary parts of the FIR that
/// observes the noise above the carrier (the conjugate observes it below), all from −`lead` to `half`, zero before
/// −`half`.
#[derive(Clone, Debug)]
pub(crate) struct SecondStage {
    pub(crate) decimation: usize,
    pub(crate) half: usize,
    pub(crate) lead: usize,
    pub(crate) taps: [Vec<f64>; 3],
    pub(crate) probes: [[Vec<f64>; 2]; PROBE_PAIRS],
    /// Ratio of the variance of an envelope's quadrature to the power in each probe, for white noise.
    pub(crate) probe_gain: [f64; PROBE_PAIRS],
}

/// Both stages as one FIR at the sample rate, for the value and its derivatives.
#[derive(Clone, Debug)]
struct Impulse {
    taps: [Vec<f64>; 3],
}

impl Filter {
    /// Designs the filter.
    ///
    /// # Errors
    /// When the rates are not in a whole ratio of at least 8, or the carrier does not fit.
    pub fn new(settings: FilterSettings) -> Result<Self, FilterError> {
        let FilterSettings {
            sample_rate_hz,
            carrier_hz,
            output_rate_hz,
        } = settings;
        if output_rate_hz == 0 || sample_rate_hz % output_rate_hz != 0 {
            return Err(FilterError::RatioNotInteger {
                sample_rate_hz,
                output_rate_hz,
            });
        }
        let hop = sample_rate_hz / output_rate_hz;
        Self::with_hop(f64::from(sample_rate_hz), carrier_hz, hop)
    }

    /// Designs the filter for a sample rate that may be any, with a frame every `hop` samples.
    ///
    /// # Errors
    /// When a frame has fewer than 8 samples, or the carrier does not fit.
    pub fn with_hop(sample_rate_hz: f64, carrier_hz: f64, hop: u32) -> Result<Self, FilterError> {
        let output_rate_hz = sample_rate_hz / f64::from(hop);
        if hop < SMALLEST_SECOND_DECIMATION {
            return Err(FilterError::TooFewSamplesPerFrame {
                sample_rate_hz,
                output_rate_hz,
            });
        }
        let rates = Rates {
            sample_rate_hz,
            carrier_hz,
            output_rate_hz,
        };
        // DC and the mirror image, twice the carrier away and aliased, must lie in the stopband.
        let guard_hz = STOPBAND * output_rate_hz;
        let (lowest_hz, highest_hz) = (guard_hz, (sample_rate_hz - guard_hz) / 2.0);
        if !(carrier_hz >= lowest_hz && carrier_hz <= highest_hz) {
            return Err(FilterError::CarrierOutOfBand {
                carrier_hz,
                lowest_hz,
                highest_hz,
                sample_rate_hz,
            });
        }

        let first_decimation = (1..=hop)
            .rev()
            .find(|d| hop.is_multiple_of(*d) && hop / d >= SMALLEST_SECOND_DECIMATION)
            .unwrap_or(1);
        let phase = CarrierPhase::new(carrier_hz, sample_rate_hz);
        let window = first_window(first_decimation);
        let (second, impulse) = SecondStage::design(&window, first_decimation, hop, rates);
        let first = FirstStage::design(&window, first_decimation, hop, &phase);
        Ok(Self {
            rates,
            phase,
            first,
            second,
            impulse,
        })
    }

    /// Designs the second stage alone, for envelopes of a carrier at an even rate.
    ///
    /// # Errors
    /// Fewer than [`LEAST_ENVELOPE_RATE_HZ`] envelopes a second.
    pub fn for_envelopes(rate_hz: f64, carrier_hz: f64) -> Result<Self, FilterError> {
        if !(rate_hz >= LEAST_ENVELOPE_RATE_HZ && rate_hz.is_finite()) {
            return Err(FilterError::SlowEnvelopes { rate_hz });
        }
        let hop = (rate_hz / f64::from(OUTPUT_RATE_HZ)).round().max(1.0) as u32;
        let rates = Rates {
            sample_rate_hz: rate_hz,
            carrier_hz,
            output_rate_hz: rate_hz / f64::from(hop),
        };
        // Envelopes do not turn with the carrier.
        let phase = CarrierPhase::new(0.0, rate_hz);
        let window = first_window(1);
        let (second, impulse) = SecondStage::design(&window, 1, hop, rates);
        let first = FirstStage::design(&window, 1, hop, &phase);
        Ok(Self {
            rates,
            phase,
            first,
            second,
            impulse,
        })
    }

    /// Returns the rate of the audio samples, Hz.
    #[must_use]
    pub fn sample_rate_hz(&self) -> f64 {
        self.rates.sample_rate_hz
    }

    /// Returns the frequency of the carrier, Hz.
    #[must_use]
    pub fn carrier_hz(&self) -> f64 {
        self.rates.carrier_hz
    }

    /// Returns the rate of the frames, Hz; not necessarily a whole number.
    #[must_use]
    pub fn output_rate_hz(&self) -> f64 {
        self.rates.output_rate_hz
    }

    /// Returns the number of samples from one frame to the next.
    #[must_use]
    pub fn hop(&self) -> u64 {
        (self.first.decimation * self.second.decimation) as u64
    }

    /// Returns the number of samples on either side of a frame's centre that contribute to it, which is the group delay in
    /// samples.
    #[must_use]
    pub fn half_support(&self) -> u64 {
        (self.first.half + self.second.half * self.first.decimation) as u64
    }

    /// Returns the time from a frame's centre until it can be computed, s.
    #[must_use]
    pub fn group_delay_s(&self) -> f64 {
        self.half_support() as f64 / self.rates.sample_rate_hz
    }

    /// Returns the gain for a component `offset_hz` from the carrier; real, because the phase is linear and referred to
    /// the frame's centre.
    #[must_use]
    pub fn response(&self, offset_hz: f64) -> f64 {
        let step = TAU * offset_hz / self.rates.sample_rate_hz;
        centred(&self.impulse.taps[0])
            .map(|(n, h)| h * (step * n).cos())
            .sum()
    }

    /// Returns the offset from the carrier, Hz, from which on everything is rejected by at least 100 dB.
    #[must_use]
    pub fn stopband_hz(&self) -> f64 {
        STOPBAND * self.rates.output_rate_hz
    }

    /// Returns the ratio of the standard deviation of one quadrature of the envelope to that of white noise of the samples.
    #[must_use]
    pub fn noise_gain(&self) -> f64 {
        // Quadrature of 2 Σ h x e^{−iωt}: 2σ² Σh².
        (2.0 * energy(&self.impulse.taps[0])).sqrt()
    }

    /// Returns the ratio of the standard deviations of the envelope's derivative and the envelope, for white noise, in 1/s.
    #[must_use]
    pub fn derivative_noise_per_s(&self) -> f64 {
        (energy(&self.impulse.taps[1]) / energy(&self.impulse.taps[0])).sqrt()
    }
}

impl FirstStage {
    fn design(window: &[f64], decimation: u32, hop: u32, phase: &CarrierPhase) -> Self {
        // Peak amplitude: the other half of a real signal's power sits at −ω and is rejected.
        let taps: Vec<Complex64> = centred(window)
            .map(|(n, h)| {
                let turned = phase.rotation_at(n.abs() as u64);
                // 2 g₁(n) e^{−iωn/rate} for either sign of n.
                2.0 * h * if n < 0.0 { turned } else { turned.conj() }
            })
            .collect();
        let half = window.len() / 2;
        let part = |part: fn(&Complex64) -> f64| taps.iter().map(part).collect();
        let [re, im] = [part(|c| c.re), part(|c| c.im)].map(padded);
        let rotation = (0..u64::from(hop / decimation))
            .map(|j| phase.rotation_at(j * u64::from(decimation)).conj());
        let (rotation_re, rotation_im) = rotation.map(|c| (c.re, c.im)).unzip();
        Self {
            decimation: decimation as usize,
            half,
            lead: re.len() - 1 - half,
            re,
            im,
            rotation_re,
            rotation_im,
        }
    }
}

impl SecondStage {
    fn design(first: &[f64], first_decimation: u32, hop: u32, rates: Rates) -> (Self, Impulse) {
        let decimation = hop / first_decimation;
        let rate = rates.sample_rate_hz;
        let step_s = f64::from(first_decimation) / rate;
        let cutoff_hz = CUTOFF * rates.output_rate_hz;
        let edge = f64::from(decimation * SECOND_SPAN_HOPS) / 2.0;
        let half = edge as usize - 1;
        let kaiser = Kaiser::new(SECOND_BETA);
        let ideal = Ideal::new(first, rate, cutoff_hz);

        let mut taps = [vec![], vec![], vec![]];
        for m in -(half as i64)..=half as i64 {
            // Tap m weighs the sample at t = m·step; the output is Σ h(T − t)·z(t), so its derivative takes h′(−t).
            let t = -(m as f64) * step_s;
            let [s, ds, dds] = ideal.derivatives_at(t);
            let scale = 1.0 / (edge * step_s);
            let [w, dw, ddw] = kaiser.derivatives_at(t * scale);
            let (dw, ddw) = (dw * scale, ddw * scale * scale);
            // h = s w, h′ = s′ w + s w′, h″ = s″ w + 2 s′ w′ + s w″; t runs against m, so these are the taps at T = 0.
            taps[0].push(s * w);
            taps[1].push(ds * w + s * dw);
            taps[2].push(dds * w + 2.0 * ds * dw + s * ddw);
        }
        normalise(&mut taps, step_s);

        let at_sample_rate = |taps: &[f64]| compose(taps, first, first_decimation as usize);
        let impulse = Impulse {
            taps: taps.each_ref().map(|taps| at_sample_rate(taps)),
        };

        // Probe at the offset Δ: p(m) = h(m) e^{−iΔm}, the low-pass moved to +Δ; its conjugate is at −Δ.
        let probes = PROBE_OFFSETS.map(|offset| {
            let turn = TAU * offset * rates.output_rate_hz * step_s;
            let part = |f: fn(f64) -> f64| -> Vec<f64> {
                centred(&taps[0]).map(|(m, h)| h * f(-turn * m)).collect()
            };
            [part(f64::cos), part(f64::sin)]
        });
        // White noise of the samples with variance σ² gives a quadrature the variance 2σ² Σh² (X̃ = 2 Σ h x e^{−iωt}: 4σ² Σh²
        // for both), and a probe the power 4σ² Σ|p|². Their ratio is (Σh²/2)/Σ|p|².
        let quadrature = energy(&impulse.taps[0]) / 2.0;
        let probe_gain = probes.each_ref().map(|[re, im]| {
            quadrature / (energy(&at_sample_rate(re)) + energy(&at_sample_rate(im)))
        });

        let taps = taps.map(padded);
        let second = Self {
            decimation: decimation as usize,
            half,
            lead: taps[0].len() - 1 - half,
            taps,
            probes: probes.map(|probe| probe.map(padded)),
            probe_gain,
        };
        (second, impulse)
    }
}

/// Ideal low-pass in time that compensates the first stage's droop, with its two derivatives.
struct Ideal {
    /// Frequency in rad/s and weight of the quadrature nodes.
    nodes: Vec<(f64, f64)>,
}

impl Ideal {
    fn new(first: &[f64], rate: f64, cutoff_hz: f64) -> Self {
        // Midpoint rule: 256 nodes resolve the few cycles of cos(2πft) up to the cut-off within the window.
        const NODES: u32 = 256;
        let width = cutoff_hz / f64::from(NODES);
        let nodes = (0..NODES).map(|i| {
            let omega = TAU * (f64::from(i) + 0.5) * width;
            let gain: f64 = centred(first)
                .map(|(n, h)| h * (omega * n / rate).cos())
                .sum();
            (omega, 2.0 * width / gain)
        });
        Self {
            nodes: nodes.collect(),
        }
    }

    fn derivatives_at(&self, t: f64) -> [f64; 3] {
        let mut derivatives = [0.0; 3];
        for &(omega, weight) in &self.nodes {
            let (sin, cos) = (omega * t).sin_cos();
            derivatives[0] += weight * cos;
            derivatives[1] -= weight * omega * sin;
            derivatives[2] -= weight * omega * omega * cos;
        }
        derivatives
    }
}

/// Scales to unit gain for a constant, unit slope for a ramp, unit curvature for a parabola; each rejects lower powers.
fn normalise([value, slope, curvature]: &mut [Vec<f64>; 3], step_s: f64) {
    let scale = |taps: &mut Vec<f64>, factor: f64| taps.iter_mut().for_each(|h| *h *= factor);
    let moment = |taps: &[f64], power: i32| -> f64 {
        centred(taps)
            .map(|(m, h)| h * (m * step_s).powi(power))
            .sum()
    };
    scale(value, 1.0 / moment(value, 0));
    scale(slope, 1.0 / moment(slope, 1));
    // Moments M_k(c) = Σ c(m) t_m^k. By symmetry the slope's M₀ and M₂ are 0 and the curvature's M₁ too. The curvature is
    // a (c − M₀(c) v) with v the value's taps: M₀ = 0, M₂ = 2 (d²t²/dt²) for a = 2/(M₂(c) − M₀(c) M₂(v)).
    let (offset, spread) = (moment(curvature, 0), moment(value, 2));
    scale(curvature, 2.0 / (moment(curvature, 2) - offset * spread));
    let offset = moment(curvature, 0);
    for (c, v) in curvature.iter_mut().zip(value.iter()) {
        *c -= offset * v;
    }
}

/// Returns a unit-gain Kaiser window; a single tap without decimation.
fn first_window(decimation: u32) -> Vec<f64> {
    if decimation == 1 {
        return vec![1.0];
    }
    let edge = FIRST_SPAN * f64::from(decimation) / 2.0;
    let half = edge.ceil() as i64 - 1;
    let kaiser = Kaiser::new(FIRST_BETA);
    let mut window: Vec<f64> = (-half..=half)
        .map(|n| kaiser.derivatives_at(n as f64 / edge)[0])
        .collect();
    let sum: f64 = window.iter().sum();
    window.iter_mut().for_each(|h| *h /= sum);
    window
}

/// Prepends zeros to the taps up to a multiple of [`LANES`], as the kernel requires.
fn padded(taps: Vec<f64>) -> Vec<f64> {
    let zeros = taps.len().next_multiple_of(LANES) - taps.len();
    [vec![0.0; zeros], taps].concat()
}

/// Returns an odd number of taps, each with its index from the centre.
fn centred(taps: &[f64]) -> impl Iterator<Item = (f64, f64)> {
    let half = (taps.len() / 2) as f64;
    taps.iter()
        .enumerate()
        .map(move |(i, &h)| (i as f64 - half, h))
}

/// Returns the FIR at the sample rate that is equivalent to `inner` followed by `outer` at the decimated rate.
fn compose(outer: &[f64], inner: &[f64], decimation: usize) -> Vec<f64> {
    let mut composite = vec![0.0; (outer.len() - 1) * decimation + inner.len()];
    for (j, g) in outer.iter().enumerate() {
        for (n, h) in inner.iter().enumerate() {
            composite[j * decimation + n] += g * h;
        }
    }
    composite
}

fn energy(taps: &[f64]) -> f64 {
    taps.iter().map(|h| h * h).sum()
}
