//! Failures of file operations in a user's words.

use std::io::{Error, ErrorKind};

/// Returns the reason why an operation on a file failed, with its remedy. The caller names the file.
///
/// ```
/// use std::io::{Error, ErrorKind};
///
/// let words = bounded_files::cause(&Error::from(ErrorKind::StorageFull));
/// assert!(words.starts_with("the disk is full"));
/// ```
#[must_use]
pub fn cause(error: &Error) -> String {
    let text = error.to_string();
    // A refusal or another text of the program, but not the system's with a path that a library adds.
    if error.get_ref().is_some() && !text.contains("(os error ") {
        return text;
    }
    let words = match error.kind() {
        // With the system's own phrase, for which people search.
        ErrorKind::StorageFull => {
            "the disk is full (No space left on device); make room on it, or choose a folder on another one"
        }
        ErrorKind::QuotaExceeded => {
            "this user's share of the disk is full (Disk quota exceeded); make room, or choose a folder on another disk"
        }
        ErrorKind::FileTooLarge => "a limit on file sizes is in force (see `ulimit -f`)",
        ErrorKind::ReadOnlyFilesystem => {
            "the file system is read-only; choose a folder on another one"
        }
        ErrorKind::PermissionDenied => {
            "permission is missing; change its owner or its rights, or choose another folder"
        }
        ErrorKind::NotFound => "it does not exist, or its folder does not; check the spelling",
        ErrorKind::AlreadyExists => "it exists already; choose another name",
        ErrorKind::NotADirectory => "a part of its path is a file, not a folder; check the path",
        ErrorKind::InvalidFilename => {
            "the disk does not allow this name; choose a shorter one of plain letters"
        }
        ErrorKind::ResourceBusy | ErrorKind::ExecutableFileBusy => {
            "another program uses it; end that program"
        }
        ErrorKind::TimedOut
        | ErrorKind::StaleNetworkFileHandle
        | ErrorKind::HostUnreachable
        | ErrorKind::NetworkUnreachable
        | ErrorKind::NetworkDown
        | ErrorKind::NotConnected => {
            "the disk, device or network does not answer; check its cable and power, and connect it again"
        }
        ErrorKind::ConnectionRefused => "nothing answers there; check the address and its power",
        ErrorKind::ConnectionReset | ErrorKind::ConnectionAborted | ErrorKind::BrokenPipe => {
            "the other side closed the connection; start it again"
        }
        ErrorKind::AddrInUse => "another program uses this address; end that program",
        ErrorKind::OutOfMemory => "memory is short; end other programs",
        ErrorKind::WriteZero => "the disk accepts no more bytes; check it, or choose another one",
        ErrorKind::UnexpectedEof => "it ends early; copy it again",
        ErrorKind::IsADirectory => "it is a folder, not a regular file",
        _ => match error.raw_os_error() {
            None => return text,
            Some(code) => match by_code(code) {
                Some(words) => words,
                None => {
                    return format!("the system refuses it ({error})");
                }
            },
        },
    };
    words.to_owned()
}

/// Returns an error and its causes, outermost first, those of the system in a user's words. A cause that an earlier line contains is
/// left out.
#[must_use]
pub fn causes(error: &(dyn std::error::Error + 'static)) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for error in std::iter::successors(Some(error), |error| error.source()) {
        let system = error.downcast_ref::<Error>();
        let line = system.map_or_else(|| error.to_string(), cause);
        if !lines.iter().any(|earlier| earlier.contains(&line)) {
            lines.push(line);
        }
    }
    lines
}

/// Returns an error and its [`causes`] as one line.
#[must_use]
pub fn cause_line(error: &(dyn std::error::Error + 'static)) -> String {
    causes(error).join(": ")
}

/// Returns the words for errors without a kind.
#[cfg(unix)]
fn by_code(code: i32) -> Option<&'static str> {
    use rustix::io::Errno;
    Some(match Errno::from_raw_os_error(code) {
        Errno::IO => {
            "the disk reports an error of reading or writing; copy what is readable, and replace the disk"
        }
        Errno::NODEV | Errno::NXIO => "its disk or device is gone; connect it again",
        Errno::MFILE | Errno::NFILE => "too many files are open; end other programs",
        Errno::LOOP => "its symbolic links lead in a circle; correct them",
        Errno::OPNOTSUPP | Errno::NOSYS => {
            "its file system does not support this; choose a folder on another disk"
        }
        Errno::INVAL => "its file system does not allow this; choose a folder on another disk",
        _ => return None,
    })
}

#[cfg(not(unix))]
fn by_code(_: i32) -> Option<&'static str> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refusal::Refusal;

    #[test]
    #[cfg(unix)]
    fn no_number_of_the_system_reaches_a_user() {
        use rustix::io::Errno;
        for (errno, words) in [
            (Errno::NOENT, "does not exist"),
            (Errno::ACCESS, "permission is missing"),
            (Errno::PERM, "permission is missing"),
            (Errno::NOSPC, "the disk is full"),
            (Errno::DQUOT, "share of the disk is full"),
            (Errno::ROFS, "read-only"),
            (Errno::IO, "the disk reports an error"),
            (Errno::NOTDIR, "not a folder"),
            (Errno::ISDIR, "it is a folder"),
            (Errno::NAMETOOLONG, "name"),
            (Errno::LOOP, "circle"),
            (Errno::MFILE, "too many files"),
            (Errno::STALE, "does not answer"),
            (Errno::NODEV, "is gone"),
            (Errno::FBIG, "ulimit"),
        ] {
            let text = cause(&Error::from_raw_os_error(errno.raw_os_error()));
            assert!(text.contains(words) && !text.contains("os error"), "{text}");
        }
    }

    #[test]
    fn an_error_is_one_line_with_its_causes() {
        #[derive(Debug, thiserror::Error)]
        #[error("cannot open the terminal")]
        struct Outer(#[source] Error);
        let line = cause_line(&Outer(ErrorKind::NotFound.into()));
        assert!(
            line.starts_with("cannot open the terminal: it does not exist"),
            "{line}"
        );
        let said = Outer(Error::other("the terminal"));
        assert_eq!(cause_line(&said), "cannot open the terminal");
    }

    #[test]
    fn a_text_of_the_program_is_kept() {
        let error = Error::other("an earlier write failed");
        assert_eq!(cause(&error), "an earlier write failed");
        let with_path = "Permission denied (os error 13) at path \"/root/.tmp\"";
        let error = Error::new(ErrorKind::PermissionDenied, with_path);
        assert!(cause(&error).starts_with("permission is missing"));
        let refusal = Refusal::TooLong { limit_bytes: 4 };
        assert_eq!(cause(&refusal.into()), refusal.to_string());
        assert_eq!(cause(&Refusal::Link.into()), Refusal::Link.to_string());
    }
}
