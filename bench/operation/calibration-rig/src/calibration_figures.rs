//! Figures of calibrations: measured points, the fit, and the residuals.

use num_complex::Complex64;

use plotting::{Axis, Dash, Figure, Ink, Key, Marker, Panel, Series, Width};

use crate::points::{Admittance, PickupPoint};

const MICRO: f64 = 1e6;
const NANO: f64 = 1e9;

/// Returns a figure of stacked panels, one column wide.
#[must_use]
pub fn figure(name: &str, title: &str, caption: String, panels: Vec<Panel>) -> Figure {
    Figure {
        name: name.to_owned(),
        title: title.to_owned(),
        caption,
        width: Width::Column,
        columns: 1,
        panel_height_mm: 34.0,
        footnote: None,
        key: Key::InPanels,
        panels,
    }
}

/// Returns a zero line over the range of the points.
#[must_use]
pub fn zero_line(points: &[(f64, f64)]) -> Series {
    let ends = [points.first(), points.last()];
    let line = ends.into_iter().flatten().map(|&(x, _)| (x, 0.0));
    Series::line(Ink::Grey, Dash::Solid, line.collect())
}

/// Returns the Bode plot of the unloaded plate's admittance with its fit and residuals (Huloux 2021, Fig. 10 b).
#[must_use]
pub fn plate(response: &[Admittance], plate: &config::MeasuredPlate) -> Figure {
    let over_frequency = |value: &dyn Fn(&Admittance) -> f64| -> Vec<(f64, f64)> {
        response
            .iter()
            .map(|admittance| (admittance.frequency_hz * 1e-3, value(admittance)))
            .collect()
    };
    let pair = |y: Axis, value: &dyn Fn(Complex64) -> f64| Panel {
        series: vec![
            Series::line(
                Ink::Vermillion,
                Dash::Solid,
                over_frequency(&|admittance| value(admittance.fitted)),
            )
            .with_name("fit"),
            Series::points(
                Ink::Black,
                Marker::Circle,
                over_frequency(&|admittance| value(admittance.measured)),
            )
            .with_name("measured"),
        ],
        ..Panel::new(Axis::linear("Frequency (kHz)").without_labels(), y)
    };
    let largest = response
        .iter()
        .map(|admittance| admittance.measured.norm())
        .fold(f64::MIN_POSITIVE, f64::max);
    let residual = over_frequency(&|admittance| {
        1e6 * (admittance.measured - admittance.fitted).norm() / largest
    });
    let residuals = Panel {
        series: vec![
            zero_line(&residual),
            Series::points(Ink::Black, Marker::Circle, residual),
        ],
        ..Panel::new(
            Axis::linear("Frequency (kHz)"),
            Axis::linear("Residual (ppm)").from_zero(),
        )
    };
    let magnitude = Axis::logarithmic("|ṽ/f̃| (m/s/N)");
    let phase = Axis::linear("Phase (°)");
    figure(
        "plate",
        "Admittance of the plate without a finger",
        format!(
            "Velocity over force of the plate with no finger on it, and the second-order mode fitted to it (Huloux 2021, Fig. \
             10 b): f₀ = {}, Q = {}, b_p = {}, γ = {}, phase of the pickup {}; intervals of 95 %. Residuals against the peak. \
             Measured {} by {}: {}.",
            plate.resonance_hz,
            plate.quality,
            plate.damping_n_s_per_m,
            plate.force_factor_n_per_v,
            plate.pickup_phase_rad,
            calendar::moment(plate.measured.date),
            plate.measured.operator,
            plate.measured.method,
        ),
        vec![
            pair(magnitude, &|y| y.norm()),
            pair(phase, &|y| y.arg().to_degrees()),
            residuals,
        ],
    )
}

/// Returns the plot of known amplitudes against the pickup's readings, with the fitted line and the residuals.
#[must_use]
pub fn pickup(
    rungs: &[PickupPoint],
    residuals_m: &[f64],
    pickup: &config::MeasuredPickup,
) -> Figure {
    let known: Vec<(f64, f64)> = rungs
        .iter()
        .map(|rung| (rung.reading, rung.known_m * MICRO))
        .collect();
    let highest = rungs.iter().map(|rung| rung.reading).fold(0.0, f64::max);
    let (slope, offset) = (pickup.metres_per_unit.value, pickup.offset.value);
    let line = [0.0, highest].map(|x| (x, (offset + slope * x) * MICRO));
    let band = rungs
        .iter()
        .map(|rung| (rung.reading, -rung.sigma_m * NANO, rung.sigma_m * NANO))
        .collect();
    let distances: Vec<(f64, f64)> = rungs
        .iter()
        .zip(residuals_m)
        .map(|(rung, residual_m)| (rung.reading, residual_m * NANO))
        .collect();
    let reading = || Axis::linear("Reading of the pickup (full scale)").from_zero();
    figure(
        "pickup",
        "Sensitivity of the pickup",
        format!(
            "Known peak amplitude of the plate against the pickup's reading at {:.1} Hz, {} levels, and the weighted line \
             through them: {} per unit, offset {}; intervals of 95 %. Below, the points' distances from it, and in the band \
             the deviation that each point was known with. Measured {} by {}: {}.",
            pickup.carrier_hz,
            pickup.points,
            pickup.metres_per_unit,
            pickup.offset,
            calendar::moment(pickup.measured.date),
            pickup.measured.operator,
            pickup.measured.method,
        ),
        vec![
            Panel {
                series: vec![
                    Series::line(Ink::Vermillion, Dash::Solid, line.into()).with_name("line"),
                    Series::points(Ink::Black, Marker::Circle, known).with_name("measured"),
                ],
                ..Panel::new(
                    reading().without_labels(),
                    Axis::linear("Known amplitude (µm)").from_zero(),
                )
            },
            Panel {
                series: vec![
                    Series::band(Ink::Blue, band),
                    zero_line(&distances),
                    Series::points(Ink::Black, Marker::Circle, distances),
                ],
                ..Panel::new(reading(), Axis::linear("Residual (nm)"))
            },
        ],
    )
}

/// Measured curves of one input.
#[derive(Debug, Clone, PartialEq)]
pub struct InputCurves {
    /// Index of the input.
    pub index: u16,
    /// Frequency of each tone, Hz, and the relative residual of the ratio to the drive's input about one gain and one delay;
    /// empty for the drive's input.
    pub departures: Vec<(f64, Complex64)>,
    /// Level of each rung, V peak, and the amplitude read, of full scale.
    pub levels: Vec<(f64, f64)>,
    /// Level of each rung that was not cut off, V peak, and the residual about the line, as a share of the largest
    /// level.
    pub off_the_line: Vec<(f64, f64)>,
}

/// Returns the plot of each input's residuals: about one gain and one delay over frequency, and about a line over
/// level.
#[must_use]
pub fn channels(inputs: &[InputCurves], channels: &config::MeasuredChannels) -> Figure {
    const LOOKS: [(Ink, Marker); 4] = [
        (Ink::Black, Marker::Circle),
        (Ink::Blue, Marker::Disc),
        (Ink::Vermillion, Marker::Square),
        (Ink::Green, Marker::Triangle),
    ];
    let input_series =
        |curve: &dyn Fn(&InputCurves) -> Vec<(f64, f64)>, has_names: bool| -> Vec<Series> {
            let looks = LOOKS.into_iter().cycle();
            let series_by_input = inputs
                .iter()
                .zip(looks)
                .filter_map(|(input, (ink, marker))| {
                    let points = curve(input);
                    let series = Series::points(ink, marker, points.clone());
                    let series = if has_names {
                        series.with_name(format!("input {}", input.index))
                    } else {
                        series
                    };
                    (!points.is_empty()).then_some(series)
                });
            series_by_input.collect()
        };
    let over_frequency = |part: fn(&Complex64) -> f64| {
        input_series(
            &|input| {
                let departures = input.departures.iter();
                departures
                    .map(|(hz, departure)| (hz * 1e-3, part(departure) * MICRO))
                    .collect()
            },
            false,
        )
    };
    let frequency = || Axis::linear("Frequency (kHz)");
    let level = || Axis::logarithmic("Drive (V)");
    let panel = |series: Vec<Series>, x: Axis, y: Axis| Panel {
        series,
        ..Panel::new(x, y)
    };
    figure(
        "channels",
        "The inputs beside that of the drive",
        format!(
            "One signal on all inputs. Above, what is left of the ratio to the drive's input once each has its gain and its \
             delay at {:.1} Hz, in size and in phase. Below, the amplitude read at each level, and its distance from a line of \
             those that were not cut off, of the largest. Round trip {}, latency {}; intervals of 95 %. Measured {} by {}: \
             {}.",
            channels.carrier_hz,
            channels.round_trip,
            channels.latency,
            calendar::moment(channels.measured.date),
            channels.measured.operator,
            channels.measured.method,
        ),
        vec![
            panel(
                over_frequency(|departure| departure.re),
                frequency().without_labels(),
                Axis::linear("Gain error (ppm)"),
            ),
            panel(
                over_frequency(|departure| departure.im),
                frequency(),
                Axis::linear("Phase error (µrad)"),
            ),
            panel(
                input_series(&|input| input.levels.clone(), true),
                level().without_labels(),
                Axis::logarithmic("Reading (full scale)"),
            ),
            panel(
                input_series(
                    &|input| {
                        let departures = input.off_the_line.iter();
                        departures
                            .map(|(drive_v, share)| (*drive_v, share * MICRO))
                            .collect()
                    },
                    false,
                ),
                level(),
                Axis::linear("Off the line (ppm)"),
            ),
        ],
    )
}
