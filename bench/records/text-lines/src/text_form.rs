//! Encoding and line ends of a text, found in its first bytes.

/// Encoding of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// UTF-8; lines of other bytes are read as those of Western Europe.
    Utf8,
    /// UTF-16, the lower byte first.
    Utf16Le,
    /// UTF-16, the higher byte first.
    Utf16Be,
}

impl Encoding {
    /// Returns the encoding that a byte-order mark states; UTF-8 without one.
    #[must_use]
    pub fn find(head: &[u8]) -> Self {
        match head {
            [0xff, 0xfe, ..] => Self::Utf16Le,
            [0xfe, 0xff, ..] => Self::Utf16Be,
            _ => Self::Utf8,
        }
    }

    /// Returns the first two bytes of `bytes` as a unit of UTF-16.
    pub(crate) fn unit(self, bytes: [u8; 2]) -> u16 {
        match self {
            Self::Utf16Be => u16::from_be_bytes(bytes),
            Self::Utf8 | Self::Utf16Le => u16::from_le_bytes(bytes),
        }
    }

    /// Appends the bytes to `text`; returns whether they are of this encoding.
    pub(crate) fn decode(self, bytes: &[u8], text: &mut String) -> bool {
        if self == Self::Utf8 {
            let valid = std::str::from_utf8(bytes);
            text.push_str(valid.unwrap_or_default());
            return valid.is_ok();
        }
        let (units, _) = bytes.as_chunks::<2>();
        let units = units.iter().map(|bytes| self.unit(*bytes));
        text.extend(char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)));
        true
    }
}

/// Ends of lines: LF, which may follow CR, or CR alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineEnd {
    /// LF or CR LF.
    Lf,
    /// CR.
    Cr,
}

impl LineEnd {
    pub(crate) fn byte(self) -> u8 {
        match self {
            Self::Lf => b'\n',
            Self::Cr => b'\r',
        }
    }
}

/// Encoding and line ends of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TextForm {
    /// Encoding.
    pub encoding: Encoding,
    /// Ends of lines.
    pub end: LineEnd,
}

impl TextForm {
    /// Finds both in the first bytes of a file.
    #[must_use]
    pub fn find(head: &[u8]) -> Self {
        let encoding = Encoding::find(head);
        let mut text = String::new();
        if !encoding.decode(head, &mut text) {
            text.extend(head.iter().copied().map(char::from));
        }
        let has = |c: char| text.contains(c);
        let end = match has('\n') || !has('\r') {
            true => LineEnd::Lf,
            false => LineEnd::Cr,
        };
        Self { encoding, end }
    }
}
