//! Scales of a channel: from stored numbers to the channel's unit.
//!
//! NI writes them as properties `NI_Scale[n]_…`: a chain in which each scale names its source, another scale or the stored number;
//! the last one gives the channel's values.

use std::collections::BTreeMap;

use crate::value::Value;

/// Source of a scale that is the stored number.
const STORED: u32 = 0xffff_ffff;

/// Most numbers of a table or a polynomial.
const MOST_POINTS: usize = 4096;
/// Most evaluations of scales for one sample; LabVIEW's chains need fewer than ten.
const MOST_EVALUATIONS: u64 = 1000;

/// One scale of a chain.
#[derive(Debug, Clone, PartialEq)]
enum Step {
    /// Coefficients from the constant upward.
    Polynomial { source: u32, coefficients: Vec<f64> },
    /// Points of a table, by growing abscissa; the ends are kept beyond it.
    Table {
        source: u32,
        points: Vec<(f64, f64)>,
    },
    /// Left operand times the sign, plus the right one: NI subtracts the left operand from the right one.
    Sum { sources: [u32; 2], sign: f64 },
    /// The stored number that has this number in DAQmx's list.
    Stored,
}

/// Scales of a channel.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Scales {
    steps: Vec<Step>,
}

impl Scales {
    /// Reads the scales among a channel's properties.
    ///
    /// # Errors
    /// A description of a scale that cannot be applied.
    pub fn read(properties: &BTreeMap<String, Value>) -> Result<Self, String> {
        let number = |key: &str| properties.get(key).and_then(Value::number);
        let text = |key: &str| properties.get(key).and_then(Value::text);
        // A channel that is stored in its unit carries the scales for information.
        if text("NI_Scaling_Status") == Some("scaled") {
            return Ok(Self::default());
        }
        let listed = number("NI_Number_Of_Scales").map(|count| count as usize);
        let found = properties.keys().filter_map(|key| {
            let (number, rest) = key.strip_prefix("NI_Scale[")?.split_once(']')?;
            (rest == "_Scale_Type").then(|| number.parse::<usize>().ok())?
        });
        let count = listed.unwrap_or_else(|| found.max().map_or(0, |last| last + 1));
        if count > 64 {
            return Err(format!("a chain of {count} scales"));
        }
        let mut steps = Vec::new();
        for n in 0..count {
            let key = |name: &str| format!("NI_Scale[{n}]_{name}");
            let source = |name: &str| number(&key(name)).map_or(STORED, |source| source as u32);
            let array = |name: &str, default: usize| -> Result<Vec<f64>, String> {
                let count = number(&key(&format!("{name}_Size"))).map_or(default, |n| n as usize);
                if count > MOST_POINTS {
                    return Err(format!("a scale of {count} numbers"));
                }
                let values = (0..count).map(|i| number(&key(&format!("{name}[{i}]"))));
                let values: Option<Vec<f64>> = values.collect();
                values.ok_or_else(|| format!("a scale without some of its {name}"))
            };
            steps.push(match text(&key("Scale_Type")) {
                None => Step::Stored,
                Some("Linear") => Step::Polynomial {
                    source: source("Linear_Input_Source"),
                    coefficients: vec![
                        number(&key("Linear_Y_Intercept")).unwrap_or(0.0),
                        number(&key("Linear_Slope")).ok_or("a linear scale without a slope")?,
                    ],
                },
                Some("Polynomial") => {
                    let coefficients = array("Polynomial_Coefficients", 4)?;
                    if coefficients.is_empty() {
                        return Err("a polynomial without coefficients".to_owned());
                    }
                    Step::Polynomial {
                        source: source("Polynomial_Input_Source"),
                        coefficients,
                    }
                }
                Some("Table") => {
                    let scaled = array("Table_Scaled_Values", 0)?;
                    let stored = array("Table_Pre_Scaled_Values", 0)?;
                    if stored.len() != scaled.len() || stored.is_empty() {
                        let lengths = format!("{} and {} points", stored.len(), scaled.len());
                        return Err(format!("a table of {lengths}"));
                    }
                    let mut points: Vec<(f64, f64)> = stored.into_iter().zip(scaled).collect();
                    if points.first() > points.last() {
                        points.reverse();
                    }
                    if !points.is_sorted_by(|a, b| a.0 < b.0) {
                        return Err("a table that rises and falls".to_owned());
                    }
                    Step::Table {
                        source: source("Table_Input_Source"),
                        points,
                    }
                }
                Some(kind @ ("Add" | "Subtract")) => Step::Sum {
                    sources: [
                        source(&format!("{kind}_Left_Operand_Input_Source")),
                        source(&format!("{kind}_Right_Operand_Input_Source")),
                    ],
                    sign: if kind == "Add" { 1.0 } else { -1.0 },
                },
                // A scale of an extension that leaves the numbers.
                Some("AdvancedAPI") => Step::Polynomial {
                    source: source("AdvancedAPI_Input_Source"),
                    coefficients: vec![0.0, 1.0],
                },
                Some(other) => {
                    return Err(format!("a scale of type \"{other}\""));
                }
            });
        }
        let scales = Self { steps };
        scales.require_end()?;
        Ok(scales)
    }

    /// Refuses chains that lead back to themselves, to a scale that is missing, or to the same scales again and again.
    fn require_end(&self) -> Result<(), String> {
        // Evaluations of each step; a step is known once its sources are.
        let mut costs: Vec<Option<u64>> = vec![None; self.steps.len()];
        for _ in &self.steps {
            for n in 0..self.steps.len() {
                let sources = self.steps.get(n).map_or([STORED; 2], Step::sources);
                let cost = sources
                    .into_iter()
                    .try_fold(1_u64, |sum, source| match source {
                        STORED => Some(sum),
                        _ => Some(sum.saturating_add((*costs.get(source as usize)?)?)),
                    });
                if let Some(known) = costs.get_mut(n) {
                    *known = cost;
                }
            }
        }
        match costs.last() {
            None => Ok(()),
            Some(Some(cost)) if *cost <= MOST_EVALUATIONS => Ok(()),
            Some(Some(_)) => Err("a chain of scales that refer to each other too often".to_owned()),
            Some(None) => Err("a chain of scales that leads to no stored number".to_owned()),
        }
    }

    /// Returns whether stored numbers are the channel's values.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// Returns a value in the channel's unit from the stored numbers, each with its number in DAQmx's list.
    pub fn apply(&self, stored: &[(Option<u32>, f64)]) -> f64 {
        let first = stored.first().map_or(f64::NAN, |(_, value)| *value);
        let last = self.steps.len().checked_sub(1);
        last.map_or(first, |last| self.value(last as u32, stored))
    }

    fn value(&self, step: u32, stored: &[(Option<u32>, f64)]) -> f64 {
        let by_number = || {
            let numbered = stored.iter().find(|(number, _)| *number == Some(step));
            numbered
                .or_else(|| stored.first())
                .map_or(f64::NAN, |(_, value)| *value)
        };
        match self.steps.get(step as usize) {
            None | Some(Step::Stored) => by_number(),
            Some(Step::Polynomial {
                source,
                coefficients,
            }) => {
                let x = self.value(*source, stored);
                coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
            }
            Some(Step::Table { source, points }) => {
                interpolated(points, self.value(*source, stored))
            }
            Some(Step::Sum { sources, sign }) => {
                sign * self.value(sources[0], stored) + self.value(sources[1], stored)
            }
        }
    }
}

impl Step {
    fn sources(&self) -> [u32; 2] {
        match self {
            Self::Stored => [STORED; 2],
            Self::Polynomial { source, .. } | Self::Table { source, .. } => [*source, STORED],
            Self::Sum { sources, .. } => *sources,
        }
    }
}

fn interpolated(points: &[(f64, f64)], x: f64) -> f64 {
    let after = points.partition_point(|(abscissa, _)| *abscissa < x);
    match (
        after.checked_sub(1).and_then(|i| points.get(i)),
        points.get(after),
    ) {
        (Some((x0, y0)), Some((x1, y1))) if x1 > x0 => y0 + (x - x0) / (x1 - x0) * (y1 - y0),
        (_, Some((_, y))) | (Some((_, y)), None) => *y,
        (None, None) => f64::NAN,
    }
}
