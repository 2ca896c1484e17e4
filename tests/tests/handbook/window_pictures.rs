//! The handbook's pictures of the participant's window, drawn by the window from the same simulated session as the dashboard's.

use bench_tests::handbook::folder;
use live::window_screen;
use participant_window::canvas::Canvas;
use participant_window::geometry::Geometry;
use participant_window::lettering::Typeface;
use participant_window::page::{GROUND, Moving, ParticipantPage};
use participant_window::ruler::Ruler;
use tui::ScreenView;

/// Width and height of the pictured monitor, pixels.
const SIZE: (u32, u32) = (960, 540);
/// Width of a pixel of a monitor 34 cm wide, m.
const PIXEL_M: f64 = 0.34 / 960.0;

fn require_picture(name: &str, canvas: &Canvas) {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, SIZE.0, SIZE.1);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().unwrap();
    let bytes = canvas.pixels().iter().flat_map(|pixel| {
        let [_, red, green, blue] = pixel.to_be_bytes();
        [red, green, blue]
    });
    writer.write_image_data(&bytes.collect::<Vec<_>>()).unwrap();
    writer.finish().unwrap();
    super::require_same(&folder().join("src/pictures").join(name), &file);
}

fn draw(view: &ScreenView, moving: Moving) -> Canvas {
    let geometry = Geometry {
        width: f64::from(SIZE.0),
        height: f64::from(SIZE.1),
        pixel_m: PIXEL_M,
    };
    let mut page = ParticipantPage::new(Typeface::default_face().unwrap(), geometry);
    let content = window_screen::page_content(view, None);
    page.draw(&content, Some(view.audio_s), moving).0.clone()
}

#[test]
fn the_ruler_page_is_up_to_date() {
    let mut canvas = Canvas::new(SIZE.0 as usize, SIZE.1 as usize, GROUND);
    Ruler::new(SIZE.0, PIXEL_M).draw(&mut canvas, &Typeface::default_face().unwrap());
    require_picture("window-ruler.png", &canvas);
}

/// Compares the window's pictures of a slider to follow and of the force shown afterwards.
pub fn require_same_views(slider_view: &ScreenView, force_view: &ScreenView) {
    let moving = Moving {
        slider_m: slider_view.slider_m,
        finger_m: None,
    };
    require_picture("window-slider.png", &draw(slider_view, moving));
    require_picture("window-force.png", &draw(force_view, Moving::default()));
}
