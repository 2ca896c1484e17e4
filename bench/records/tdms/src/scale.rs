//! Scales of a channel: from stored numbers to the channel's unit.
//!
//! NI writes them as properties `NI_Scale[n]_…`: a chain in which each scale names its source, another scale or the stored number;
//! the last one gives the channel's values.

use std::collections::BTreeMap;

use crate::value::Value;

/// Source of a scale that is the stored number.
const STORED: u32 = 0xffff_ffff;

/// One scale of a chain.
#[derive(Debug, Clone, PartialEq)]
enum Step {
    /// Coefficients from the constant upward.
    Polynomial {
        source: u32,
        coefficients: Vec<f64>,
    },
    /// Points of a table, by growing abscissa; the ends are kept beyond it.
    Table {
        source: u32,
        points: Vec<(f64, f64)>,
    },
    Sum {
        sources: [u32; 2],
        sign: f64,
    },
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
            return Err(format!("{count} scales"));
        }
        let mut steps = Vec::new();
        for n in 0..count {
            let key = |name: &str| format!("NI_Scale[{n}]_{name}");
            let source = |name: &str| number(&key(name)).map_or(STORED, |source| source as u32);
            let array = |name: &str, default: usize| -> Vec<f64> {
                let count = number(&key(&format!("{name}_Size"))).map_or(default, |n| n as usize);
                let values =
                    (0..count.min(4096)).map_while(|i| number(&key(&format!("{name}[{i}]"))));
                values.collect()
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
                Some("Polynomial") => Step::Polynomial {
                    source: source("Polynomial_Input_Source"),
                    coefficients: array("Polynomial_Coefficients", 4),
                },
                Some("Table") => {
                    let scaled = array("Table_Scaled_Values", 0);
                    let stored = array("Table_Pre_Scaled_Values", 0);
                    let mut points: Vec<(f64, f64)> = stored.into_iter().zip(scaled).collect();
                    points.sort_by(|a, b| a.0.total_cmp(&b.0));
                    if points.is_empty() {
                        return Err("a table of scale without points".to_owned());
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
                Some(other) => {
                    return Err(format!(
                        "its scale is of type \"{other}\", which is not read: write the channel scaled, in its unit"
                    ));
                }
            });
        }
        Ok(Self { steps })
    }

    /// Returns a value in the channel's unit from the stored numbers, each with its number in DAQmx's list.
    pub fn apply(&self, stored: &[(Option<u32>, f64)]) -> f64 {
        let first = stored.first().map_or(f64::NAN, |(_, value)| *value);
        self.steps.len().checked_sub(1).map_or(first, |last| {
            self.value(last as u32, stored, self.steps.len())
        })
    }

    /// `depth` ends a chain that leads back to itself.
    fn value(&self, step: u32, stored: &[(Option<u32>, f64)], depth: usize) -> f64 {
        let by_number = || {
            let numbered = stored.iter().find(|(number, _)| *number == Some(step));
            numbered
                .or_else(|| stored.first())
                .map_or(f64::NAN, |(_, value)| *value)
        };
        let Some(depth) = depth.checked_sub(1).filter(|_| step != STORED) else {
            return if step == STORED {
                by_number()
            } else {
                f64::NAN
            };
        };
        let source = |source: u32| self.value(source, stored, depth);
        match self.steps.get(step as usize) {
            None => f64::NAN,
            Some(Step::Stored) => by_number(),
            Some(Step::Polynomial {
                source: from,
                coefficients,
            }) => {
                let x = source(*from);
                coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
            }
            Some(Step::Table {
                source: from,
                points,
            }) => interpolated(points, source(*from)),
            Some(Step::Sum { sources, sign }) => source(sources[0]) + sign * source(sources[1]),
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
