//! Faults of a sweep.

use crate::swept_quantity::SweptQuantity;

/// Fewest distinct frequencies.
pub const LEAST_FREQUENCIES: usize = 8;

/// Fault of a sweep; the message does not name the file, the caller's report does. Lines count from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SweepFault {
    /// The file has no rows of numbers.
    #[error(
        "it has no row of three numbers: save the sweep as a table of text with frequency and two parts of the response in each row"
    )]
    NoRows,
    /// The file is a Touchstone file.
    #[error(
        "line {line}: it has scattering parameters (Touchstone); export admittance or impedance from the analyser instead"
    )]
    Scattering {
        /// Line that states it.
        line: usize,
    },
    /// The choice of columns does not name three.
    #[error(
        "the columns `{choice}` are {count}, not three: name frequency, then real and imaginary part or magnitude and phase, as in f,G,B or f[kHz],mag[dB],phase[deg]"
    )]
    ColumnCount {
        /// The choice.
        choice: String,
        /// Number of columns in it.
        count: usize,
    },
    /// The header does not show the columns.
    #[error(
        "its columns ({found}) do not show which are frequency and response: name three with --columns, by name or by number from 0, as in 0,1,2"
    )]
    UnknownColumns {
        /// Columns of the file.
        found: String,
    },
    /// A named column is not in the file.
    #[error("no column `{column}`; its columns are {found}")]
    NoColumn {
        /// The column.
        column: String,
        /// Columns of the file.
        found: String,
    },
    /// A name fits several columns.
    #[error(
        "`{column}` fits several columns ({found}): write the whole heading, or a number from 0"
    )]
    ManyColumns {
        /// The column.
        column: String,
        /// Columns that it fits.
        found: String,
    },
    /// A unit is not one of a sweep.
    #[error(
        "`{unit}` is not a unit of a sweep: write Hz, kHz, MHz or rad/s; S, mS or µS; Ω or kΩ; m/V, µm/V or nm/V; m/s/V or mm/s/V; dB; deg or rad"
    )]
    UnknownUnit {
        /// The unit.
        unit: String,
    },
    /// A column has a unit of another kind.
    #[error(
        "the column `{column}` is no {expected} by its unit or name: correct the order or the units in --columns"
    )]
    OtherKind {
        /// The column.
        column: String,
        /// Kind that its place needs.
        expected: &'static str,
    },
    /// A column has a unit of another quantity.
    #[error(
        "the column `{column}` is an {found}, and the sweep is read as {quantity}: correct --quantity or --columns"
    )]
    OtherQuantity {
        /// The column.
        column: String,
        /// Its quantity.
        found: SweptQuantity,
        /// Quantity of the sweep.
        quantity: SweptQuantity,
    },
    /// The quantity is not known.
    #[error(
        "its columns do not show the quantity: add --quantity admittance, impedance, displacement or velocity"
    )]
    NoQuantity,
    /// A phase has no unit.
    #[error(
        "the column `{column}` states no unit of its phase: write {column}[deg] or {column}[rad] in --columns"
    )]
    NoAngle {
        /// The column.
        column: String,
    },
    /// The phases are those of another unit.
    #[error(
        "the phases of the column `{column}` reach {largest:.1}, as in {other}, and it is read in {stated}: write {column}[{other}] in --columns"
    )]
    OtherAngle {
        /// The column.
        column: String,
        /// Largest absolute phase.
        largest: f64,
        /// Unit in which it is read.
        stated: &'static str,
        /// Unit that the numbers fit.
        other: &'static str,
    },
    /// A magnitude is negative.
    #[error(
        "line {line}, column `{column}`: a magnitude cannot be {value}: write {column}[dB] in --columns if it is in decibels"
    )]
    NegativeMagnitude {
        /// The line.
        line: usize,
        /// The column.
        column: String,
        /// The value.
        value: f64,
    },
    /// The magnitudes in decibels hardly differ.
    #[error(
        "the column `{column}` varies by {range_db:.2} dB and reads as a plain magnitude: write its unit in --columns, as in {column}[S]"
    )]
    NotDecibels {
        /// The column.
        column: String,
        /// Range, dB.
        range_db: f64,
    },
    /// A cell is not a finite number.
    #[error(
        "line {line}, column `{column}`: {cell:?} is not a finite number: correct it, or delete the line"
    )]
    Number {
        /// The line.
        line: usize,
        /// The column.
        column: String,
        /// The cell.
        cell: String,
    },
    /// The frequencies are not those of a plate.
    #[error(
        "its frequencies run from {} to {} Hz, where no plate resonates (1 kHz to 10 MHz): state the unit of the column, as in {column}[kHz]",
        statistics::significant(*.from_hz), statistics::significant(*.to_hz)
    )]
    Frequencies {
        /// Column of the frequencies.
        column: String,
        /// Lowest frequency, Hz.
        from_hz: f64,
        /// Highest frequency, Hz.
        to_hz: f64,
    },
    /// The sweep has too few frequencies.
    #[error(
        "it has {count} frequencies, and at least {} are needed: sweep in finer steps",
        LEAST_FREQUENCIES
    )]
    TooFew {
        /// Number of distinct frequencies.
        count: usize,
    },
    /// No resonance lies within the sweep.
    #[error(
        "no resonance between {from_hz:.0} and {to_hz:.0} Hz stands out of the response: sweep about the resonance, at least 8 steps across its bandwidth f0/Q, or correct --columns and --quantity"
    )]
    NoResonance {
        /// Lowest frequency, Hz.
        from_hz: f64,
        /// Highest frequency, Hz.
        to_hz: f64,
    },
    /// The response rises to an end of the sweep.
    #[error(
        "no resonance between {from_hz:.0} and {to_hz:.0} Hz: the response rises to {edge_hz:.0} Hz, an end of the sweep; sweep further"
    )]
    BeyondTheEnd {
        /// Lowest frequency, Hz.
        from_hz: f64,
        /// Highest frequency, Hz.
        to_hz: f64,
        /// End to which the response rises, Hz.
        edge_hz: f64,
    },
    /// An admittance and an impedance were exchanged.
    #[error(
        "the clamped capacitance comes out negative: the {read} is an {likely}; write --quantity {likely}, or correct the signs"
    )]
    OtherDual {
        /// Quantity as read.
        read: SweptQuantity,
        /// Quantity that the sweep seems to be.
        likely: SweptQuantity,
    },
}
