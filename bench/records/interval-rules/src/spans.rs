//! Stretches in which a rule holds.

use protocols::Direction;

use crate::quantity::Quantity;
use crate::rule::{Condition, Rule};
use crate::series::{Series, Stretch};

/// A stretch in which a rule holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// First sample in it, s.
    pub from_s: f64,
    /// Last sample in it, s.
    pub to_s: f64,
    /// Reason in words, for a user.
    pub why: String,
}

/// A stretch in which a rule holds and the finger slides in one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectedSpan {
    /// The stretch.
    pub span: Span,
    /// Direction of the finger.
    pub direction: Direction,
}

impl Rule {
    /// Returns the stretches of `series`, of the rule's [`quantity`](Self::quantity) in N or m/s, in which the rule holds.
    #[must_use]
    pub fn spans(&self, series: &Series<'_>) -> Vec<Span> {
        let stretches = series.filtered();
        let holds = stretches.iter().flat_map(|stretch| {
            runs(stretch, |value| self.admits(value).then_some(()))
                .into_iter()
                .map(move |(run, ())| (stretch, run))
        });
        holds
            .filter(|(_, run)| self.is_long_enough(run.from_s, run.to_s))
            .map(|(stretch, run)| Span {
                from_s: run.from_s,
                to_s: run.to_s,
                why: self.reason(&stretch.values[run.first..=run.last], run.to_s - run.from_s),
            })
            .collect()
    }

    /// Returns the stretches of `series` in which the rule holds and `velocity`, in m/s, keeps its sign for the rule's duration.
    #[must_use]
    pub fn explorations(&self, series: &Series<'_>, velocity: &Series<'_>) -> Vec<DirectedSpan> {
        let slides: Vec<_> = velocity
            .filtered()
            .iter()
            .flat_map(|stretch| runs(stretch, direction))
            .collect();
        let mut explorations = Vec::new();
        for span in self.spans(series) {
            for (slide, direction) in &slides {
                let (from_s, to_s) = (span.from_s.max(slide.from_s), span.to_s.min(slide.to_s));
                if self.is_long_enough(from_s, to_s) {
                    let why = format!("{}, {direction}", span.why);
                    let span = Span { from_s, to_s, why };
                    explorations.push(DirectedSpan {
                        span,
                        direction: *direction,
                    });
                }
            }
        }
        explorations
    }

    fn is_long_enough(&self, from_s: f64, to_s: f64) -> bool {
        // Times are rounded to some digits in text files.
        to_s - from_s >= self.duration_s() - 1e-6
    }

    fn reason(&self, values: &[f64], duration_s: f64) -> String {
        let magnitude = |value: f64| match (self.quantity(), self.condition()) {
            (Quantity::Normal, Condition::Above(_)) => value,
            _ => value.abs(),
        };
        let magnitudes = values.iter().map(|value| magnitude(*value));
        let (least, greatest) = magnitudes.fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(least, greatest), value| (least.min(value), greatest.max(value)),
        );
        let quantity = self.quantity();
        format!(
            "{quantity} is {} to {} for {duration_s:.2} s ({self})",
            quantity.text(least),
            quantity.text(greatest),
        )
    }
}

fn direction(velocity_m_per_s: f64) -> Option<Direction> {
    if velocity_m_per_s > 0.0 {
        Some(Direction::LeftToRight)
    } else if velocity_m_per_s < 0.0 {
        Some(Direction::RightToLeft)
    } else {
        None
    }
}

/// Consecutive samples of the same class.
#[derive(Clone, Copy, Debug)]
struct Run {
    first: usize,
    last: usize,
    from_s: f64,
    to_s: f64,
}

/// Returns the runs of samples of the same class; samples without a class belong to none.
fn runs<C: PartialEq + Copy>(stretch: &Stretch, class: impl Fn(f64) -> Option<C>) -> Vec<(Run, C)> {
    let mut runs: Vec<(Run, C)> = Vec::new();
    let mut current = None;
    for (i, (&time_s, &value)) in stretch.time_s.iter().zip(&stretch.values).enumerate() {
        let sample_class = class(value);
        match (runs.last_mut(), sample_class) {
            (Some((run, _)), Some(_)) if sample_class == current => {
                (run.last, run.to_s) = (i, time_s);
            }
            (_, Some(class)) => {
                let run = Run {
                    first: i,
                    last: i,
                    from_s: time_s,
                    to_s: time_s,
                };
                runs.push((run, class));
            }
            (_, None) => {}
        }
        current = sample_class;
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A finger that touches with 0.5 N from 1 s on, slides there and back at 50 mm/s, and leaves at 4 s; 1 kHz.
    struct Trial {
        time_s: Vec<f64>,
        normal_n: Vec<f64>,
        velocity_m_per_s: Vec<f64>,
    }

    impl Trial {
        fn new() -> Self {
            let time_s: Vec<f64> = (0..5_000).map(|n| 1e-3 * f64::from(n)).collect();
            let pulse = |t: f64, from: f64, to: f64| f64::from((from..to).contains(&t));
            // Noise of ±20 mN and ±4 mm/s at half the rate and at a fifth of it.
            let noise = |i: usize| [1.0, -1.0, 0.6, -0.9, 0.4][i % 5];
            let normal_n = (time_s.iter().enumerate())
                .map(|(i, t)| 0.5 * pulse(*t, 1.0, 4.0) + 0.02 * noise(i))
                .collect();
            let velocity_m_per_s = (time_s.iter().enumerate())
                .map(|(i, t)| 0.05 * (pulse(*t, 1.2, 2.4) - pulse(*t, 2.5, 3.7)) + 0.004 * noise(i))
                .collect();
            Self {
                time_s,
                normal_n,
                velocity_m_per_s,
            }
        }

        fn normal(&self) -> Series<'_> {
            Series {
                time_s: &self.time_s,
                values: &self.normal_n,
            }
        }

        fn velocity(&self) -> Series<'_> {
            Series {
                time_s: &self.time_s,
                values: &self.velocity_m_per_s,
            }
        }
    }

    fn are_near(span: &Span, from_s: f64, to_s: f64) -> bool {
        (span.from_s - from_s).abs() < 0.02 && (span.to_s - to_s).abs() < 0.02
    }

    #[test]
    fn unloaded_stretches_are_found_in_noise_and_despite_strays() {
        let mut trial = Trial::new();
        trial.normal_n[500] = 9.0;
        let spans = Rule::parse("normal < 0.05 N for 0.3 s")
            .unwrap()
            .spans(&trial.normal());
        assert_eq!(spans.len(), 2, "{spans:?}");
        assert!(
            are_near(&spans[0], 0.0, 1.0) && are_near(&spans[1], 4.0, 5.0),
            "{spans:?}"
        );
        // The stretches end before the touch and begin after it.
        assert!(spans[0].to_s < 1.0 && spans[1].from_s > 4.0, "{spans:?}");
        assert!(
            spans[0].why.starts_with("the normal force is "),
            "{}",
            spans[0].why
        );
        assert!(
            spans[0].why.ends_with("(normal < 0.05 N for 0.3 s)"),
            "{}",
            spans[0].why
        );
    }

    #[test]
    fn explorations_have_the_direction_of_the_speed() {
        let trial = Trial::new();
        let velocity = trial.velocity();
        let found = Rule::parse("40 to 60 mm/s for 0.5 s")
            .unwrap()
            .explorations(&velocity, &velocity);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(
            are_near(&found[0].span, 1.2, 2.4) && are_near(&found[1].span, 2.5, 3.7),
            "{found:?}"
        );
        assert_eq!(
            [found[0].direction, found[1].direction],
            [Direction::LeftToRight, Direction::RightToLeft]
        );
        let by_force = Rule::parse("normal > 0.2 N for 0.5 s")
            .unwrap()
            .explorations(&trial.normal(), &velocity);
        let long: Vec<_> = by_force
            .iter()
            .map(|exploration| exploration.direction)
            .collect();
        assert_eq!(
            long,
            [Direction::LeftToRight, Direction::RightToLeft],
            "{by_force:?}"
        );
    }

    #[test]
    fn a_force_upside_down_is_neither_a_touch_nor_an_unloaded_plate() {
        let mut trial = Trial::new();
        trial.normal_n.iter_mut().for_each(|n| *n = -*n);
        let unloaded = Rule::parse("normal < 0.05 N for 0.3 s")
            .unwrap()
            .spans(&trial.normal());
        assert_eq!(unloaded.len(), 2, "{unloaded:?}");
        assert!(
            Rule::parse("normal > 0.2 N for 0.3 s")
                .unwrap()
                .spans(&trial.normal())
                .is_empty()
        );
    }

    #[test]
    fn a_gap_ends_a_stretch_and_a_short_one_is_none() {
        let mut trial = Trial::new();
        trial.time_s[700..].iter_mut().for_each(|t| *t += 0.5);
        trial.normal_n[300..320].fill(f64::NAN);
        let spans = Rule::parse("normal < 0.05 N for 0.5 s")
            .unwrap()
            .spans(&trial.normal());
        assert_eq!(spans.len(), 2, "{spans:?}");
        assert!(
            are_near(&spans[0], 0.0, 0.7) && are_near(&spans[1], 4.5, 5.5),
            "{spans:?}"
        );
    }

    #[test]
    fn a_series_of_ten_samples_a_second_is_no_row_of_gaps() {
        let time_s: Vec<f64> = (0..50).map(|n| 0.1 * f64::from(n)).collect();
        let values = vec![0.01; 50];
        let spans = Rule::parse("normal < 0.05 N for 2 s")
            .unwrap()
            .spans(&Series {
                time_s: &time_s,
                values: &values,
            });
        assert_eq!(spans.len(), 1);
    }
}
