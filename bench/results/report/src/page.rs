//! HTML page: head, table of contents and sections.

use maud::{DOCTYPE, Markup, PreEscaped, html as markup};

use crate::content::{ReportContent, ReportError, recording_entries};
use crate::drawing::drawing;
use crate::number::date;
use crate::{
    assumptions, calibration, descriptive, drift, estimates, flags, force_clocks, law_check,
    omissions, skin, statistics, study, trials,
};

const STYLE: &str = include_str!("page.css");

/// Section of the page.
struct Section {
    id: &'static str,
    title: &'static str,
    body: Markup,
}

/// Returns the page.
///
/// # Errors
/// A figure cannot be drawn.
pub fn html(content: &ReportContent<'_>) -> Result<String, ReportError> {
    let results = content.results;
    let recordings = recording_entries(content);
    let section = |id, title, body| Section { id, title, body };
    let folded = |id, title, body: Markup| {
        let body = markup! { details { summary { "Show" } (body) } };
        Section { id, title, body }
    };
    let mut sections = vec![
        section("summary", "Summary", study::summary(content, &recordings)),
        section(
            "friction",
            "Friction, gap, force and amplitude",
            descriptive::descriptive(&results.descriptive),
        ),
        section("figures", "Figures", figures(content)?),
        section("study", "The study", study::study(content, &recordings)),
        section(
            "participants",
            "Participants",
            study::participants(&recordings),
        ),
        section(
            "trials",
            "Trials and verdicts",
            trials::trials(content, &recordings),
        ),
        section(
            "left-out",
            "Omitted data",
            omissions::omissions(results, &recordings),
        ),
        section(
            "skin",
            "Skin of the participants",
            skin::skin(results.skin, &results.holds_under_every_law_tried),
        ),
        folded(
            "estimates",
            "Estimates",
            estimates::estimates(
                results.skin,
                &recordings,
                &results.holds_under_every_law_tried,
            ),
        ),
        folded("drift", "Drift", drift::drift(&recordings)),
        section("flags", "Flags and warnings", flags::flags(&recordings)),
        section(
            "published",
            "Comparison with the published statistics",
            statistics::table(&results.statistics),
        ),
        section(
            "assumptions",
            "Assumptions",
            assumptions::assumptions(&results.settings),
        ),
        section(
            "calibration",
            "Calibration",
            calibration::calibration(content, &recordings),
        ),
        section(
            "conditional",
            "Dependence on assumptions",
            assumptions::dependencies(&recordings),
        ),
        section(
            "method",
            "Methods and citation",
            assumptions::methods(content),
        ),
    ];
    if let Some(body) = force_clocks::force_clocks(results, &recordings)? {
        let before_flags = sections.iter().position(|section| section.id == "flags");
        let at = before_flags.unwrap_or(sections.len());
        sections.insert(at, folded("force-clocks", "Clocks of the forces", body));
    }
    if !results.law_check.is_empty() {
        let after_flags = sections
            .iter()
            .position(|section| section.id == "published");
        let body = law_check::law_check(&results.law_check);
        let at = after_flags.unwrap_or(sections.len());
        sections.insert(at, section("law-check", "Check of the laws", body));
    }
    let page = markup! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "Friction report: " (content.name) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { "Friction report: " (content.name) }
                    p.made { "Made on " (date(content.date)) " by " (content.program) "." }
                    nav aria-label="Contents" {
                        ol { @for section in &sections {
                            li { a href={ "#" (section.id) } { (section.title) } }
                        } }
                    }
                }
                main { @for section in &sections {
                    section id=(section.id) {
                        h2 { (section.title) }
                        (section.body)
                    }
                } }
            }
        }
    };
    Ok(page.into_string().replace(is_control, "\u{fffd}"))
}

/// Returns whether a character is a control character or changes the direction of text.
fn is_control(c: char) -> bool {
    let is_mark = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    is_mark || (c.is_control() && c != '\n' && c != '\t')
}

fn figures(content: &ReportContent<'_>) -> Result<Markup, ReportError> {
    let mut drawings = Vec::new();
    for figure in content.figures {
        drawings.push((figure, drawing(figure)?));
    }
    Ok(markup! {
        @if drawings.is_empty() { p { "No figure could be drawn from these recordings." } }
        @for ((figure, svg), number) in drawings.iter().zip(1..) {
            figure id={ "figure-" (number) } {
                (svg)
                figcaption { b { "Figure " (number) ". " (figure.title) ". " } (figure.caption) }
            }
        }
    })
}
