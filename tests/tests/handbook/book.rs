//! Checks that the handbook has all its chapters and that every link in the documentation has a target.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use bench_tests::handbook::folder;
use bench_tests::program::workspace;
use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            paths.extend(files(&path, extension));
        } else if path.extension().is_some_and(|suffix| suffix == extension) {
            paths.push(path);
        }
    }
    paths.sort();
    paths
}

/// Links and headings of a page of Markdown.
#[derive(Default)]
struct Page {
    /// Targets of links and pictures, as written.
    links: Vec<String>,
    /// Anchors of the headings, as mdBook and repository sites form them.
    anchors: BTreeSet<String>,
}

impl Page {
    fn read(path: &Path) -> Self {
        Self::parse(&std::fs::read_to_string(path).unwrap())
    }

    fn parse(text: &str) -> Self {
        let mut page = Self::default();
        let mut heading: Option<String> = None;
        for event in Parser::new_ext(text, Options::ENABLE_TABLES) {
            match event {
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    page.links.push(dest_url.into_string());
                }
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::Text(part) | Event::Code(part) => {
                    if let Some(heading) = &mut heading {
                        heading.push_str(&part);
                    }
                }
                Event::End(TagEnd::Heading(_)) => {
                    page.add_anchor(&anchor(&heading.take().unwrap_or_default()));
                }
                _ => {}
            }
        }
        page
    }

    /// Adds the anchor of a heading, with a number if an earlier heading has the same words.
    fn add_anchor(&mut self, words: &str) {
        let candidates = (1..).map(|number| format!("{words}-{number}"));
        let mut names = std::iter::once(words.to_owned()).chain(candidates);
        let free = names.find(|name| !self.anchors.contains(name));
        self.anchors.extend(free);
    }
}

/// Returns the anchor of a heading: lower case, a hyphen for each space, no punctuation.
fn anchor(heading: &str) -> String {
    let characters = heading.chars().filter_map(|letter| match letter {
        letter if letter.is_alphanumeric() || matches!(letter, '_' | '-') => Some(letter),
        letter if letter.is_whitespace() => Some('-'),
        _ => None,
    });
    characters.flat_map(char::to_lowercase).collect()
}

fn normalise(path: &Path) -> PathBuf {
    let mut result = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                result.pop();
            }
            Component::CurDir => {}
            part => result.push(part),
        }
    }
    result
}

/// Returns the links of a page without a target.
fn dead_links(path: &Path) -> Vec<String> {
    let page = Page::read(path);
    let is_dead = |link: &&String| {
        if link.contains("://") || link.starts_with("mailto:") {
            return false;
        }
        let (file, fragment) = link.split_once('#').unwrap_or((link, ""));
        let target = match file {
            "" => path.to_owned(),
            file => normalise(&path.parent().unwrap().join(file)),
        };
        if fragment.is_empty() {
            return !target.exists();
        }
        !target.is_file() || !Page::read(&target).anchors.contains(fragment)
    };
    let name = path.strip_prefix(workspace()).unwrap().display();
    let dead = page.links.iter().filter(is_dead);
    dead.map(|link| format!("{name}: {link}")).collect()
}

#[test]
fn links_and_headings_of_a_page_are_found() {
    let text =
        "# A `b`: c-d\n## Twice\n## Twice\n[x](y.md#twice-1) ![z](w.png)\n```\n[no](link)\n```\n";
    let page = Page::parse(text);
    assert_eq!(page.links, ["y.md#twice-1", "w.png"]);
    let anchors: Vec<&str> = page.anchors.iter().map(String::as_str).collect();
    assert_eq!(anchors, ["a-b-c-d", "twice", "twice-1"]);
}

#[test]
fn each_link_of_the_documentation_leads_somewhere() {
    let handbook = files(&folder().join("src"), "md");
    assert!(handbook.len() > 10, "{handbook:?}");
    let documents = files(&workspace().join("docs"), "md");
    let root_pages = std::fs::read_dir(workspace()).unwrap();
    let root_pages = root_pages.map(|entry| entry.unwrap().path());
    let root_pages =
        root_pages.filter(|path| path.extension().is_some_and(|suffix| suffix == "md"));
    let pages: BTreeSet<PathBuf> = handbook
        .into_iter()
        .chain(documents)
        .chain(root_pages)
        .collect();
    let dead: Vec<String> = pages.iter().flat_map(|path| dead_links(path)).collect();
    assert!(dead.is_empty(), "links to nothing:\n{}", dead.join("\n"));
}

#[test]
fn each_chapter_is_listed_and_each_picture_is_shown() {
    let src = folder().join("src");
    let summary = std::fs::read_to_string(src.join("SUMMARY.md")).unwrap();
    let mut text = String::new();
    for chapter in files(&src, "md") {
        let name = chapter.file_name().unwrap().to_str().unwrap();
        if name != "SUMMARY.md" {
            assert!(
                summary.contains(&format!("({name})")),
                "{name} is in no summary"
            );
        }
        text += &std::fs::read_to_string(&chapter).unwrap();
    }
    let text = text + &std::fs::read_to_string(workspace().join("README.md")).unwrap();
    for picture in [files(&src, "svg"), files(&src, "png")].concat() {
        let name = picture.file_name().unwrap().to_str().unwrap();
        assert!(text.contains(&format!("/{name})")), "nothing shows {name}");
        let bytes = std::fs::metadata(&picture).unwrap().len();
        assert!(bytes < 400_000, "{name} has {bytes} bytes");
    }
}

#[test]
fn each_drawing_is_a_sound_document() {
    let drawings = [
        files(&folder(), "svg"),
        files(&workspace().join("docs"), "svg"),
    ]
    .concat();
    for path in drawings {
        let text = std::fs::read_to_string(&path).unwrap();
        let document = roxmltree::Document::parse(&text);
        assert!(
            document.is_ok(),
            "{}: {}",
            path.display(),
            document.unwrap_err()
        );
    }
}
