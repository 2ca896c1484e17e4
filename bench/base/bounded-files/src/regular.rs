//! Opening and reading of regular files.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read};
use std::path::Path;

use crate::content_store::ContentStore;
use crate::refusal::{FileKind, Refusal};
use crate::text::as_text;

/// Size limit of a text that is read whole, bytes: a hundred times the longest description of a bench, protocol or
/// calibration.
pub const TEXT_LIMIT_BYTES: u64 = 1 << 20;

/// Opens a regular file for reading; symbolic links are followed.
///
/// # Errors
/// [`Refusal::NotRegular`] inside the error for any other file, without waiting for it, and [`Refusal::Elsewhere`] for a
/// placeholder of git-annex or Git LFS; otherwise the operating system's reason.
pub fn open(path: &Path) -> io::Result<File> {
    let metadata = fs::metadata(path).map_err(|error| match ContentStore::find_absent(path) {
        Some(store) if error.kind() == io::ErrorKind::NotFound => Refusal::Elsewhere(store).into(),
        _ => error,
    })?;
    // Opening a device may already affect it, such as rewind a tape or reset a board.
    require_regular(&metadata)?;
    let mut options = OpenOptions::new();
    options.read(true);
    never_wait(&mut options, false);
    let mut file = options.open(path)?;
    // The file may have been replaced in the meantime.
    require_regular(&file.metadata()?)?;
    match ContentStore::find_in(&mut file)? {
        Some(store) => Err(Refusal::Elsewhere(store).into()),
        None => Ok(file),
    }
}

pub(crate) fn require_regular(metadata: &fs::Metadata) -> Result<(), Refusal> {
    FileKind::from_type(metadata.file_type()).map_or(Ok(()), |kind| Err(Refusal::NotRegular(kind)))
}

/// Sets flags to open a named pipe without waiting for its writer, a terminal without becoming its process's
/// controlling terminal, and, if `in_place`, to refuse a symbolic link.
#[cfg(unix)]
pub(crate) fn never_wait(options: &mut OpenOptions, in_place: bool) {
    use rustix::fs::OFlags;
    use std::os::unix::fs::OpenOptionsExt;
    let mut flags = OFlags::NONBLOCK | OFlags::NOCTTY;
    flags.set(OFlags::NOFOLLOW, in_place);
    options.custom_flags(flags.bits().cast_signed());
}

#[cfg(not(unix))]
pub(crate) fn never_wait(_: &mut OpenOptions, _: bool) {}

/// Reads a whole file of at most `limit_bytes`.
///
/// # Errors
/// [`Refusal`] inside the error for a longer file and for one that is not regular; otherwise the operating system's
/// reason.
pub fn read(path: &Path, limit_bytes: u64) -> io::Result<Vec<u8>> {
    read_limited(open(path)?, limit_bytes)
}

/// Reads `source` to its end, at most `limit_bytes`.
///
/// # Errors
/// [`Refusal::TooLong`] inside the error for a longer source; otherwise the source's reason.
pub fn read_limited(source: impl Read, limit_bytes: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // Not by the file's stated length: the file may grow, and some files do not state one.
    source
        .take(limit_bytes.saturating_add(1))
        .read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit_bytes {
        return Err(Refusal::TooLong { limit_bytes }.into());
    }
    Ok(bytes)
}

/// Reads a whole text file of at most `limit_bytes`.
///
/// # Errors
/// As [`read`]; also if the bytes are not UTF-8.
pub fn read_text(path: &Path, limit_bytes: u64) -> io::Result<String> {
    let bytes = read(path, limit_bytes)?;
    Ok(as_text(&bytes)?.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refusal::refusal;

    #[test]
    fn a_text_of_exactly_the_limit_is_read_and_one_byte_more_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("text");
        fs::write(&path, "12345").unwrap();
        assert_eq!(read_text(&path, 5).unwrap(), "12345");
        let error = read_text(&path, 4).unwrap_err();
        assert_eq!(refusal(&error), Some(&Refusal::TooLong { limit_bytes: 4 }));
        fs::write(&path, b"\xff").unwrap();
        let error = read_text(&path, 4).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidData);
        let byte = Refusal::NotUtf8 {
            line: 1,
            byte: 0xff,
        };
        assert_eq!(refusal(&error), Some(&byte));
        let absent = read(&folder.path().join("absent"), 4).unwrap_err();
        assert_eq!(absent.kind(), io::ErrorKind::NotFound);
    }

    #[cfg(unix)]
    /// Fault 44.
    #[test]
    fn what_is_no_regular_file_is_named_at_once() {
        use std::os::unix::fs::symlink;
        use std::os::unix::net::UnixListener;
        let folder = tempfile::tempdir().unwrap();
        let path_of = |name: &str| folder.path().join(name);
        fs::create_dir(path_of("folder")).unwrap();
        let _listener = UnixListener::bind(path_of("socket")).unwrap();
        symlink("/dev/zero", path_of("device")).unwrap();
        rustix::fs::mknodat(
            rustix::fs::CWD,
            path_of("pipe"),
            rustix::fs::FileType::Fifo,
            rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR,
            0,
        )
        .unwrap();
        for (name, kind) in [
            ("folder", FileKind::Folder),
            ("socket", FileKind::Socket),
            ("device", FileKind::Device),
            ("pipe", FileKind::NamedPipe),
        ] {
            let error = read_text(&path_of(name), TEXT_LIMIT_BYTES).unwrap_err();
            assert_eq!(refusal(&error), Some(&Refusal::NotRegular(kind)), "{name}");
        }
        fs::write(path_of("file"), "text").unwrap();
        symlink(path_of("file"), path_of("link")).unwrap();
        assert_eq!(read_text(&path_of("link"), 4).unwrap(), "text");
    }
}
