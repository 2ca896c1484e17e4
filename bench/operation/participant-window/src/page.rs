//! The participant's page: a still picture, drawn anew only when it changes, with slider and finger drawn over it.

use crate::canvas::{Canvas, Colour};
use crate::geometry::Geometry;
use crate::lettering::Typeface;
use crate::message::{Content, Feedback, Track};

/// Colour of the background.
pub const GROUND: Colour = 0x0010_1418;
/// Colour of the main text.
pub const INK: Colour = 0x00f2_f2f2;
/// Colour of secondary text.
pub const FAINT: Colour = 0x0090_989e;
/// Colour of the plate.
pub const PLATE: Colour = 0x0058_6068;
/// Colour of the slider, used for nothing else.
pub const SLIDER: Colour = 0x00ff_b000;
/// Colour of a force within the band.
pub const GOOD: Colour = 0x0040_c060;
/// Colour of the finger.
pub const FINGER: Colour = 0x0060_d0ff;

/// Contents of the still picture, which is drawn anew only when they change.
#[derive(Clone, Debug, PartialEq)]
struct Still {
    content: Content,
    /// Countdown, in words.
    count: Option<String>,
}

/// The participant's page on a screen.
#[derive(Debug)]
pub struct ParticipantPage {
    face: Typeface,
    geometry: Geometry,
    still: Option<Still>,
    background: Canvas,
    frame: Canvas,
}

/// Slider and finger, drawn over the still picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moving {
    /// Position of the slider along the plate, m.
    pub slider_m: Option<f64>,
    /// Position of the finger along the plate, m.
    pub finger_m: Option<f64>,
}

impl ParticipantPage {
    /// Returns an empty page for a screen.
    #[must_use]
    pub fn new(face: Typeface, geometry: Geometry) -> Self {
        // The casts saturate.
        let (width, height) = (geometry.width as usize, geometry.height as usize);
        Self {
            face,
            geometry,
            still: None,
            background: Canvas::new(width, height, GROUND),
            frame: Canvas::new(width, height, GROUND),
        }
    }

    /// Returns the screen's geometry.
    #[must_use]
    pub fn geometry(&self) -> Geometry {
        self.geometry
    }

    /// Draws the page at a time on the bench's clock, `None` while the bench is silent. Returns the picture, and
    /// whether more of it has changed than the rows of slider and finger.
    pub fn draw(
        &mut self,
        content: &Content,
        audio_s: Option<f64>,
        moving: Moving,
    ) -> (&Canvas, bool) {
        let still = Still {
            content: content.clone(),
            count: content
                .until_s
                .zip(audio_s)
                .map(|(until_s, now_s)| countdown(until_s - now_s)),
        };
        let changed = self.still.as_ref() != Some(&still);
        if changed {
            self.background.clear(GROUND);
            still_picture(&mut self.background, &self.face, self.geometry, &still);
            self.frame.clone_from(&self.background);
            self.still = Some(still);
        } else {
            self.frame
                .copy_rows(&self.background, self.geometry.moving_rows());
        }
        if let Some(track) = &content.track {
            draw_moving(&mut self.frame, self.geometry, track, moving);
        }
        (&self.frame, changed)
    }
}

/// Returns the time left in words: whole seconds, rounded up, with minutes from one minute on.
fn countdown(left_s: f64) -> String {
    // The cast saturates.
    let seconds = left_s.max(0.0).ceil() as u64;
    if seconds >= 60 {
        format!("{}:{:02}", seconds / 60, seconds % 60)
    } else {
        seconds.to_string()
    }
}

fn still_picture(canvas: &mut Canvas, face: &Typeface, geometry: Geometry, still: &Still) {
    let (middle, height) = (geometry.width / 2.0, geometry.height);
    let content = &still.content;
    if let Some(progress) = &content.progress {
        face.write(
            canvas,
            progress,
            (middle, height * 0.07),
            height / 30.0,
            FAINT,
        );
    }
    let mut next_y = lines(
        canvas,
        face,
        geometry,
        (&content.title, height * 0.2, height / 13.0),
        INK,
    );
    if let Some(sentence) = &content.then {
        let ink = if content.now { INK } else { FAINT };
        next_y = lines(
            canvas,
            face,
            geometry,
            (sentence, next_y + height / 40.0, height / 18.0),
            ink,
        );
    }
    if let Some(count) = &still.count {
        let em = (height * 0.5 - next_y).clamp(height / 20.0, height / 6.0);
        face.write(canvas, count, (middle, height * 0.54), em, INK);
    }
    if let Some(reading) = &content.feedback {
        feedback(canvas, face, geometry, reading);
    }
    if let Some(track) = &content.track {
        plate(canvas, face, geometry, track);
    }
}

/// Writes a text on as many lines as it needs; returns the vertical position below it.
fn lines(
    canvas: &mut Canvas,
    face: &Typeface,
    geometry: Geometry,
    (text, top, em): (&str, f64, f64),
    colour: Colour,
) -> f64 {
    let mut baseline = top;
    for line in face.wrapped(text, em, geometry.width * 0.9) {
        // A word wider than the screen is shrunk to fit.
        let fitting = (geometry.width * 0.96 / face.width(&line, em)).min(1.0);
        face.write(
            canvas,
            &line,
            (geometry.width / 2.0, baseline),
            em * fitting,
            colour,
        );
        baseline += 1.25 * em;
    }
    baseline
}

/// Draws the mean force on a bar, with the band in its middle.
fn feedback(canvas: &mut Canvas, face: &Typeface, geometry: Geometry, reading: &Feedback) {
    let (middle, height) = (geometry.width / 2.0, geometry.height);
    face.write(
        canvas,
        &reading.words,
        (middle, height * 0.42),
        height / 14.0,
        INK,
    );
    let band = reading
        .band_n
        .filter(|(low, high)| *low >= 0.0 && high > low && high.is_finite());
    let Some((low_n, high_n)) = band else {
        return;
    };
    let half_width = (geometry.width * 0.35).min(height * 0.5);
    let x_at =
        |n: f64| middle - half_width + 2.0 * half_width * (n / (low_n + high_n)).clamp(0.0, 1.0);
    let (top, bottom) = (height * 0.52, height * 0.57);
    canvas.rectangle(
        (middle - half_width, top),
        (middle + half_width, bottom),
        PLATE,
    );
    canvas.rectangle((x_at(low_n), top), (x_at(high_n), bottom), GOOD);
    let (low, high) = &reading.ends;
    let em = height / 32.0;
    face.write(canvas, low, (x_at(low_n), bottom + 1.3 * em), em, FAINT);
    face.write(canvas, high, (x_at(high_n), bottom + 1.3 * em), em, FAINT);
    if let Some(mean_n) = reading.mean_n.filter(|n| n.is_finite()) {
        let half_mark = (height / 200.0).max(1.5);
        let (x, overshoot) = (x_at(mean_n), height * 0.02);
        canvas.rectangle(
            (x - half_mark, top - overshoot),
            (x + half_mark, bottom + overshoot),
            INK,
        );
    }
}

/// Draws the plate with its marks, the slider's path, and the place for the finger.
fn plate(canvas: &mut Canvas, face: &Typeface, geometry: Geometry, track: &Track) {
    let y = geometry.plate_y();
    let (left, right) = (geometry.x(track, 0.0), geometry.x(track, track.plate_m));
    let (start, end) = (
        geometry.x(track, track.motion.from_m),
        geometry.x(track, track.motion.to_m),
    );
    let thick = (geometry.height / 240.0).max(1.5);
    canvas.rectangle((left, y - thick), (right, y + thick), PLATE);
    let tick = geometry.fingertip();
    for x in [start, end] {
        canvas.rectangle((x - thick, y - tick), (x + thick, y + tick), FAINT);
    }
    let em = geometry.height / 30.0;
    let words_y = y + geometry.fingertip() + 1.6 * em;
    for (x, word) in [(start, &track.marks.0), (end, &track.marks.1)] {
        let half_width = face.width(word, em) / 2.0;
        let room = (half_width, (geometry.width - half_width).max(half_width));
        face.write(canvas, word, (x.clamp(room.0, room.1), words_y), em, FAINT);
    }
    let arrow = if track.motion.to_m < track.motion.from_m {
        "←"
    } else {
        "→"
    };
    face.write(
        canvas,
        arrow,
        ((start + end) / 2.0, words_y),
        1.6 * em,
        FAINT,
    );
    if track.place {
        canvas.ring(
            (start, y),
            geometry.fingertip(),
            (2.0 * thick).max(2.0),
            INK,
        );
    }
}

/// Draws slider and finger.
fn draw_moving(canvas: &mut Canvas, geometry: Geometry, track: &Track, moving: Moving) {
    let y = geometry.plate_y();
    if let Some(slider_m) = moving.slider_m.filter(|m| m.is_finite()) {
        let (x, half_width) = (geometry.x(track, slider_m), geometry.half_slider());
        let bottom = y - geometry.fingertip();
        let top = bottom - geometry.slider_height();
        canvas.rectangle((x - half_width, top), (x + half_width, bottom), SLIDER);
    }
    if let Some(finger_m) = moving.finger_m.filter(|m| m.is_finite()) {
        let thick = (geometry.fingertip() / 4.0).max(2.0);
        canvas.ring(
            (geometry.x(track, finger_m), y),
            geometry.fingertip(),
            thick,
            FINGER,
        );
    }
}
