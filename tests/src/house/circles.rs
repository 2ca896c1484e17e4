//! Dependency cycles of files: each file takes something from the next, and so indirectly from itself.

use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};

use super::edges::{Edges, Unresolved, edges};
use super::modules::{Tree, Unreadable};

/// Files of a crate that form a cycle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Circle {
    /// Edges among its files.
    pub ties: Vec<Tie>,
}

/// Names that one file of a cycle takes from another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tie {
    /// The file that uses the names.
    pub from: PathBuf,
    /// The file that defines them.
    pub to: PathBuf,
    /// The names.
    pub names: Vec<String>,
}

impl Circle {
    /// Returns the files of the cycle.
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

/// Files and dependencies of a crate.
#[derive(Debug)]
pub struct Survey {
    /// Every file that a `mod` reaches from the root file.
    pub files: Vec<PathBuf>,
    /// Cycles of files, without those compiled only for tests.
    pub circles: Vec<Circle>,
    /// Paths of this crate that lead to no known item.
    pub unresolved: Vec<Unresolved>,
}

/// Surveys the crate with the root file `root`.
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
    let reachable_files: Vec<_> = (0..tree.files.len())
        .map(|file| reachable(file, edges))
        .collect();
    let mut cycles = Vec::new();
    let mut visited = BTreeSet::new();
    for file in 0..tree.files.len() {
        if !reachable_files[file].contains(&file) || visited.contains(&file) {
            continue;
        }
        let members: BTreeSet<_> = reachable_files[file]
            .iter()
            .copied()
            .filter(|member| reachable_files[*member].contains(&file))
            .collect();
        let is_inside =
            |(from, to): &(usize, usize)| members.contains(from) && members.contains(to);
        let ties = edges.iter().filter(|(ends, _)| is_inside(ends));
        cycles.push(Circle {
            ties: ties
                .map(|(&(from, to), names)| Tie {
                    from: tree.files[from].clone(),
                    to: tree.files[to].clone(),
                    names: names.iter().cloned().collect(),
                })
                .collect(),
        });
        visited.extend(members);
    }
    cycles
}

/// Returns the files that `from` depends on, directly or through others.
fn reachable(from: usize, edges: &Edges) -> BTreeSet<usize> {
    let (mut files, mut queue) = (BTreeSet::new(), vec![from]);
    while let Some(file) = queue.pop() {
        let outgoing = edges.range((file, 0)..=(file, usize::MAX));
        for (&(_, to), _) in outgoing {
            if files.insert(to) {
                queue.push(to);
            }
        }
    }
    files
}
