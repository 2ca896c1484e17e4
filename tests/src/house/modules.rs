//! The modules of a crate, read from its root file down through every `mod`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::code::{Body, Declaration};

/// A crate's modules and their files.
#[derive(Debug)]
pub struct Tree {
    /// Files, the root first.
    pub files: Vec<PathBuf>,
    /// Modules, the root first.
    pub modules: Vec<Module>,
}

/// One module.
#[derive(Debug)]
pub struct Module {
    /// The module that declares it; `None` for the root.
    pub parent: Option<usize>,
    /// The file with its code.
    pub file: usize,
    /// Whether it is compiled only for tests.
    pub test: bool,
    /// Modules that it declares, by name: several if `cfg` chooses among them.
    pub children: BTreeMap<String, Vec<usize>>,
    /// Its code.
    pub body: Body,
}

/// A source tree that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum Unreadable {
    /// A file or folder cannot be read.
    #[error("cannot read {path}: {error}")]
    Disk {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        error: std::io::Error,
    },
    /// A file is not valid Rust.
    #[error("cannot parse {path}: {error}")]
    NotRust {
        /// The file.
        path: PathBuf,
        /// The parser's error.
        error: syn::Error,
    },
    /// A module's file does not exist.
    #[error("{file} declares `mod {name};`, which has no file")]
    NoFile {
        /// The declaring file.
        file: PathBuf,
        /// The module.
        name: String,
    },
}

impl Tree {
    /// Reads the crate with the root file `root`.
    ///
    /// # Errors
    /// When a file cannot be read or parsed, or a declared module has no file.
    pub fn read(root: &Path) -> Result<Self, Unreadable> {
        let mut tree = Self {
            files: Vec::new(),
            modules: Vec::new(),
        };
        let folder = root.parent().unwrap_or(Path::new("")).to_owned();
        tree.file(root, &folder, None, false)?;
        Ok(tree)
    }

    /// Reads a module's file; its child modules lie in `folder`.
    fn file(
        &mut self,
        path: &Path,
        folder: &Path,
        parent: Option<usize>,
        test: bool,
    ) -> Result<usize, Unreadable> {
        let text = std::fs::read_to_string(path).map_err(|error| Unreadable::Disk {
            path: path.to_owned(),
            error,
        })?;
        let syntax = syn::parse_file(&text).map_err(|error| Unreadable::NotRust {
            path: path.to_owned(),
            error,
        })?;
        let file = self.files.len();
        self.files.push(path.to_owned());
        self.module(Body::new(&syntax.items), file, folder, parent, test)
    }

    fn module(
        &mut self,
        mut body: Body,
        file: usize,
        folder: &Path,
        parent: Option<usize>,
        test: bool,
    ) -> Result<usize, Unreadable> {
        let declarations = std::mem::take(&mut body.modules);
        let index = self.modules.len();
        self.modules.push(Module {
            parent,
            file,
            test,
            children: BTreeMap::new(),
            body,
        });
        for child in declarations {
            let name = child.name.clone();
            let children = self.read_declared(child, index, file, folder)?;
            let siblings = self.modules[index].children.entry(name).or_default();
            siblings.extend(children);
        }
        Ok(index)
    }

    /// Reads the module declared by `mod name;` or `mod name { … }`: several modules if `cfg` chooses among files.
    fn read_declared(
        &mut self,
        child: Declaration,
        parent: usize,
        file: usize,
        folder: &Path,
    ) -> Result<Vec<usize>, Unreadable> {
        let test = child.test || self.modules[parent].test;
        let child_folder = folder.join(&child.name);
        if let Some(body) = child.body {
            let module = self.module(body, file, &child_folder, Some(parent), test)?;
            return Ok(vec![module]);
        }
        let declaring_file = self.files[file].clone();
        let sibling_folder = declaring_file.parent().unwrap_or(Path::new(""));
        // Each candidate with the folder of its child modules.
        let mut candidates: Vec<_> = child
            .paths
            .iter()
            .map(|path| sibling_folder.join(path))
            .collect();
        candidates.push(child_folder.join("mod.rs"));
        let mut candidates: Vec<_> = candidates
            .into_iter()
            .map(|path| (path.parent().unwrap_or(Path::new("")).to_owned(), path))
            .collect();
        let path = folder.join(format!("{}.rs", child.name));
        candidates.push((child_folder, path));
        candidates.retain(|(_, path)| path.is_file());
        if candidates.is_empty() {
            return Err(Unreadable::NoFile {
                file: declaring_file,
                name: child.name,
            });
        }
        candidates
            .iter()
            .map(|(child_folder, path)| self.file(path, child_folder, Some(parent), test))
            .collect()
    }
}
