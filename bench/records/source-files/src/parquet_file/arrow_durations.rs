//! Columns of durations, which only Arrow's schema in the file's metadata tells from integers.
//!
//! The schema is a flatbuffer in base 64: a message of Arrow's `Message.fbs`, with the fields of `Schema.fbs`.

/// Key of the schema in the metadata.
pub(super) const KEY: &str = "ARROW:schema";

/// Number of the type `Duration` in Arrow's union of types.
const DURATION: u8 = 18;
/// Parts of a second of Arrow's units of time, in their order.
const PARTS: [f64; 4] = [1.0, 1e3, 1e6, 1e9];
/// Unit of a duration that states none.
const MILLISECOND: u16 = 1;

/// Returns the names of the columns of durations, each with the parts of a second that it counts.
pub(super) fn durations(schema: &str) -> Vec<(String, f64)> {
    let bytes = base64(schema);
    found(&bytes).unwrap_or_default()
}

fn found(bytes: &[u8]) -> Option<Vec<(String, f64)>> {
    // A mark of four bytes and the length of the message stand before it.
    let start = if bytes.starts_with(&[0xff; 4]) { 8 } else { 4 };
    let buffer = Buffer(bytes.get(start..)?);
    let message = buffer.follow(0)?;
    let schema = buffer.follow(buffer.field(message, 2)?)?;
    let fields = buffer.follow(buffer.field(schema, 1)?)?;
    let mut durations = Vec::new();
    for i in 0..buffer.u32(fields)? as usize {
        let field = buffer.follow(fields + 4 + 4 * i)?;
        let kind = buffer.field(field, 2).and_then(|place| buffer.byte(place));
        if kind != Some(DURATION) {
            continue;
        }
        let name = buffer.text(buffer.follow(buffer.field(field, 0)?)?)?;
        let kind = buffer.follow(buffer.field(field, 3)?)?;
        let unit = buffer.field(kind, 0).and_then(|place| buffer.u16(place));
        let parts = PARTS.get(usize::from(unit.unwrap_or(MILLISECOND)))?;
        durations.push((name, *parts));
    }
    Some(durations)
}

/// Flatbuffer.
struct Buffer<'a>(&'a [u8]);

impl Buffer<'_> {
    fn byte(&self, place: usize) -> Option<u8> {
        self.0.get(place).copied()
    }

    fn u16(&self, place: usize) -> Option<u16> {
        let bytes = self.0.get(place..)?.first_chunk()?;
        Some(u16::from_le_bytes(*bytes))
    }

    fn u32(&self, place: usize) -> Option<u32> {
        let bytes = self.0.get(place..)?.first_chunk()?;
        Some(u32::from_le_bytes(*bytes))
    }

    /// Returns the place that an offset at `place` leads to.
    fn follow(&self, place: usize) -> Option<usize> {
        place.checked_add(self.u32(place)? as usize)
    }

    /// Returns the place of a table's field; `None` where it is absent.
    fn field(&self, table: usize, index: usize) -> Option<usize> {
        let back = i32::from_le_bytes(self.u32(table)?.to_le_bytes());
        let list = usize::try_from(i64::try_from(table).ok()? - i64::from(back)).ok()?;
        let entry = 4 + 2 * index;
        let is_there = entry < usize::from(self.u16(list)?);
        let offset = is_there.then(|| self.u16(list + entry))??;
        (offset > 0).then(|| table + usize::from(offset))
    }

    fn text(&self, place: usize) -> Option<String> {
        let bytes = self.0.get(place.checked_add(4)?..)?;
        let bytes = bytes.get(..self.u32(place)? as usize)?;
        String::from_utf8(bytes.to_vec()).ok()
    }
}

/// Returns the bytes of a text in base 64, up to the first other character.
fn base64(text: &str) -> Vec<u8> {
    let digit = |byte: u8| match byte {
        b'A'..=b'Z' => Some(byte - b'A'),
        b'a'..=b'z' => Some(byte - b'a' + 26),
        b'0'..=b'9' => Some(byte - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    };
    let digits: Vec<u8> = text.bytes().map_while(digit).collect();
    let mut bytes = Vec::new();
    for group in digits.chunks(4) {
        let word = group.iter().enumerate().fold(0u32, |word, (i, digit)| {
            word | u32::from(*digit) << (18 - 6 * i)
        });
        let [_, all @ ..] = word.to_be_bytes();
        bytes.extend(&all[..group.len().saturating_sub(1)]);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Schema that pyarrow wrote for the columns `t`, a duration in milliseconds, `d`, one in nanoseconds, and `x`, floats.
    const SCHEMA: &str = "/////8gAAAAQAAAAAAAKAAwABgAFAAgACgAAAAABBAAMAAAACAAIAAAABAAIAAAABAAAAAMAAABwAAAAMAAAAAQAAACs////AAABAxAAAAAUAAAABAAAAAAAAAABAAAAeAAAANr///8AAAIA1P///wAAARIQAAAAGAAAAAQAAAAAAAAAAQAAAGQABgAIAAYABgAAAAAAAwAQABQACAAGAAcADAAAABAAEAAAAAAAARIQAAAAGAAAAAQAAAAAAAAAAQAAAHQAAAAEAAQABAAAAA==";

    #[test]
    fn durations_are_told_from_integers() {
        let expected = [("t".to_owned(), 1e3), ("d".to_owned(), 1e9)];
        assert_eq!(durations(SCHEMA), expected);
        for end in 0..SCHEMA.len() {
            let cut = durations(&SCHEMA[..end]);
            assert!(cut.len() <= 2);
        }
        assert!(durations("no schema").is_empty());
    }
}
