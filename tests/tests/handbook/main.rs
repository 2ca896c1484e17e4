//! Checks of the handbook in docs/handbook: its links and pictures exist, its commands parse, its screenshots and list of
//! messages match the program, and each command has a manual page.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

mod book;
mod columns;
mod commands;
mod manual;
mod messages;
mod pictures;
mod simulated;
mod window_pictures;

use std::path::Path;

use bench_tests::handbook::WRITE;

/// Compares a file of the handbook with the program's current output, or writes it.
fn require_same(path: &Path, content: impl AsRef<[u8]>) {
    let content = content.as_ref();
    if std::env::var_os(WRITE).is_some_and(|value| value == "1") {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
    }
    let file = std::fs::read(path).unwrap_or_default();
    assert!(
        file == content,
        "{} is not what the program makes now; `./dev handbook` writes it anew, then look at it and commit it",
        path.display()
    );
}
