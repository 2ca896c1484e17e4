//! A page as files: a picture and plain text, in the program's working directory.

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::Path;

use ratatui::buffer::Buffer;

use crate::picture::{self, Paper};
use crate::theme::Theme;

/// Maximum number of pages per folder.
const MAX_NUMBER: u32 = 9999;

/// Writes the drawn screen into `folder` under the page's name without overwriting a file. Returns the picture's name.
///
/// # Errors
/// An error if the files cannot be written.
pub fn write(folder: &Path, name: &str, theme: Theme, screen: &Buffer) -> io::Result<String> {
    let paper = match theme {
        Theme::Light => Paper::Light,
        _ => Paper::Dark,
    };
    for number in 1..=MAX_NUMBER {
        let stem = format!("page-{name}-{number}");
        let picture = format!("{stem}.svg");
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(folder.join(&picture));
        let mut file = match file {
            Ok(file) => file,
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
            Err(error) => return Err(error),
        };
        file.write_all(
            picture::svg(screen, &format!("the page {name} of the dashboard"), paper).as_bytes(),
        )?;
        std::fs::write(folder.join(format!("{stem}.txt")), picture::text(screen))?;
        return Ok(picture);
    }
    Err(io::Error::from(io::ErrorKind::AlreadyExists))
}

#[cfg(test)]
mod tests {
    use ratatui::layout::Rect;
    use ratatui::style::Style;

    use super::*;

    #[test]
    fn pages_are_written_under_separate_names() {
        let folder = tempfile::tempdir().unwrap();
        let mut screen = Buffer::empty(Rect::new(0, 0, 8, 1));
        screen.set_string(0, 0, "μ 0.42", Style::new());
        let file_name = |name| write(folder.path(), name, Theme::Colour, &screen).unwrap();
        assert_eq!(file_name("run"), "page-run-1.svg");
        assert_eq!(file_name("run"), "page-run-2.svg");
        let text = std::fs::read_to_string(folder.path().join("page-run-2.txt")).unwrap();
        assert_eq!(text, "μ 0.42\n");
        let missing_folder = folder.path().join("gone");
        assert!(write(&missing_folder, "log", Theme::Light, &screen).is_err());
    }
}
