//! The tests of the workspace, with the rows of FAULTS.md and HAZARDS.md that their doc comments claim to prove.

use std::collections::BTreeSet;
use std::fmt;
use std::path::Path;

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use syn::Meta;

use super::modules::Unreadable;
use super::packages::Package;
use super::sizes::rust_files;

/// A row of FAULTS.md or HAZARDS.md.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Row {
    /// A row of FAULTS.md.
    Fault(u32),
    /// A section of HAZARDS.md.
    Hazard(u32),
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fault(number) => write!(f, "fault {number}"),
            Self::Hazard(number) => write!(f, "hazard {number}"),
        }
    }
}

/// A test function.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Test {
    /// Its package and its name: `safety::nothing_is_armed_blind`.
    pub name: String,
    /// The rows that it proves.
    pub proves: BTreeSet<Row>,
}

/// Tests and malformed tags of source files.
#[derive(Debug, Default)]
pub struct TestIndex {
    /// Tests, also in the arguments of a macro such as `proptest!`.
    pub tests: Vec<Test>,
    /// Lines that begin like a tag, but are malformed or not above a test.
    pub strays: Vec<Stray>,
}

/// A line that begins like a tag but is not a valid one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "{package}: `/// {line}` is no tag of a test; write `/// Fault 16.` or `/// Hazards 3, 10.` above `#[test]`"
)]
pub struct Stray {
    /// The package.
    pub package: String,
    /// The line.
    pub line: String,
}

impl TestIndex {
    /// Reads all source files in and below `folder` that belong to one of `packages`.
    ///
    /// # Errors
    /// When a file cannot be read or is not Rust.
    pub fn read(folder: &Path, packages: &[Package]) -> Result<Self, Unreadable> {
        let disk = |path: &Path, error| Unreadable::Disk {
            path: path.to_owned(),
            error,
        };
        let mut index = Self::default();
        for path in rust_files(folder).map_err(|error| disk(folder, error))? {
            // One package's folder may lie inside another's.
            let owners = packages.iter().filter(|p| path.starts_with(&p.folder));
            let innermost = owners.max_by_key(|package| package.folder.components().count());
            let Some(package) = innermost else { continue };
            let text = std::fs::read_to_string(&path).map_err(|error| disk(&path, error))?;
            let tokens: TokenStream =
                syn::parse_str(&text).map_err(|error| Unreadable::NotRust { path, error })?;
            index.scan(&package.name, tokens);
        }
        Ok(index)
    }

    fn scan(&mut self, package: &str, tokens: TokenStream) {
        // Attributes of the next item.
        let mut attributes = Vec::new();
        let mut tokens = tokens.into_iter().peekable();
        while let Some(token) = tokens.next() {
            match token {
                TokenTree::Punct(mark) if mark.as_char() == '#' => {
                    if let Some(TokenTree::Group(group)) = tokens.next_if(is_bracketed) {
                        attributes.extend(syn::parse2::<Meta>(group.stream()));
                    }
                }
                TokenTree::Ident(word) if word == "fn" => {
                    let name = tokens.next_if(|token| matches!(token, TokenTree::Ident(_)));
                    let test = attributes.iter().any(|meta| meta.path().is_ident("test"));
                    let name = name.filter(|_| test);
                    let name = name.map(|name| format!("{package}::{name}"));
                    self.function(package, name, &std::mem::take(&mut attributes));
                }
                TokenTree::Ident(word) if word == "pub" || word == "async" => {}
                TokenTree::Group(group) => self.scan(package, group.stream()),
                _ => self.function(package, None, &std::mem::take(&mut attributes)),
            }
        }
    }

    /// Reads the doc comment of a test, or of another item if `name` is `None`.
    fn function(&mut self, package: &str, name: Option<String>, attributes: &[Meta]) {
        let mut proves = BTreeSet::new();
        for line in attributes.iter().flat_map(doc_lines) {
            match tag(&line) {
                Tag::Rows(rows) if name.is_some() => proves.extend(rows),
                Tag::None => {}
                Tag::Rows(_) | Tag::Malformed => self.strays.push(Stray {
                    package: package.to_owned(),
                    line,
                }),
            }
        }
        self.tests.extend(name.map(|name| Test { name, proves }));
    }
}

fn is_bracketed(token: &TokenTree) -> bool {
    matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Bracket)
}

/// Returns the lines of text of a doc comment.
fn doc_lines(attribute: &Meta) -> Vec<String> {
    match attribute {
        Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            syn::Expr::Lit(syn::ExprLit {
                lit: syn::Lit::Str(text),
                ..
            }) => text
                .value()
                .lines()
                .map(|line| line.trim().to_owned())
                .collect(),
            _ => Vec::new(),
        },
        _ => Vec::new(),
    }
}

enum Tag {
    None,
    Malformed,
    Rows(Vec<Row>),
}

/// Parses `Fault 16.`, `Faults 5, 17.`, `Hazard 3.` or `Hazards 3, 10.`, which must be the whole line.
fn tag(line: &str) -> Tag {
    let fault = line.strip_prefix("Fault");
    let row = if fault.is_some() {
        Row::Fault
    } else {
        Row::Hazard
    };
    let Some(rest) = fault.or_else(|| line.strip_prefix("Hazard")) else {
        return Tag::None;
    };
    let several = rest.starts_with('s');
    let numbers = rest.strip_prefix(if several { "s " } else { " " });
    let numbers = numbers.unwrap_or("");
    if !numbers.starts_with(|c: char| c.is_ascii_digit()) {
        return Tag::None;
    }
    // Without its full stop the tag is malformed.
    let numbers = numbers.strip_suffix('.').unwrap_or("");
    let rows = numbers.split(", ").map(|number| number.parse().map(row));
    match rows.collect::<Result<Vec<_>, _>>() {
        Ok(rows) if (rows.len() > 1) == several => Tag::Rows(rows),
        _ => Tag::Malformed,
    }
}
