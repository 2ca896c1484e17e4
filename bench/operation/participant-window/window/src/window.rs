//! The window on a screen, from its options to its end.

use participant_window::lettering::Typeface;
use participant_window::place;
use participant_window::scales::Scales;
use winit::event_loop::EventLoop;

use crate::app;
use crate::error::WindowError;
use crate::options::Options;

/// Size limit of a font file, bytes.
const FONT_LIMIT_BYTES: u64 = 64 << 20;

/// Returns the typeface of the options.
fn typeface(options: &Options) -> Result<Typeface, WindowError> {
    let Some(path) = &options.font else {
        return Typeface::default_face().map_err(|source| WindowError::Font {
            path: "the built-in font".into(),
            source,
        });
    };
    let file =
        bounded_files::read(path, FONT_LIMIT_BYTES).map_err(|source| WindowError::FontFile {
            path: path.clone(),
            source,
        })?;
    Typeface::read(file).map_err(|source| WindowError::Font {
        path: path.clone(),
        source,
    })
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// [`WindowError`].
pub fn run(options: Options) -> Result<(), WindowError> {
    let face = typeface(&options)?;
    let scales = Scales::read(&options.scales)?;
    let _only_one = place::only_window(&options.socket)?.ok_or(WindowError::Second)?;
    let events = EventLoop::new().map_err(|_| {
        // The library's message names a line of its source code.
        let is_set = std::env::var_os("DISPLAY").is_some_and(|name| !name.is_empty());
        WindowError::NoScreen(if is_set || cfg!(target_os = "macos") {
            "the display does not answer, or refuses connections"
        } else {
            "DISPLAY is not set"
        })
    })?;
    let mut app = app::App::new(options, face, scales);
    let result = events.run_app(&mut app);
    if let Some(error) = app.into_error() {
        return Err(error);
    }
    result.map_err(|error| WindowError::Failed(error.to_string()))
}
