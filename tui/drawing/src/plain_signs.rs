//! Conversion of a screen to ASCII, for terminals with a locale other than UTF-8.

use ratatui::buffer::Buffer;

use crate::braille;

/// Replaces every non-ASCII character by an ASCII one.
pub fn plain_signs(buf: &mut Buffer) {
    let width = usize::from(buf.area.width).max(1);
    for row in buf.content.chunks_mut(width) {
        for column in 0..row.len() {
            let symbol = row[column].symbol();
            let Some(sign) = symbol.chars().next().filter(|c| !c.is_ascii()) else {
                continue;
            };
            row[column].set_char(plain(sign));
            // The only sign whose meaning needs two characters.
            if sign == '±'
                && let Some(next) = row.get_mut(column + 1)
                && next.symbol() == " "
            {
                next.set_char('-');
            }
        }
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
