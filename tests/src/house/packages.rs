//! Packages of the workspace, their dependencies, and the table of allowed dependencies in ARCHITECTURE.md.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use cargo_metadata::{DependencyKind, MetadataCommand};

/// A package of the workspace.
#[derive(Debug, Clone)]
pub struct Package {
    /// Its name.
    pub name: String,
    /// Folder of its Cargo.toml.
    pub folder: PathBuf,
    /// Root file of its library, if it has one.
    pub library: Option<PathBuf>,
    /// Root files of its binaries.
    pub binaries: Vec<PathBuf>,
    /// Packages of the workspace that it uses.
    pub uses: BTreeSet<String>,
    /// Packages of the workspace that only its tests, benchmarks and examples use.
    pub tests_use: BTreeSet<String>,
}

impl Package {
    /// Returns the folder of its source files.
    pub fn source(&self) -> PathBuf {
        self.folder.join("src")
    }

    /// Returns the root files of its library and binaries.
    pub fn roots(&self) -> impl Iterator<Item = &Path> {
        let roots = self.library.iter().chain(&self.binaries);
        roots.map(PathBuf::as_path)
    }
}

/// Returns the packages of the workspace in `folder`.
///
/// # Errors
/// When cargo cannot read their manifests.
pub fn packages(folder: &Path) -> Result<Vec<Package>, cargo_metadata::Error> {
    let metadata = MetadataCommand::new()
        .manifest_path(folder.join("Cargo.toml"))
        .no_deps()
        .exec()?;
    let package = |package: &cargo_metadata::Package| {
        let roots = |is_kind: fn(&cargo_metadata::Target) -> bool| {
            let targets = package.targets.iter().filter(move |target| is_kind(target));
            targets.map(|target| target.src_path.clone().into_std_path_buf())
        };
        let dependencies = |is_test: bool| {
            package
                .dependencies
                .iter()
                .filter(|dependency| (dependency.kind == DependencyKind::Development) == is_test)
                .filter(|dependency| dependency.path.is_some())
                .map(|dependency| dependency.name.clone())
                .collect::<BTreeSet<_>>()
        };
        let manifest = package.manifest_path.as_std_path();
        let uses = dependencies(false);
        Package {
            name: package.name.to_string(),
            folder: manifest.parent().unwrap_or(Path::new("")).to_owned(),
            // A dynamically loaded library (cdylib) counts as a library too.
            library: roots(|target| target.is_lib() || target.is_cdylib()).next(),
            binaries: roots(cargo_metadata::Target::is_bin).collect(),
            tests_use: dependencies(true).difference(&uses).cloned().collect(),
            uses,
        }
    };
    Ok(metadata.packages.iter().map(package).collect())
}

/// One row of the table "Allowed edges".
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row {
    /// The package.
    pub package: String,
    /// Packages that it may use.
    pub uses: BTreeSet<String>,
    /// Packages that its tests, benchmarks and examples may use too, from an optional third column.
    pub tests_use: BTreeSet<String>,
}

/// A disagreement between the table and the workspace.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// A package is not in the table.
    #[error("`{package}` is missing from the table")]
    NotInTable {
        /// The package.
        package: String,
    },
    /// The table names a package that the workspace does not have.
    #[error("the table names `{package}`, which is no package of the workspace")]
    NoSuchPackage {
        /// The package.
        package: String,
    },
    /// A package has two rows.
    #[error("`{package}` has more than one row")]
    Twice {
        /// The package.
        package: String,
    },
    /// A package uses a package that its row does not allow.
    #[error("`{package}` uses `{used}`, which its row does not allow")]
    NotAllowed {
        /// The package.
        package: String,
        /// The package used.
        used: String,
    },
    /// The tests of a package use a package that its row allows neither to it nor to them.
    #[error("the tests of `{package}` use `{used}`, which its row does not allow")]
    NotAllowedInTests {
        /// The package.
        package: String,
        /// The package used.
        used: String,
    },
    /// A row allows a package that is below it in the table.
    #[error("`{package}` may use `{used}`, which stands below it in the table")]
    Upward {
        /// The package.
        package: String,
        /// The package below.
        used: String,
    },
}

/// Returns the first name between backquotes in each cell of the table after the line `heading`.
fn table(text: &str, heading: &str) -> Vec<Vec<String>> {
    text.lines()
        .skip_while(|line| *line != heading)
        .skip_while(|line| !line.starts_with("| ---"))
        .skip(1)
        .take_while(|line| line.starts_with('|'))
        .map(|line| line.split('|').skip(1).map(str::to_owned).collect())
        .collect()
}

/// Returns the texts between backquotes.
fn quoted_names(cell: &str) -> impl Iterator<Item = String> {
    cell.split('`').skip(1).step_by(2).map(str::to_owned)
}

/// Heading of the table of edges between packages.
pub const PACKAGES: &str = "## Allowed edges";
/// Heading of the table of edges between folders.
pub const FOLDERS: &str = "## Folders";

/// Reads the first table after the line `heading` of ARCHITECTURE.md.
pub fn rows(architecture: &str, heading: &str) -> Vec<Row> {
    let names = |cells: &[String], column: usize| -> BTreeSet<String> {
        cells
            .get(column)
            .into_iter()
            .flat_map(|c| quoted_names(c))
            .collect()
    };
    table(architecture, heading)
        .iter()
        .map(|cells| Row {
            package: quoted_names(&cells[0]).next().unwrap_or_default(),
            uses: names(cells, 1),
            tests_use: names(cells, 2),
        })
        .collect()
}

/// Returns the packages that the first table of ARCHITECTURE.md marks as pure with a plain "yes".
pub fn pure_packages(architecture: &str) -> BTreeSet<String> {
    table(architecture, "## Packages")
        .iter()
        .filter(|cells| cells.get(3).is_some_and(|pure| pure.trim() == "yes"))
        .filter_map(|cells| quoted_names(&cells[1]).next())
        .collect()
}

/// Returns the folders of `rows` as if each were a package, which uses the folders that its packages use. A package belongs to
/// the row with the longest path to it.
///
/// # Errors
/// The name of a package in no folder of `rows`.
pub fn folders(
    rows: &[Row],
    packages: &[Package],
    workspace: &Path,
) -> Result<Vec<Package>, String> {
    let folder_of = |package: &Package| {
        let path = package.folder.strip_prefix(workspace).ok()?;
        let names = rows.iter().map(|row| row.package.as_str());
        names
            .filter(|name| path.starts_with(name))
            .max_by_key(|name| name.len())
    };
    let mut folders = BTreeMap::new();
    for package in packages {
        let name = folder_of(package).ok_or(&package.name)?;
        folders.insert(package.name.as_str(), name);
    }
    let used_folders = |name: &str, uses: fn(&Package) -> &BTreeSet<String>| {
        let inside = packages
            .iter()
            .filter(|package| folders[package.name.as_str()] == name);
        let used = inside
            .flat_map(uses)
            .filter_map(|used| folders.get(used.as_str()));
        used.filter(|used| **used != name)
            .map(|used| (*used).to_owned())
            .collect::<BTreeSet<_>>()
    };
    let folder = |row: &Row| {
        let uses = used_folders(&row.package, |package| &package.uses);
        let tests_use = used_folders(&row.package, |package| &package.tests_use);
        Package {
            name: row.package.clone(),
            folder: workspace.join(&row.package),
            library: None,
            binaries: Vec::new(),
            tests_use: tests_use.difference(&uses).cloned().collect(),
            uses,
        }
    };
    Ok(rows.iter().map(folder).collect())
}

/// Compares the table with the workspace. The order of the rows is the order of the packages: each may use only those above it.
pub fn faults(rows: &[Row], packages: &[Package]) -> Vec<Fault> {
    let mut faults = Vec::new();
    let exists = |name: &str| packages.iter().any(|package| package.name == name);
    let mut earlier_rows = BTreeSet::new();
    for row in rows {
        let package = row.package.clone();
        if !exists(&package) {
            let package = package.clone();
            faults.push(Fault::NoSuchPackage { package });
        }
        for used in row.uses.union(&row.tests_use) {
            let (package, used) = (package.clone(), used.clone());
            if !exists(&used) {
                faults.push(Fault::NoSuchPackage { package: used });
            } else if !earlier_rows.contains(&used) {
                faults.push(Fault::Upward { package, used });
            }
        }
        if !earlier_rows.insert(package.clone()) {
            faults.push(Fault::Twice { package });
        }
    }
    for Package {
        name,
        uses,
        tests_use,
        ..
    } in packages
    {
        let Some(row) = rows.iter().find(|row| row.package == *name) else {
            let package = name.clone();
            faults.push(Fault::NotInTable { package });
            continue;
        };
        for used in uses.difference(&row.uses) {
            let (package, used) = (name.clone(), used.clone());
            faults.push(Fault::NotAllowed { package, used });
        }
        for used in tests_use.difference(&row.uses) {
            if !row.tests_use.contains(used) {
                let (package, used) = (name.clone(), used.clone());
                faults.push(Fault::NotAllowedInTests { package, used });
            }
        }
    }
    faults
}
