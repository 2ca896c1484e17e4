//! Files in and below a map's folder.

use std::fs;
use std::path::Path;

use recording::study::DESCRIPTION_FILE;

/// Levels of folders below the map's folder that are searched.
const DEPTH: usize = 8;
/// Greatest number of files.
const MOST_FILES: usize = 200_000;

/// Returns the paths of the files in and below `folder`, relative to it with `/` between their parts, in order. Hidden folders and
/// studies are left out.
pub(crate) fn list(folder: &Path) -> std::io::Result<Vec<String>> {
    let mut paths = Vec::new();
    descend(folder, "", DEPTH, &mut paths)?;
    paths.sort();
    Ok(paths)
}

fn descend(
    folder: &Path,
    prefix: &str,
    depth: usize,
    paths: &mut Vec<String>,
) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let Some(name) = name.to_str().filter(|name| !name.starts_with('.')) else {
            continue;
        };
        let path = entry.path();
        let Ok(metadata) = fs::metadata(&path) else {
            continue;
        };
        let relative = format!("{prefix}{name}");
        if metadata.is_file() && paths.len() < MOST_FILES {
            paths.push(relative);
        } else if metadata.is_dir() && depth > 0 && !path.join(DESCRIPTION_FILE).exists() {
            // A folder that cannot be listed has no file that could be read.
            let _ = descend(&path, &format!("{relative}/"), depth - 1, paths);
        }
    }
    Ok(())
}
