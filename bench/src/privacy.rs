//! Who can read what the program writes.

/// Lets nobody but the user read the files and folders that this process makes from now on, whatever the umask was.
/// What exists keeps its permissions. On systems other than Unix, a file has the permissions of its folder.
pub fn keep_new_files_private() {
    #[cfg(unix)]
    {
        use rustix::fs::Mode;
        use rustix::process::umask;
        let others = Mode::RWXG | Mode::RWXO;
        let user = umask(others).intersection(Mode::RWXU);
        umask(others.union(user));
    }
}
