//! Drawing on a screen of cells: braille curves over value axes, styles by meaning, large digits, ASCII replacements
//! for other characters, lines that lose whole parts where they are too long, and pictures of a drawn screen.

pub mod braille;
pub mod chosen_theme;
pub mod digits;
pub mod escape;
pub mod numbers;
pub mod page_files;
pub mod picture;
pub mod plain_signs;
pub mod plot;
pub mod theme;
pub mod value_axis;
pub mod words;
