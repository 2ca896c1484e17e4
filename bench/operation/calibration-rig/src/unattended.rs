//! A calibration without an operator: prints progress as lines, and answers a request once the force sensor shows that it is
//! fulfilled.

use std::collections::VecDeque;
use std::io::Write;

use anyhow::bail;

use crate::operator::{
    Answer, CalibrationProgress, ForceAxis, GRAVITY_M_PER_S2, LiveReading, Operator, OperatorInput,
    Request,
};

/// Length of a plateau of the forces, s.
const PLATEAU_S: f64 = 0.5;
/// Largest difference between the halves of a plateau, N, in addition to [`STEADY_SHARE`].
const STEADY_N: f64 = 2e-3;
/// Largest difference between the halves of a plateau, as a share of the expected change.
const STEADY_SHARE: f64 = 0.01;
/// Share of the expected change at which a change is detected; low, because the sensor's gain is not yet known.
const SEEN_SHARE: f64 = 0.3;
/// Timeout of a request, s: a person may have to walk to the bench.
const REQUEST_TIMEOUT_S: f64 = 120.0;

/// An operator replaced by the force sensor's readings.
pub struct Unattended<W> {
    output: W,
    pending: Option<Asked>,
    /// Time, s, and normal and lateral force, N, over the length of a plateau.
    recent: VecDeque<(f64, [f64; 2])>,
    now_s: f64,
    loaded: Option<(ForceAxis, f64)>,
    printed: Option<(usize, String)>,
    points: usize,
}

struct Asked {
    request: Request,
    since_s: f64,
    /// Forces at the time of the request, N.
    previous_n: [f64; 2],
}

impl<W: Write> Unattended<W> {
    /// Creates an operator that prints progress to `output`.
    pub fn new(output: W) -> Self {
        Self {
            output,
            pending: None,
            recent: VecDeque::new(),
            now_s: 0.0,
            loaded: None,
            printed: None,
            points: 0,
        }
    }

    fn line(&mut self, text: std::fmt::Arguments<'_>) {
        // A closed output does not end a calibration.
        let _ = writeln!(self.output, "{}", escaping::escaped(&text.to_string()));
    }

    fn mean_n(readings: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
        let (mut sum, mut count) = ([0.0; 2], 0.0);
        for [normal, lateral] in readings {
            sum = [sum[0] + normal, sum[1] + lateral];
            count += 1.0;
        }
        sum.map(|sum| if count > 0.0 { sum / count } else { 0.0 })
    }

    /// Returns whether a finger has pressed with `least_n` to `most_n` throughout a plateau.
    fn rests(&self, request: &Asked, least_n: f64, most_n: f64) -> bool {
        let in_range = |(_, [normal_n, _]): &(f64, [f64; 2])| (least_n..=most_n).contains(normal_n);
        let long = self.now_s - request.since_s >= PLATEAU_S;
        long && !self.recent.is_empty() && self.recent.iter().all(in_range)
    }

    /// Returns whether the forces have settled at the level that `request` should produce.
    fn settled(&self, request: &Asked) -> bool {
        let (Some(first), Some(last)) = (self.recent.front(), self.recent.back()) else {
            return false;
        };
        let span_s = last.0 - first.0;
        if last.0 - request.since_s < PLATEAU_S || span_s < 0.8 * PLATEAU_S {
            return false;
        }
        let (axis, requested_kg) = match (request.request, self.loaded) {
            (Request::Load { axis, mass_kg }, _) => (axis, mass_kg),
            (_, Some((axis, _))) => (axis, 0.0),
            _ => (ForceAxis::Normal, 0.0),
        };
        let present_kg = match self.loaded {
            Some((loaded, mass_kg)) if loaded == axis => mass_kg,
            _ => 0.0,
        };
        let expected_n = (requested_kg - present_kg).abs() * GRAVITY_M_PER_S2;
        let middle_s = first.0 + 0.5 * span_s;
        let half = |late: bool| {
            let half = self
                .recent
                .iter()
                .filter(|(t_s, _)| (*t_s > middle_s) == late);
            Self::mean_n(half.map(|(_, forces)| *forces))[axis.index()]
        };
        let (early, late) = (half(false), half(true));
        let changed = (late - request.previous_n[axis.index()]).abs() >= SEEN_SHARE * expected_n;
        changed && (late - early).abs() <= STEADY_N + STEADY_SHARE * expected_n
    }
}

impl<W: Write + Send> Operator for Unattended<W> {
    fn ask(&mut self, request: Option<&Request>) {
        self.pending = request.map(|request| Asked {
            request: *request,
            since_s: self.now_s,
            previous_n: Self::mean_n(self.recent.iter().map(|(_, forces)| *forces)),
        });
        if let Some(
            Request::Load { .. }
            | Request::Unload
            | Request::RestFinger { .. }
            | Request::Connect(_),
        ) = request
        {
            let words = request.map(Request::words).unwrap_or_default();
            self.line(format_args!("  please: {words}"));
        }
    }

    fn progress(&mut self, progress: &CalibrationProgress) {
        let step = (progress.step, progress.doing.clone());
        if self.printed.as_ref() != Some(&step) && !progress.doing.is_empty() {
            self.line(format_args!(
                "step {} of {}: {}",
                progress.step, progress.steps, progress.doing
            ));
            self.printed = Some(step);
        }
        for point in progress.points.iter().skip(self.points) {
            let residual = point
                .residual
                .as_ref()
                .map(|residual| format!("  off by {residual}"))
                .unwrap_or_default();
            self.line(format_args!("  {}  {}{residual}", point.place, point.value));
        }
        self.points = progress.points.len();
    }

    fn show(&mut self, now: &LiveReading) {
        self.now_s = now.t_s;
        if let (Some(normal_n), Some(lateral_n)) = (now.normal_n, now.lateral_n) {
            self.recent.push_back((now.t_s, [normal_n, lateral_n]));
        }
        while self
            .recent
            .front()
            .is_some_and(|(t_s, _)| *t_s < now.t_s - PLATEAU_S)
        {
            self.recent.pop_front();
        }
    }

    fn next_input(&mut self) -> anyhow::Result<Option<OperatorInput>> {
        let Some(pending) = &self.pending else {
            return Ok(None);
        };
        let done = match pending.request {
            Request::Connect(_) | Request::Review | Request::GoOn => true,
            // The move cannot be confirmed: only a simulated instrument moves automatically.
            Request::MoveVibrometer { .. } | Request::MoveVibrometerAcross { .. } => true,
            Request::Load { .. } | Request::Unload => self.settled(pending),
            Request::RestFinger { least_n, most_n } => self.rests(pending, least_n, most_n),
            Request::NameMass { axis } => bail!(
                "no operator to type the masses of the {} axis: give --normal-g and --lateral-g, or --masses-csv",
                axis.name()
            ),
            Request::MeterReading { .. } => bail!(
                "no operator to type the meter's reading: give --known-v or --instrument, or calibrate on a terminal"
            ),
            Request::KnownAmplitude { .. } => bail!(
                "no operator to type the amplitude: give --reference-channel, --instrument, --known-um or --known-csv, or calibrate on a terminal"
            ),
        };
        if !done {
            if self.now_s - pending.since_s > REQUEST_TIMEOUT_S {
                bail!(
                    "timed out after {REQUEST_TIMEOUT_S} s: \"{}\" was requested, but the force sensor read no new, steady load; do what is requested while the command waits, and check the sensor's cable and axes",
                    pending.request.words()
                );
            }
            return Ok(None);
        }
        match pending.request {
            Request::Load { axis, mass_kg } => self.loaded = Some((axis, mass_kg)),
            Request::Unload => self.loaded = None,
            _ => {}
        }
        self.pending = None;
        Ok(Some(OperatorInput::Answer(Answer::Ready)))
    }

    fn broken_off(&mut self, _: &str, _: Option<&str>) -> bool {
        false
    }

    fn failed(&mut self, _why: &str) -> bool {
        false
    }

    fn close(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shows `normal_n` for `seconds`; returns the answer, if any.
    fn rest(
        operator: &mut Unattended<Vec<u8>>,
        normal_n: f64,
        seconds: f64,
    ) -> Option<OperatorInput> {
        let from_s = operator.now_s;
        for i in 1..=(seconds / 0.05).round() as u32 {
            operator.show(&LiveReading {
                t_s: from_s + 0.05 * f64::from(i),
                normal_n: Some(normal_n),
                lateral_n: Some(0.0),
                ..LiveReading::default()
            });
            if let Some(wish) = operator.next_input().unwrap() {
                return Some(wish);
            }
        }
        None
    }

    fn load(mass_kg: f64) -> Request {
        Request::Load {
            axis: ForceAxis::Normal,
            mass_kg,
        }
    }

    #[test]
    fn a_load_is_there_once_the_force_rests_on_a_new_plateau() {
        let ready = Some(OperatorInput::Answer(Answer::Ready));
        let mut operator = Unattended::new(Vec::new());
        rest(&mut operator, 0.0, 1.0);
        operator.ask(Some(&load(0.1)));
        assert_eq!(rest(&mut operator, 0.0, 3.0), None, "nothing was put there");
        // 100 g on a sensor that reads 20 % too little, swinging first.
        for normal_n in [0.3, 1.4, 0.5, 1.0, 0.7] {
            assert_eq!(rest(&mut operator, normal_n, 0.2), None, "it swings");
        }
        assert_eq!(rest(&mut operator, 0.78, 1.0), ready);
        operator.ask(Some(&load(0.2)));
        assert_eq!(rest(&mut operator, 0.78, 2.0), None, "still the first mass");
        assert_eq!(rest(&mut operator, 1.57, 1.0), ready);
        operator.ask(Some(&Request::Unload));
        assert_eq!(rest(&mut operator, 1.57, 2.0), None, "still loaded");
        assert_eq!(rest(&mut operator, 0.0, 1.0), ready);
        assert_eq!(rest(&mut operator, 0.0, 1.0), None, "nothing more is asked");
    }

    #[test]
    fn an_unloaded_sensor_need_not_change() {
        let mut operator = Unattended::new(Vec::new());
        operator.ask(Some(&Request::Unload));
        let answer = rest(&mut operator, 0.01, 1.0);
        assert_eq!(answer, Some(OperatorInput::Answer(Answer::Ready)));
    }

    #[test]
    fn a_request_that_is_not_fulfilled_times_out() {
        let mut operator = Unattended::new(Vec::new());
        operator.ask(Some(&load(0.1)));
        operator.show(&LiveReading {
            t_s: REQUEST_TIMEOUT_S + 1.0,
            ..LiveReading::default()
        });
        let error = operator.next_input().unwrap_err().to_string();
        assert!(
            error.contains("Put 100 g") && error.contains("force sensor"),
            "{error}"
        );
        operator.ask(Some(&Request::KnownAmplitude {
            drive_v: 10.0,
            expected_m: None,
        }));
        let error = operator.next_input().unwrap_err().to_string();
        assert!(error.contains("--known-um"), "{error}");
    }

    #[test]
    fn each_step_and_point_is_a_line() {
        let mut operator = Unattended::new(Vec::new());
        let point = crate::operator::PointRead {
            place: "5 V".to_owned(),
            value: "1 µm".to_owned(),
            ..Default::default()
        };
        for count in [0, 1, 1, 2] {
            operator.progress(&CalibrationProgress {
                step: 1,
                steps: 2,
                doing: "Driving.".to_owned(),
                points: vec![point.clone(); count],
                ..CalibrationProgress::default()
            });
        }
        let text = String::from_utf8(operator.output).unwrap();
        assert_eq!(text, "step 1 of 2: Driving.\n  5 V  1 µm\n  5 V  1 µm\n");
    }
}
