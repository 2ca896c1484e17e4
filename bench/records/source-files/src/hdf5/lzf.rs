//! LZF, the compression that h5py adds to HDF5.

use hdf5_reader::error::{Error, Result};

use hdf5_reader::messages::filter_pipeline::FilterDescription;

/// Number by which HDF5 knows the filter.
pub(crate) const FILTER: u16 = 32000;
/// Longest output of a chunk, bytes.
const MOST_BYTES: usize = 256 << 20;

/// Decompresses a chunk.
pub(crate) fn decompress(
    filter: &FilterDescription,
    compressed: &[u8],
    _element_bytes: usize,
) -> Result<Vec<u8>> {
    // h5py stores the chunk's size as the third number.
    let size = filter.client_data.get(2).copied().unwrap_or(0) as usize;
    let most = if size == 0 {
        MOST_BYTES
    } else {
        size.min(MOST_BYTES)
    };
    expand(compressed, most).ok_or_else(|| Error::DecompressionError("LZF".to_owned()))
}

/// Expands literals and references; `None` if the input ends early, refers to what is not there, or gives more than `most` bytes.
fn expand(input: &[u8], most: usize) -> Option<Vec<u8>> {
    let mut output = Vec::new();
    let mut rest = input.iter().copied();
    while let Some(control) = rest.next() {
        let control = usize::from(control);
        if control < 32 {
            for _ in 0..=control {
                output.push(rest.next()?);
            }
        } else {
            let mut length = control >> 5;
            if length == 7 {
                length += usize::from(rest.next()?);
            }
            let distance = ((control & 31) << 8) + usize::from(rest.next()?) + 1;
            let begin = output.len().checked_sub(distance)?;
            for index in begin..begin + length + 2 {
                output.push(*output.get(index)?);
            }
        }
        if output.len() > most {
            return None;
        }
    }
    Some(output)
}

#[cfg(test)]
mod tests {
    use super::expand;

    #[test]
    fn literals_and_references_expand() {
        // "ab", then 8 bytes from 2 back: "abababab".
        assert_eq!(
            expand(&[1, b'a', b'b', 6 << 5, 1], 100).unwrap(),
            b"ababababab"
        );
        // A long reference: 7 + 3 + 2 bytes from 1 back.
        assert_eq!(expand(&[0, b'x', 7 << 5, 3, 0], 100).unwrap(), [b'x'; 13]);
    }

    #[test]
    fn damaged_input_is_refused() {
        for input in [
            &[5, b'a'][..],
            &[32, 0],
            &[0, b'a', 7 << 5],
            &[0, b'x', 7 << 5, 255, 0],
        ] {
            assert_eq!(expand(input, 20), None, "{input:?}");
        }
    }
}
