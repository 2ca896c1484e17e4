//! Findings and their words.

use std::borrow::Cow;

use force_alignment::TellingFactor;
use serde::{Deserialize, Serialize};
use statistics::significant;

use crate::channel::Channel;
use crate::friction_split::FrictionSplit;
use crate::lateral_evidence::LateralEvidence;
use crate::quantity::Quantity;
use crate::units::{
    CONTACT_AREA_M2, FRICTION, HPA_PER_MMHG, LARGEST_N, force_factor, force_remedy, height_m,
    nearest, position_remedy,
};
use crate::unloaded::UnloadedFinger;

/// Reading that no finger and no sound channel makes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, thiserror::Error)]
pub enum Implausible {
    /// The normal force is too large or too small.
    #[error(
        "force.csv: normal_n reads {} N while the finger slides, {} any finger's: {}", significant(*normal_n),
        if *normal_n > LARGEST_N { "more than" } else { "less than" }, force_remedy(*normal_n)
    )]
    Size {
        /// Size of the force at the 90th percentile, N.
        normal_n: f64,
    },
    /// The normal force is less than that of a touch.
    #[error(
        "force.csv: normal_n reads {} N while the finger slides, less than the {} N with which a finger touches: {}; or state the force \
         of a touch as contact_n", significant(*normal_n), significant(*contact_n), force_remedy(*normal_n)
    )]
    Light {
        /// Size of the force at the 90th percentile, N.
        normal_n: f64,
        /// Force from which a finger touches, N.
        contact_n: f64,
    },
    /// The normal force is small, and the laws do not hold.
    #[error(
        "force.csv: normal_n reads {} N while the finger slides, which is little for a finger, and the laws do not hold: {}",
        significant(*normal_n), force_remedy(*normal_n)
    )]
    SmallForces {
        /// Size of the force at the 90th percentile, N.
        normal_n: f64,
    },
    /// Readings jump and come back within a few rows.
    #[error(
        "{file}: {column} jumps to {value} at {at_s:.3} s and back, {}, as no finger does: these rows are left out; look for the \
         program's sign for a lost reading, or for a loose cable",
        if *count == 1 { "in 1 row".to_owned() } else { format!("and so in {count} rows") }
    )]
    Stray {
        /// File.
        file: Cow<'static, str>,
        /// Name of the column.
        column: Cow<'static, str>,
        /// Number of rows.
        count: usize,
        /// First value.
        value: f64,
        /// Its time, s.
        at_s: f64,
    },
    /// Most rows have the time of another row.
    #[error(
        "{file}: {lost} of {rows} rows have no time of their own: time_s was rounded, as a spreadsheet does that saves what it shows; take \
         the file as the program of the sensor wrote it"
    )]
    RoundedTimes {
        /// File.
        file: Cow<'static, str>,
        /// Number of rows that are left out.
        lost: u64,
        /// Number of all rows.
        rows: u64,
    },
    /// A column wraps.
    #[error(
        "force.csv: {column} jumps between {} and {} N, {jumps} times at once: integers went beyond their range and began \
         again at its other end; read them with a wider type, or record with a larger range", significant(*least_n), significant(*most_n)
    )]
    Wrapped {
        /// Name of the column.
        column: Cow<'static, str>,
        /// Least reading, N.
        least_n: f64,
        /// Greatest reading, N.
        most_n: f64,
        /// Number of jumps from one end to the other.
        jumps: usize,
    },
    /// Readings come twice.
    #[error(
        "force.csv: the readings from {from_s:.3} to {to_s:.3} s are those from {first_s:.3} s on again, to the last digit: a buffer was written \
         twice, or a stretch was copied; take the readings as the sensor gave them, or cut them there"
    )]
    Repeated {
        /// Start of the second time, s.
        from_s: f64,
        /// End of it, s.
        to_s: f64,
        /// Start of the first time, s.
        first_s: f64,
    },
    /// A column has a hum of the mains.
    #[error(
        "force.csv: {column} has a hum of {amplitude_n:.2} N at {hz} Hz without a finger: look at the ground and the shield of the sensor's cable, or \
         take it out of both forces"
    )]
    Hum {
        /// Name of the column.
        column: Cow<'static, str>,
        /// Amplitude, N.
        amplitude_n: f64,
        /// Frequency of the mains, Hz.
        hz: f64,
    },
    /// The lateral force contains a part of the normal force.
    #[error(
        "force.csv: lateral_n contains {:.0} % of normal_n, by slides there and back whose friction differs by it at the crest of the film: \
         correct it by the sensor's matrix, or subtract this share of normal_n with the sign that makes both directions alike",
        100.0 * per_normal
    )]
    Crosstalk {
        /// Lateral force per newton of normal force that does not turn with the slide.
        per_normal: f64,
    },
    /// A column was low-passed.
    #[error(
        "force.csv: without a finger {column} has hardly any noise above {cut_off_hz:.0} Hz: it was low-passed, and friction that follows the modulation \
         at {} Hz is flattened, its highest values too small and its lowest too large; take the readings before the filter",
        significant(*modulation_hz)
    )]
    Smoothed {
        /// Name of the column.
        column: Cow<'static, str>,
        /// Frequency above which its noise falls, Hz.
        cut_off_hz: f64,
        /// Frequency of the modulation, Hz.
        modulation_hz: f64,
    },
    /// Rows are missing while the finger slides.
    #[error(
        "force.csv: nothing was read for {:.2} s from {from_s:.3} s on while the finger slides, and every {step_s:.4} s elsewhere: readings \
         are missing, or the clock was set; friction there is unknown", to_s - from_s
    )]
    Gap {
        /// Time of the last row before, s.
        from_s: f64,
        /// Time of the first row after, s.
        to_s: f64,
        /// Usual interval, s.
        step_s: f64,
    },
    /// The normal force is negative while the finger presses.
    #[error(
        "force.csv: normal_n is negative while the finger presses ({} N): it has the sensor's sign; multiply it by -1",
        significant(*normal_n)
    )]
    Sign {
        /// Force at the 10th percentile, N.
        normal_n: f64,
    },
    /// A column has one value throughout.
    #[error(
        "force.csv: {column} is {value} in each of {rows} rows: the sensor sent nothing new, or the column was filled in; \
         look at its cable and at the program that wrote the file"
    )]
    Constant {
        /// Name of the column.
        column: Cow<'static, str>,
        /// Its value.
        value: f64,
        /// Number of rows.
        rows: usize,
    },
    /// A column keeps one value for a while.
    #[error(
        "force.csv: {column} is {value} N from {from_s:.3} to {to_s:.3} s while the finger slides, as no finger does: the sensor or its \
         program sent nothing new, and these rows are left out; look at the cable and at the program that wrote the file"
    )]
    Held {
        /// Name of the column.
        column: Cow<'static, str>,
        /// Its value, N.
        value: f64,
        /// First time, s.
        from_s: f64,
        /// Last time, s.
        to_s: f64,
    },
    /// A column follows a straight line for a while.
    #[error(
        "force.csv: {column} is straight from {from_s:.3} to {to_s:.3} s: a gap was filled in; leave lost rows out, or write NaN"
    )]
    Interpolated {
        /// Name of the column.
        column: Cow<'static, str>,
        /// First time, s.
        from_s: f64,
        /// Last time, s.
        to_s: f64,
    },
    /// A column is cut off at the end of a range.
    #[error(
        "force.csv: {column} is {} N in {rows} rows and never beyond: it was cut off at the end of the range of the sensor, its amplifier \
         or its converter, and the force beyond is lost; record with a larger range", significant(*limit_n)
    )]
    Clipped {
        /// Name of the column.
        column: Cow<'static, str>,
        /// Reading at the end of the range, N.
        limit_n: f64,
        /// Number of rows there.
        rows: usize,
    },
    /// The lateral force does not fit the normal force.
    #[error(
        "force.csv: lateral_n is {} times normal_n while the finger slides, and friction is {} to {}: look at the units and the \
         gains of both columns", significant(*ratio), FRICTION[0], FRICTION[1]
    )]
    Friction {
        /// Ratio of the lateral to the normal force.
        ratio: f64,
    },
    /// The carrier is far from the plate's resonance.
    #[error(
        "carrier_hz = {carrier_hz:.0} is {:.0} Hz from resonance_hz = {resonance_hz:.0}: the plate hardly moves there, so its \
         impedance is uncertain and amplitudes are small", (carrier_hz - resonance_hz).abs()
    )]
    Carrier {
        /// Carrier, Hz.
        carrier_hz: f64,
        /// Stated resonance of the plate, Hz.
        resonance_hz: f64,
    },
    /// The ambient pressure is rather in millimetres of mercury.
    #[error(
        "room.pressure_hpa = {pressure_hpa} is the pressure at {:.0} m above the sea, and {pressure_hpa} mmHg are {:.0} hPa: state what a \
         barometer at the bench reads in hPa", 10.0 * (height_m(*pressure_hpa) / 10.0).round(), pressure_hpa * HPA_PER_MMHG
    )]
    Pressure {
        /// Stated pressure, hPa.
        pressure_hpa: f64,
    },
    /// A channel uses a small part of its range.
    #[error(
        "signals.wav: the {channel} never exceeds 1/{:.0} of full scale: 24-bit samples that were read as 32-bit ones \
         (multiply them by 256), or an input with too little gain", 1.0 / level
    )]
    SmallShare {
        /// Name of the channel.
        channel: String,
        /// Largest |sample|, as a share of full scale.
        level: f32,
    },
    /// The normal force is far from zero without a finger.
    #[error(
        "force.csv: normal_n reads {} N in the intervals without a finger: it is untared, subtract that reading; or something \
         rested on the plate", significant(*normal_n)
    )]
    Untared {
        /// Median without a finger, N.
        normal_n: f64,
    },
    /// A finger was on the plate in the intervals without one, by the forces.
    #[error(
        "force.csv: normal_n reads {} N in the intervals without a finger, {}: a finger was on the plate; correct the unloaded \
         intervals", significant(*normal_n), .evidence
    )]
    FingerUnloaded {
        /// Median in these intervals, N.
        normal_n: f64,
        /// Evidence against a zero of the sensor.
        evidence: UnloadedFinger,
    },
    /// The columns of normal and lateral force are exchanged.
    #[error(
        "force.csv: normal_n follows the modulation, by {:.0} % of its mean, and lateral_n by {:.0} %, but the film modulates \
         friction: the columns are exchanged; exchange their names", normal * 100.0, lateral * 100.0
    )]
    Exchanged {
        /// Modulated share of the column `normal_n`.
        normal: f64,
        /// Modulated share of the column `lateral_n`.
        lateral: f64,
    },
    /// The columns are exchanged, by strokes in both directions.
    #[error(
        "force.csv: normal_n turns with the direction of the strokes, by ±{turn_n:.2} N, and lateral_n presses one way, with \
         {press_n:.2} N: the columns are exchanged; exchange their names"
    )]
    ExchangedByStrokes {
        /// Half the change of the column `normal_n` with the direction, N.
        turn_n: f64,
        /// Mean size of the column `lateral_n`, N.
        press_n: f64,
    },
    /// Both columns are one.
    #[error(
        "force.csv: normal_n and lateral_n are equal in each row: one column was read twice; name the other one"
    )]
    Alike,
    /// The lateral force has the other sign.
    #[error(
        "force.csv: lateral_n is negative while the finger slides towards growing positions: it has the sensor's sign; multiply it \
         by -1 (friction is taken by its size, so that the estimates remain)"
    )]
    LateralSign,
    /// The forces come late or early.
    #[error(
        "force.csv: the forces come {:.1} ± {:.1} ms {} against drive and pickup, as contact and friction show; analysed with their \
         times corrected: add {:+.4} s to time_s, and look for a trigger or a filter in the path of the sensor",
        late_s.abs() * 1e3, half_width95_s * 1e3, if *late_s > 0.0 { "late" } else { "early" }, -late_s
    )]
    ForcesLate {
        /// Delay, s.
        late_s: f64,
        /// Half width of its 95 % interval, s.
        half_width95_s: f64,
    },
    /// The forces come at times that nothing in the recording confirms, and friction is not that which follows from the impedance.
    #[error(
        "force.csv: the forces come at times that neither contact nor friction confirms, and the friction is {} (RMS) off that which \
         follows from the impedance: look at time_s, its start and its clock", significant(*rms_mu)
    )]
    ForcesUnplaced {
        /// RMS of estimated less measured friction.
        rms_mu: f64,
    },
    /// The forces come late or early by one of two delays.
    #[error(
        "force.csv: the forces come late by {first_s:.3} or by {second_s:.3} s against drive and pickup (early if negative): the \
         recording does not show by which; state the right times"
    )]
    ForcesUnclear {
        /// One delay, s.
        first_s: f64,
        /// The other delay, s.
        second_s: f64,
    },
    /// The lateral force's zero is that of strokes there and back.
    #[error(
        "force.csv: lateral_n differs between strokes there and back by twice {:+.0} ± {:.0} mN, and shows no zero without a finger; \
         analysed with this zero: tare the sensor, and leave the plate free for a second", zero_n * 1e3, half_width95_n * 1e3
    )]
    StrokesZero {
        /// Zero of the lateral force, N.
        zero_n: f64,
        /// Half width of its 95 % interval, N.
        half_width95_n: f64,
    },
    /// The forces are on a clock of another rate.
    #[error(
        "force.csv: its times are on a clock that is {:.0} ± {:.0} ppm {} against that of signals.wav; analysed with their times \
         corrected: multiply time_s by {:.6}, and state the true rate of the sensor",
        ppm.abs(), half_width95_ppm, if *ppm > 0.0 { "slow" } else { "fast" }, 1.0 + 1e-6 * ppm
    )]
    ForcesClock {
        /// Excess of true over stated time, ppm.
        ppm: f64,
        /// Half width of its 95 % interval, ppm.
        half_width95_ppm: f64,
    },
    /// The position is in another unit.
    #[error(
        "position.csv: the finger travels {} m at {} m/s, more than any finger on a plate: {}",
        significant(*travel_m), significant(*speed_m_per_s), position_remedy(*travel_m)
    )]
    PositionUnit {
        /// Longest travel in an exploration, m.
        travel_m: f64,
        /// Median speed, m/s.
        speed_m_per_s: f64,
    },
    /// The position runs against the stated directions.
    #[error(
        "position.csv: position_m falls in every exploration stated as left_to_right, and grows in every one stated as \
         right_to_left: it runs backwards; multiply it by -1 and state centre_m on that scale, or exchange the directions"
    )]
    Backwards,
    /// The finger passes beside the place at which instances are selected.
    #[error(
        "position.csv: the finger slides from {} to {} m and never near centre_m = {}: state position_m and centre_m in metres from \
         one origin", significant(*from_m), significant(*to_m), significant(*centre_m)
    )]
    OffCentre {
        /// Smallest position of all slides, m.
        from_m: f64,
        /// Largest position of all slides, m.
        to_m: f64,
        /// Stated centre of the plate, m.
        centre_m: f64,
    },
    /// The finger slides at another speed than those that are selected.
    #[error(
        "position.csv: the finger slides at {} m/s, and instances are selected from {} to {} m/s: look at the scale of position_m, which \
         is wrong by 2 or 4 if an encoder's edges were counted as periods, or state the speed as speed_m_per_s",
        significant(*speed_m_per_s), significant(*least_m_per_s), significant(*most_m_per_s)
    )]
    OtherSpeed {
        /// Median speed of the slides, m/s.
        speed_m_per_s: f64,
        /// Least speed that is selected, m/s.
        least_m_per_s: f64,
        /// Greatest speed that is selected, m/s.
        most_m_per_s: f64,
    },
    /// The plate moves too little to lift a finger.
    #[error(
        "signals.wav: the plate moves by {} µm at most under the finger, too little to lift a finger as far as friction \
         falls: look at metres_per_unit and the gain of the pickup, and at the drive", significant(*amplitude_m * 1e6)
    )]
    Amplitude {
        /// Largest amplitude, m.
        amplitude_m: f64,
    },
    /// The plate moves further than any.
    #[error(
        "signals.wav: the plate moves by {} µm under the finger, many times as far as a plate does at such a carrier: look at \
         metres_per_unit and at the gains of both channels", significant(*amplitude_m * 1e6)
    )]
    LargeAmplitude {
        /// Largest amplitude, m.
        amplitude_m: f64,
    },
    /// The positions come late or early against the friction.
    #[error(
        "position.csv: the positions come {:.2} s {} against lateral_n, which turns with the finger: correct the \
         times of the one that is wrong, by {:.2} s", late_s.abs(), if *late_s > 0.0 { "late" } else { "early" }, late_s.abs()
    )]
    PositionsLate {
        /// Delay of the positions, s.
        late_s: f64,
    },
    /// The position keeps one value, and then jumps.
    #[error(
        "position.csv: position_m stands still from {from_s:.3} to {to_s:.3} s and then jumps by {:.1} mm{}: the encoder or its program sent \
         nothing new, and the speeds there are wrong; look at its cable and at the program that wrote the file", jump_m.abs() * 1e3,
        if *count == 1 { String::new() } else { format!(", and so {count} times") }
    )]
    PositionHeld {
        /// Start of the first time, s.
        from_s: f64,
        /// End of it, s.
        to_s: f64,
        /// Jump after it, m.
        jump_m: f64,
        /// Number of times.
        count: usize,
    },
    /// The position jumps under a finger.
    #[error(
        "position.csv: position_m jumps by {:.1} mm at {at_s:.3} s while the finger presses{}: a counter that began again, was set back or \
         miscounted; state the bits of the counter, or look at the encoder", jump_m * 1e3,
        if *count == 1 { String::new() } else { format!(", and so {count} times") }
    )]
    PositionJumps {
        /// Time of the first jump, s.
        at_s: f64,
        /// The jump, m.
        jump_m: f64,
        /// Number of jumps.
        count: usize,
    },
    /// The lateral force acts where nothing presses, and always where something does.
    #[error(
        "force.csv: lateral_n acts for {alone_s:.2} s in which normal_n is none, and always where it is not: the columns are exchanged; exchange their names, \
         or correct the zero of lateral_n if they are right"
    )]
    LateralAlone {
        /// Time of a lateral force alone, s.
        alone_s: f64,
    },
    /// The voltage of the drive is in a force.
    #[error(
        "force.csv: {column} follows the modulation with {amplitude_n:.3} N without a finger: the amplifier's voltage is in the force channel; \
         look at grounds and cables, or subtract it by the drive's envelope"
    )]
    Coupled {
        /// Name of the column.
        column: Cow<'static, str>,
        /// Amplitude at the modulation, N.
        amplitude_n: f64,
    },
    /// The modulation's phase jumps.
    #[error(
        "signals.wav: the modulation jumps by {:+.0} ms at {at_s:.2} s, apart from whole periods: samples are missing or doubled there{}; write \
         lost samples as NaN, and look for full buffers of the program that wrote the file", jump_s * 1e3,
        if *is_timed { ", or the drive was started again" } else { ", so that the forces lack their times" }
    )]
    ModulationJumps {
        /// Time of the jump, s.
        at_s: f64,
        /// Jump of its phase as a time, s, apart from whole periods.
        jump_s: f64,
        /// Whether the forces have their times against drive and pickup all the same.
        is_timed: bool,
    },
    /// The lateral force is that of another time than the normal one or the position.
    #[error(
        "force.csv: lateral_n comes {}: correct the times of the one that is wrong, or take lateral_n before a filter that removes its mean",
        evidence.words(*late_s)
    )]
    LateralLag {
        /// Least delay of the lateral force, s.
        late_s: f64,
        /// Evidence.
        evidence: LateralEvidence,
    },
    /// Friction differs within a recording.
    #[error(
        "force.csv: friction is {}: by a zero or a gain that changed, or a finger held differently; look at lateral_n without a finger, and at \
         the range and the matrix of the sensor", split.words(*mu)
    )]
    FrictionDiffers {
        /// Both frictions.
        mu: [f64; 2],
        /// Boundary between them.
        split: FrictionSplit,
    },
    /// Friction follows the amplitude with a lag, or falls below zero.
    #[error(
        "force.csv: friction fits the amplitude only {:.0} ms {} it and with {} far above the plate, as no film makes it: the forces were \
         averaged or filtered, or normal_n and lateral_n have different times; take the readings before the filter",
        lag_s.abs() * 1e3, if *lag_s > 0.0 { "behind" } else { "ahead of" }, significant(*floor)
    )]
    FrictionLag {
        /// Lag of friction, s.
        lag_s: f64,
        /// Friction far above a film.
        floor: f64,
    },
    /// Friction is not that which follows from the impedance.
    #[error(
        "force.csv: the friction is {rms_mu:.3} (RMS) off that which follows from the impedance: a force that is filtered, wraps, drifts or \
         changes its gain does this, and so does a finger of other laws; look at lateral_n and normal_n over time"
    )]
    FrictionUnlike {
        /// RMS difference.
        rms_mu: f64,
    },
    /// Friction nearly vanishes at the least stimulus.
    #[error(
        "stimulus.csv: friction is {} at the least stimulus and {} at the greatest, which no surface has: the stimulus is upside down, or \
         comes late or early, by half of its period if it is periodic; correct its sign or its times",
        significant(*mu_at_least), significant(*mu_at_greatest)
    )]
    StimulusUpsideDown {
        /// Friction at the least stimulus.
        mu_at_least: f64,
        /// Friction at the greatest stimulus.
        mu_at_greatest: f64,
    },
    /// The position does not change.
    #[error(
        "position.csv: position_m has one value throughout each exploration: the encoder sent nothing new, or the column was \
         filled in; look at its cable and at the program that wrote the file"
    )]
    PositionStill,
    /// Drive and pickup are exchanged.
    #[error(
        "signals.wav: the pickup's envelope is {:.1} ms ahead of the drive's, but a plate follows its drive: drive and pickup are \
         exchanged, as by swapped cables; exchange channels.drive.index and channels.pickup.index", lead_s * 1e3
    )]
    ChannelsExchanged {
        /// Lead of the envelope that is stated to be the pickup's, s.
        lead_s: f64,
    },
    /// A scale of drive or pickup is off by a telling factor.
    #[error(
        "the unloaded plate answers to the modulation as if its modal mass were {} times the stated one: a scale is off by {factor}; \
         check volts_per_unit, force_factor_n_per_v and metres_per_unit (peak), and modal_mass_kg", significant(*ratio)
    )]
    ScaleFactor {
        /// Ratio of the modal mass by the plate's answer to the stated one.
        ratio: f64,
        /// Factor.
        factor: TellingFactor,
    },
    /// A scale of drive or pickup is far off.
    #[error(
        "the unloaded plate answers to the modulation as if its modal mass were {} times the stated one: check volts_per_unit, \
         force_factor_n_per_v, metres_per_unit and modal_mass_kg{}", significant(*ratio), nearest(*ratio, *near)
    )]
    Scale {
        /// Ratio of the modal mass by the plate's answer to the stated one.
        ratio: f64,
        /// Telling factor near it, but further away than its errors allow.
        near: Option<TellingFactor>,
    },
    /// The stated modulation is not in the drive.
    #[error(
        "the drive's envelope is modulated at modulation_hz = {stated_hz} by {:.0} % only: state the frequency of the modulation, \
         or correct the sample rate", share * 100.0
    )]
    OtherModulation {
        /// Stated frequency, Hz.
        stated_hz: f64,
        /// Share of the envelope's mean that is at that frequency.
        share: f64,
    },
    /// A finger was on the plate in the intervals without one.
    #[error(
        "the plate's damping in the intervals without a finger is {excess_n_s_per_m:.2} N·s/m higher at small amplitudes: a finger was \
         on it, although the forces do not show it; correct the unloaded intervals"
    )]
    FingerOnPlate {
        /// Excess of the damping at small over that at large amplitudes, N·s/m.
        excess_n_s_per_m: f64,
    },
    /// Drive or pickup is compressed at large amplitudes.
    #[error(
        "the plate's damping in the intervals without a finger is {:.0} % higher at large amplitudes than at small ones: a channel or the \
         amplifier is near the end of its range there; measure the drive at the actuators, and drive less or use a larger range",
        100.0 * growth
    )]
    Compression {
        /// Growth of the damping from small to large amplitudes, relative.
        growth: f64,
    },
    /// The pickup reads another quantity than the displacement.
    #[error("pickup: its phase is that of {}, not of a displacement: {}", quantity.words().0, quantity.words().1)]
    PickupQuantity {
        /// The quantity.
        quantity: Quantity,
    },
    /// The self-sensed normal force fits the measured one only with a contact area that no finger has.
    #[error(
        "the self-sensed normal force is that of normal_n only with a contact of {} mm², and a finger pad's is {:.0} to {:.0}: normal_n \
         is some {:.1} times too large, or another scale is off; look at its unit and its gain",
        significant(area_m2 * 1e6), CONTACT_AREA_M2[0] * 1e6, CONTACT_AREA_M2[1] * 1e6, force_factor(*area_m2)
    )]
    ContactArea {
        /// Contact area, m².
        area_m2: f64,
    },
    /// The drive's phase jumps.
    #[error(
        "signals.wav: the drive's phase jumps by {turn_rad:+.1} rad between {from_s:.3} and {to_s:.3} s: samples are missing or doubled \
         there{}; write lost samples as NaN, and look for full buffers of the program that wrote the file",
        if *is_timed { ", or the drive was started again" } else { ", so that the forces lack their times" }
    )]
    DriveJumps {
        /// Last time before the jump, s.
        from_s: f64,
        /// First time after it, s.
        to_s: f64,
        /// Turn, rad.
        turn_rad: f64,
        /// Whether the forces have their times against drive and pickup all the same.
        is_timed: bool,
    },
    /// The level of drive or pickup jumps.
    #[error(
        "the {channel}'s level jumps to {ratio:.2} times at {at_s:.2} s, and the {}'s does not: a gain or range was changed there, or a contact is \
         loose; record with fixed ranges, or state the recording's parts before and after it apart", channel.other()
    )]
    LevelJumps {
        /// Channel.
        channel: Channel,
        /// Time of the jump, s.
        at_s: f64,
        /// Ratio of the level after the jump to that before it.
        ratio: f64,
    },
    /// The lateral force has one sign in both directions.
    #[error(
        "force.csv: lateral_n has one sign while the finger slides there and back, as a magnitude, a rectified voltage or a sign that changes \
         with the recording has: take the signed component along the slide; a resultant of several axes is no friction"
    )]
    LateralUnsigned,
    /// A channel has one value throughout.
    #[error(
        "signals.wav: the {channel} is {value} in each sample: a dead channel; look at its cable, its index and the program that \
         wrote the file"
    )]
    DeadChannel {
        /// Name of the channel.
        channel: String,
        /// Its value.
        value: String,
    },
    /// The signal's strongest tone is far from the stated carrier.
    #[error(
        "signals.wav: the strongest tone of the drive is at {found_hz:.0} Hz, and carrier_hz = {stated_hz:.0} is not in it: state \
         the carrier, or correct the sample rate if it is {} times that of the data", significant(found_hz / stated_hz)
    )]
    OtherCarrier {
        /// Frequency of the strongest tone, Hz.
        found_hz: f64,
        /// Stated carrier, Hz.
        stated_hz: f64,
    },
}
