//! Serialisation of arrays and matrices of any size.

/// Arrays of complex numbers.
pub(crate) mod complex {
    use num_complex::Complex64;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    pub(crate) fn serialize<S: Serializer, const N: usize>(
        array: &[Complex64; N],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(array)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>, const N: usize>(
        deserializer: D,
    ) -> Result<[Complex64; N], D::Error> {
        let values = Vec::deserialize(deserializer)?;
        <[Complex64; N]>::try_from(values)
            .map_err(|values| D::Error::invalid_length(values.len(), &"a number per parameter"))
    }
}

/// Square matrices that may be missing, by columns.
pub(crate) mod square {
    use nalgebra::SMatrix;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer, const N: usize>(
        matrix: &Option<SMatrix<f64, N, N>>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let columns = matrix.as_ref().map(SMatrix::as_slice);
        columns.serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>, const N: usize>(
        deserializer: D,
    ) -> Result<Option<SMatrix<f64, N, N>>, D::Error> {
        let Some(values) = Option::<Vec<f64>>::deserialize(deserializer)? else {
            return Ok(None);
        };
        if values.len() != N * N {
            let expected = "a number per pair of parameters";
            return Err(D::Error::invalid_length(values.len(), &expected));
        }
        Ok(Some(SMatrix::from_column_slice(&values)))
    }
}
