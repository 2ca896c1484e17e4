//! The participant's screen: large and plain, without the force while the finger moves.

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Flex, Layout, Rect};
use ratatui::text::{Line, Text};
use ratatui::widgets::Widget;
use serde::{Deserialize, Serialize};

use crate::digits;
use crate::words::wrap;
use drawing::plot::put;
use drawing::theme::Theme;

/// The instruction to the participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Instruction {
    /// Wait.
    Wait,
    /// Press the button to begin.
    Welcome,
    /// Release the dead-man switch.
    ReleaseSwitch,
    /// Press the dead-man switch and hold it.
    HoldSwitch,
    /// Lift the finger: the dead-man switch was released.
    SwitchReleased,
    /// Take the finger off the plate.
    LiftFinger,
    /// Put the finger on the start mark.
    PlaceFinger,
    /// Get ready: the countdown runs.
    GetReady,
    /// Follow the slider.
    FollowSlider,
    /// Read the mean force of the exploration.
    Feedback,
    /// Take a break.
    Rest,
    /// Lift the finger: the session is paused.
    Paused,
    /// Nothing more: the session has finished.
    Finished,
}

impl Instruction {
    /// Returns the words on the screen.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Wait => "Please wait",
            Self::Welcome => "Press the button to begin",
            Self::ReleaseSwitch => "Release the hold button",
            Self::HoldSwitch => "Press the hold button and keep it pressed",
            Self::SwitchReleased => "You released the hold button. Please lift your finger",
            Self::LiftFinger => "Lift your finger off the plate",
            Self::PlaceFinger => "Place your finger on the start mark",
            Self::GetReady => "Get ready",
            Self::FollowSlider => "Follow the slider",
            Self::Feedback => "Your mean force",
            Self::Rest => "Take a break",
            Self::Paused => "Paused. Please lift your finger",
            Self::Finished => "Finished. Thank you!",
        }
    }
}

/// The content of the participant's screen.
///
/// ```
/// use ratatui::{buffer::Buffer, layout::Rect};
/// use tui::participant_screen::view;
/// use tui::{Instruction, ParticipantView, Theme};
///
/// let shown = ParticipantView {
///     instruction: Instruction::PlaceFinger,
///     slider_m: Some(0.005),
///     plate_m: 0.105,
///     start_m: 0.005,
///     end_m: 0.1,
///     countdown: None,
///     mean_force_n: None,
///     force_band_n: Some((0.5, 0.8)),
///     trial: 1,
///     trials: 10,
///     rest_s: None,
/// };
/// let area = Rect::new(0, 0, 60, 20);
/// let mut buffer = Buffer::empty(area);
/// view(&shown, Theme::Mono, area, &mut buffer);
/// let first: String = (0..60).map(|x| buffer[(x, 0)].symbol()).collect();
/// assert_eq!(first.trim(), "trial 1 of 10");
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParticipantView {
    /// Instruction in words.
    pub instruction: Instruction,
    /// Position of the slider along the plate, m; `None` hides the slider.
    pub slider_m: Option<f64>,
    /// Length of the plate, m.
    pub plate_m: f64,
    /// Position where the exploration starts, m.
    pub start_m: f64,
    /// Position where the exploration ends, m; below `start_m` when it goes from right to left.
    pub end_m: f64,
    /// Seconds until the start.
    pub countdown: Option<u32>,
    /// Mean normal force of the last exploration, N; shown only under [`Instruction::Feedback`].
    pub mean_force_n: Option<f64>,
    /// Limits of the normal force that the participant should keep, N.
    pub force_band_n: Option<(f64, f64)>,
    /// Number of the trial, from 1; 0 hides it.
    pub trial: u32,
    /// Number of trials.
    pub trials: u32,
    /// Time left of the break, s.
    pub rest_s: Option<f64>,
}

/// Draws the participant's screen.
pub fn view(shown: &ParticipantView, theme: Theme, area: Rect, buf: &mut Buffer) {
    if area.is_empty() {
        return;
    }
    let [progress, middle, track] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Min(1),
        Constraint::Length(TRACK_ROWS.min(area.height.saturating_sub(2))),
    ])
    .areas(area);
    // One row or two hold the instruction alone.
    let [progress, middle] = if area.height < 3 {
        [Rect::ZERO, area]
    } else {
        [progress, middle]
    };
    if shown.trial > 0 {
        Line::styled(
            format!("trial {} of {}", shown.trial, shown.trials),
            theme.faint(),
        )
        .centered()
        .render(progress, buf);
    }
    instruction(shown, theme, middle, buf);
    slider(shown, theme, track, buf);
}

/// Draws the instruction, with the countdown or the feedback below it.
fn instruction(shown: &ParticipantView, theme: Theme, area: Rect, buf: &mut Buffer) {
    let words = wrap(shown.instruction.words(), area.width);
    let words_rows = u16::try_from(words.len()).unwrap_or(u16::MAX);
    let words: Vec<Line> = words.into_iter().map(Line::from).collect();
    let below = match shown.instruction {
        Instruction::Feedback => 4,
        Instruction::GetReady | Instruction::Rest if seconds(shown).is_some() => {
            if area.height >= words_rows.saturating_add(1 + digits::ROWS) {
                digits::ROWS
            } else {
                1
            }
        }
        _ => 0,
    };
    let below = below.min(area.height.saturating_sub(words_rows));
    let gap = u16::from(below > 0 && area.height > words_rows + below);
    let [top, _, bottom] = Layout::vertical([
        Constraint::Length(words_rows),
        Constraint::Length(gap),
        Constraint::Length(below),
    ])
    .flex(Flex::Center)
    .areas(area);
    Text::from(words)
        .style(theme.strong())
        .centered()
        .render(top, buf);
    match shown.instruction {
        Instruction::Feedback => feedback(shown, theme, bottom, buf),
        Instruction::GetReady | Instruction::Rest => {
            if let Some(seconds) = seconds(shown) {
                number(seconds, theme, bottom, buf);
            }
        }
        _ => {}
    }
}

/// Returns the seconds that are counted down under the instruction, if any.
fn seconds(shown: &ParticipantView) -> Option<u32> {
    match shown.instruction {
        Instruction::GetReady => shown.countdown,
        // The cast saturates.
        Instruction::Rest => shown
            .rest_s
            .filter(|s| s.is_finite())
            .map(|s| s.max(0.0).ceil() as u32),
        _ => None,
    }
}

/// Rows of the plate with its slider.
const TRACK_ROWS: u16 = 5;

/// Draws seconds in large digits, or in one row where these do not fit.
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

/// Draws the mean force with its judgement, and a bar with the band where it fits.
fn feedback(shown: &ParticipantView, theme: Theme, area: Rect, buf: &mut Buffer) {
    let Some(mean_n) = shown.mean_force_n.filter(|n| n.is_finite()) else {
        Line::styled("not measured", theme.faint())
            .centered()
            .render(area, buf);
        return;
    };
    let band_n = shown
        .force_band_n
        .filter(|(min, max)| min.is_finite() && max > min && *max > 0.0);
    let (word, style) = match band_n {
        Some((min_n, _)) if mean_n < min_n => ("too light", theme.warning()),
        Some((_, max_n)) if mean_n > max_n => ("too hard", theme.warning()),
        Some(_) => ("just right", theme.good()),
        None => ("", theme.strong()),
    };
    Line::styled(
        format!("{mean_n:.2} N  {word}").trim_end().to_owned(),
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
    let at = |n: f64| left + column(n / (min_n + max_n), columns);
    buf.set_string(at(mean_n), area.y + 1, "▼", theme.strong());
    for x in left..left + columns {
        let inside = (at(min_n)..=at(max_n)).contains(&x);
        let (symbol, style) = if inside {
            ("█", theme.good())
        } else {
            ("░", theme.faint())
        };
        buf.set_string(x, area.y + 2, symbol, style);
    }
    let (low, high) = (format!("{min_n:.1}"), format!("{max_n:.1} N"));
    buf.set_string(at(min_n).saturating_sub(1), area.y + 3, low, theme.faint());
    buf.set_string(at(max_n).saturating_sub(1), area.y + 3, high, theme.faint());
}

/// Draws the plate with its marks and the slider.
fn slider(shown: &ParticipantView, theme: Theme, area: Rect, buf: &mut Buffer) {
    let moves = matches!(
        shown.instruction,
        Instruction::PlaceFinger | Instruction::GetReady | Instruction::FollowSlider
    );
    let plate_m = shown.plate_m;
    if !moves || area.height < 3 || area.width < 20 || !(plate_m.is_finite() && plate_m > 0.0) {
        return;
    }
    let left = area.x + 2;
    let columns = area.width - 4;
    let at = |m: f64| left + column(m / plate_m, columns);
    let plate = area.y + area.height - 3;
    for x in left..left + columns {
        buf.set_string(x, plate, "━", theme.faint());
    }
    for (mark_m, word) in [(shown.start_m, "start"), (shown.end_m, "end")] {
        let x = at(mark_m);
        put(buf, (x, plate), "┻", theme.strong());
        let word_columns = u16::try_from(word.len()).unwrap_or(0);
        let word_x = x
            .saturating_sub(word_columns / 2)
            .min(area.right().saturating_sub(word_columns))
            .max(area.x);
        buf.set_string(word_x, plate + 1, word, theme.faint());
    }
    if let Some(slider_m) = shown.slider_m.filter(|m| m.is_finite()) {
        let x = at(slider_m)
            .saturating_sub(1)
            .clamp(area.x, area.right() - 3);
        for y in area.y..plate {
            buf.set_string(x, y, "███", theme.first_curve());
        }
    }
}

/// Returns the column at a fraction of a bar, clamped to the bar.
fn column(fraction: f64, columns: u16) -> u16 {
    let last = columns.saturating_sub(1);
    (fraction * f64::from(last))
        .round()
        .clamp(0.0, f64::from(last)) as u16
}
