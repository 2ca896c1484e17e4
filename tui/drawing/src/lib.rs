//! What a screen of cells is drawn with: curves of braille over value axes, styles by meaning, large digits, ASCII in place of other
//! signs, and a drawn screen as a picture.

pub mod braille;
pub mod digits;
pub mod picture;
pub mod plain_signs;
pub mod plot;
pub mod theme;
pub mod value_axis;
