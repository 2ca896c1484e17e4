//! Comparison of the index of messages with the code: no message is missing, stale or worded differently.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use bench_tests::handbook::folder;
use bench_tests::house::sizes::rust_files;
use bench_tests::program::workspace;
use help::messages::{MessageGroup, chapter, index};
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Attribute, Expr, ExprMethodCall, Fields, Item, Lit};

/// Types that the index of messages leaves out: errors of an option, a file's line or a computation, which state the remedy or
/// are wrapped by another message.
const LEFT_OUT: &[&str] = &[
    "BrokenOff",
    "BrokenRule",
    "CalFileError",
    "CarrierError",
    "ClockError",
    "CommandError",
    "ConnectionEnd",
    "ConstantError",
    "CrosstalkError",
    "DamagedLine",
    "DemodulationError",
    "DemodulatorError",
    "DiskError",
    "EndedEarly",
    "EnvelopeError",
    "EstimateError",
    "EventLogError",
    "ExclusionsError",
    "FaultTextError",
    "FigureError",
    "FilterError",
    "FinishError",
    "FitError",
    "ImportError",
    "LayoutError",
    "LayoutFault",
    "LimitError",
    "ListError",
    "ManifestError",
    "ManifestReadError",
    "LvmError",
    "MapError",
    "Missing",
    "ModelError",
    "ModulationError",
    "NoCarrier",
    "NoForceAxis",
    "NoTrialLabel",
    "NotDrilledError",
    "NotStarted",
    "NumberFault",
    "OffPlateError",
    "OtherSensor",
    "OverlapError",
    "PageError",
    "ParticipantIdError",
    "PersonError",
    "ProgramError",
    "ProtocolError",
    "ReadError",
    "RecordMismatch",
    "RecordingError",
    "Refusal",
    "RefusedText",
    "RehearsedFaultError",
    "RequestError",
    "SampleLossError",
    "SelectionError",
    "SendError",
    "SettingError",
    "SeveralObstacles",
    "SmoothingError",
    "SourceError",
    "SpectrumError",
    "TableError",
    "TableFault",
    "TdmsError",
    "TextLineError",
    "TomlError",
    "TimeFault",
    "ToneCountError",
    "ToneError",
    "TripCause",
    "Undecoded",
    "UnknownFault",
    "UnknownFormat",
    "UnknownQuantity",
    "UnreadContent",
    "VerifyError",
    "WavError",
    "WavWarning",
    "WriteError",
];

/// Messages of a type, by variant, or by an empty name for a struct; `None` for a message made elsewhere.
type Words = BTreeMap<String, Option<String>>;

#[test]
fn the_chapter_is_the_index() {
    super::require_same(&folder().join("src/messages.md"), chapter());
}

#[test]
fn each_message_is_in_the_index_with_its_exact_text() {
    let mut problems = Vec::new();
    for group in index() {
        let mut subjects = BTreeSet::new();
        for (file, name) in &group.sources {
            let path = workspace().join(file);
            let text = std::fs::read_to_string(&path).unwrap();
            let Some(words) = words_of(&syn::parse_file(&text).unwrap(), name) else {
                problems.push(format!("{file} has no type {name}"));
                continue;
            };
            let texts = literals(text.parse().unwrap());
            for (variant, message) in words {
                let subject = match variant.as_str() {
                    "" => name.clone(),
                    variant => format!("{name}::{variant}"),
                };
                problems.extend(compare(&group, &subject, message.as_deref(), &texts));
                subjects.insert(subject);
            }
        }
        if let Some(folder) = &group.rows {
            let rows = rows(&workspace().join(folder));
            problems.extend(
                rows.iter()
                    .flat_map(|row| compare(&group, row, Some(row), &[])),
            );
            subjects.extend(rows);
        }
        for file in &group.lines {
            let text = std::fs::read_to_string(workspace().join(file)).unwrap();
            let texts = literals(text.parse().unwrap());
            problems.extend(compare(&group, file, None, &texts));
            subjects.insert(file.clone());
        }
        let stale = group.messages.iter().filter(|m| !subjects.contains(&m.of));
        problems.extend(stale.map(|m| format!("`{}` says nothing any more: take it out", m.of)));
    }
    assert!(
        problems.is_empty(),
        "bench/operation/help/messages.toml:\n{}",
        problems.join("\n")
    );
}

#[test]
fn each_type_with_messages_is_in_the_index_or_left_out_on_purpose() {
    let index = index();
    let index_types: BTreeSet<&str> = index
        .iter()
        .flat_map(|group| group.sources.iter().map(|(_, name)| name.as_str()))
        .collect();
    let mut types = BTreeSet::new();
    for folder in ["bench", "protocols", "signalgen"] {
        for path in rust_files(&workspace().join(folder)).unwrap() {
            if !path.components().any(|part| part.as_os_str() == "src") {
                continue;
            }
            let file = syn::parse_file(&std::fs::read_to_string(&path).unwrap()).unwrap();
            types.extend(message_types(&file.items));
        }
    }
    let unknown: Vec<_> = types
        .iter()
        .filter(|name| !index_types.contains(name.as_str()) && !LEFT_OUT.contains(&name.as_str()))
        .collect();
    assert!(
        unknown.is_empty(),
        "put these into bench/operation/help/messages.toml, or into LEFT_OUT of this test: {unknown:#?}"
    );
    let stale: Vec<_> = LEFT_OUT
        .iter()
        .filter(|name| !types.contains(**name) || index_types.contains(**name))
        .collect();
    assert!(stale.is_empty(), "take these out of LEFT_OUT: {stale:?}");
}

/// Its words may stand in several texts, which the screen puts together.
#[test]
fn each_word_of_a_short_form_is_in_the_code() {
    let mut words = BTreeSet::new();
    for folder in ["bench", "protocols", "signalgen", "tui"] {
        for path in rust_files(&workspace().join(folder)).unwrap() {
            let text = std::fs::read_to_string(&path).unwrap();
            for text in literals(text.parse().unwrap()) {
                words.extend(text.split([' ', '…']).map(str::to_owned));
            }
        }
    }
    let groups = index();
    let messages = groups.iter().flat_map(|group| &group.messages);
    let briefs = messages.filter_map(|message| message.brief.as_deref());
    let unknown: BTreeSet<&str> = briefs
        .flat_map(|brief| brief.split([' ', '…']))
        .filter(|word| !words.contains(*word))
        .collect();
    assert!(unknown.is_empty(), "{unknown:?}");
}

/// Compares the index's entries for `subject` with the text in the code.
fn compare(
    group: &MessageGroup,
    subject: &str,
    message: Option<&str>,
    texts: &[String],
) -> Vec<String> {
    let entries: Vec<_> = group.messages.iter().filter(|m| m.of == subject).collect();
    if entries.is_empty() {
        return vec![format!(
            "`{subject}` is missing: {}",
            message.unwrap_or("see the source")
        )];
    }
    let differences = entries.iter().filter_map(|entry| match message {
        Some(message) if message == entry.says => None,
        Some(message) => Some(format!("`{subject}` says = {message:?}")),
        None if is_in_texts(&entry.says, texts) => None,
        None => Some(format!(
            "`{subject}`: no text of its source is {:?}",
            entry.says
        )),
    });
    differences.collect()
}

/// Returns whether one of the texts contains the pieces of `message` between its values, in their order.
fn is_in_texts(message: &str, texts: &[String]) -> bool {
    let pieces = || {
        message
            .split('…')
            .filter(|piece| piece.chars().any(char::is_alphanumeric))
    };
    texts.iter().any(|text| {
        let mut rest = text.as_str();
        pieces().all(|piece| {
            let index = rest.find(piece.trim());
            rest = index.map_or("", |start| &rest[start + piece.trim().len()..]);
            index.is_some()
        })
    })
}

/// Returns the messages of each variant of a type, or of the type itself; `None` if there is no such type.
fn words_of(file: &syn::File, name: &str) -> Option<Words> {
    file.items.iter().find_map(|item| match item {
        Item::Enum(item) if item.ident == name => {
            let variants = item.variants.iter().filter(|v| !is_transparent(&v.attrs));
            let words = variants.map(|v| (v.ident.to_string(), message_text(&v.attrs)));
            Some(words.collect())
        }
        Item::Struct(item) if item.ident == name => {
            Some(Words::from([(String::new(), message_text(&item.attrs))]))
        }
        _ => None,
    })
}

/// Returns the names of the types that define messages.
fn message_types(items: &[Item]) -> Vec<String> {
    items
        .iter()
        .filter_map(|item| match item {
            Item::Enum(item) => {
                let speaks = item
                    .variants
                    .iter()
                    .any(|v| message_text(&v.attrs).is_some());
                speaks.then(|| item.ident.to_string())
            }
            Item::Struct(item)
                if !matches!(item.fields, Fields::Unit) || message_text(&item.attrs).is_some() =>
            {
                message_text(&item.attrs).map(|_| item.ident.to_string())
            }
            _ => None,
        })
        .collect()
}

fn error_tokens(attributes: &[Attribute]) -> Option<TokenStream> {
    let attribute = attributes.iter().find(|a| a.path().is_ident("error"))?;
    Some(attribute.meta.require_list().ok()?.tokens.clone())
}

fn is_transparent(attributes: &[Attribute]) -> bool {
    error_tokens(attributes).is_some_and(|tokens| tokens.to_string() == "transparent")
}

/// Returns the text of `#[error("…")]`, with `…` for values.
fn message_text(attributes: &[Attribute]) -> Option<String> {
    literals(error_tokens(attributes)?).into_iter().next()
}

/// Returns the string literals, with `…` for values, in their order.
fn literals(tokens: TokenStream) -> Vec<String> {
    let mut texts = Vec::new();
    for token in tokens {
        match token {
            TokenTree::Group(group)
                if group.delimiter() != Delimiter::None || !group.stream().is_empty() =>
            {
                texts.extend(literals(group.stream()));
            }
            TokenTree::Literal(literal) => {
                if let Ok(text) = syn::parse_str::<syn::LitStr>(&literal.to_string()) {
                    texts.push(template(&text.value()));
                }
            }
            _ => {}
        }
    }
    texts
}

/// Returns a format string with `…` for values; a named constant counts as a value.
fn template(format: &str) -> String {
    let mut text = String::new();
    let mut characters = format.chars().peekable();
    while let Some(character) = characters.next() {
        match character {
            '{' | '}' if characters.peek() == Some(&character) => {
                text.push(character);
                characters.next();
            }
            '{' => {
                characters.by_ref().take_while(|c| *c != '}').for_each(drop);
                if !text.ends_with('…') {
                    text.push('…');
                }
            }
            _ => text.push(character),
        }
    }
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Returns the names of the rows that the sources of `check` can make.
fn rows(folder: &Path) -> BTreeSet<String> {
    let mut rows = Rows::default();
    for path in rust_files(folder).unwrap() {
        let mut file = syn::parse_file(&std::fs::read_to_string(path).unwrap()).unwrap();
        file.items.retain(|item| !matches!(item, Item::Mod(_)));
        rows.visit_file(&file);
    }
    // Rows that are named in a table of the wiring.
    rows.0
        .extend(["e-stop", "heartbeat", "stop: heartbeat", "stop: enable"].map(str::to_owned));
    rows.0
}

#[derive(Default)]
struct Rows(BTreeSet<String>);

impl Visit<'_> for Rows {
    fn visit_expr_method_call(&mut self, call: &ExprMethodCall) {
        if (call.method == "row" || call.method == "verdict_row")
            && let Some(Expr::Lit(first)) = call.args.first()
            && let Lit::Str(name) = &first.lit
        {
            self.0.insert(name.value());
        }
        visit::visit_expr_method_call(self, call);
    }
}

#[test]
fn a_variant_without_a_message_and_other_words_are_found() {
    let source = "#[derive(Error)] enum E { #[error(\"the {part} is {:.1} V off: {why}\", v)] A { part: u8 },\n\
        #[error(transparent)] B(F), C }";
    let words = words_of(&syn::parse_file(source).unwrap(), "E").unwrap();
    let message = words["A"].clone().unwrap();
    assert_eq!(message, "the … is … V off: …");
    assert_eq!(words.keys().collect::<Vec<_>>(), ["A", "C"]);
    let group = &index()[0];
    assert_eq!(compare(group, "E::A", Some(&message), &[]).len(), 1);
    let texts = literals(
        "write!(f, \"normal force {n:.2} N over {l}\")"
            .parse()
            .unwrap(),
    );
    assert!(
        is_in_texts("normal force … N over …", &texts) && !is_in_texts("lateral force", &texts)
    );
}
