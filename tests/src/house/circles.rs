//! Circles of files: each takes something from another of them, and in the end from itself.

use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};

use super::edges::{Edges, Unresolved, edges};
use super::modules::{Tree, Unreadable};

/// Files of a crate that form a circle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Circle {
    /// Edges among its files.
    pub ties: Vec<Tie>,
}

/// What one file of a circle takes from another of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tie {
    /// The file that takes.
    pub from: PathBuf,
    /// The file that defines.
    pub to: PathBuf,
    /// The names taken.
    pub names: Vec<String>,
}

impl Circle {
    /// Returns its files.
    pub fn files(&self) -> BTreeSet<&Path> {
        self.ties.iter().map(|tie| tie.from.as_path()).collect()
    }
}

impl fmt::Display for Circle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "a circle of {} files:", self.files().len())?;
        for tie in &self.ties {
            let names = tie.names.join(", ");
            writeln!(
                f,
                "  {} takes {names} from {}",
                tie.from.display(),
                tie.to.display()
            )?;
        }
        Ok(())
    }
}

/// What the modules of a crate look like.
#[derive(Debug)]
pub struct Survey {
    /// Every file that a `mod` reaches from the root file.
    pub files: Vec<PathBuf>,
    /// Circles of files, those compiled for tests alone left out.
    pub circles: Vec<Circle>,
    /// Paths of this crate that lead to no known item.
    pub unresolved: Vec<Unresolved>,
}

/// Surveys the crate whose root file is `root`.
///
/// # Errors
/// When its source cannot be read.
pub fn survey(root: &Path) -> Result<Survey, Unreadable> {
    let tree = Tree::read(root)?;
    let (edges, unresolved) = edges(&tree);
    let circles = circles(&tree, &edges);
    Ok(Survey {
        files: tree.files,
        circles,
        unresolved,
    })
}

fn circles(tree: &Tree, edges: &Edges) -> Vec<Circle> {
    let reached: Vec<_> = (0..tree.files.len())
        .map(|file| reachable(file, edges))
        .collect();
    let mut found = Vec::new();
    let mut placed = BTreeSet::new();
    for file in 0..tree.files.len() {
        if !reached[file].contains(&file) || placed.contains(&file) {
            continue;
        }
        let together: BTreeSet<_> = reached[file]
            .iter()
            .copied()
            .filter(|other| reached[*other].contains(&file))
            .collect();
        let inside = |(from, to): &(usize, usize)| together.contains(from) && together.contains(to);
        let ties = edges.iter().filter(|(ends, _)| inside(ends));
        found.push(Circle {
            ties: ties
                .map(|(&(from, to), names)| Tie {
                    from: tree.files[from].clone(),
                    to: tree.files[to].clone(),
                    names: names.iter().cloned().collect(),
                })
                .collect(),
        });
        placed.extend(together);
    }
    found
}

/// Files that `from` takes from, directly or through others.
fn reachable(from: usize, edges: &Edges) -> BTreeSet<usize> {
    let (mut reached, mut next) = (BTreeSet::new(), vec![from]);
    while let Some(file) = next.pop() {
        let taken = edges.range((file, 0)..=(file, usize::MAX));
        for (&(_, to), _) in taken {
            if reached.insert(to) {
                next.push(to);
            }
        }
    }
    reached
}
