//! Contents of the participant's screen, and information that must not be on it.

use std::sync::Arc;

use participant_texts::{Instruction, Language, RepeatCause, Texts};
use proptest::prelude::*;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier};
use tui::participant_screen::view;
use tui::{ScreenView, Theme};

const ALL: [Instruction; 10] = [
    Instruction::Wait,
    Instruction::Welcome,
    Instruction::LiftFinger,
    Instruction::PlaceFinger,
    Instruction::GetReady,
    Instruction::FollowSlider,
    Instruction::Feedback,
    Instruction::Rest,
    Instruction::Paused,
    Instruction::Finished,
];

fn view_with(instruction: Instruction) -> ScreenView {
    ScreenView {
        instruction,
        slider_m: Some(0.042),
        plate_m: 0.105,
        start_m: 0.005,
        end_m: 0.1,
        countdown: Some(3),
        mean_force_n: Some(0.87),
        force_band_n: Some((0.5, 0.8)),
        trial: 3,
        trials: 10,
        rest_s: Some(41.2),
        ..ScreenView::default()
    }
}

fn draw(participant_view: &ScreenView, columns: u16, rows: u16) -> Buffer {
    let area = Rect::new(0, 0, columns, rows);
    let mut buffer = Buffer::empty(area);
    view(participant_view, Theme::Colour, area, &mut buffer);
    buffer
}

fn text(buffer: &Buffer) -> String {
    buffer
        .content()
        .chunks(usize::from(buffer.area.width).max(1))
        .map(|row| {
            let row: String = row.iter().map(|cell| cell.symbol()).collect();
            row.trim_end().to_owned() + "\n"
        })
        .collect()
}

#[test]
fn every_instruction() {
    for instruction in ALL {
        let screen = text(&draw(&view_with(instruction), 80, 24));
        insta::assert_snapshot!(format!("{instruction:?}"), screen);
    }
}

#[test]
fn a_small_screen_still_instructs() {
    for instruction in ALL {
        let screen = text(&draw(&view_with(instruction), 20, 3));
        let first = instruction.words().split(' ').next().unwrap();
        assert!(screen.contains(first), "{screen}");
    }
}

/// Fault 37.
#[test]
fn every_small_size_shows_the_instruction() {
    // Instructions in the inner loop, because a solved layout is cached.
    for (columns, rows) in (0..=60).flat_map(|c| (0..=30).map(move |r| (c, r))) {
        for instruction in ALL {
            let screen = draw(&view_with(instruction), columns, rows);
            if columns >= 9 && rows >= 1 {
                let screen = text(&screen);
                let first = instruction.words().split(' ').next().unwrap();
                assert!(screen.contains(first), "{columns}x{rows}: {screen}");
            }
        }
    }
}

#[test]
fn the_force_shows_under_feedback_alone() {
    for instruction in ALL {
        let measured_view = view_with(instruction);
        let unmeasured_view = ScreenView {
            mean_force_n: None,
            force_band_n: None,
            ..measured_view.clone()
        };
        let is_same = draw(&measured_view, 80, 24) == draw(&unmeasured_view, 80, 24);
        assert_eq!(
            is_same,
            instruction != Instruction::Feedback,
            "{instruction:?}"
        );
    }
}

#[test]
fn feedback_judges_the_force_in_words_and_colour() {
    for (mean_n, words, color) in [
        (0.42, "0.42 N  too light", Color::Magenta),
        (0.5, "0.50 N  just right", Color::Green),
        (0.8, "0.80 N  just right", Color::Green),
        (0.81, "0.81 N  too hard", Color::Magenta),
    ] {
        let screen = draw(
            &ScreenView {
                mean_force_n: Some(mean_n),
                ..view_with(Instruction::Feedback)
            },
            80,
            24,
        );
        assert!(text(&screen).contains(words));
        let value = format!("{mean_n:.2}");
        let start = screen.content().windows(4).position(|cells| {
            cells
                .iter()
                .map(|cell| cell.symbol())
                .eq(value.split("").filter(|s| !s.is_empty()))
        });
        assert_eq!(screen.content()[start.unwrap()].fg, color);
    }
}

#[test]
fn the_slider_keeps_to_its_place() {
    let left_edge = |slider_m| {
        let screen = draw(
            &ScreenView {
                slider_m: Some(slider_m),
                ..view_with(Instruction::FollowSlider)
            },
            80,
            24,
        );
        screen
            .content()
            .iter()
            .position(|cell| cell.symbol() == "█")
            .unwrap()
            % 80
    };
    assert_eq!(left_edge(-1.0), left_edge(0.0));
    assert_eq!(left_edge(0.0525), 39);
    assert_eq!(left_edge(0.105), left_edge(7.0));
    assert!(
        left_edge(0.0) < left_edge(0.03)
            && left_edge(0.03) < left_edge(0.06)
            && left_edge(0.06) < left_edge(0.105)
    );
}

/// Fault 37.
#[test]
fn the_slider_moves_by_eighths_of_a_column_in_the_terminals_own_foreground() {
    let eighths = " ▏▎▍▌▋▊▉█";
    // Left edge of the slider in its first row, in eighths of a column.
    let edge = |slider_m: f64| {
        let view = ScreenView {
            slider_m: Some(slider_m),
            ..view_with(Instruction::FollowSlider)
        };
        let screen = draw(&view, 80, 24);
        let row = screen.content().chunks(80).nth(19).unwrap();
        let mut positions: Vec<usize> = Vec::new();
        for (x, cell) in row.iter().enumerate() {
            let part = eighths
                .chars()
                .position(|c| cell.symbol().starts_with(c))
                .unwrap();
            if part == 0 {
                continue;
            }
            assert_eq!(cell.fg, Color::Reset, "{slider_m}");
            let reversed = cell.modifier.contains(Modifier::REVERSED);
            let (from, to) = if reversed { (part, 8) } else { (0, part) };
            positions.extend((from..to).map(|eighth| 8 * x + eighth));
        }
        assert_eq!(positions.len(), 24, "{slider_m}: three columns wide");
        let contiguous = positions.windows(2).all(|pair| pair[0] + 1 == pair[1]);
        assert!(contiguous, "{slider_m}: {positions:?}");
        positions[0]
    };
    // 105 mm are 75 columns: 1.4 mm per column, 0.175 mm per eighth.
    let edges: Vec<usize> = (0..100).map(|i| edge(0.02 + 1e-4 * f64::from(i))).collect();
    assert!(edges.windows(2).all(|pair| pair[1] - pair[0] <= 1));
    assert!(edges[99] - edges[0] >= 55);
}

#[test]
fn the_words_are_those_of_the_language() {
    let texts = Arc::new(Texts::of(Language::De).clone());
    for (instruction, words) in [
        (Instruction::PlaceFinger, "drücken Sie dann den Knopf"),
        (Instruction::Feedback, "0,87 N  zu fest"),
        (Instruction::FollowSlider, "Durchgang 3 von 10"),
    ] {
        let view = ScreenView {
            texts: texts.clone(),
            ..view_with(instruction)
        };
        let screen = text(&draw(&view, 80, 24));
        assert!(screen.contains(words), "{screen}");
    }
    let repeat_view = ScreenView {
        repeat: Some(RepeatCause::TooSlow),
        practice: true,
        texts,
        ..view_with(Instruction::Wait)
    };
    let screen = text(&draw(&repeat_view, 80, 24));
    assert!(screen.contains("Zu langsam: wir wiederholen"), "{screen}");
    assert!(screen.contains("Übung 3 von 10"), "{screen}");
}

proptest! {
    #[test]
    fn any_view_at_any_size_is_drawn_without_panic(
        which in 0..10usize,
        columns in 0..=200u16,
        rows in 0..=60u16,
        value in prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(-1e300), -1.0..1.0f64],
        other in prop_oneof![Just(f64::NAN), Just(0.0), Just(f64::MAX), 0.0..1.0f64],
        count in any::<u32>(),
    ) {
        let view = ScreenView {
            slider_m: Some(value),
            plate_m: other,
            start_m: value,
            end_m: other,
            countdown: Some(count),
            mean_force_n: Some(value),
            force_band_n: Some((value, other)),
            trial: count,
            rest_s: Some(other),
            ..view_with(ALL[which])
        };
        let _ = draw(&view, columns, rows);
    }
}
