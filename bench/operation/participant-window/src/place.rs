//! The socket where session and window meet, in a folder private to the user.

use std::fs::{self, DirBuilder};
use std::io;
use std::os::unix::fs::{DirBuilderExt, FileTypeExt, MetadataExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};

/// Name of the socket.
const SOCKET: &str = "participant.sock";

/// Why session and window cannot meet.
#[derive(Debug, thiserror::Error)]
pub enum PlaceError {
    /// The folder is open to other users.
    #[error(
        "{folder} is open to other users of this computer: give a socket in a folder of your own (chmod 700 {folder})"
    )]
    Open {
        /// The folder.
        folder: PathBuf,
    },
    /// The folder or the socket belongs to another user.
    #[error("{path} belongs to another user: give a socket in a folder of your own")]
    Foreign {
        /// Folder or socket.
        path: PathBuf,
    },
    /// The socket is in use by another session.
    #[error(
        "another session has the participant's window at {path}: end it, or give this one another socket"
    )]
    Taken {
        /// The socket.
        path: PathBuf,
    },
    /// The path exists and is not a socket.
    #[error("{path} is not a socket: give another path")]
    NoSocket {
        /// The path.
        path: PathBuf,
    },
    /// The system returned an error.
    #[error("{path}: {}", bounded_files::cause(source))]
    System {
        /// Folder or socket.
        path: PathBuf,
        /// The system's reason.
        #[source]
        source: io::Error,
    },
}

/// Returns a user's socket: in the runtime directory `runtime`, or else in a folder of `temporary`.
#[must_use]
pub fn socket(runtime: Option<PathBuf>, temporary: &Path) -> PathBuf {
    let folder = match runtime.filter(|runtime| runtime.is_absolute()) {
        Some(runtime) => runtime.join("friction-bench"),
        None => temporary.join(format!("friction-bench-{}", user())),
    };
    folder.join(SOCKET)
}

/// Returns the default socket of this process's user.
#[must_use]
pub fn default_socket() -> PathBuf {
    let runtime = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    socket(runtime, &std::env::temp_dir())
}

fn user() -> u32 {
    rustix::process::geteuid().as_raw()
}

fn system(path: &Path) -> impl FnOnce(io::Error) -> PlaceError {
    let path = path.to_owned();
    move |source| PlaceError::System { path, source }
}

/// Requires a folder that only this user can enter.
fn require_private(folder: &Path) -> Result<(), PlaceError> {
    let metadata = fs::symlink_metadata(folder).map_err(system(folder))?;
    let folder = folder.to_owned();
    if !metadata.is_dir() || metadata.uid() != user() {
        return Err(PlaceError::Foreign { path: folder });
    }
    if metadata.mode() & 0o077 != 0 {
        return Err(PlaceError::Open { folder });
    }
    Ok(())
}

fn parent_folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Returns the folder of a socket; creates it, private to this user, if it does not exist.
fn make_private(path: &Path) -> Result<&Path, PlaceError> {
    let folder = parent_folder(path);
    match DirBuilder::new().mode(0o700).create(folder) {
        Ok(()) => {}
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
        Err(error) => return Err(system(folder)(error)),
    }
    require_private(folder)?;
    Ok(folder)
}

/// Opens the socket for this session; replaces one left by a killed session.
///
/// # Errors
/// [`PlaceError`].
pub fn listen(path: &Path) -> Result<UnixListener, PlaceError> {
    make_private(path)?;
    if let Ok(metadata) = fs::symlink_metadata(path) {
        if !metadata.file_type().is_socket() {
            return Err(PlaceError::NoSocket {
                path: path.to_owned(),
            });
        }
        if UnixStream::connect(path).is_ok() {
            return Err(PlaceError::Taken {
                path: path.to_owned(),
            });
        }
        fs::remove_file(path).map_err(system(path))?;
    }
    let listener = UnixListener::bind(path).map_err(system(path))?;
    fs::set_permissions(path, fs::Permissions::from_mode(0o600)).map_err(system(path))?;
    listener.set_nonblocking(true).map_err(system(path))?;
    Ok(listener)
}

/// Returns the lock that limits a socket to one window; `None` if another window holds it.
///
/// # Errors
/// [`PlaceError`].
pub fn only_window(path: &Path) -> Result<Option<fs::File>, PlaceError> {
    let folder = make_private(path)?;
    let lock = folder.join("participant.lock");
    let file = bounded_files::open_in_place(&lock).map_err(system(&lock))?;
    match file.try_lock() {
        Ok(()) => Ok(Some(file)),
        Err(fs::TryLockError::WouldBlock) => Ok(None),
        Err(fs::TryLockError::Error(error)) => Err(system(&lock)(error)),
    }
}

/// Connects to the session's socket; `None` without a session.
///
/// # Errors
/// [`PlaceError`] if the folder or the socket is not private to this user.
pub fn connect(path: &Path) -> Result<Option<UnixStream>, PlaceError> {
    let metadata = match fs::symlink_metadata(path) {
        Ok(metadata) => metadata,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(system(path)(error)),
    };
    require_private(parent_folder(path))?;
    if metadata.uid() != user() {
        return Err(PlaceError::Foreign {
            path: path.to_owned(),
        });
    }
    if !metadata.file_type().is_socket() {
        return Err(PlaceError::NoSocket {
            path: path.to_owned(),
        });
    }
    match UnixStream::connect(path) {
        Ok(stream) => Ok(Some(stream)),
        // A killed session leaves its socket.
        Err(error) if error.kind() == io::ErrorKind::ConnectionRefused => Ok(None),
        Err(error) => Err(system(path)(error)),
    }
}

/// Returns whether the peer process belongs to this user, as far as the system can tell.
#[must_use]
pub fn is_ours(stream: &UnixStream) -> bool {
    #[cfg(target_os = "linux")]
    {
        rustix::net::sockopt::socket_peercred(stream).is_ok_and(|peer| peer.uid.as_raw() == user())
    }
    #[cfg(not(target_os = "linux"))]
    {
        let _only_this_user_enters_the_folder = stream;
        true
    }
}

/// Returns the time on the clock shared by all processes of this computer, s.
#[must_use]
pub fn shared_s() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn private() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o700)).unwrap();
        folder
    }

    #[test]
    fn the_socket_is_the_users_alone_and_so_is_its_folder() {
        let folder = private();
        let path = socket(Some(folder.path().to_owned()), Path::new("/tmp"));
        let _listener = listen(&path).unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().mode() & 0o777;
        assert_eq!((mode(&path), mode(path.parent().unwrap())), (0o600, 0o700));
        assert!(is_ours(&connect(&path).unwrap().unwrap()));
        assert!(matches!(listen(&path), Err(PlaceError::Taken { .. })));
    }

    #[test]
    fn a_folder_that_others_enter_is_refused_by_both() {
        let folder = private();
        let path = folder.path().join("s");
        let _listener = listen(&path).unwrap();
        for mode in [0o701, 0o710, 0o755, 0o777] {
            fs::set_permissions(folder.path(), fs::Permissions::from_mode(mode)).unwrap();
            assert!(
                matches!(listen(&path), Err(PlaceError::Open { .. })),
                "{mode:o}"
            );
            assert!(
                matches!(connect(&path), Err(PlaceError::Open { .. })),
                "{mode:o}"
            );
        }
    }

    #[test]
    fn a_socket_that_a_killed_session_left_is_replaced_and_anything_else_stays() {
        let folder = private();
        let path = folder.path().join("s");
        assert!(connect(&path).unwrap().is_none(), "no session yet");
        drop(listen(&path).unwrap());
        assert!(path.exists() && connect(&path).unwrap().is_none());
        let _again = listen(&path).unwrap();
        let file = folder.path().join("notes.txt");
        fs::write(&file, "kept").unwrap();
        assert!(matches!(listen(&file), Err(PlaceError::NoSocket { .. })));
        assert!(matches!(connect(&file), Err(PlaceError::NoSocket { .. })));
        assert_eq!(fs::read_to_string(&file).unwrap(), "kept");
    }

    #[test]
    fn one_window_has_the_lock_until_it_is_closed() {
        let folder = private();
        let path = folder.path().join("s");
        let first = only_window(&path).unwrap();
        assert!(first.is_some());
        assert!(only_window(&path).unwrap().is_none());
        drop(first);
        assert!(only_window(&path).unwrap().is_some());
    }

    #[test]
    fn without_a_runtime_directory_the_folder_has_the_users_number() {
        let path = socket(None, Path::new("/tmp"));
        assert_eq!(
            path,
            Path::new(&format!("/tmp/friction-bench-{}/participant.sock", user()))
        );
        assert_eq!(socket(Some("here".into()), Path::new("/tmp")), path);
    }
}
