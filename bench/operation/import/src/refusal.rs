//! Reasons why a recording is not imported.

use import_map::NameError;
use metrology::drive_modulation::ModulationError;
use source_files::SourceError;

/// Reason why a file gives no recording, with the remedy.
#[derive(Debug, thiserror::Error)]
pub enum ImportRefusal {
    /// A file cannot be read, or lacks an array.
    #[error(transparent)]
    Source(Box<SourceError>),
    /// The file's name gives no place in a study.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The operating system refused.
    #[error("{path}: {cause}")]
    System {
        /// File or folder.
        path: String,
        /// Reason and remedy.
        cause: String,
    },
    /// A table of marks or a sweep cannot be read.
    #[error("{file}: {reason}")]
    Table {
        /// File.
        file: String,
        /// Reason and remedy.
        reason: String,
    },
    /// The file states no rate.
    #[error("{key} = \"file\", but {file} states no rate: write the rate in Hz")]
    NoRate {
        /// Key.
        key: String,
        /// File.
        file: String,
    },
    /// The file states another rate.
    #[error(
        "{key} = {stated_hz} Hz, but {file} states {file_hz} Hz: correct it, or write \"file\""
    )]
    OtherRate {
        /// Key.
        key: String,
        /// Rate of the map, Hz.
        stated_hz: f64,
        /// File.
        file: String,
        /// Rate of the file, Hz.
        file_hz: f64,
    },
    /// A rate is not possible.
    #[error("{key} is {hz} Hz: {remedy}")]
    Rate {
        /// Key.
        key: String,
        /// Rate, Hz.
        hz: f64,
        /// Remedy.
        remedy: &'static str,
    },
    /// Times of samples are not even.
    #[error(
        "{key}: sample {sample} is {deviation:.2} sampling intervals from an even spacing: resample the data, or write rate_hz if the times are rounded"
    )]
    Uneven {
        /// Key.
        key: String,
        /// Index of the sample.
        sample: u64,
        /// Deviation, in sampling intervals.
        deviation: f64,
    },
    /// Times go back.
    #[error(
        "{key}: the time of sample {sample} is not after the one before: sort the rows, write dates beside a clock that passes midnight or is \
         set back, and keep recordings in files of their own"
    )]
    Backwards {
        /// Key.
        key: String,
        /// Index of the sample.
        sample: u64,
    },
    /// Samples have the same time.
    #[error(
        "{key}: sample {sample} has the time of the one before: write rate_hz in place of time if the times are rounded or those of blocks, and \
         delete rows that are there twice"
    )]
    EqualTimes {
        /// Key.
        key: String,
        /// Index of the sample.
        sample: u64,
    },
    /// The times of a part of a recording begin before those of the part before end.
    #[error(
        "the times of {second} begin at {start}, and those of {first}, which it continues, end at {end}: if no sample is missing between \
         them, write rate_hz in place of time; else let the group `part` capture their order"
    )]
    PartTimes {
        /// File of the part before.
        first: String,
        /// Its last time.
        end: f64,
        /// File of the part.
        second: String,
        /// Its first time.
        start: f64,
    },
    /// Drive and pickup begin at different times.
    #[error(
        "{second} begins {apart_s:+.6} s after {first}, as the file states: samples of drive and pickup are of the same times; cut the \
         earlier one, or correct the start in the file"
    )]
    Starts {
        /// Array of the drive.
        first: String,
        /// Array of the pickup.
        second: String,
        /// Start of the second less that of the first, s.
        apart_s: f64,
    },
    /// The file states another unit of times than seconds, and the map states none.
    #[error("{name} is in units of {unit_s:?} s, as its file states: write {key} = {unit_s:?}")]
    TimeUnit {
        /// Array of the times.
        name: String,
        /// Unit by the file, s.
        unit_s: f64,
        /// Key of the map.
        key: String,
    },
    /// A force was cut off at the end of a range.
    #[error(
        "{stream} is {limit_n:.4} N in {count} samples and never beyond: it was cut off at the end of the range of the sensor, its \
         amplifier or its converter; record with a larger range, or leave [{stream}] out and import the vibration alone"
    )]
    CutOff {
        /// Table of the map.
        stream: &'static str,
        /// Force at the end of the range, before any tare, N.
        limit_n: f64,
        /// Number of samples there.
        count: usize,
    },
    /// Two parts of a recording have the same bytes.
    #[error(
        "{second} has the same bytes as {first}, another part of the recording: delete the copy, or copy the right file"
    )]
    SamePart {
        /// A file.
        first: String,
        /// Its copy.
        second: String,
    },
    /// Two arrays that belong together differ in length.
    #[error(
        "{first} has {first_length} values and {second} {second_length}: they are of one stream, so name arrays of the same length"
    )]
    Lengths {
        /// First array.
        first: String,
        /// Its length.
        first_length: u64,
        /// Second array.
        second: String,
        /// Its length.
        second_length: u64,
    },
    /// The position follows the normal force's rate with another number of values.
    #[error(
        "{name} has {length} values and the normal force {force_length}, and both would have one rate: state rate_hz of the position"
    )]
    PositionRate {
        /// Array of the position.
        name: String,
        /// Its length.
        length: u64,
        /// Length of the normal force.
        force_length: u64,
    },
    /// An array has too few values.
    #[error("{name} has {length} values: too few for a recording; name the right array")]
    Short {
        /// Name of the array.
        name: String,
        /// Number of values.
        length: u64,
    },
    /// An array has too many values.
    #[error(
        "{name} has {length} values, and the limit for envelopes is {limit}: cut the recording into parts"
    )]
    Long {
        /// Name of the array.
        name: String,
        /// Number of values.
        length: u64,
        /// Greatest number.
        limit: u64,
    },
    /// A low-pass cannot be undone.
    #[error(
        "envelopes.low_pass can be undone up to {reach_hz:.0} Hz, and {needed_hz:.0} Hz are needed: record with a shorter time constant, a lower order, or more digits"
    )]
    LowPass {
        /// Frequency up to which it can be undone, Hz.
        reach_hz: f64,
        /// Frequency up to which the analysis needs the envelopes, Hz.
        needed_hz: f64,
    },
    /// A channel is dead.
    #[error(
        "{stream} ({name}) is dead: all its values are {value}; name the right array, or look for the plug"
    )]
    Dead {
        /// Stream.
        stream: String,
        /// Array.
        name: String,
        /// Its value; NaN if it has no number.
        value: f64,
    },
    /// The carrier of the map is not in the data.
    #[error(
        "carrier.hz = {stated_hz} Hz is not the carrier of the data: the drive's strongest tone is at {found_hz:.2} Hz; correct carrier.hz, or write \"found\""
    )]
    Carrier {
        /// Stated carrier, Hz.
        stated_hz: f64,
        /// Found carrier, Hz.
        found_hz: f64,
    },
    /// No carrier stands out of the drive.
    #[error(
        "no carrier stands out of the drive ({name}): name the array of the voltage across the actuators"
    )]
    NoCarrier {
        /// Array.
        name: String,
    },
    /// The carrier moves.
    #[error(
        "the carrier moves by {range_hz:.1} Hz within the recording: write carrier.hz = \"follows\""
    )]
    CarrierMoves {
        /// Range, Hz.
        range_hz: f64,
    },
    /// The modulation of the map is not in the data.
    #[error(
        "modulation.hz = {stated_hz} Hz, but the drive is modulated at {found_hz:.3} Hz: correct modulation.hz, or write \"found\""
    )]
    Modulation {
        /// Stated frequency, Hz.
        stated_hz: f64,
        /// Found frequency, Hz.
        found_hz: f64,
    },
    /// The drive is not modulated.
    #[error(
        "modulation.{key} = \"found\", but the drive is not modulated: write hz = 0 and index = 0 if that is right"
    )]
    NoModulation {
        /// Key.
        key: &'static str,
    },
    /// The drive is off, or on too briefly, so that its modulation cannot be found.
    #[error(
        "modulation.{key} = \"found\", but {reason}: name the array of the voltage across the actuators, or write hz and index"
    )]
    Undriven {
        /// Key.
        key: &'static str,
        /// Reason.
        reason: ModulationError,
    },
    /// Carrier and modulation are off by the same factor.
    #[error(
        "drive.rate_hz = {stated_hz} Hz is not that of the data: carrier and modulation are both {factor:.4} times the stated ones, so the rate would be {meant_hz:.0} Hz"
    )]
    DriveRate {
        /// Stated rate, Hz.
        stated_hz: f64,
        /// Factor.
        factor: f64,
        /// Rate with which both would be as stated, Hz.
        meant_hz: f64,
    },
    /// The forces' rate is not that of the data.
    #[error(
        "normal.rate_hz = {stated_hz} Hz is not that of the data: the friction follows the modulation at {factor:.3} times its frequency, so the rate would be {meant_hz:.0} Hz"
    )]
    ForceRate {
        /// Stated rate, Hz.
        stated_hz: f64,
        /// Factor.
        factor: f64,
        /// Rate with which the modulation would be as stated, Hz.
        meant_hz: f64,
    },
    /// Drive and pickup are exchanged.
    #[error(
        "drive and pickup are exchanged: the amplitude of [drive] follows that of [pickup] by {lag_ms:.2} ms, as a plate follows its voltage; exchange their arrays"
    )]
    Exchanged {
        /// Lag, ms.
        lag_ms: f64,
    },
    /// A value cannot be found in the data.
    #[error("{key} cannot be found: {reason}; write a number")]
    NotFound {
        /// Key.
        key: &'static str,
        /// Reason.
        reason: String,
    },
    /// A value cannot be found, and the recording as the map has it shows why.
    #[error("{key} cannot be found: {reason}; correct first: {flaws}")]
    Misread {
        /// Key.
        key: &'static str,
        /// Reason.
        reason: String,
        /// Flaws of the recording.
        flaws: String,
    },
    /// The forces come at other times than the map states.
    #[error(
        "the forces {deviation} against drive and pickup, as contact and friction show: correct rate_hz or time and offset_s of [normal], \
         or write clock = \"own\", offset_s = \"found\" and ppm = \"found\" there"
    )]
    ForceTimes {
        /// Deviation of their times, with its size.
        deviation: String,
    },
    /// A phase in radians is in degrees.
    #[error(
        "{name} reaches {greatest:.0} and jumps, as a phase in degrees does: write phase_deg in place of phase_rad"
    )]
    Degrees {
        /// Array of the phase.
        name: String,
        /// Its greatest size.
        greatest: f64,
    },
    /// Two participants have the same bytes.
    #[error(
        "{file} has the same bytes as {twin}, which is of another participant: one of the two is a copy under a wrong name"
    )]
    SameBytes {
        /// File of the recording.
        file: String,
        /// The other file.
        twin: String,
    },
    /// The plate alone was driven at another frequency.
    #[error(
        "{file}, the plate alone, has its carrier at {found_hz:.0} Hz, and the recording at {carrier_hz:.0} Hz: take one of the same carrier, \
         or leave [baseline] out if the recording has a stretch without a finger"
    )]
    BaselineCarrier {
        /// Place of the drive.
        file: String,
        /// Its carrier, Hz.
        found_hz: f64,
        /// The recording's carrier, Hz.
        carrier_hz: f64,
    },
    /// One file is read for two participants.
    #[error(
        "{file} is read for {participant} and for {other}: write the captured text in its place, as in \
         file = \"{{participant}}/force.txt\""
    )]
    SharedFile {
        /// File.
        file: String,
        /// Participant of the recording.
        participant: String,
        /// The other participant.
        other: String,
    },
    /// A recording that did not come from this map is in the way.
    #[error(
        "{recording} is there already and did not come from this map: use another study, or state another session or trial in [place]"
    )]
    Occupied {
        /// Recording.
        recording: String,
    },
    /// Forces or positions do not overlap the drive in time.
    #[error(
        "{stream} is from {:.3} to {:.3} s, and the drive from {:.3} to {:.3} s: state offset_s, with which both overlap \
         ({offset_s:.3} if both began at once)",
        span_s.0, span_s.1, drive_s.0, drive_s.1
    )]
    Apart {
        /// Stream.
        stream: &'static str,
        /// First and last time, s.
        span_s: (f64, f64),
        /// First and last time of the drive, s.
        drive_s: (f64, f64),
        /// Offset with which both begin at once, s.
        offset_s: f64,
    },
    /// The recording's description would not be valid.
    #[error("{0}")]
    Manifest(#[from] recording::manifest::ManifestError),
    /// The recording cannot be read back.
    #[error("the recording cannot be read back: {0}")]
    ReadBack(String),
}

impl From<SourceError> for ImportRefusal {
    fn from(error: SourceError) -> Self {
        Self::Source(Box::new(error))
    }
}

impl ImportRefusal {
    /// Describes a failure of the operating system at a path.
    pub(crate) fn system(path: &std::path::Path, error: &std::io::Error) -> Self {
        Self::System {
            path: path.display().to_string(),
            cause: bounded_files::cause(error),
        }
    }
}
