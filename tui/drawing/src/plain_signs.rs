//! Conversion of a screen to ASCII, for terminals with a locale other than UTF-8.

use ratatui::buffer::Buffer;

use crate::braille;

/// Replaces every non-ASCII character by an ASCII one.
pub fn plain_signs(buf: &mut Buffer) {
    for cell in &mut buf.content {
        let Some(sign) = cell.symbol().chars().next().filter(|c| !c.is_ascii()) else {
            continue;
        };
        cell.set_char(plain(sign));
    }
}

/// Returns the ASCII replacement for `sign`.
pub fn plain(sign: char) -> char {
    match sign {
        '\u{2800}'..='\u{28ff}' => {
            braille::plain(u8::try_from(u32::from(sign) - 0x2800).unwrap_or(u8::MAX))
        }
        'μ' | 'µ' => 'u',
        '−' | '–' | '─' | '━' | '═' => '-',
        '│' | '┤' | '┃' | '▏' => '|',
        '┌' | '┐' | '└' | '┘' | '├' | '┬' | '┴' | '┼' | '±' | '✓' => '+',
        '█' | '▓' => '#',
        '▒' | '░' => ':',
        '╱' => '/',
        '✗' | '×' => 'x',
        '●' => 'o',
        '▼' | '↓' => 'v',
        '▲' | '↑' => '^',
        '▸' | '→' => '>',
        '←' => '<',
        '·' => '.',
        '…' => '~',
        '“' | '”' => '"',
        '’' => '\'',
        'σ' => 's',
        'τ' => 't',
        'η' => 'h',
        'Δ' => 'D',
        '²' => '2',
        '³' => '3',
        _ => '?',
    }
}
