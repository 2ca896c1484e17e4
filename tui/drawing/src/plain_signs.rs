//! A screen in ASCII alone, for terminals whose locale is not UTF-8.

use ratatui::buffer::Buffer;

use crate::braille;

/// Replaces every sign beyond ASCII by one that stands for it.
pub fn plain_signs(buf: &mut Buffer) {
    for cell in &mut buf.content {
        let Some(sign) = cell.symbol().chars().next().filter(|c| !c.is_ascii()) else {
            continue;
        };
        cell.set_char(plain(sign));
    }
}

/// Returns the ASCII sign for `sign`.
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
