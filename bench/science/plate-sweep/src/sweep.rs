//! A sweep: responses in order of frequency.

use metrology::plate_fit::Response;
use num_complex::Complex64;

use crate::column_choice::{ChosenColumn, ColumnChoice};
use crate::heading::{ColumnRole, Heading, key};
use crate::sweep_fault::{LEAST_FREQUENCIES, SweepFault};
use crate::sweep_table::SweepTable;
use crate::sweep_unit::SweepUnit;
use crate::swept_quantity::SweptQuantity;

/// Lowest and highest resonance of a plate, Hz, and the tolerance about them.
const PLATES_HZ: std::ops::RangeInclusive<f64> = 1e3..=1e7;
/// Largest phase that reads as radians, and largest that reads as degrees.
const LARGEST_RAD: f64 = 6.6;
const LARGEST_DEG: f64 = 361.0;
/// Largest phase that does not read as degrees: a resonance turns by more.
const SMALL_DEG: f64 = 3.2;
/// Smallest range of magnitudes in decibels, dB.
const LEAST_RANGE_DB: f64 = 0.5;

/// A sweep in order of frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    pub(crate) quantity: SweptQuantity,
    /// Charge or displacement over voltage.
    pub(crate) responses: Vec<Response>,
    columns: String,
    notes: Vec<String>,
}

/// A column of the table, with its heading; the unit is the one in which it is read.
struct SweepColumn {
    place: usize,
    heading: Heading,
}

/// Parts in which a response is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ResponseParts {
    Cartesian,
    Polar,
}

impl Sweep {
    /// Creates the sweep of `quantity` with these values at these frequencies, in any order; values at the same frequency are
    /// averaged, and those at 0 Hz left out.
    ///
    /// # Errors
    /// A value is not finite, the frequencies are too few or none of a plate.
    pub fn new(
        quantity: SweptQuantity,
        frequency_hz: &[f64],
        values: &[Complex64],
    ) -> Result<Self, SweepFault> {
        let points = frequency_hz.iter().zip(values);
        let points = (1..).zip(points.map(|(frequency_hz, value)| (*frequency_hz, *value)));
        Self::from_points(
            quantity,
            points.collect(),
            "frequency",
            "three arrays".to_owned(),
            Vec::new(),
        )
    }

    /// Reads the sweep in `text`: a table of any program with a column of frequencies and two of the response. Without `choice`
    /// its header must show the columns, and without `quantity` the quantity.
    ///
    /// # Errors
    /// [`SweepFault`] names line, column and remedy.
    pub fn read(
        text: &str,
        choice: Option<&ColumnChoice>,
        quantity: Option<SweptQuantity>,
    ) -> Result<Self, SweepFault> {
        let table = SweepTable::parse(text)?;
        let columns = match choice {
            Some(choice) => chosen_columns(&table, choice)?,
            None => shown_columns(&table, quantity)?,
        };
        for column in &columns {
            require_known_unit(&column.heading)?;
        }
        let [frequency, first, second] = &columns;
        let parts = parts(&first.heading, &second.heading)?;
        let quantity = swept_quantity(&first.heading, &second.heading, parts, quantity)?;
        let mut notes = Vec::new();
        let hertz = match frequency.heading.unit {
            Some(SweepUnit::Frequency(size)) => size,
            None => {
                notes.push(no_unit(&frequency.heading, "Hz"));
                1.0
            }
            Some(_) => return Err(other_kind(&frequency.heading, "frequency")),
        };
        let names = [frequency, first, second].map(|column| column.heading.name.as_str());
        let rows = table.numbers(columns.each_ref().map(|column| column.place), names)?;
        let value = match parts {
            ResponseParts::Cartesian => {
                cartesian(&first.heading, &second.heading, quantity, &mut notes)?
            }
            ResponseParts::Polar => {
                polar(&first.heading, &second.heading, quantity, &rows, &mut notes)?
            }
        };
        let points = rows
            .iter()
            .map(|(line, [f, a, b])| (*line, (f * hertz, value(*a, *b))))
            .collect();
        let in_words = columns
            .each_ref()
            .map(|column| column.heading.text.clone())
            .join(", ");
        let sweep = Self::from_points(quantity, points, names[0], in_words, notes)?;
        Ok(sweep)
    }

    fn from_points(
        quantity: SweptQuantity,
        points: Vec<(usize, (f64, Complex64))>,
        column: &str,
        columns: String,
        mut notes: Vec<String>,
    ) -> Result<Self, SweepFault> {
        let mut responses: Vec<(Response, f64)> = Vec::with_capacity(points.len());
        let mut left_out = 0usize;
        for (line, (frequency_hz, value)) in points {
            let ratio = quantity.response(frequency_hz, value);
            if frequency_hz == 0.0 {
                left_out += 1;
                continue;
            }
            if !(frequency_hz > 0.0 && frequency_hz.is_finite()) {
                return Err(SweepFault::Number {
                    line,
                    column: column.to_owned(),
                    cell: frequency_hz.to_string(),
                });
            }
            if !ratio.is_finite() {
                return Err(SweepFault::Number {
                    line,
                    column: quantity.name().to_owned(),
                    cell: value.to_string(),
                });
            }
            responses.push((
                Response {
                    frequency_hz,
                    ratio,
                },
                1.0,
            ));
        }
        responses.sort_by(|(a, _), (b, _)| a.frequency_hz.total_cmp(&b.frequency_hz));
        let rows = responses.len();
        responses.dedup_by(|(next, weight), (kept, kept_weight)| {
            let is_same = next.frequency_hz == kept.frequency_hz;
            if is_same {
                kept.ratio =
                    (kept.ratio * *kept_weight + next.ratio * *weight) / (*kept_weight + *weight);
                *kept_weight += *weight;
            }
            is_same
        });
        let responses: Vec<Response> = responses
            .into_iter()
            .map(|(response, _)| response)
            .collect();
        let count = responses.len();
        let (Some(first), Some(last)) = (responses.first(), responses.last()) else {
            return Err(SweepFault::TooFew { count });
        };
        let (from_hz, to_hz) = (first.frequency_hz, last.frequency_hz);
        if to_hz < *PLATES_HZ.start() || from_hz > *PLATES_HZ.end() {
            return Err(SweepFault::Frequencies {
                column: column.to_owned(),
                from_hz,
                to_hz,
            });
        }
        if count < LEAST_FREQUENCIES {
            return Err(SweepFault::TooFew { count });
        }
        if left_out > 0 {
            notes.push(format!("{left_out} row(s) at 0 Hz are left out"));
        }
        if count < rows {
            notes.push(format!(
                "{rows} rows have {count} different frequencies; rows of the same frequency are averaged"
            ));
        }
        Ok(Self {
            quantity,
            responses,
            columns,
            notes,
        })
    }

    /// Returns the swept quantity.
    #[must_use]
    pub fn quantity(&self) -> SweptQuantity {
        self.quantity
    }

    /// Returns the headings of the columns that were read.
    #[must_use]
    pub fn columns(&self) -> &str {
        &self.columns
    }

    /// Returns the remarks on the reading of the table, each a sentence without its stop.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Returns the lowest and the highest frequency, Hz.
    #[must_use]
    pub fn range_hz(&self) -> [f64; 2] {
        let ends = [self.responses.first(), self.responses.last()];
        ends.map(|end| end.map_or(f64::NAN, |response| response.frequency_hz))
    }
}

/// Returns the columns of a choice.
fn chosen_columns(
    table: &SweepTable,
    choice: &ColumnChoice,
) -> Result<[SweepColumn; 3], SweepFault> {
    let [a, b, c] = &choice.columns;
    Ok([
        chosen_column(table, a, 0)?,
        chosen_column(table, b, 1)?,
        chosen_column(table, c, 2)?,
    ])
}

fn chosen_column(
    table: &SweepTable,
    chosen: &ChosenColumn,
    order: usize,
) -> Result<SweepColumn, SweepFault> {
    let place = match chosen.name.parse::<usize>() {
        Ok(number) if number < table.width() => number,
        // Without a header, the names are those of the columns in order.
        Err(_) if table.headings.is_empty() && order < table.width() => order,
        Err(_) if !table.headings.is_empty() => named_column(table, &chosen.name)?,
        _ => {
            return Err(SweepFault::NoColumn {
                column: chosen.name.clone(),
                found: table.columns_in_words(),
            });
        }
    };
    let heading = table.headings.get(place).cloned();
    let heading = heading.unwrap_or_else(|| Heading::parse(&chosen.name));
    Ok(SweepColumn {
        place,
        heading: Heading {
            unit: chosen.unit.or(heading.unit),
            text: match chosen.unit {
                // The unit in force is that of the choice.
                Some(_) => heading.name.clone(),
                None => heading.text.clone(),
            },
            ..heading
        },
    })
}

/// Returns the place of the column with this name: the whole heading, its name, or another name of the same quantity.
fn named_column(table: &SweepTable, name: &str) -> Result<usize, SweepFault> {
    let query = Heading::parse(name);
    let meaning = |heading: &Heading| heading.role().map(|role| (role, heading.quantity()));
    let fits: [&dyn Fn(&Heading) -> bool; 4] = [
        &|heading| heading.text.eq_ignore_ascii_case(name),
        &|heading| heading.name.eq_ignore_ascii_case(name),
        &|heading| !key(name).is_empty() && key(&heading.name) == key(name),
        &|heading| meaning(heading).is_some() && meaning(heading) == meaning(&query),
    ];
    for fit in fits {
        let headings = table.headings.iter().enumerate();
        let found: Vec<(usize, &Heading)> = headings.filter(|(_, heading)| fit(heading)).collect();
        match found[..] {
            [] => {}
            [(place, _)] => return Ok(place),
            _ => {
                let found = found
                    .iter()
                    .map(|(_, heading)| format!("`{}`", heading.text));
                return Err(SweepFault::ManyColumns {
                    column: name.to_owned(),
                    found: found.collect::<Vec<_>>().join(", "),
                });
            }
        }
    }
    Err(SweepFault::NoColumn {
        column: name.to_owned(),
        found: table.columns_in_words(),
    })
}

/// Returns the columns that the header shows: one of frequencies and one pair of parts.
fn shown_columns(
    table: &SweepTable,
    quantity: Option<SweptQuantity>,
) -> Result<[SweepColumn; 3], SweepFault> {
    let with_role = |role| {
        let headings = table.headings.iter().enumerate();
        headings.filter(move |(_, heading)| heading.role() == Some(role))
    };
    let agree = |a: &Heading, b: &Heading| match (a.quantity(), b.quantity()) {
        (Some(a), Some(b)) => a == b,
        _ => true,
    };
    let is_asked = |heading: &Heading| match (quantity, heading.quantity()) {
        (Some(asked), Some(found)) => asked == found,
        _ => true,
    };
    let pairs_of = |first, second| {
        let pairs = with_role(first).flat_map(move |a| with_role(second).map(move |b| (a, b)));
        pairs.filter(|((_, a), (_, b))| agree(a, b) && is_asked(a) && is_asked(b))
    };
    let pairs: Vec<_> = pairs_of(ColumnRole::Real, ColumnRole::Imaginary)
        .chain(pairs_of(ColumnRole::Magnitude, ColumnRole::Phase))
        .collect();
    let frequencies: Vec<_> = with_role(ColumnRole::Frequency).collect();
    let ([frequency], [(first, second)]) = (&frequencies[..], &pairs[..]) else {
        return Err(SweepFault::UnknownColumns {
            found: table.columns_in_words(),
        });
    };
    Ok(
        [*frequency, *first, *second].map(|(place, heading)| SweepColumn {
            place,
            heading: heading.clone(),
        }),
    )
}

/// Requires that a heading in brackets that are part of no name states a unit of a sweep.
fn require_known_unit(heading: &Heading) -> Result<(), SweepFault> {
    let inner = heading
        .text
        .strip_suffix([')', ']'])
        .and_then(|text| text.rsplit_once(['(', '[']));
    match inner {
        Some((_, unit))
            if heading.unit.is_none() && heading.role().is_none() && !unit.trim().is_empty() =>
        {
            Err(SweepFault::UnknownUnit {
                unit: unit.trim().to_owned(),
            })
        }
        _ => Ok(()),
    }
}

fn other_kind(heading: &Heading, expected: &'static str) -> SweepFault {
    SweepFault::OtherKind {
        column: heading.text.clone(),
        expected,
    }
}

fn no_unit(heading: &Heading, unit: &str) -> String {
    format!(
        "the column `{}` states no unit and is read in {unit}",
        heading.name
    )
}

/// Returns the parts in which two columns give a response.
fn parts(first: &Heading, second: &Heading) -> Result<ResponseParts, SweepFault> {
    use ColumnRole::{Frequency, Imaginary, Magnitude, Phase, Real};
    match (first.role(), second.role()) {
        (Some(Magnitude) | None, Some(Phase)) => Ok(ResponseParts::Polar),
        (Some(Magnitude), _) => Err(other_kind(second, "phase")),
        (Some(Real) | None, Some(Imaginary) | None) => Ok(ResponseParts::Cartesian),
        (Some(Real), Some(Phase)) => Err(other_kind(first, "magnitude")),
        (Some(Frequency | Imaginary | Phase), _) => {
            Err(other_kind(first, "real part or magnitude"))
        }
        (_, Some(Frequency | Real | Magnitude)) => {
            Err(other_kind(second, "imaginary part or phase"))
        }
    }
}

/// Returns the quantity that is asked for or shown, which the columns must not contradict.
fn swept_quantity(
    first: &Heading,
    second: &Heading,
    parts: ResponseParts,
    asked: Option<SweptQuantity>,
) -> Result<SweptQuantity, SweepFault> {
    // A lone x, r or v is a reactance, a displacement, a resistance, a velocity…
    let is_clear = |heading: &Heading| {
        heading.unit.is_some() || !["x", "r", "v"].contains(&key(&heading.name).as_str())
    };
    let mut stated = [
        Some(first),
        Some(second).filter(|_| parts == ResponseParts::Cartesian),
    ]
    .into_iter()
    .flatten()
    .filter_map(|heading| Some((heading, heading.quantity()?)));
    let all: Vec<(&Heading, SweptQuantity)> = stated.by_ref().collect();
    let clear = all.iter().find(|(heading, _)| is_clear(heading));
    let quantity = asked.or_else(|| clear.or(all.first()).map(|(_, quantity)| *quantity));
    let quantity = quantity.ok_or(SweepFault::NoQuantity)?;
    let other = all
        .iter()
        .find(|(heading, found)| is_clear(heading) && *found != quantity);
    match other {
        Some((heading, found)) => Err(SweepFault::OtherQuantity {
            column: heading.text.clone(),
            found: *found,
            quantity,
        }),
        None => Ok(quantity),
    }
}

/// A function from two cells to a value in the SI unit of its quantity.
type ValueOfCells = Box<dyn Fn(f64, f64) -> Complex64>;

fn cartesian(
    first: &Heading,
    second: &Heading,
    quantity: SweptQuantity,
    notes: &mut Vec<String>,
) -> Result<ValueOfCells, SweepFault> {
    let size = |heading: &Heading| match heading.unit {
        Some(SweepUnit::Response(_, size)) => Ok(Some(size)),
        None => Ok(None),
        Some(_) => Err(other_kind(heading, "real or imaginary part")),
    };
    let sizes = [size(first)?, size(second)?];
    for (heading, size) in [first, second].into_iter().zip(sizes) {
        if size.is_none() && sizes == [None, None] {
            notes.push(no_unit(heading, quantity.unit()));
        } else if size.is_none() {
            notes.push(format!(
                "the column `{}` states no unit and is read in that of the other part",
                heading.name
            ));
        }
    }
    if first.role().is_none() && second.role().is_none() {
        notes.push(format!(
            "the columns `{}` and `{}` are read as real and imaginary part",
            first.name, second.name
        ));
    }
    let [re, im] = sizes;
    let re_size = re.or(im).unwrap_or(1.0);
    let im_size = im.or(re).unwrap_or(1.0);
    Ok(Box::new(move |re, im| {
        Complex64::new(re_size * re, im_size * im)
    }))
}

fn polar(
    magnitude: &Heading,
    phase: &Heading,
    quantity: SweptQuantity,
    rows: &[(usize, [f64; 3])],
    notes: &mut Vec<String>,
) -> Result<ValueOfCells, SweepFault> {
    let radians = match phase.unit {
        Some(SweepUnit::Angle(size)) => size,
        _ => {
            return Err(SweepFault::NoAngle {
                column: phase.name.clone(),
            });
        }
    };
    let largest = rows
        .iter()
        .map(|(_, [_, _, phase])| phase.abs())
        .fold(0.0, f64::max);
    let is_degrees = (radians - 1f64.to_radians()).abs() < 1e-9;
    let other = match (is_degrees, radians == 1.0) {
        (true, _) if largest <= SMALL_DEG => Some(("degrees", "rad")),
        (_, true) if largest > LARGEST_RAD && largest <= LARGEST_DEG => Some(("radians", "deg")),
        _ => None,
    };
    if let Some((stated, other)) = other {
        return Err(SweepFault::OtherAngle {
            column: phase.name.clone(),
            largest,
            stated,
            other,
        });
    }
    if let Some(SweepUnit::Decibels(reference)) = magnitude.unit {
        let magnitudes = rows.iter().map(|(_, [_, magnitude, _])| *magnitude);
        let highest = magnitudes.clone().fold(f64::NEG_INFINITY, f64::max);
        let range_db = highest - magnitudes.fold(f64::INFINITY, f64::min);
        if range_db < LEAST_RANGE_DB {
            return Err(SweepFault::NotDecibels {
                column: magnitude.name.clone(),
                range_db,
            });
        }
        if reference.is_none() {
            notes.push(format!(
                "the column `{}` states no reference of its decibels, and 0 dB are read as 1 {}",
                magnitude.name,
                quantity.unit()
            ));
        }
        let size = reference.map_or(1.0, |(_, size)| size);
        return Ok(Box::new(move |db, phase| {
            Complex64::from_polar(size * 10f64.powf(db / 20.0), phase * radians)
        }));
    }
    let negative = rows.iter().find(|(_, [_, magnitude, _])| *magnitude < 0.0);
    if let Some((line, [_, value, _])) = negative {
        return Err(SweepFault::NegativeMagnitude {
            line: *line,
            column: magnitude.name.clone(),
            value: *value,
        });
    }
    let size = match magnitude.unit {
        Some(SweepUnit::Response(_, size)) => size,
        None => {
            notes.push(no_unit(magnitude, quantity.unit()));
            1.0
        }
        Some(_) => return Err(other_kind(magnitude, "magnitude")),
    };
    Ok(Box::new(move |magnitude, phase| {
        Complex64::from_polar(size * magnitude, phase * radians)
    }))
}
