//! Days and times of the laboratory's calendar: those of the computer's time zone.
//!
//! Files state times in UTC with a `Z`, so that they can be compared. Dates that people read are days of the laboratory, and
//! times that people read state their offset from UTC.

use jiff::Timestamp;
use jiff::tz::TimeZone;

/// Returns the day of `time` in the laboratory, as `2026-01-31`.
#[must_use]
pub fn day(time: Timestamp) -> String {
    day_in(time, TimeZone::system())
}

/// Returns the day of `time` in `zone`, as `2026-01-31`.
///
/// ```
/// use jiff::tz::{Offset, TimeZone};
///
/// let evening = "2026-01-31T20:00:00Z".parse().unwrap();
/// let tokyo = TimeZone::fixed(Offset::constant(9));
/// assert_eq!(calendar::day_in(evening, tokyo), "2026-02-01");
/// assert_eq!(calendar::day_in(evening, TimeZone::UTC), "2026-01-31");
/// ```
#[must_use]
pub fn day_in(time: Timestamp, zone: TimeZone) -> String {
    time.to_zoned(zone).strftime("%Y-%m-%d").to_string()
}

/// Returns `time` in the laboratory, with its offset from UTC, as `2026-01-31 14:05:00 +01:00`.
#[must_use]
pub fn moment(time: Timestamp) -> String {
    moment_in(time, TimeZone::system())
}

/// Returns `time` in `zone`, with its offset from UTC.
///
/// ```
/// use jiff::tz::{Offset, TimeZone};
///
/// let evening = "2026-01-31T20:00:00Z".parse().unwrap();
/// let zone = TimeZone::fixed(Offset::constant(-3));
/// assert_eq!(calendar::moment_in(evening, zone), "2026-01-31 17:00:00 -03:00");
/// ```
#[must_use]
pub fn moment_in(time: Timestamp, zone: TimeZone) -> String {
    let zoned = time.to_zoned(zone);
    zoned.strftime("%Y-%m-%d %H:%M:%S %:z").to_string()
}

/// Returns a name of `time` for a folder, with its offset from UTC, as `2026-01-31_140500+0100`.
#[must_use]
pub fn folder_name(time: Timestamp) -> String {
    let zoned = time.to_zoned(TimeZone::system());
    zoned.strftime("%Y-%m-%d_%H%M%S%z").to_string()
}

/// First second of 2024, before this program existed, Unix time.
const EARLIEST_S: i64 = 1_704_067_200;

/// Returns the complaint about a clock that shows a day before this program existed; `None` for every later day.
#[must_use]
pub fn complaint(now: Timestamp) -> Option<String> {
    (now.as_second() < EARLIEST_S).then(|| {
        format!(
            "the computer's clock says {}: set it, because every recording states the date",
            now.strftime("%Y-%m-%d")
        )
    })
}
