//! Places of vectors in arrays.

/// Place of a vector in an array.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Place {
    /// Axis along which it runs.
    pub(crate) axis: usize,
    /// Index on each of the other axes, in their order.
    pub(crate) fixed: Vec<u64>,
}

impl Place {
    /// Returns the offset of the first element and the distance between elements, from the distances along each axis.
    pub(crate) fn offset_and_step(&self, strides: &[u64]) -> (u64, u64) {
        let mut fixed = self.fixed.iter();
        let (mut offset, mut step) = (0u64, 0);
        for (axis, stride) in strides.iter().enumerate() {
            if axis == self.axis {
                step = *stride;
            } else {
                let index = fixed.next().copied().unwrap_or(0);
                offset = offset.saturating_add(index.saturating_mul(*stride));
            }
        }
        (offset, step)
    }
}

/// Returns the distances between elements of `item` bytes along each axis of an array.
pub(crate) fn strides(shape: &[u64], item: u64, is_column_major: bool) -> Vec<u64> {
    let mut strides = vec![0; shape.len()];
    let mut stride = item;
    for i in 0..shape.len() {
        let axis = if is_column_major {
            i
        } else {
            shape.len() - 1 - i
        };
        strides[axis] = stride;
        stride = stride.saturating_mul(shape[axis]);
    }
    strides
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_lie_by_rows_or_by_columns() {
        let shape = [2, 3, 4];
        assert_eq!(strides(&shape, 8, false), [96, 32, 8]);
        assert_eq!(strides(&shape, 8, true), [8, 16, 48]);
        let place = Place {
            axis: 1,
            fixed: vec![1, 3],
        };
        assert_eq!(place.offset_and_step(&[96, 32, 8]), (120, 32));
    }
}
