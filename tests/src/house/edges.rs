//! Dependencies between the files of a crate, with the names used.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use super::code::{Import, Named, Reach};
use super::modules::Tree;

/// Names that one file takes from another, by (user, definer); a file is its index in [`Tree::files`].
pub type Edges = BTreeMap<(usize, usize), BTreeSet<String>>;

/// A path that begins with `crate`, `self` or `super` and leads to no known item.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
#[error("{file}: `{path}` leads to no known item")]
pub struct Unresolved {
    /// The file that names the path.
    pub file: PathBuf,
    /// The path.
    pub path: String,
}

/// Target of a path.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Target {
    Item { file: usize, name: String },
    Module(usize),
}

/// Targets found for a name.
#[derive(Debug, Default)]
struct Found {
    targets: BTreeSet<Target>,
    /// Whether the name may belong to another crate.
    outside: bool,
}

impl Found {
    fn is_empty(&self) -> bool {
        self.targets.is_empty() && !self.outside
    }

    fn add(&mut self, other: Self) {
        self.targets.extend(other.targets);
        self.outside |= other.outside;
    }
}

/// Module and name of each lookup in progress, and whether the path continues after the name. Globs and imports may lead back
/// to them. In `pub use gap::gap` the first step is the module and the second the function of the same name.
type Seen = BTreeSet<(usize, String, bool)>;

/// Returns the edges between the crate's files, and the paths that lead to no known item.
///
/// A re-export (`pub use`) is not an edge: each user of the name depends on the file that defines it. So a parent that only
/// declares its modules and re-exports their items depends on none of them. A private import is an edge, used or not.
pub fn edges(tree: &Tree) -> (Edges, Vec<Unresolved>) {
    let mut walk = Walk {
        tree,
        edges: Edges::new(),
        unresolved: BTreeSet::new(),
    };
    for (index, module) in tree.modules.iter().enumerate() {
        if module.test {
            continue;
        }
        for import in &module.body.imports {
            walk.import(index, import);
        }
        for named in &module.body.paths {
            walk.named(index, named);
        }
    }
    (walk.edges, walk.unresolved.into_iter().collect())
}

struct Walk<'t> {
    tree: &'t Tree,
    edges: Edges,
    unresolved: BTreeSet<Unresolved>,
}

impl Walk<'_> {
    fn import(&mut self, from: usize, import: &Import) {
        let found = resolve(self.tree, from, &import.path, &mut Seen::new());
        self.require(from, &import.path, &found);
        if import.reach == Reach::Outside {
            return;
        }
        for target in &found.targets {
            match target {
                Target::Module(module) if import.name.is_none() => {
                    let module = &self.tree.modules[*module];
                    if !module.body.items.is_empty() {
                        self.edge(from, module.file, "*");
                    }
                }
                Target::Module(_) => {}
                Target::Item { file, name } => self.edge(from, *file, name),
            }
        }
    }

    fn named(&mut self, from: usize, named: &Named) {
        let body = &self.tree.modules[from].body;
        if let [name] = &named.path[..]
            && body.bound.contains(name)
            && !named.is_macro
        {
            return;
        }
        let mut found = resolve(self.tree, from, &named.path, &mut Seen::new());
        if found.targets.is_empty() && named.is_macro {
            found.targets = self.textual(from, &named.path);
        }
        self.require(from, &named.path, &found);
        for target in found.targets {
            if let Target::Item { file, name } = target {
                self.edge(from, file, &name);
            }
        }
    }

    /// Finds a macro that an enclosing module defines textually before this place.
    fn textual(&self, from: usize, path: &[String]) -> BTreeSet<Target> {
        let mut above = self.tree.modules[from].parent;
        while let ([name], Some(module)) = (path, above) {
            let module = &self.tree.modules[module];
            if module.body.items.contains_key(name) {
                let (file, name) = (module.file, name.clone());
                return [Target::Item { file, name }].into();
            }
            above = module.parent;
        }
        BTreeSet::new()
    }

    fn edge(&mut self, from: usize, to: usize, name: &str) {
        let from = self.tree.modules[from].file;
        if from != to {
            let names = self.edges.entry((from, to)).or_default();
            names.insert(name.to_owned());
        }
    }

    /// Requires that a path beginning in this crate resolves, at least to a module where a macro may define the item.
    fn require(&mut self, from: usize, path: &[String], found: &Found) {
        let anchors = path
            .iter()
            .take_while(|name| ["crate", "self", "super"].contains(&name.as_str()))
            .count();
        if anchors == 0 || !found.is_empty() {
            return;
        }
        for known in (anchors..path.len()).rev() {
            let found = resolve(self.tree, from, &path[..known], &mut Seen::new());
            let Some(Target::Module(module)) = found.targets.first() else {
                continue;
            };
            let module = &self.tree.modules[*module];
            if module.body.makes_items && known + 1 == path.len() {
                return self.edge(from, module.file, &path[known]);
            }
            break;
        }
        let file = self.tree.modules[from].file;
        self.unresolved.insert(Unresolved {
            file: self.tree.files[file].clone(),
            path: path.join("::"),
        });
    }
}

fn resolve(tree: &Tree, from: usize, path: &[String], seen: &mut Seen) -> Found {
    let (mut module, mut rest) = (from, path);
    let mut anchored = false;
    while let Some((first, after)) = rest.split_first() {
        module = match first.as_str() {
            "crate" => 0,
            "self" => module,
            "super" => match tree.modules[module].parent {
                Some(parent) => parent,
                None => return Found::default(),
            },
            _ => break,
        };
        (anchored, rest) = (true, after);
    }
    if rest.is_empty() {
        return Found {
            targets: [Target::Module(module)].into(),
            outside: false,
        };
    }
    let found = walk(tree, module, rest, seen, Some(from).filter(|_| !anchored));
    Found {
        outside: found.outside || !anchored && found.targets.is_empty(),
        ..found
    }
}

/// Follows `path` down from `module`; imports inside the functions of the module `function` count too.
fn walk(
    tree: &Tree,
    module: usize,
    path: &[String],
    seen: &mut Seen,
    function: Option<usize>,
) -> Found {
    let goes_on = path.len() > 1;
    let first = look_up(tree, module, (&path[0], goes_on), seen, function);
    if !goes_on {
        return first;
    }
    let mut found = Found {
        targets: BTreeSet::new(),
        outside: first.outside,
    };
    let mut items = BTreeSet::new();
    for target in first.targets {
        match target {
            Target::Module(child) => found.add(walk(tree, child, &path[1..], seen, None)),
            item => {
                items.insert(item);
            }
        }
    }
    // The path continues inside an item, as `Type::function`, unless a module of this name has the rest of the path.
    if found.targets.is_empty() {
        found.targets = items;
    }
    found
}

fn look_up(
    tree: &Tree,
    index: usize,
    (name, goes_on): (&str, bool),
    seen: &mut Seen,
    function: Option<usize>,
) -> Found {
    let mut found = Found::default();
    let looking = (index, name.to_owned(), goes_on);
    if !seen.insert(looking.clone()) {
        return found;
    }
    let module = &tree.modules[index];
    if module.body.items.contains_key(name) {
        found.targets.insert(Target::Item {
            file: module.file,
            name: name.to_owned(),
        });
    } else if index == 0 {
        for module in &tree.modules {
            if module.body.exported_macros.iter().any(|made| made == name) {
                let (file, name) = (module.file, name.to_owned());
                found.targets.insert(Target::Item { file, name });
            }
        }
    }
    for child in module.children.get(name).into_iter().flatten() {
        found.targets.insert(Target::Module(*child));
    }
    let holds = |import: &&Import| import.reach != Reach::Function || function == Some(index);
    let imports = || module.body.imports.iter().filter(holds);
    for import in imports().filter(|import| import.name.as_deref() == Some(name)) {
        found.add(resolve(tree, index, &import.path, seen));
    }
    if found.is_empty() {
        for import in imports().filter(|import| import.name.is_none()) {
            found.add(through_glob(tree, index, import, (name, goes_on), seen));
        }
    }
    seen.remove(&looking);
    found
}

fn through_glob(
    tree: &Tree,
    from: usize,
    glob: &Import,
    name: (&str, bool),
    seen: &mut Seen,
) -> Found {
    // The glob's path is looked up with a fresh `seen`: it may contain the name that is being looked up.
    let from_where = resolve(tree, from, &glob.path, &mut seen.clone());
    let mut found = Found {
        targets: BTreeSet::new(),
        outside: from_where.outside,
    };
    for target in from_where.targets {
        match target {
            Target::Module(module) => found.add(look_up(tree, module, name, seen, None)),
            Target::Item { file, name: of } => {
                let has_variant = tree.modules.iter().any(|module| {
                    let variants = module.body.items.get(&of).filter(|_| module.file == file);
                    variants.is_some_and(|variants| variants.iter().any(|v| v == name.0))
                });
                if has_variant {
                    found.targets.insert(Target::Item { file, name: of });
                }
            }
        }
    }
    found
}
