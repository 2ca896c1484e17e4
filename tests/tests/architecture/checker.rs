//! Tests of the checker on small source trees: each breaks one rule and must be detected, or keeps all rules and must pass.

use std::path::Path;

use bench_tests::house::circles::{Survey, survey};
use bench_tests::house::modules::Unreadable;
use bench_tests::house::packages::{
    FOLDERS, Fault, PACKAGES, Package, faults, folders, packages, pure_packages, rows,
};
use bench_tests::house::sizes::{TooLong, large_package, long_files};
use tempfile::TempDir;

/// Writes files at their paths in a new folder.
pub fn tree(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (path, text) in files {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    folder
}

/// Surveys the crate of `files` with the root `lib.rs`.
fn survey_files(files: &[(&str, &str)]) -> Survey {
    let folder = tree(files);
    survey(&folder.path().join("lib.rs")).unwrap()
}

/// Returns the ties of the only cycle, as "from > to: names", with the files' names.
fn only_circle(files: &[(&str, &str)]) -> Vec<String> {
    let survey = survey_files(files);
    assert_eq!(survey.unresolved, []);
    let [circle] = &survey.circles[..] else {
        panic!("{:?}", survey.circles);
    };
    let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_owned();
    let ties = circle.ties.iter();
    ties.map(|tie| {
        let (from, to, names) = (name(&tie.from), name(&tie.to), tie.names.join(" "));
        format!("{from} > {to}: {names}")
    })
    .collect()
}

fn no_circle(files: &[(&str, &str)]) {
    let survey = survey_files(files);
    assert_eq!((survey.circles, survey.unresolved), (vec![], vec![]));
}

const LIB: (&str, &str) = ("lib.rs", "mod a;\nmod b;");

#[test]
fn two_files_that_use_each_other_are_a_circle() {
    let ties = only_circle(&[
        LIB,
        ("a.rs", "use crate::b::B;\npub struct A(B);"),
        ("b.rs", "use super::a::A;\npub struct B(Box<A>);"),
    ]);
    assert_eq!(ties, ["a.rs > b.rs: B", "b.rs > a.rs: A"]);
}

#[test]
fn a_child_using_an_item_of_its_calling_parent_closes_a_circle() {
    let ties = only_circle(&[
        (
            "lib.rs",
            "mod child;\npub struct Own;\npub fn run() { child::go(Own) }",
        ),
        ("child.rs", "use super::Own;\npub fn go(_: Own) {}"),
    ]);
    assert_eq!(ties, ["lib.rs > child.rs: go", "child.rs > lib.rs: Own"]);
}

#[test]
fn a_glob_import_of_the_parent_is_an_edge() {
    let ties = only_circle(&[
        (
            "lib.rs",
            "mod child;\npub struct Own;\npub fn run() { child::go(Own) }",
        ),
        ("child.rs", "use super::*;\npub fn go(_: Own) {}"),
    ]);
    assert_eq!(ties, ["lib.rs > child.rs: go", "child.rs > lib.rs: * Own"]);
}

#[test]
fn a_re_export_leads_to_the_defining_file() {
    let ties = only_circle(&[
        ("lib.rs", "mod a;\nmod b;\npub use b::B as Renamed;"),
        ("a.rs", "use crate::Renamed;\npub struct A(Renamed);"),
        ("b.rs", "use crate::a;\npub struct B(Box<a::A>);"),
    ]);
    assert_eq!(ties, ["a.rs > b.rs: B", "b.rs > a.rs: A"]);
}

#[test]
fn a_function_of_its_modules_name_is_found_through_its_re_export() {
    let ties = only_circle(&[
        ("lib.rs", "mod a;\nmod figures;"),
        (
            "a.rs",
            "use crate::figures;\npub struct A;\npub fn f() { figures::model(&A) }",
        ),
        ("figures/mod.rs", "mod model;\npub use model::model;"),
        (
            "figures/model.rs",
            "use crate::a::A;\npub fn model(_: &A) {}",
        ),
    ]);
    assert_eq!(ties, ["a.rs > model.rs: model", "model.rs > a.rs: A"]);
}

#[test]
fn a_parent_that_re_exports_closes_no_circle() {
    no_circle(&[
        ("lib.rs", "mod house;\npub use house::*;"),
        (
            "house/mod.rs",
            "mod a;\nmod b;\npub use self::{a::A, b::*};",
        ),
        ("house/a.rs", "pub struct A(super::B);"),
        ("house/b.rs", "pub struct B;\npub enum Way { Out }"),
    ]);
}

#[test]
fn a_parent_that_uses_its_re_export_has_an_edge() {
    let ties = only_circle(&[
        (
            "lib.rs",
            "mod a;\npub use a::A;\npub const N: usize = 1;\npub fn make() -> A { todo!() }",
        ),
        ("a.rs", "pub struct A([u8; crate::N]);"),
    ]);
    assert_eq!(ties, ["lib.rs > a.rs: A", "a.rs > lib.rs: N"]);
}

#[test]
fn a_path_in_an_expression_is_an_edge() {
    let ties = only_circle(&[
        LIB,
        ("a.rs", "pub fn f() -> u8 { crate::b::g() }"),
        ("b.rs", "pub fn g() -> u8 { crate::a::f() }"),
    ]);
    assert_eq!(ties, ["a.rs > b.rs: g", "b.rs > a.rs: f"]);
}

#[test]
fn a_path_in_the_arguments_of_a_macro_is_an_edge() {
    let ties = only_circle(&[
        LIB,
        ("a.rs", "pub fn f() { assert_eq!(1, super::b::g(2)); }"),
        (
            "b.rs",
            "use crate::a;\npub fn g(n: u8) -> u8 { println!(\"{:?}\", a::f()); n }",
        ),
    ]);
    assert_eq!(ties, ["a.rs > b.rs: g", "b.rs > a.rs: f"]);
}

#[test]
fn a_path_in_an_attribute_of_serde_is_an_edge() {
    let ties = only_circle(&[
        LIB,
        (
            "a.rs",
            "#[derive(Deserialize)]\npub struct A {\n#[serde(default = \"crate::b::g\")]\nn: u8 }",
        ),
        ("b.rs", "pub fn g() -> u8 { let a: crate::a::A; 1 }"),
    ]);
    assert_eq!(ties, ["a.rs > b.rs: g", "b.rs > a.rs: A"]);
}

#[test]
fn imports_in_groups_in_functions_and_of_variants_are_edges() {
    let ties = only_circle(&[
        LIB,
        (
            "a.rs",
            "pub enum A { One }\npub fn f() { use crate::{b::{self, G as H}}; b::g(); H; }",
        ),
        (
            "b.rs",
            "use crate::a::A::{self, *};\npub fn g() -> A { One }\npub struct G;",
        ),
    ]);
    assert_eq!(ties, ["a.rs > b.rs: G g", "b.rs > a.rs: A"]);
}

#[test]
fn a_macro_call_is_an_edge() {
    let ties = only_circle(&[
        (
            "lib.rs",
            "macro_rules! one { () => { 1 } }\nmod a;\npub fn f() -> u8 { a::g() }",
        ),
        ("a.rs", "pub fn g() -> u8 { one!() }"),
    ]);
    assert_eq!(ties, ["lib.rs > a.rs: g", "a.rs > lib.rs: one"]);
}

#[test]
fn a_circle_of_three_files_excludes_their_other_dependencies() {
    let ties = only_circle(&[
        ("lib.rs", "mod a;\nmod b;\nmod c;\nmod d;"),
        ("a.rs", "pub fn a() { crate::b::b() }"),
        ("b.rs", "pub fn b() { crate::c::c() }"),
        ("c.rs", "pub fn c() { crate::a::a(); crate::d::d() }"),
        ("d.rs", "pub fn d() {}"),
    ]);
    assert_eq!(ties, ["a.rs > b.rs: b", "b.rs > c.rs: c", "c.rs > a.rs: a"]);
}

#[test]
fn code_for_tests_closes_no_circle() {
    no_circle(&[
        LIB,
        (
            "a.rs",
            "pub struct A;\n#[cfg(test)]\nmod tests;\n#[cfg(test)]\nuse crate::b::B;\n\
             impl A {\n#[cfg(test)]\nfn b(&self) -> B { todo!() } }",
        ),
        ("a/tests.rs", "use crate::b::B;"),
        ("b.rs", "pub struct B(crate::a::A);"),
    ]);
}

#[test]
fn code_under_cfg_not_test_closes_a_circle() {
    let ties = only_circle(&[
        LIB,
        ("a.rs", "pub struct A;\n#[cfg(not(test))]\nuse crate::b::B;"),
        ("b.rs", "pub struct B(crate::a::A);"),
    ]);
    assert_eq!(ties, ["a.rs > b.rs: B", "b.rs > a.rs: A"]);
}

#[test]
fn files_that_cfg_chooses_between_are_all_read() {
    let ties = only_circle(&[
        (
            "lib.rs",
            "#[cfg_attr(windows, path = \"other.rs\")]\nmod a;\nmod b;",
        ),
        ("a.rs", "pub struct A;"),
        ("other.rs", "pub struct A(crate::b::B);"),
        ("b.rs", "pub struct B(Box<crate::a::A>);"),
    ]);
    assert_eq!(ties, ["other.rs > b.rs: B", "b.rs > other.rs: A"]);
}

#[test]
fn names_of_values_and_of_other_crates_are_no_edges() {
    no_circle(&[
        LIB,
        (
            "a.rs",
            "use std::fmt;\nuse super::b::*;\npub fn a(b: u8) { let g = b; g + fmt::g() + s.g; }",
        ),
        ("b.rs", "mod inner { pub fn g() {} }\npub use inner::g;"),
    ]);
    no_circle(&[
        ("lib.rs", "mod a;\nmod b;\nuse b::B;"),
        ("a.rs", "pub struct A;"),
        ("b.rs", "use a::A;\npub struct B<A>(A, outside::a::A);"),
    ]);
}

#[test]
fn an_unresolved_path_of_this_crate_is_reported() {
    let survey = survey_files(&[
        LIB,
        ("a.rs", "use crate::b::Missing;\nuse super::b::made::Item;"),
        ("b.rs", "make_items!();"),
    ]);
    let paths: Vec<_> = survey.unresolved.iter().map(|u| u.path.as_str()).collect();
    assert_eq!(paths, ["super::b::made::Item"]);
    let survey = survey_files(&[LIB, ("a.rs", "use crate::b::Missing;"), ("b.rs", "")]);
    let paths: Vec<_> = survey.unresolved.iter().map(|u| u.path.as_str()).collect();
    assert_eq!(paths, ["crate::b::Missing"]);
}

#[test]
fn a_module_without_a_file_is_an_error() {
    let folder = tree(&[("lib.rs", "mod a;")]);
    let error = survey(&folder.path().join("lib.rs")).unwrap_err();
    assert!(matches!(error, Unreadable::NoFile { name, .. } if name == "a"));
    let folder = tree(&[("lib.rs", "fn {")]);
    let error = survey(&folder.path().join("lib.rs")).unwrap_err();
    assert!(matches!(error, Unreadable::NotRust { .. }));
}

/// Returns a workspace of three packages; `upper` has these further lines in its manifest.
fn make_workspace(manifest_lines: &str) -> Vec<Package> {
    let manifest = |name: &str, manifest_lines: &str| {
        format!(
            "[package]\nname = \"{name}\"\nversion = \"0.1.0\"\nedition = \"2024\"\n{manifest_lines}"
        )
    };
    let folder = tree(&[
        (
            "Cargo.toml",
            "[workspace]\nresolver = \"3\"\nmembers = [\"lower\", \"middle\", \"upper\"]",
        ),
        ("lower/Cargo.toml", &manifest("lower", "")),
        ("lower/src/lib.rs", ""),
        ("middle/Cargo.toml", &manifest("middle", "")),
        ("middle/src/lib.rs", ""),
        ("upper/Cargo.toml", &manifest("upper", manifest_lines)),
        ("upper/src/lib.rs", ""),
    ]);
    packages(folder.path()).unwrap()
}

const TABLE: &str = "## Packages\n\n| folder | package | what | pure |\n| --- | --- | --- | --- |\n\
    | `lower/` | `lower` | a | yes |\n| `upper/` | `upper` | a | no |\n\n\
    ## Allowed edges\n| from | may use | its tests too |\n| --- | --- | --- |\n\
    | `lower` | | |\n| `middle` | | |\n| `upper` | `lower` | `middle` |\n\nText with `more`.\n";

fn package_names(package: &str, used: &str) -> (String, String) {
    (package.to_owned(), used.to_owned())
}

#[test]
fn the_tables_are_read() {
    let rows = rows(TABLE, PACKAGES);
    let packages: Vec<_> = rows.iter().map(|row| row.package.as_str()).collect();
    assert_eq!(packages, ["lower", "middle", "upper"]);
    assert_eq!(rows[2].uses, ["lower".to_owned()].into());
    assert_eq!(rows[2].tests_use, ["middle".to_owned()].into());
    assert_eq!(pure_packages(TABLE), ["lower".to_owned()].into());
}

#[test]
fn an_edge_that_the_table_does_not_allow_is_found() {
    let rows = rows(TABLE, PACKAGES);
    let manifest = "[dependencies]\nlower = { path = \"../lower\" }\n\
                   [dev-dependencies]\nmiddle = { path = \"../middle\" }";
    assert_eq!(faults(&rows, &make_workspace(manifest)), []);
    for table in ["dependencies", "build-dependencies"] {
        let edited_manifest = format!("[{table}]\nmiddle = {{ path = \"../middle\" }}");
        let (package, used) = package_names("upper", "middle");
        let problems = faults(&rows, &make_workspace(&edited_manifest));
        assert_eq!(problems, [Fault::NotAllowed { package, used }]);
    }
    let mut strict = rows.clone();
    strict[2].tests_use.clear();
    let (package, used) = package_names("upper", "middle");
    let problems = faults(&strict, &make_workspace(manifest));
    assert_eq!(problems, [Fault::NotAllowedInTests { package, used }]);
}

#[test]
fn a_table_that_does_not_fit_the_workspace_is_found() {
    let (rows, packages) = (rows(TABLE, PACKAGES), make_workspace(""));
    let package = "middle".to_owned();
    let mut shorter_table = rows.clone();
    shorter_table.retain(|row| row.package != package);
    let problems = faults(&shorter_table, &packages);
    assert!(
        problems.contains(&Fault::NotInTable { package }),
        "{problems:?}"
    );

    let mut smaller_workspace = packages.clone();
    smaller_workspace.retain(|package| package.name != "lower");
    let package = "lower".to_owned();
    let problems = faults(&rows, &smaller_workspace);
    assert!(problems.contains(&Fault::NoSuchPackage { package }));

    let repeated_table = [rows.clone(), vec![rows[2].clone()]].concat();
    let package = "upper".to_owned();
    assert_eq!(
        faults(&repeated_table, &packages),
        [Fault::Twice { package }]
    );
}

#[test]
fn an_edge_between_folders_that_no_row_names_is_found() {
    let table = "## Folders\n| folder | may use |\n| --- | --- |\n| `lower` | |\n| `middle` | |\n| `upper` | `lower` |\n";
    let rows = rows(table, FOLDERS);
    let problems = |manifest_lines: &str| {
        let packages = make_workspace(manifest_lines);
        let root = packages[0].folder.parent().unwrap().to_owned();
        faults(&rows, &folders(&rows, &packages, &root).unwrap())
    };
    assert_eq!(
        problems("[dependencies]\nlower = { path = \"../lower\" }"),
        []
    );
    let (package, used) = package_names("upper", "middle");
    let middle = problems("[dependencies]\nmiddle = { path = \"../middle\" }");
    assert_eq!(middle, [Fault::NotAllowed { package, used }]);
}

#[test]
fn a_package_outside_every_folder_of_the_table_is_found() {
    let rows = rows(TABLE, PACKAGES);
    let packages = make_workspace("");
    let root = packages[0].folder.parent().unwrap();
    assert_eq!(folders(&rows[..2], &packages, root).unwrap_err(), "upper");
}

#[test]
fn an_upward_dependency_is_found() {
    let mut rows = rows(TABLE, PACKAGES);
    rows[0].uses.insert("upper".to_owned());
    let (package, used) = package_names("lower", "upper");
    let problems = faults(&rows, &make_workspace(""));
    assert_eq!(problems, [Fault::Upward { package, used }]);
}

#[test]
fn an_oversized_package_and_an_oversized_file_are_found() {
    let ten = "//\n".repeat(10);
    let folder = tree(&[
        ("src/lib.rs", &ten),
        (
            "src/deeper/code.rs",
            "\n\n\n\n#[cfg(test)]\nmod tests {\n    // Not counted.\n}\n",
        ),
        ("src/deeper/tests.rs", &ten),
        ("src/tests/more.rs", &ten),
        ("src/notes.txt", &ten),
        ("target/built.rs", &ten),
    ]);
    let source = folder.path().join("src");
    let too_long = |path, lines, limit| TooLong { path, lines, limit };
    assert_eq!(large_package(&source, 13).unwrap(), None);
    let sizes = large_package(&source, 12).unwrap();
    assert_eq!(sizes, Some(too_long(source.clone(), 13, 12)));
    assert_eq!(long_files(folder.path(), 10).unwrap(), []);
    let sizes = long_files(folder.path(), 9).unwrap();
    let expected = ["deeper/tests.rs", "lib.rs", "tests/more.rs"];
    assert_eq!(
        sizes,
        expected.map(|file| too_long(source.join(file), 10, 9))
    );
}
