//! Verdict on the channels: `[channels]` of the calibration file, and the faults found.

use std::fmt::Write as _;

use anyhow::Context;
use jiff::Timestamp;
use metrology::FittedValue;
use metrology::channel_fit::{ChannelFit, RatioReading};
use metrology::spectrum::NoiseDensity;
use num_complex::Complex64;

use super::channels_procedure::ChannelsProcedure;
use super::channels_setup::{LADDER_DWELL_S, LISTEN_S, OPENINGS, SPAN_HZ, TONES};
use super::fault::ChannelsFault;
use super::ladder::{self, Straightness};
use super::tone_ratios::{quadrature, ratios};
use calibration_rig::calibration_figures as figures;
use calibration_rig::calibration_figures::InputCurves;
use calibration_rig::judged::{Calibrates, Judged, Part};
use config::{MeasuredDelay, MeasuredInput, Provenance, Quantity, SampleFormat};
use safety::DELAY_WITHIN_S;

/// Change of a delay since the previous calibration that counts as a slip, samples.
const SLIPPED: f64 = 0.5;

fn db(ratio: f64) -> f64 {
    20.0 * ratio.log10()
}

impl ChannelsProcedure {
    /// Returns the input's reading relative to the drive's input with only the drive's cable connected: the mean over the
    /// tones, with the standard error from their scatter.
    fn crosstalk(&self, leaked: &[RatioReading]) -> Quantity {
        let n = leaked.len() as f64;
        let mean = leaked.iter().map(|leak| leak.ratio).sum::<Complex64>() / n;
        let squares: f64 = leaked
            .iter()
            .map(|leak| (leak.ratio - mean).norm_sqr())
            .sum();
        let error = (squares / (n * (n - 1.0))).sqrt();
        Quantity::new(mean.norm(), error, leaked.len() - 1, "1")
    }

    fn straightness(&self, input: usize) -> anyhow::Result<Straightness> {
        let noise = quadrature(&self.noise[input], LADDER_DWELL_S);
        ladder::straightness(&self.ladders[input], noise).with_context(|| {
            format!("input {input} is cut off at almost every level: lower its gain")
        })
    }

    fn input(
        &self,
        index: u16,
    ) -> anyhow::Result<(MeasuredInput, Option<ChannelFit>, InputCurves)> {
        let input = usize::from(index);
        let straight = self.straightness(input)?;
        let ladder = &self.ladders[input];
        let mut curves = InputCurves {
            index,
            departures: Vec::new(),
            levels: ladder
                .iter()
                .map(|rung| (rung.drive_v, rung.amplitude))
                .collect(),
            off_the_line: straight.departures,
        };
        let clips_at = straight.clips_at.map(|(level, scatter)| {
            let step = match self.setup.config.audio.sample_format {
                SampleFormat::I16 => 2f64.powi(-15),
                SampleFormat::I32 | SampleFormat::I24 | SampleFormat::F32 => 2f64.powi(-23),
            };
            let error = scatter.hypot(step / 12f64.sqrt());
            Quantity::new(level, error, 9, "full scale")
        });
        let density = |noise: &NoiseDensity| {
            Quantity::new(
                noise.value,
                noise.standard_error,
                noise.degrees_of_freedom,
                "full scale/√Hz",
            )
        };
        let exact = |value: f64, unit: &str| Quantity::new(value, 0.0, 2 * TONES - 2, unit);
        let mut channel = MeasuredInput {
            index,
            gain: exact(1.0, "1"),
            phase_rad: exact(0.0, "rad"),
            delay: exact(0.0, "samples"),
            departure: 0.0,
            noise: density(&self.noise[input]),
            noise_on_bench: density(&self.noise_on_bench[input]),
            nonlinearity: straight.nonlinearity,
            clips_at,
            clean_up_to: straight.clean_up_to,
            crosstalk: None,
        };
        if index == self.setup.drive() {
            return Ok((channel, None, curves));
        }
        let pair = [input, usize::from(self.setup.drive())];
        let leaked = ratios(&self.drive_alone, pair, &self.noise, None);
        let ratios = ratios(&self.patched, pair, &self.noise, Some(&leaked));
        let fit = ChannelFit::fit(&ratios, self.setup.carrier_hz)?;
        curves.departures = ratios
            .iter()
            .map(|reading| {
                let departure = fit.departure_of(reading, self.setup.carrier_hz);
                (reading.frequency_hz, departure)
            })
            .collect();
        let crosstalk = self.crosstalk(&leaked);
        // Crosstalk into the drive's input is not measured: it is assumed to be as large, to have any phase, and to vary over
        // the band as with a delay like this channel's.
        let crosstalk_ratio = crosstalk.value;
        let quantity = |estimate: FittedValue, scale: f64, unobserved: f64, unit: &str| {
            let observed = scale * estimate.standard_error;
            Quantity::combined(
                scale * estimate.value,
                observed.hypot(unobserved),
                observed,
                fit.degrees_of_freedom,
                unit,
            )
        };
        let unobserved = crosstalk_ratio.hypot(fit.departure);
        channel.gain = quantity(fit.gain, 1.0, unobserved * fit.gain.value, "1");
        channel.phase_rad = quantity(fit.phase_rad, 1.0, unobserved, "rad");
        let samples = fit.delay_s.value * self.setup.rate_hz();
        channel.delay = quantity(
            fit.delay_s,
            self.setup.rate_hz(),
            (crosstalk_ratio * samples.abs().max(1.0)).hypot(fit.excess_s * self.setup.rate_hz()),
            "samples",
        );
        channel.departure = fit.departure;
        channel.crosstalk = Some(crosstalk);
        Ok((channel, Some(fit), curves))
    }

    fn faults(&self, channel: &MeasuredInput, fit: Option<&ChannelFit>) -> Vec<ChannelsFault> {
        let limits = &self.setup.config.calibration;
        let input = channel.index;
        let mut faults = Vec::new();
        let density = channel.noise.value;
        let limit = limits.input_noise_units_per_sqrt_hz;
        if density > limit {
            faults.push(ChannelsFault::Noisy {
                input,
                density,
                limit,
            });
        }
        if channel.nonlinearity > limits.input_nonlinearity {
            faults.push(ChannelsFault::NotLinear {
                input,
                percent: 100.0 * channel.nonlinearity,
                limit: limits.input_nonlinearity,
            });
        }
        let crosstalk_db = channel.crosstalk.as_ref().map(|x| db(x.value));
        if let Some(crosstalk_db) = crosstalk_db
            && crosstalk_db > limits.crosstalk_db
        {
            faults.push(ChannelsFault::Crosstalk {
                input,
                crosstalk_db,
                limit_db: limits.crosstalk_db,
            });
        }
        let samples = channel.delay.value;
        if samples.abs() > limits.delay_samples {
            faults.push(ChannelsFault::Delayed {
                input,
                samples,
                limit: limits.delay_samples,
            });
        }
        if fit.is_some_and(|fit| fit.inverted) {
            faults.push(ChannelsFault::Inverted { input });
        }
        let relative = channel.gain.standard_error / channel.gain.value;
        let error = relative.max(channel.phase_rad.standard_error);
        // Crosstalk within its own limit is not a fault.
        let limit = limits.input_error;
        if error > limit.max(channel.crosstalk.as_ref().map_or(0.0, |x| 1.01 * x.value)) {
            faults.push(ChannelsFault::Uncertain {
                input,
                error,
                limit,
            });
        }
        let earlier = self.setup.before.as_ref();
        let shift = earlier
            .and_then(|channels| channels.input(input))
            .map(|channel| samples - channel.delay.value);
        if let Some(samples) = shift.filter(|shift| shift.abs() > SLIPPED) {
            faults.push(ChannelsFault::SlippedSince { input, samples });
        }
        faults
    }

    /// Returns the ratio of the level read back to the level commanded at the carrier, from the tones within a tenth of their
    /// span.
    fn round_trip(&self) -> Quantity {
        let drive = usize::from(self.setup.drive());
        let expected = self.setup.expected(self.tones_v);
        let shares: Vec<f64> = self
            .patched
            .iter()
            .filter(|(hz, _)| (hz - self.setup.carrier_hz).abs() <= 0.11 * SPAN_HZ)
            .map(|(_, values)| values[drive].norm() / expected)
            .collect();
        mean(&shares, "1", 0.0)
    }

    /// Returns the loop delay over the openings of the streams; `None` unless each opening has shown it.
    fn loop_delay(&self) -> Option<MeasuredDelay> {
        let delays_s = &self.setup.delays.seconds;
        (delays_s.len() >= OPENINGS).then(|| MeasuredDelay {
            mean: mean(delays_s, "s", DELAY_ERROR_S),
            extent_s: [
                delays_s.iter().copied().fold(f64::INFINITY, f64::min),
                delays_s.iter().copied().fold(0.0, f64::max),
            ],
            openings: delays_s.len(),
        })
    }

    fn table(&self) -> String {
        let mut text =
            String::from("cabling,input,frequency_hz,drive_v,re_units,im_units,peak_units\n");
        for row in &self.rows {
            let _ = writeln!(
                text,
                "{},{},{},{},{:e},{:e},{:e}",
                row.cabling,
                row.input,
                row.frequency_hz,
                row.drive_v,
                row.value.re,
                row.value.im,
                row.peak
            );
        }
        text
    }

    fn line(&self, channel: &MeasuredInput) -> String {
        let clips = match &channel.clips_at {
            Some(clips_at) => format!("clips at {:.4}", clips_at.value),
            None => format!("clips above {:.2}", channel.clean_up_to),
        };
        let leaks = channel
            .crosstalk
            .as_ref()
            .map_or("the drive's".to_owned(), |x| {
                format!(
                    "gain {:.5}, {:+.4} samples, crosstalk {:.1} dB",
                    channel.gain.value,
                    channel.delay.value,
                    db(x.value)
                )
            });
        format!(
            "input {:<10} {leaks}; noise {:.2e}/√Hz, {clips}",
            channel.index, channel.noise.value
        )
    }
}

/// Returns the mean of repeated readings, with the larger of its standard error and `least`.
fn mean(values: &[f64], unit: &str, least: f64) -> Quantity {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    let error = (squares / (n * (n - 1.0).max(1.0))).sqrt();
    Quantity::new(mean, error.max(least), values.len().saturating_sub(1), unit)
}

/// Standard error of the loop delay of one opening, and margin for it within the watch's tolerance, s.
const DELAY_ERROR_S: f64 = 2e-4;
const DELAY_ROOM_S: f64 = 1e-3;

/// Returns the fault of a delay that could leave the watch's tolerance at another opening of the streams.
fn delay_spread(delay: &MeasuredDelay) -> Option<ChannelsFault> {
    let [least_s, most_s] = delay.extent_s;
    let mean_s = delay.mean.value;
    let furthest_s = (mean_s - least_s).max(most_s - mean_s);
    (furthest_s + DELAY_ROOM_S > DELAY_WITHIN_S).then_some(ChannelsFault::DelaySpread {
        least_s,
        most_s,
        openings: delay.openings,
    })
}

/// Standard error of the onset time of a tone, s.
const ONSET_ERROR_S: f64 = 1.5e-4;

impl Calibrates for ChannelsProcedure {
    const NAME: &'static str = "channels";

    fn judge(&self, date: Timestamp, operator: &str) -> anyhow::Result<Judged> {
        let config = &self.setup.config;
        let mut faults: Vec<String> = Vec::new();
        let (mut inputs, mut curves) = (Vec::new(), Vec::new());
        for index in 0..self.setup.inputs() {
            let (channel, fit, input_curves) = self.input(index)?;
            let input_faults = self.faults(&channel, fit.as_ref());
            faults.extend(input_faults.iter().map(ChannelsFault::to_string));
            inputs.push(channel);
            curves.push(input_curves);
        }
        let round_trip = self.round_trip();
        if (round_trip.value - 1.0).abs() > config.safety.readback_tolerance {
            let level = ChannelsFault::Level {
                commanded_v: self.tones_v,
                returned_v: round_trip.value * self.tones_v,
            };
            faults.push(level.to_string());
        }
        let loop_delay = self.loop_delay();
        faults.extend(
            loop_delay
                .as_ref()
                .and_then(delay_spread)
                .map(|fault| fault.to_string()),
        );
        let channels = config::MeasuredChannels {
            measured: Provenance {
                date,
                operator: operator.to_owned(),
                method: format!(
                    "one signal on all inputs: {LISTEN} s of silence, {} levels up to {:.1} V, {} tones over {:.0} Hz at {:.1} V up and down, the same with the drive's cable alone; errors hold scatter, noise and a crosstalk into the drive as large as that out of it",
                    self.ladders.first().map_or(0, Vec::len),
                    self.levels_v[self.ladders.first().map_or(0, Vec::len).saturating_sub(1)],
                    self.patched.len(),
                    2.0 * SPAN_HZ,
                    self.tones_v,
                    LISTEN = LISTEN_S,
                ),
            },
            carrier_hz: self.setup.carrier_hz,
            round_trip,
            latency: mean(&self.latencies, "s", ONSET_ERROR_S),
            loop_delay,
            inputs,
        };
        let mut remarks: Vec<String> = channels
            .inputs
            .iter()
            .map(|channel| self.line(channel))
            .collect();
        remarks.extend(
            self.warnings
                .iter()
                .map(|warning| format!("warning  {warning}")),
        );
        remarks.push(match &channels.loop_delay {
            Some(delay) => format!(
                "loop delay       {:.1} to {:.1} ms over {} openings of the streams",
                1e3 * delay.extent_s[0],
                1e3 * delay.extent_s[1],
                delay.openings
            ),
            None => format!(
                "warning  the loop's delay could not be measured at opening {} of {OPENINGS}: {}; mend that and calibrate the channels \
                 again, or no start can tell a changed delay",
                self.setup.delays.seconds.len() + 1,
                self.setup.delays.fault.as_deref().unwrap_or("it was not tried"),
            ),
        });
        let mut values = vec![
            ("round trip", channels.round_trip.clone()),
            ("latency", channels.latency.clone()),
        ];
        values.extend(
            channels
                .loop_delay
                .iter()
                .map(|delay| ("loop delay", delay.mean.clone())),
        );
        if let Some(pickup) = channels.input(config.channels.pickup.index) {
            values.extend([
                ("pickup gain", pickup.gain.clone()),
                ("pickup phase", pickup.phase_rad.clone()),
                ("pickup delay", pickup.delay.clone()),
                ("pickup noise", pickup.noise.clone()),
            ]);
        }
        Ok(Judged {
            values,
            remarks,
            faults,
            stem: Self::NAME,
            table: self.table(),
            figure: Some(figures::channels(&curves, &channels)),
            side_files: Vec::new(),
            part: Part::Channels(Box::new(channels)),
        })
    }
}
