//! MATLAB's table of objects: the classes, and the places of the properties, of tables, maps, times and a user's own classes.
//!
//! MathWorks does not document it. Read as [mat-io](https://github.com/foreverallama/matio) describes it: names, then regions of
//! 32-bit numbers, with their offsets at the begin.

/// First number of a variable that is an object.
const MAGIC: u32 = 0xdd00_0000;
/// Bytes before the names.
const HEADER_BYTES: usize = 40;
/// Versions of the table that are read.
const VERSIONS: std::ops::RangeInclusive<u32> = 2..=4;
/// A property with its value in a cell.
const CELL: u32 = 1;
/// Cells before the first property's.
const FIRST_CELL: usize = 2;

/// An object of the table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Object {
    pub(crate) class: String,
    /// Names of the properties, and the numbers of the cells with their values.
    pub(crate) properties: Vec<(String, usize)>,
}

/// Returns the objects of a table, by number; number 0 is unused. `None` for a table of another version, or a damaged one.
pub(crate) fn objects(table: &[u8]) -> Option<Vec<Object>> {
    let word = |index: usize| {
        let bytes = table.get(index.checked_mul(4)?..)?.first_chunk()?;
        Some(u32::from_le_bytes(*bytes))
    };
    if !VERSIONS.contains(&word(0)?) {
        return None;
    }
    let offset = |region: usize| Some(word(2 + region)? as usize);
    let region = |number: usize| {
        let bytes = table.get(offset(number)?..offset(number + 1)?)?;
        let (words, _) = bytes.as_chunks::<4>();
        Some(
            words
                .iter()
                .map(|word| u32::from_le_bytes(*word))
                .collect::<Vec<u32>>(),
        )
    };
    let names = table.get(HEADER_BYTES..offset(0)?)?;
    let names: Vec<String> = names
        .split(|byte| *byte == 0)
        .filter(|name| !name.is_empty())
        .map(|name| String::from_utf8_lossy(name).into_owned())
        .collect();
    let name = |number: u32| names.get((number as usize).checked_sub(1)?).cloned();
    let (classes, returned, objects, own) = (region(0)?, region(1)?, region(2)?, region(3)?);
    let (returned, own) = (blocks(&returned)?, blocks(&own)?);
    let class = |number: u32| {
        let block = classes.as_chunks::<4>().0.get(number as usize)?;
        let class = name(block[1])?;
        Some(match name(block[0]) {
            Some(package) => format!("{package}.{class}"),
            None => class,
        })
    };
    let object = |block: &[u32; 6]| {
        let [number, _, _, saved, normal, _] = *block;
        // An object that its class saves as another value has the property `any`.
        let properties = match saved {
            0 => own.get(normal as usize)?,
            saved => returned.get(saved as usize)?,
        };
        let in_cells = properties.iter().filter(|[_, kind, _]| *kind == CELL);
        let properties =
            in_cells.map(|[key, _, cell]| Some((name(*key)?, *cell as usize + FIRST_CELL)));
        Some(Object {
            class: class(number)?,
            properties: properties.collect::<Option<_>>()?,
        })
    };
    let unused = Object {
        class: String::new(),
        properties: Vec::new(),
    };
    let listed = objects.as_chunks::<6>().0.iter().skip(1);
    // An object that cannot be read leaves the others.
    let listed = listed.map(|block| object(block).unwrap_or_else(|| unused.clone()));
    Some(std::iter::once(unused.clone()).chain(listed).collect())
}

/// Splits a region into blocks of properties, each with its length before it, at even words.
fn blocks(words: &[u32]) -> Option<Vec<Vec<[u32; 3]>>> {
    let mut blocks = Vec::new();
    let mut rest = words;
    while let Some((count, after)) = rest.split_first() {
        let length = (*count as usize).checked_mul(3)?;
        let (triples, _) = after.get(..length)?.as_chunks::<3>();
        blocks.push(triples.to_vec());
        let padded = (1 + length).next_multiple_of(2).min(rest.len());
        rest = rest.get(padded..)?;
    }
    Some(blocks)
}

/// Returns the lengths of the axes and the objects' numbers from the numbers of a variable that is an array of objects.
pub(crate) fn references(numbers: &[f64]) -> Option<(Vec<u64>, Vec<usize>)> {
    let [magic, axes, rest @ ..] = numbers else {
        return None;
    };
    let (shape, rest) = rest.split_at_checked(*axes as usize)?;
    let shape: Vec<u64> = shape.iter().map(|length| *length as u64).collect();
    let count = shape
        .iter()
        .try_fold(1_u64, |count, length| count.checked_mul(*length))?;
    let objects = rest.get(..usize::try_from(count).ok()?)?;
    let is_object = *magic == f64::from(MAGIC);
    is_object.then(|| {
        (
            shape,
            objects.iter().map(|number| *number as usize).collect(),
        )
    })
}

/// Returns the texts in the numbers of MATLAB's class `string`; `None` for another version of it.
pub(crate) fn strings(numbers: &[u64]) -> Option<Vec<String>> {
    let [1, axes, rest @ ..] = numbers else {
        return None;
    };
    let (shape, rest) = rest.split_at_checked(usize::try_from(*axes).ok()?)?;
    let count = shape
        .iter()
        .try_fold(1_u64, |count, length| count.checked_mul(*length))?;
    let (lengths, characters) = rest.split_at_checked(usize::try_from(count).ok()?)?;
    let mut units = characters
        .iter()
        .flat_map(|word| [0, 16, 32, 48].map(|shift| (*word >> shift) as u16));
    let mut strings = Vec::new();
    for length in lengths {
        // Missing strings have a length beyond any other.
        let length = if *length == u64::MAX {
            0
        } else {
            usize::try_from(*length).ok()?
        };
        let text: Vec<u16> = units.by_ref().take(length).collect();
        if text.len() != length {
            return None;
        }
        strings.push(String::from_utf16_lossy(&text));
    }
    Some(strings)
}

#[cfg(test)]
mod tests {
    use super::{Object, objects, references, strings};

    fn table() -> Vec<u8> {
        let names = b"width\0Box\0lab\0any\0str\0";
        let mut names = names.to_vec();
        names.resize(names.len().next_multiple_of(8), 0);
        let regions: [&[u32]; 5] = [
            // Classes: none, lab.Box, str.
            &[0, 0, 0, 0, 3, 2, 0, 0, 0, 5, 0, 0],
            // Returned values: none; any in cell 7.
            &[0, 0, 1, 4, 1, 7],
            // Objects: none; Box with the first own properties; str with the first returned ones.
            &[0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 1, 2, 0, 0, 1, 0, 2],
            // Own properties: none; width in cell 3, and an attribute; of 8 words.
            &[0, 0, 2, 1, 1, 3, 1, 2, 9, 0],
            &[0, 0],
        ];
        let mut offset = 40 + names.len() as u32;
        let mut words = vec![4, 5, offset];
        for region in regions {
            offset += 4 * region.len() as u32;
            words.push(offset);
        }
        words.extend([0, 0]);
        let mut bytes: Vec<u8> = words
            .iter()
            .flat_map(|word: &u32| word.to_le_bytes())
            .collect();
        bytes.truncate(40);
        bytes.extend(names);
        bytes.extend(
            regions
                .iter()
                .flat_map(|words| words.iter())
                .flat_map(|word| word.to_le_bytes()),
        );
        bytes
    }

    #[test]
    fn objects_have_their_classes_and_properties() {
        let objects = objects(&table()).unwrap();
        let object = |class: &str, properties: &[(&str, usize)]| Object {
            class: class.to_owned(),
            properties: properties
                .iter()
                .map(|(name, cell)| ((*name).to_owned(), *cell))
                .collect(),
        };
        assert_eq!(
            objects,
            [
                object("", &[]),
                object("lab.Box", &[("width", 5)]),
                object("str", &[("any", 9)])
            ]
        );
    }

    #[test]
    fn cut_and_foreign_tables_are_refused() {
        let table = table();
        for length in 0..table.len() - 8 {
            let _ = objects(&table[..length]);
        }
        assert_eq!(objects(&[]), None);
        let mut other = table.clone();
        other[0] = 9;
        assert_eq!(objects(&other), None);
        // A block of properties longer than its region.
        let mut other = table;
        let at = other.len() - 4 * 10;
        other[at] = 200;
        assert_eq!(objects(&other), None);
    }

    #[test]
    fn variables_refer_to_objects() {
        let magic = f64::from(super::MAGIC);
        let numbers = [magic, 2.0, 1.0, 2.0, 4.0, 5.0, 1.0];
        assert_eq!(references(&numbers), Some((vec![1, 2], vec![4, 5])));
        assert_eq!(references(&numbers[..5]), None);
        assert_eq!(references(&[1.0, 2.0, 1.0, 1.0, 4.0, 1.0]), None);
    }

    #[test]
    fn strings_are_decoded() {
        let units: Vec<u16> = "hé€llo".encode_utf16().collect();
        let mut words = vec![1, 2, 1, 2, 2, 4];
        for four in units.chunks(4) {
            let word = four
                .iter()
                .rev()
                .fold(0_u64, |word, unit| word << 16 | u64::from(*unit));
            words.push(word);
        }
        assert_eq!(strings(&words).unwrap(), ["hé", "€llo"]);
        assert_eq!(strings(&words[..6]), None);
        assert_eq!(strings(&[2, 2, 0, 0]), None);
    }
}
