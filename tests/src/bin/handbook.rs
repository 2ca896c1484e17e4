//! Builds the handbook into the folder that is named: `./dev handbook`.
#![expect(clippy::print_stdout, reason = "it says where the book is")]

use std::path::PathBuf;

use anyhow::Context;

fn main() -> anyhow::Result<()> {
    let to = std::env::args_os().nth(1).map(PathBuf::from);
    let to = to.context("name the folder to build the handbook into")?;
    let to = std::path::absolute(to)?;
    bench_tests::handbook::build(&to)?;
    println!("{}", to.join("index.html").display());
    Ok(())
}
