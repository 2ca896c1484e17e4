//! Checks that the chapter of the columns lists every column that `analyze --tables` writes.

use bench_tests::handbook::folder;

#[test]
fn the_chapter_is_the_dictionary() {
    super::require_same(&folder().join("src/columns.md"), tables::chapter::chapter());
}
