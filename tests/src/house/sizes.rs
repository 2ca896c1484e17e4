//! Sizes of packages and files. All lines of a file count, also blank lines, comments and tests; the size of a package excludes
//! its unit tests.

use std::io;
use std::path::{Path, PathBuf};

/// A package or file above its limit.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{path} has {lines} lines; the limit is {limit}")]
pub struct TooLong {
    /// The file, or the package's folder of source files.
    pub path: PathBuf,
    /// Number of its lines.
    pub lines: usize,
    /// Greatest number allowed.
    pub limit: usize,
}

/// Returns the `.rs` files in and below `folder`, without hidden folders and cargo's build folders.
///
/// # Errors
/// When a folder cannot be read.
pub fn rust_files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let (mut files, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(folder) = folders.pop() {
        // Cargo marks its build folder with this file.
        if folder.join("CACHEDIR.TAG").exists() || folder.ends_with("target") {
            continue;
        }
        for entry in std::fs::read_dir(&folder)? {
            let path = entry?.path();
            let hidden = path
                .file_name()
                .is_none_or(|name| name.to_string_lossy().starts_with('.'));
            if path.is_dir() && !path.is_symlink() && !hidden {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path);
            }
        }
    }
    files.sort();
    Ok(files)
}

/// Returns the number of lines of a file.
///
/// # Errors
/// When it cannot be read.
pub fn lines(file: &Path) -> io::Result<usize> {
    Ok(std::fs::read_to_string(file)?.lines().count())
}

/// Returns the files in and below `folder` that have more than `limit` lines.
///
/// # Errors
/// When a file cannot be read.
pub fn long_files(folder: &Path, limit: usize) -> io::Result<Vec<TooLong>> {
    let mut too_long = Vec::new();
    for path in rust_files(folder)? {
        let lines = lines(&path)?;
        if lines > limit {
            too_long.push(TooLong { path, lines, limit });
        }
    }
    Ok(too_long)
}

/// Returns the number of lines of a source file without unit tests: 0 for `tests.rs` and files below `tests/`, otherwise the
/// lines before `#[cfg(test)]` and `mod tests {`.
///
/// # Errors
/// When it cannot be read.
fn lines_without_tests(source: &Path, file: &Path) -> io::Result<usize> {
    let relative = file.strip_prefix(source).unwrap_or(file);
    if relative.file_stem().is_some_and(|name| name == "tests")
        || relative
            .components()
            .any(|part| part.as_os_str() == "tests")
    {
        return Ok(0);
    }
    let text = std::fs::read_to_string(file)?;
    let code = text.split("\n#[cfg(test)]\nmod tests {\n").next();
    Ok(code.map_or(0, |code| code.lines().count()))
}

/// Returns the package's source folder if its files have more than `limit` lines in total, without unit tests.
///
/// # Errors
/// When a file cannot be read.
pub fn large_package(source: &Path, limit: usize) -> io::Result<Option<TooLong>> {
    let mut total = 0;
    for file in rust_files(source)? {
        total += lines_without_tests(source, &file)?;
    }
    Ok((total > limit).then(|| TooLong {
        path: source.to_owned(),
        lines: total,
        limit,
    }))
}
