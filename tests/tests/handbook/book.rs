//! The book builds, has all its chapters, and every link in it leads somewhere.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use bench_tests::handbook::{build, folder};
use bench_tests::program::workspace;

fn files(folder: &Path, end: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path, end));
        } else if path.extension().is_some_and(|is| is == end) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The values of an attribute in a page of HTML.
fn values<'a>(page: &'a str, attribute: &str) -> Vec<&'a str> {
    let opening = format!(" {attribute}=\"");
    let parts = page.split(&opening).skip(1);
    parts.filter_map(|rest| rest.split('"').next()).collect()
}

fn without_dots(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                plain.pop();
            }
            Component::CurDir => {}
            part => plain.push(part),
        }
    }
    plain
}

#[test]
fn the_handbook_builds_and_each_link_in_it_leads_somewhere() {
    let built = tempfile::tempdir().unwrap();
    build(built.path()).unwrap();
    let pages = files(built.path(), "html");
    assert!(pages.len() > 10, "{pages:?}");
    let mut wrong = Vec::new();
    for path in &pages {
        let page = std::fs::read_to_string(path).unwrap();
        // Of all chapters on one page, and of a page that may stand anywhere.
        if path.ends_with("print.html") || path.ends_with("404.html") {
            continue;
        }
        for link in [values(&page, "href"), values(&page, "src")].concat() {
            if link.is_empty() || link.contains("://") || link.starts_with("data:") {
                continue;
            }
            let (file, place) = link.split_once('#').unwrap_or((link, ""));
            let target = match file {
                "" => path.clone(),
                file => without_dots(&path.parent().unwrap().join(file)),
            };
            let there = match std::fs::read_to_string(&target) {
                Ok(page) => place.is_empty() || values(&page, "id").contains(&place),
                Err(_) => target.is_file() && place.is_empty(),
            };
            if !there {
                let page = path.strip_prefix(built.path()).unwrap().display();
                wrong.push(format!("{page}: {link}"));
            }
        }
    }
    assert!(wrong.is_empty(), "links to nothing:\n{}", wrong.join("\n"));
}

#[test]
fn each_chapter_is_listed_and_each_picture_is_shown() {
    let src = folder().join("src");
    let summary = std::fs::read_to_string(src.join("SUMMARY.md")).unwrap();
    let mut all = String::new();
    for chapter in files(&src, "md") {
        let name = chapter.file_name().unwrap().to_str().unwrap();
        if name != "SUMMARY.md" {
            assert!(
                summary.contains(&format!("({name})")),
                "{name} is in no summary"
            );
        }
        all += &std::fs::read_to_string(&chapter).unwrap();
    }
    let all = all + &std::fs::read_to_string(workspace().join("README.md")).unwrap();
    for picture in [files(&src, "svg"), files(&src, "png")].concat() {
        let name = picture.file_name().unwrap().to_str().unwrap();
        assert!(all.contains(&format!("/{name})")), "nothing shows {name}");
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
        let read = roxmltree::Document::parse(&text);
        assert!(read.is_ok(), "{}: {}", path.display(), read.unwrap_err());
    }
}

/// Links of README.md to the files of this folder.
#[test]
fn each_link_of_the_readme_leads_somewhere() {
    let text = std::fs::read_to_string(workspace().join("README.md")).unwrap();
    let links: BTreeSet<&str> = text
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split([')', '#', ' ']).next())
        .filter(|link| !link.is_empty() && !link.contains("://"))
        .collect();
    for link in links {
        assert!(workspace().join(link).exists(), "README.md: {link}");
    }
}
