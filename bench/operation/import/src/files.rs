//! Files in and below a map's folder.

use std::fs;
use std::path::Path;

use recording::study::DESCRIPTION_FILE;

/// Levels of folders below the map's folder that are searched.
const DEPTH: usize = 8;
/// Greatest number of files.
const MOST_FILES: usize = 200_000;

/// Files in and below a folder.
#[derive(Debug, Default)]
pub(crate) struct Listing {
    /// Paths relative to the folder, with `/` between their parts, in order. Those of links that lead nowhere are among them.
    pub paths: Vec<String>,
    /// Names that are not text, as far as they can be shown.
    unnamed: Vec<String>,
    /// There are more files than are listed.
    is_cut: bool,
}

impl Listing {
    /// Returns sentences for a user about files that are left out.
    pub fn notes(&self) -> impl Iterator<Item = String> {
        let unnamed = self.unnamed.first().map(|first| {
            format!(
                "{} left out, as {first}: names are in UTF-8; rename what is part of the data",
                match self.unnamed.len() {
                    1 => "1 name is".to_owned(),
                    count => format!("{count} names are"),
                }
            )
        });
        let cut = self.is_cut.then(|| {
            format!(
                "files beyond the first {MOST_FILES} are left out: move the map nearer to the data"
            )
        });
        unnamed.into_iter().chain(cut)
    }
}

/// Lists the files in and below `folder`. Hidden folders and studies are left out.
pub(crate) fn list(folder: &Path) -> std::io::Result<Listing> {
    let mut listing = Listing::default();
    descend(folder, "", DEPTH, &mut listing)?;
    listing.paths.sort();
    listing.unnamed.sort();
    Ok(listing)
}

fn descend(
    folder: &Path,
    prefix: &str,
    depth: usize,
    listing: &mut Listing,
) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let Some(name) = name.to_str() else {
            listing
                .unnamed
                .push(format!("{prefix}{}", name.to_string_lossy()));
            continue;
        };
        if name.starts_with('.') {
            continue;
        }
        let path = entry.path();
        let relative = format!("{prefix}{name}");
        // A link that leads nowhere is a file whose content is not here.
        if !path.is_dir() {
            if listing.paths.len() < MOST_FILES {
                listing.paths.push(relative);
            } else {
                listing.is_cut = true;
            }
        } else if depth > 0 && !path.join(DESCRIPTION_FILE).exists() {
            // A folder that cannot be listed has no file that could be read.
            let _ = descend(&path, &format!("{relative}/"), depth - 1, listing);
        }
    }
    Ok(())
}

#[cfg(all(test, unix))]
mod tests {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn a_link_without_its_content_is_listed_and_a_name_that_is_no_text_is_noted() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("day 1")).unwrap();
        fs::create_dir(path(".git")).unwrap();
        fs::write(path("day 1/S1.mat"), "").unwrap();
        fs::write(path(".git/config"), "").unwrap();
        symlink("../.git/annex/objects/a/b/c.mat", path("day 1/S2.mat")).unwrap();
        assert_eq!(list(folder.path()).unwrap().notes().next(), None);
        fs::write(folder.path().join(OsStr::from_bytes(b"S\xe93.mat")), "").unwrap();
        let listing = list(folder.path()).unwrap();
        assert_eq!(listing.paths, ["day 1/S1.mat", "day 1/S2.mat"]);
        let notes: Vec<String> = listing.notes().collect();
        assert_eq!(notes.len(), 1);
        assert!(
            notes[0].starts_with("1 name is left out, as S\u{fffd}3.mat: "),
            "{notes:?}"
        );
    }
}
