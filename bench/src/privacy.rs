//! Permissions of the files that the program writes.

/// Makes all files and folders that this process creates from now on readable by the user only, regardless of the umask.
/// Existing files keep their permissions. On systems other than Unix, a file has the permissions of its folder.
pub fn keep_new_files_private() {
    #[cfg(unix)]
    {
        use rustix::fs::Mode;
        use rustix::process::umask;
        let group_and_others = Mode::RWXG | Mode::RWXO;
        let user = umask(group_and_others).intersection(Mode::RWXU);
        umask(group_and_others.union(user));
    }
}
