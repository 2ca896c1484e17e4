//! Names of arrays, columns and elements: `U`, `/U`, `S.F[:,2]`, `group/channel`, a column's name or number, `[:,0]`.

use crate::array::{ArrayInfo, Vector};
use crate::error::SourceFault;
use crate::place::Place;

/// Index of one axis in a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Index {
    /// All of the axis.
    All,
    /// One element of it.
    One(u64),
}

/// Array that a name means, with the indices at the name's end.
struct Named<'a> {
    array: usize,
    info: &'a ArrayInfo,
    indices: Option<Vec<Index>>,
}

/// Finds the vector that `name` means. In a table, the arrays are columns.
pub(crate) fn vector(
    arrays: &[ArrayInfo],
    is_table: bool,
    name: &str,
) -> Result<Vector, SourceFault> {
    let named = find(arrays, is_table, name)?;
    require_values(named.info)?;
    let place = place(&named)?;
    let Named { array, info, .. } = named;
    Ok(Vector {
        name: name.to_owned(),
        array,
        length: info.shape.get(place.axis).copied().unwrap_or(1),
        place,
        element: info.element,
        rate_hz: info.rate_hz,
        start_s: info.start_s,
        unit: info.unit.clone(),
    })
}

/// Single element of an array.
pub(crate) struct Single {
    /// Index of the array.
    pub(crate) array: usize,
    /// Place of a vector that includes it.
    pub(crate) place: Place,
    /// Its index in that vector.
    pub(crate) index: u64,
}

/// Finds the single element that `name` means.
pub(crate) fn single(
    arrays: &[ArrayInfo],
    is_table: bool,
    name: &str,
) -> Result<Single, SourceFault> {
    let Named {
        array,
        info,
        indices,
    } = find(arrays, is_table, name)?;
    let not_scalar = || SourceFault::NotScalar {
        name: name.to_owned(),
        shape: info.shape_text(),
    };
    let Some(indices) = indices else {
        let is_single = info.count() == 1 || !info.element.is_numeric();
        let place = Place {
            axis: 0,
            fixed: vec![0; info.shape.len().saturating_sub(1)],
        };
        return is_single
            .then_some(Single {
                array,
                place,
                index: 0,
            })
            .ok_or_else(not_scalar);
    };
    let ones: Option<Vec<u64>> = indices
        .iter()
        .map(|index| match index {
            Index::One(one) => Some(*one),
            Index::All => None,
        })
        .collect();
    let ones = ones.ok_or_else(not_scalar)?;
    let (place, index) = match (ones.as_slice(), info.long_axis()) {
        // One index of a vector.
        ([one], Some(axis)) => {
            let fixed = vec![0; info.shape.len().saturating_sub(1)];
            (Place { axis, fixed }, *one)
        }
        (all, _) if all.len() == info.shape.len() && !all.is_empty() => {
            let is_within = all
                .iter()
                .zip(&info.shape)
                .all(|(one, length)| one < length);
            if !is_within {
                return Err(selection(info, "the indices are beyond its end"));
            }
            let fixed = all[1..].to_vec();
            (Place { axis: 0, fixed }, all[0])
        }
        _ => return Err(not_scalar()),
    };
    if index >= info.shape.get(place.axis).copied().unwrap_or(1) {
        return Err(selection(info, "the index is beyond its end"));
    }
    Ok(Single {
        array,
        place,
        index,
    })
}

/// Requires that an array has numbers.
pub(crate) fn require_values(info: &ArrayInfo) -> Result<(), SourceFault> {
    if info.element.is_numeric() {
        return Ok(());
    }
    if let (Some(content), Some(remedy)) = (&info.unreadable, info.remedy) {
        let content = format!("`{}`, {content},", info.name);
        return Err(SourceFault::Unread { content, remedy });
    }
    let content = match &info.unreadable {
        Some(class) => format!("an object of the class `{class}`"),
        None => "a text".to_owned(),
    };
    Err(SourceFault::NoValues {
        name: info.name.clone(),
        content,
    })
}

/// Finds the array that a name means.
fn find<'a>(arrays: &'a [ArrayInfo], is_table: bool, name: &str) -> Result<Named<'a>, SourceFault> {
    let plain = plain(name);
    let named = |array: usize, indices| Named {
        array,
        info: &arrays[array],
        indices,
    };
    if let Some(array) = position(arrays, plain) {
        return Ok(named(array, None));
    }
    if let Some((stem, indices)) = with_indices(plain) {
        if let Some(array) = position(arrays, stem) {
            return Ok(named(array, Some(indices)));
        }
        if let ([Index::All, Index::One(column)], true, true) =
            (indices.as_slice(), is_table, stem.is_empty())
            && let Some(array) = column_index(arrays, *column)
        {
            return Ok(named(array, None));
        }
    }
    if let Ok(column) = plain.parse::<u64>() {
        if is_table && let Some(array) = column_index(arrays, column) {
            return Ok(named(array, None));
        }
        if let [info] = arrays
            && info.name.is_empty()
            && info.shape.len() == 2
        {
            return Ok(named(0, Some(vec![Index::All, Index::One(column)])));
        }
    }
    if is_table {
        let mut matches =
            (0..arrays.len()).filter(|array| without_unit(&arrays[*array].name) == plain);
        if let (Some(array), None) = (matches.next(), matches.next()) {
            return Ok(named(array, None));
        }
    }
    Err(SourceFault::NoArray {
        name: name.to_owned(),
        names: nearest(arrays.iter().map(shown_name), plain),
    })
}

/// Returns a name as messages show it.
fn shown_name(info: &ArrayInfo) -> String {
    match (info.name.as_str(), info.shape.len()) {
        ("", 0 | 1) => "[:]".to_owned(),
        ("", _) => "[:,0]".to_owned(),
        (name, _) => name.to_owned(),
    }
}

fn column_index(arrays: &[ArrayInfo], column: u64) -> Option<usize> {
    usize::try_from(column)
        .ok()
        .filter(|column| *column < arrays.len())
}

fn position(arrays: &[ArrayInfo], name: &str) -> Option<usize> {
    arrays.iter().position(|info| plain(&info.name) == name)
}

/// Returns a name without blanks around it and its first `/`.
fn plain(name: &str) -> &str {
    let name = name.trim();
    name.strip_prefix('/').unwrap_or(name)
}

/// Returns a column's name without the unit in brackets at its end.
fn without_unit(name: &str) -> &str {
    let stem = [('[', ']'), ('(', ')')]
        .into_iter()
        .find_map(|(open, close)| {
            let (stem, _) = name.trim_end().strip_suffix(close)?.rsplit_once(open)?;
            Some(stem.trim_end())
        });
    stem.unwrap_or(name)
}

/// Splits the indices off a name.
fn with_indices(name: &str) -> Option<(&str, Vec<Index>)> {
    let (stem, indices) = name.strip_suffix(']')?.rsplit_once('[')?;
    let index = |text: &str| match text.trim() {
        ":" => Some(Index::All),
        number => number.parse().ok().map(Index::One),
    };
    let indices: Option<Vec<Index>> = indices.split(',').map(index).collect();
    Some((stem.trim_end(), indices?))
}

/// Returns the place of the vector that the indices choose.
fn place(named: &Named<'_>) -> Result<Place, SourceFault> {
    let Named { info, indices, .. } = named;
    let whole = info.long_axis().map(|axis| Place {
        axis,
        fixed: vec![0; info.shape.len().saturating_sub(1)],
    });
    let Some(indices) = indices else {
        return whole.ok_or_else(|| selection(info, "no column of it is named"));
    };
    let all = indices.iter().filter(|index| **index == Index::All).count();
    if all != 1 {
        return Err(selection(
            info,
            "the name needs one `:` and one number for each other axis",
        ));
    }
    let is_start = indices
        .iter()
        .all(|index| matches!(index, Index::All | Index::One(0)));
    if let (Some(place), true) = (whole, is_start) {
        // A column, a row and a list are one vector.
        return Ok(place);
    }
    if indices.len() != info.shape.len() {
        return Err(selection(
            info,
            &format!(
                "the name has {} of its {} indices",
                indices.len(),
                info.shape.len()
            ),
        ));
    }
    let mut place = Place::default();
    for (axis, index) in indices.iter().enumerate() {
        match index {
            Index::All => place.axis = axis,
            Index::One(one) if *one < info.shape[axis] => place.fixed.push(*one),
            Index::One(one) => {
                return Err(selection(
                    info,
                    &format!("the index {one} is beyond its end"),
                ));
            }
        }
    }
    Ok(place)
}

fn selection(info: &ArrayInfo, finding: &str) -> SourceFault {
    let indices: Vec<&str> = match info.shape.len() {
        0 | 1 => vec![":"],
        axes => std::iter::once(":")
            .chain(std::iter::repeat_n("0", axes - 1))
            .collect(),
    };
    SourceFault::Selection {
        name: info.name.clone(),
        shape: info.shape_text(),
        selection: finding.to_owned(),
        example: format!("{}[{}]", info.name, indices.join(",")),
    }
}

/// Returns names, the ones most similar to `name` first.
pub(crate) fn nearest(names: impl Iterator<Item = String>, name: &str) -> Vec<String> {
    let likeness = |candidate: &String| {
        let is_part = candidate.contains(name) && !name.is_empty();
        let likeness =
            strsim::normalized_damerau_levenshtein(&candidate.to_lowercase(), &name.to_lowercase());
        f64::from(u8::from(is_part)) + likeness
    };
    let mut names: Vec<_> = names
        .take(MOST_NAMES)
        .map(|name| (likeness(&name), name))
        .collect();
    names.sort_by(|a, b| b.0.total_cmp(&a.0));
    names.into_iter().map(|(_, name)| name).collect()
}

/// Number of names that are compared for a message.
const MOST_NAMES: usize = 1000;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::array::Element;

    fn arrays(shapes: &[(&str, &[u64])]) -> Vec<ArrayInfo> {
        let array = |(name, shape): &(&str, &[u64])| {
            ArrayInfo::new(*name, Element::Float { bits: 64 }, shape.to_vec())
        };
        shapes.iter().map(array).collect()
    }

    fn found(arrays: &[ArrayInfo], name: &str) -> (usize, usize, Vec<u64>, u64) {
        let vector = vector(arrays, false, name).unwrap();
        (
            vector.array,
            vector.place.axis,
            vector.place.fixed,
            vector.length,
        )
    }

    #[test]
    fn names_choose_vectors() {
        let arrays = arrays(&[
            ("U", &[9, 1]),
            ("S.F", &[9, 3]),
            ("g/x", &[9]),
            ("cube", &[2, 3, 4]),
            ("odd[0]", &[1, 5]),
            ("one", &[]),
        ]);
        for name in ["U", "/U", " U ", "U[:]", "U[:,0]", "U[0,:]"] {
            assert_eq!(found(&arrays, name), (0, 0, vec![0], 9), "{name}");
        }
        assert_eq!(found(&arrays, "S.F[:,2]"), (1, 0, vec![2], 9));
        assert_eq!(found(&arrays, "S.F[ 4 , : ]"), (1, 1, vec![4], 3));
        assert_eq!(found(&arrays, "/g/x"), (2, 0, vec![], 9));
        assert_eq!(found(&arrays, "cube[1,:,3]"), (3, 1, vec![1, 3], 3));
        assert_eq!(found(&arrays, "odd[0]"), (4, 1, vec![0], 5));
        assert_eq!(found(&arrays, "one"), (5, 0, vec![], 1));
    }

    #[test]
    fn indices_that_choose_no_vector_are_refused_with_an_example() {
        let arrays = arrays(&[("S.F", &[9, 3]), ("U", &[9])]);
        for (name, words) in [
            ("S.F", "`S.F` is 9 × 3, and no column of it is named"),
            ("S.F[:,3]", "the index 3 is beyond its end"),
            ("S.F[:,:]", "one `:`"),
            ("S.F[1]", "one `:`"),
            ("S.F[:,0,1]", "the name has 3 of its 2 indices"),
        ] {
            let text = vector(&arrays, false, name).unwrap_err().to_string();
            assert!(
                text.contains(words) && text.contains("`S.F[:,0]`"),
                "{text}"
            );
        }
        let text = vector(&arrays, false, "F").unwrap_err().to_string();
        assert_eq!(text, "no array `F` is in it; it has `S.F`, `U`");
    }

    #[test]
    fn columns_of_a_table_have_numbers_and_units() {
        let arrays = arrays(&[("t [s]", &[9]), ("F (N)", &[9]), ("x / mm", &[9])]);
        let column = |name: &str| vector(&arrays, true, name).map(|vector| vector.array);
        for (name, index) in [("t", 0), ("F", 1), ("F (N)", 1), ("1", 1), ("[:,2]", 2)] {
            assert_eq!(column(name), Ok(index), "{name}");
        }
        assert!(column("3").is_err() && column("[:,3]").is_err());
        // A bare array of two axes has columns too.
        let bare = [ArrayInfo::new("", Element::Logical, vec![9, 2])];
        assert_eq!(found(&bare, "1"), (0, 0, vec![1], 9));
        assert_eq!(found(&bare, "[:,1]"), (0, 0, vec![1], 9));
    }

    #[test]
    fn single_numbers_are_elements() {
        let arrays = arrays(&[("fs", &[1, 1]), ("p", &[1, 4]), ("A", &[2, 3])]);
        let element = |name: &str| {
            let single = single(&arrays, false, name).unwrap();
            (
                single.array,
                single.place.axis,
                single.place.fixed,
                single.index,
            )
        };
        assert_eq!(element("fs"), (0, 0, vec![0], 0));
        assert_eq!(element("p[3]"), (1, 1, vec![0], 3));
        assert_eq!(element("p[0,3]"), (1, 0, vec![3], 0));
        assert_eq!(element("A[1,2]"), (2, 0, vec![2], 1));
        for name in ["p", "A", "A[1]", "p[4]", "A[2,0]", "A[:,0]"] {
            assert!(single(&arrays, false, name).is_err(), "{name}");
        }
    }
}
