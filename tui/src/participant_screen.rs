//! The participant's screen: large and plain, without the force while the finger moves.

use std::sync::Arc;

use participant_texts::{Instruction, RepeatCause, Texts};
use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Flex, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Text};
use ratatui::widgets::Widget;

use drawing::digits;
use drawing::plot::put;
use drawing::theme::Theme;
use drawing::words::wrap;

/// Contents of the participant's screen.
///
/// ```
/// use ratatui::{buffer::Buffer, layout::Rect};
/// use tui::participant_screen::view;
/// use participant_texts::Instruction;
/// use tui::{ScreenView, Theme};
///
/// let shown = ScreenView {
///     instruction: Instruction::PlaceFinger,
///     slider_m: Some(0.005),
///     plate_m: 0.105,
///     start_m: 0.005,
///     end_m: 0.1,
///     force_band_n: Some((0.5, 0.8)),
///     trial: 1,
///     trials: 10,
///     ..ScreenView::default()
/// };
/// let area = Rect::new(0, 0, 60, 20);
/// let mut buffer = Buffer::empty(area);
/// view(&shown, Theme::Mono, area, &mut buffer);
/// let first: String = (0..60).map(|x| buffer[(x, 0)].symbol()).collect();
/// assert_eq!(first.trim(), "trial 1 of 10");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ScreenView {
    /// The instruction.
    pub instruction: Instruction,
    /// Position of the slider along the plate, m; `None` hides the slider.
    pub slider_m: Option<f64>,
    /// Length of the plate, m.
    pub plate_m: f64,
    /// Start of the exploration, m.
    pub start_m: f64,
    /// End of the exploration, m; below `start_m` if it goes from right to left.
    pub end_m: f64,
    /// Seconds until the start.
    pub countdown: Option<u32>,
    /// Mean normal force of the last exploration, N; shown only under [`Instruction::Feedback`].
    pub mean_force_n: Option<f64>,
    /// Band of the normal force for the participant, N.
    pub force_band_n: Option<(f64, f64)>,
    /// Number of the trial, from 1; 0 hides it.
    pub trial: u32,
    /// Number of trials.
    pub trials: u32,
    /// Whether these are practice trials.
    pub practice: bool,
    /// Remaining time of the break, s.
    pub rest_s: Option<f64>,
    /// Why the trial just made is repeated; `None` if it is not.
    pub repeat: Option<RepeatCause>,
    /// Whether the session waits for the participant's button.
    pub button: bool,
    /// Whether the bench has no button, so that a finger at rest means "ready".
    pub touch: bool,
    /// Time of this view on the bench's clock, s.
    pub audio_s: f64,
    /// Time on the bench's clock at which the slider leaves its start, s; known from the countdown on.
    pub moves_at_s: Option<f64>,
    /// Speed of the slider, m/s.
    pub speed_m_per_s: f64,
    /// Whether the protocol lets the participant see the finger.
    pub show_finger: bool,
    /// Texts in the protocol's language or the laboratory's own.
    pub texts: Arc<Texts>,
}

impl Default for ScreenView {
    fn default() -> Self {
        Self {
            instruction: Instruction::Wait,
            slider_m: None,
            plate_m: 0.0,
            start_m: 0.0,
            end_m: 0.0,
            countdown: None,
            mean_force_n: None,
            force_band_n: None,
            trial: 0,
            trials: 0,
            practice: false,
            rest_s: None,
            repeat: None,
            button: false,
            touch: false,
            audio_s: 0.0,
            moves_at_s: None,
            speed_m_per_s: 0.0,
            show_finger: false,
            texts: Arc::default(),
        }
    }
}

impl ScreenView {
    /// Returns the text of the instruction, and the text that follows it.
    #[must_use]
    pub fn sentences(&self) -> (&str, Option<&str>) {
        let texts = &*self.texts;
        match (self.instruction, self.repeat) {
            (Instruction::Wait, Some(repeat)) => (repeat.text(texts), None),
            (Instruction::PlaceFinger, _) if self.touch => {
                (&texts.place_finger, Some(&texts.then_rest))
            }
            (Instruction::PlaceFinger, _) => (&texts.place_finger, Some(&texts.then_press)),
            (Instruction::Rest, _) if self.button && !self.touch => {
                (&texts.rest, Some(&texts.rest_over))
            }
            (instruction, _) => (instruction.text(texts, !self.touch), None),
        }
    }
}

/// Draws the participant's screen.
pub fn view(view: &ScreenView, theme: Theme, area: Rect, buf: &mut Buffer) {
    if area.is_empty() {
        return;
    }
    let [progress, middle, track] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Min(1),
        Constraint::Length(TRACK_ROWS.min(area.height.saturating_sub(2))),
    ])
    .areas(area);
    // A screen of one or two rows shows the instruction alone.
    let [progress, middle] = if area.height < 3 {
        [Rect::ZERO, area]
    } else {
        [progress, middle]
    };
    if view.trial > 0 {
        Line::styled(
            view.texts
                .trial_text(view.practice, view.trial, view.trials),
            theme.faint(),
        )
        .centered()
        .render(progress, buf);
    }
    instruction(view, theme, middle, buf);
    slider(view, theme, track, buf);
}

/// Draws the instruction, with the countdown or the feedback below it.
fn instruction(view: &ScreenView, theme: Theme, area: Rect, buf: &mut Buffer) {
    let (first, second) = view.sentences();
    let mut words = wrap(first, area.width);
    let first_rows = words.len();
    words.extend(
        second
            .into_iter()
            .flat_map(|second| wrap(second, area.width)),
    );
    let words_rows = u16::try_from(words.len()).unwrap_or(u16::MAX);
    // The following instruction is emphasised when it applies.
    let words: Vec<Line> = words
        .into_iter()
        .enumerate()
        .map(|(row, words)| match row < first_rows {
            true => Line::styled(words, theme.strong()),
            false if view.button => Line::styled(words, theme.strong()),
            false => Line::styled(words, theme.faint()),
        })
        .collect();
    let detail_rows = match view.instruction {
        Instruction::Feedback => 4,
        Instruction::GetReady | Instruction::Rest if seconds(view).is_some() => {
            if area.height >= words_rows.saturating_add(1 + digits::ROWS) {
                digits::ROWS
            } else {
                1
            }
        }
        _ => 0,
    };
    let detail_rows = detail_rows.min(area.height.saturating_sub(words_rows));
    let gap = u16::from(detail_rows > 0 && area.height > words_rows + detail_rows);
    let [top, _, bottom] = Layout::vertical([
        Constraint::Length(words_rows),
        Constraint::Length(gap),
        Constraint::Length(detail_rows),
    ])
    .flex(Flex::Center)
    .areas(area);
    Text::from(words).centered().render(top, buf);
    match view.instruction {
        Instruction::Feedback => feedback(view, theme, bottom, buf),
        Instruction::GetReady | Instruction::Rest => {
            if let Some(seconds) = seconds(view) {
                number(seconds, theme, bottom, buf);
            }
        }
        _ => {}
    }
}

/// Returns the countdown below the instruction, if any, s.
fn seconds(view: &ScreenView) -> Option<u32> {
    match view.instruction {
        Instruction::GetReady => view.countdown,
        // The cast saturates.
        Instruction::Rest => view
            .rest_s
            .filter(|s| s.is_finite())
            .map(|s| s.max(0.0).ceil() as u32),
        _ => None,
    }
}

/// Height of the plate with its slider, rows.
const TRACK_ROWS: u16 = 5;

/// Draws seconds in large digits, or in one row if these do not fit.
fn number(seconds: u32, theme: Theme, area: Rect, buf: &mut Buffer) {
    let words = seconds.to_string();
    let columns = digits::columns(&words);
    if area.height < digits::ROWS || area.width < columns {
        Line::styled(words, theme.strong())
            .centered()
            .render(area, buf);
        return;
    }
    let middle = Rect {
        x: area.x + (area.width - columns) / 2 + 1,
        ..area
    };
    digits::render(&words, theme.strong(), middle, buf);
}

/// Draws the mean force with its judgement, and a bar with the band if it fits.
fn feedback(view: &ScreenView, theme: Theme, area: Rect, buf: &mut Buffer) {
    let Some(mean_n) = view.mean_force_n.filter(|n| n.is_finite()) else {
        Line::styled(view.texts.not_measured.as_ref(), theme.faint())
            .centered()
            .render(area, buf);
        return;
    };
    let band_n = view
        .force_band_n
        .filter(|(min, max)| min.is_finite() && max > min && *max > 0.0);
    let (word, style) = match band_n {
        Some((min_n, _)) if mean_n < min_n => (&*view.texts.too_light, theme.warning()),
        Some((_, max_n)) if mean_n > max_n => (&*view.texts.too_hard, theme.warning()),
        Some(_) => (&*view.texts.just_right, theme.good()),
        None => ("", theme.strong()),
    };
    Line::styled(
        format!("{} N  {word}", view.texts.number(mean_n, 2))
            .trim_end()
            .to_owned(),
        style,
    )
    .centered()
    .render(area, buf);
    let Some((min_n, max_n)) = band_n else { return };
    let columns = area.width.saturating_sub(4).min(60);
    if area.height < 4 || columns < 20 {
        return;
    }
    let left = area.x + (area.width - columns) / 2;
    // The band's middle is the bar's middle, so that too light and too hard look alike.
    let x_at = |n: f64| left + column(n / (min_n + max_n), columns);
    buf.set_string(x_at(mean_n), area.y + 1, "▼", theme.strong());
    for x in left..left + columns {
        let is_inside = (x_at(min_n)..=x_at(max_n)).contains(&x);
        let (symbol, style) = if is_inside {
            ("█", theme.good())
        } else {
            ("░", theme.faint())
        };
        buf.set_string(x, area.y + 2, symbol, style);
    }
    let low = view.texts.number(min_n, 1);
    let high = format!("{} N", view.texts.number(max_n, 1));
    buf.set_string(
        x_at(min_n).saturating_sub(1),
        area.y + 3,
        low,
        theme.faint(),
    );
    buf.set_string(
        x_at(max_n).saturating_sub(1),
        area.y + 3,
        high,
        theme.faint(),
    );
}

/// Draws the plate with its marks and the slider.
fn slider(view: &ScreenView, theme: Theme, area: Rect, buf: &mut Buffer) {
    let moves = matches!(
        view.instruction,
        Instruction::PlaceFinger | Instruction::GetReady | Instruction::FollowSlider
    );
    let plate_m = view.plate_m;
    if !moves || area.height < 3 || area.width < 20 || !(plate_m.is_finite() && plate_m > 0.0) {
        return;
    }
    let left = area.x + 2;
    let columns = area.width - 4;
    let x_at = |m: f64| left + column(m / plate_m, columns);
    let plate = area.y + area.height - 3;
    for x in left..left + columns {
        buf.set_string(x, plate, "━", theme.faint());
    }
    for (mark_m, word) in [
        (view.start_m, &view.texts.start),
        (view.end_m, &view.texts.end),
    ] {
        let x = x_at(mark_m);
        put(buf, (x, plate), "┻", theme.strong());
        put_centred(word, x, plate + 1, area, theme.faint(), buf);
    }
    millimetres(plate_m, x_at, plate + 2, area, theme, buf);
    if let Some(slider_m) = view.slider_m.filter(|m| m.is_finite()) {
        let middle = (slider_m / plate_m).clamp(0.0, 1.0) * f64::from(columns - 1) + 0.5;
        let offset = ((middle - 1.5) * 8.0).round();
        // The cast saturates.
        let eighths = offset.clamp(0.0, f64::from(columns - 3) * 8.0) as u16;
        for y in area.y..plate {
            bar(buf, (left, y), eighths, theme.strong());
        }
    }
}

/// Writes a word centred on a column, within the area.
fn put_centred(word: &str, x: u16, y: u16, area: Rect, style: Style, buf: &mut Buffer) {
    let columns = u16::try_from(word.chars().count()).unwrap_or(u16::MAX);
    let word_x = x
        .saturating_sub(columns / 2)
        .min(area.right().saturating_sub(columns))
        .max(area.x);
    buf.set_stringn(word_x, y, word, usize::from(area.width), style);
}

/// Writes the scale of the plate, mm: every ten or twenty as the room allows.
fn millimetres(
    plate_m: f64,
    x_at: impl Fn(f64) -> u16,
    y: u16,
    area: Rect,
    theme: Theme,
    buf: &mut Buffer,
) {
    let steps_mm = [10.0, 20.0, 50.0, 100.0, 200.0, 500.0];
    let has_room = |step_mm: f64| x_at(step_mm / 1e3).saturating_sub(x_at(0.0)) >= 6;
    let Some(step_mm) = steps_mm.into_iter().find(|&step_mm| has_room(step_mm)) else {
        return;
    };
    let mut mm = 0.0;
    while mm <= plate_m * 1e3 && mm < 1e3 * steps_mm[5] {
        let last = mm + step_mm > plate_m * 1e3;
        let word = format!("{mm:.0}{}", if last { " mm" } else { "" });
        put_centred(&word, x_at(mm / 1e3), y, area, theme.faint(), buf);
        mm += step_mm;
    }
}

/// Blocks that fill a cell from the left, in eighths.
const EIGHTHS: [&str; 9] = [" ", "▏", "▎", "▍", "▌", "▋", "▊", "▉", "█"];

/// Draws a bar three columns wide, shifted right by `eighths` of a column.
fn bar(buf: &mut Buffer, (left, y): (u16, u16), eighths: u16, style: Style) {
    let (cells, part) = (eighths / 8, usize::from(eighths % 8));
    let x = left + cells;
    if part == 0 {
        buf.set_string(x, y, "███", style);
        return;
    }
    // The last cell is a block filled from the left, with its colours reversed.
    let reversed = style.add_modifier(Modifier::REVERSED);
    put(buf, (x, y), EIGHTHS[part], reversed);
    put(buf, (x + 1, y), EIGHTHS[8], style);
    put(buf, (x + 2, y), EIGHTHS[8], style);
    put(buf, (x + 3, y), EIGHTHS[part], style);
}

/// Returns the column at a fraction of a bar, clamped to the bar.
fn column(fraction: f64, columns: u16) -> u16 {
    let last = columns.saturating_sub(1);
    (fraction * f64::from(last))
        .round()
        .clamp(0.0, f64::from(last)) as u16
}
