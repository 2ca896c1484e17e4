//! Dependencies between the files of a crate, with the names used.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use super::code::{Import, NamedPath, Reach};
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
struct Resolution {
    targets: BTreeSet<Target>,
    /// Whether the name may belong to another crate.
    may_be_external: bool,
}

impl Resolution {
    fn is_empty(&self) -> bool {
        self.targets.is_empty() && !self.may_be_external
    }

    fn add(&mut self, other: Self) {
        self.targets.extend(other.targets);
        self.may_be_external |= other.may_be_external;
    }
}

/// Module and name of each lookup in progress, and whether the path continues after the name. Globs and imports may lead back
/// to them. In `pub use gap::gap` the first step is the module and the second the function of the same name.
type Visited = BTreeSet<(usize, String, bool)>;

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
        for path in &module.body.paths {
            walk.path(index, path);
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
        let resolution = resolve(self.tree, from, &import.path, &mut Visited::new());
        self.require(from, &import.path, &resolution);
        if import.reach == Reach::Outside {
            return;
        }
        for target in &resolution.targets {
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

    fn path(&mut self, from: usize, path: &NamedPath) {
        let body = &self.tree.modules[from].body;
        if let [name] = &path.path[..]
            && body.bindings.contains(name)
            && !path.is_macro
        {
            return;
        }
        let mut resolution = resolve(self.tree, from, &path.path, &mut Visited::new());
        if resolution.targets.is_empty() && path.is_macro {
            resolution.targets = self.textual_macros(from, &path.path);
        }
        self.require(from, &path.path, &resolution);
        for target in resolution.targets {
            if let Target::Item { file, name } = target {
                self.edge(from, file, &name);
            }
        }
    }

    /// Finds a macro that an enclosing module defines textually before this place.
    fn textual_macros(&self, from: usize, path: &[String]) -> BTreeSet<Target> {
        let mut ancestor = self.tree.modules[from].parent;
        while let ([name], Some(module)) = (path, ancestor) {
            let module = &self.tree.modules[module];
            if module.body.items.contains_key(name) {
                let (file, name) = (module.file, name.clone());
                return [Target::Item { file, name }].into();
            }
            ancestor = module.parent;
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
    fn require(&mut self, from: usize, path: &[String], resolution: &Resolution) {
        let anchors = path
            .iter()
            .take_while(|name| ["crate", "self", "super"].contains(&name.as_str()))
            .count();
        if anchors == 0 || !resolution.is_empty() {
            return;
        }
        for length in (anchors..path.len()).rev() {
            let resolution = resolve(self.tree, from, &path[..length], &mut Visited::new());
            let Some(Target::Module(module)) = resolution.targets.first() else {
                continue;
            };
            let module = &self.tree.modules[*module];
            if module.body.makes_items && length + 1 == path.len() {
                return self.edge(from, module.file, &path[length]);
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

fn resolve(tree: &Tree, from: usize, path: &[String], visited: &mut Visited) -> Resolution {
    let (mut module, mut rest) = (from, path);
    let mut is_anchored = false;
    while let Some((segment, remainder)) = rest.split_first() {
        module = match segment.as_str() {
            "crate" => 0,
            "self" => module,
            "super" => match tree.modules[module].parent {
                Some(parent) => parent,
                None => return Resolution::default(),
            },
            _ => break,
        };
        (is_anchored, rest) = (true, remainder);
    }
    if rest.is_empty() {
        return Resolution {
            targets: [Target::Module(module)].into(),
            may_be_external: false,
        };
    }
    let resolution = walk(
        tree,
        module,
        rest,
        visited,
        Some(from).filter(|_| !is_anchored),
    );
    Resolution {
        may_be_external: resolution.may_be_external
            || !is_anchored && resolution.targets.is_empty(),
        ..resolution
    }
}

/// Follows `path` down from `module`; imports inside the functions of the module `function` count too.
fn walk(
    tree: &Tree,
    module: usize,
    path: &[String],
    visited: &mut Visited,
    function: Option<usize>,
) -> Resolution {
    let has_more = path.len() > 1;
    let head = look_up(tree, module, (&path[0], has_more), visited, function);
    if !has_more {
        return head;
    }
    let mut resolution = Resolution {
        targets: BTreeSet::new(),
        may_be_external: head.may_be_external,
    };
    let mut items = BTreeSet::new();
    for target in head.targets {
        match target {
            Target::Module(child) => resolution.add(walk(tree, child, &path[1..], visited, None)),
            item => {
                items.insert(item);
            }
        }
    }
    // The path continues inside an item, as `Type::function`, unless a module of this name has the rest of the path.
    if resolution.targets.is_empty() {
        resolution.targets = items;
    }
    resolution
}

fn look_up(
    tree: &Tree,
    index: usize,
    (name, has_more): (&str, bool),
    visited: &mut Visited,
    function: Option<usize>,
) -> Resolution {
    let mut resolution = Resolution::default();
    let key = (index, name.to_owned(), has_more);
    if !visited.insert(key.clone()) {
        return resolution;
    }
    let module = &tree.modules[index];
    if module.body.items.contains_key(name) {
        resolution.targets.insert(Target::Item {
            file: module.file,
            name: name.to_owned(),
        });
    } else if index == 0 {
        for module in &tree.modules {
            if module
                .body
                .exported_macros
                .iter()
                .any(|exported| exported == name)
            {
                let (file, name) = (module.file, name.to_owned());
                resolution.targets.insert(Target::Item { file, name });
            }
        }
    }
    for child in module.children.get(name).into_iter().flatten() {
        resolution.targets.insert(Target::Module(*child));
    }
    let is_visible = |import: &&Import| import.reach != Reach::Function || function == Some(index);
    let imports = || module.body.imports.iter().filter(is_visible);
    for import in imports().filter(|import| import.name.as_deref() == Some(name)) {
        resolution.add(resolve(tree, index, &import.path, visited));
    }
    if resolution.is_empty() {
        for import in imports().filter(|import| import.name.is_none()) {
            resolution.add(resolve_glob(tree, index, import, (name, has_more), visited));
        }
    }
    visited.remove(&key);
    resolution
}

fn resolve_glob(
    tree: &Tree,
    from: usize,
    glob: &Import,
    name: (&str, bool),
    visited: &mut Visited,
) -> Resolution {
    // The glob's path is looked up with a fresh `visited`: it may contain the name that is being looked up.
    let sources = resolve(tree, from, &glob.path, &mut visited.clone());
    let mut resolution = Resolution {
        targets: BTreeSet::new(),
        may_be_external: sources.may_be_external,
    };
    for target in sources.targets {
        match target {
            Target::Module(module) => resolution.add(look_up(tree, module, name, visited, None)),
            Target::Item { file, name: item } => {
                let has_variant = tree.modules.iter().any(|module| {
                    let variants = module.body.items.get(&item).filter(|_| module.file == file);
                    variants.is_some_and(|variants| variants.iter().any(|v| v == name.0))
                });
                if has_variant {
                    resolution.targets.insert(Target::Item { file, name: item });
                }
            }
        }
    }
    resolution
}
