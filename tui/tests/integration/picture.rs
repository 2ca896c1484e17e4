//! A screen as a picture and as text: both contain every cell, the document stays valid for any text, and the same
//! cells make the same bytes.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use crate::{rig, synthetic};
use proptest::prelude::*;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use roxmltree::Document;
use tui::picture::{Paper, svg, text};
use tui::{Event, State, Theme};

fn draw(columns: u16, rows: u16) -> Buffer {
    let mut state = State::new(Theme::Colour);
    for (at_s, event) in synthetic::session().into_iter().take(2500) {
        state.apply(&Event::Tick { now_s: at_s });
        state.apply(&event);
    }
    rig::draw(&state, columns, rows).backend().buffer().clone()
}

fn one_row(text: &str, style: Style) -> Buffer {
    let mut screen = Buffer::empty(Rect::new(0, 0, 20, 1));
    screen.set_string(0, 0, text, style);
    screen
}

/// Returns the words of a picture with their left edges and lengths in cells.
fn words(picture: &str) -> Vec<(String, u32, u32)> {
    let document = Document::parse(picture).unwrap();
    let number =
        |node: roxmltree::Node, name| node.attribute(name).unwrap().parse::<u32>().unwrap();
    document
        .descendants()
        .filter(|node| node.has_tag_name("text"))
        .map(|node| {
            let x = (number(node, "x") - 8) / 8;
            (
                node.text().unwrap().to_owned(),
                x,
                number(node, "textLength") / 8,
            )
        })
        .collect()
}

fn path(picture: &str, ink: &str) -> String {
    let document = Document::parse(picture).unwrap();
    let paths: Vec<_> = document
        .descendants()
        .filter(|node| node.has_tag_name("path") && node.attribute("fill") == Some(ink))
        .map(|node| node.attribute("d").unwrap().to_owned())
        .collect();
    paths.concat()
}

#[test]
fn a_dashboard_is_drawn_in_both_and_the_same_every_time() {
    for size in [(80, 24), (120, 40), (200, 60)] {
        let screen = draw(size.0, size.1);
        let lines = text(&screen);
        assert_eq!(lines.lines().count(), usize::from(size.1));
        assert!(lines.contains("sub-01"), "{lines}");
        for paper in [Paper::Dark, Paper::Light] {
            let picture = svg(&screen, "the dashboard", paper);
            assert_eq!(picture, svg(&draw(size.0, size.1), "the dashboard", paper));
            let words_drawn: Vec<String> =
                words(&picture).into_iter().map(|(word, ..)| word).collect();
            assert!(words_drawn.join(" ").contains("sub-01"), "{words_drawn:?}");
            assert!(picture.len() < 120_000, "{} bytes", picture.len());
        }
    }
}

#[test]
fn words_keep_their_places_with_any_gap_between_them() {
    let screen = one_row("  μ 0.42    gap  9", Style::new());
    let places = words(&svg(&screen, "", Paper::Dark));
    let expected = [("μ 0.42", 2, 6), ("gap", 12, 3), ("9", 17, 1)];
    assert_eq!(
        places,
        expected.map(|(word, x, cells)| (word.to_owned(), x, cells))
    );
    let wide_row = one_row("触覚 a", Style::new());
    assert_eq!(
        words(&svg(&wide_row, "", Paper::Dark)),
        [("触覚 a".to_owned(), 0, 6)]
    );
    assert_eq!(text(&wide_row), "触覚 a\n");
}

#[test]
fn styles_are_painted() {
    let bold = svg(&one_row("A", Style::new().red().bold()), "", Paper::Dark);
    assert!(
        bold.contains("fill=\"#f06565\" font-weight=\"bold\">A"),
        "{bold}"
    );
    let reversed = Style::new().fg(Color::Red).add_modifier(Modifier::REVERSED);
    let alarm = svg(&one_row("STOP", reversed), "", Paper::Dark);
    assert_eq!(path(&alarm, "#f06565"), "M8 8h32v16h-32z");
    assert!(alarm.contains("fill=\"#181a1f\">STOP"), "{alarm}");
    let indexed = svg(
        &one_row(
            "x",
            Style::new().fg(Color::Indexed(208)).bg(Color::Rgb(1, 2, 3)),
        ),
        "",
        Paper::Light,
    );
    assert!(
        indexed.contains("#ff8700") && indexed.contains("#010203"),
        "{indexed}"
    );
    let secret = svg(&one_row("secret", Style::new().hidden()), "", Paper::Dark);
    assert!(words(&secret).is_empty());
    let underline = svg(&one_row("a", Style::new().underlined()), "", Paper::Dark);
    assert!(
        path(&underline, "#d7dae0").contains("M8 22h8v1h-8z"),
        "{underline}"
    );
}

#[test]
fn lines_blocks_and_dots_are_shapes() {
    let shapes = |symbols: &str| {
        path(
            &svg(&one_row(symbols, Style::new()), "", Paper::Dark),
            "#d7dae0",
        )
    };
    assert_eq!(shapes("──"), "M8 15h16v1h-16z");
    assert_eq!(shapes("│"), "M11 8h1v16h-1z");
    assert_eq!(shapes("█▏▁▐"), "M8 8h9v16h-9zM24 22h8v2h-8zM36 8h4v16h-4z");
    assert_eq!(shapes("⠁⢀"), "M9 9h2v2h-2zM21 21h2v2h-2z");
    let shade = svg(&one_row("░", Style::new()), "", Paper::Dark);
    assert_eq!(path(&shade, "#474a4f"), "M8 8h8v16h-8z");
}

#[test]
fn reserved_and_forbidden_characters_do_not_break_the_document() {
    let screen = one_row("<a> & \"b\" \u{1b}[0m", Style::new());
    let picture = svg(&screen, "1 < 2 & \u{0}", Paper::Light);
    let document = Document::parse(&picture).unwrap();
    let title = document
        .descendants()
        .find(|node| node.has_tag_name("title"));
    assert_eq!(title.unwrap().text(), Some("1 < 2 & \u{fffd}"));
}

#[test]
fn a_screen_of_no_size_is_a_picture_too() {
    for area in [
        Rect::new(0, 0, 0, 0),
        Rect::new(3, 4, 5, 0),
        Rect::new(9, 9, 1, 1),
    ] {
        let screen = Buffer::empty(area);
        Document::parse(&svg(&screen, "", Paper::Dark)).unwrap();
        assert_eq!(text(&screen), "\n".repeat(usize::from(area.height)));
    }
}

proptest! {
    #[test]
    fn any_text_and_style_makes_a_document(content in "\\PC{0,30}", fg: u8, bg: u8, bits: u16) {
        let style = Style::new().fg(Color::Indexed(fg)).bg(Color::Indexed(bg))
            .add_modifier(Modifier::from_bits_truncate(bits));
        let screen = one_row(&content, style);
        let picture = svg(&screen, &content, Paper::Light);
        prop_assert!(Document::parse(&picture).is_ok(), "{picture}");
        if !style.add_modifier.contains(Modifier::HIDDEN) {
            let letters = |text: &str| text.chars().filter(|c| c.is_alphanumeric()).collect::<String>();
            let words_drawn: String = words(&picture).into_iter().map(|(word, ..)| word).collect();
            prop_assert_eq!(letters(&words_drawn), letters(&text(&screen)));
        }
    }
}
