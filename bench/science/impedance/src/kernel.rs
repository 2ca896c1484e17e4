//! Inner loops, compiled for several instruction sets and selected at run time.
//!
//! The selected version is the same for every call on a machine, so results repeat bit for bit there;
//! between machines with different vector lengths the last bits may differ.
//!
//! A `with_simd` contains only loops and calls of functions that are always inlined: the closure of a `map` over an array would
//! be compiled for the oldest processor.

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

/// Longest vector of all instruction sets in use. The number of taps is a multiple of this.
pub(crate) const LANES: usize = 8;

/// Outputs that are summed in parallel, so that each load of the taps serves them all.
const ABREAST: usize = 4;

/// Decimating FIR with complex taps over real samples: output j is Σ taps\[n\]·samples\[j·step + n\].
pub(crate) struct MixAndDecimate<'a> {
    pub(crate) samples: &'a [f64],
    pub(crate) step: usize,
    /// Real and imaginary parts, their length a multiple of [`LANES`].
    pub(crate) taps: [&'a [f64]; 2],
    /// Real and imaginary parts; their length is the number of outputs.
    pub(crate) outputs: [&'a mut [f64]; 2],
}

impl MixAndDecimate<'_> {
    pub(crate) fn run(self) {
        Arch::new().dispatch(self);
    }
}

impl WithSimd for MixAndDecimate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            samples,
            step,
            taps,
            outputs: [re, im],
        } = self;
        let length = taps[0].len();
        let multiple = re.len() / ABREAST * ABREAST;
        for first in (0..multiple).step_by(ABREAST) {
            let mut windows = [samples; ABREAST];
            for i in 0..ABREAST {
                windows[i] = &samples[(first + i) * step..][..length];
            }
            let products = products(simd, windows, taps);
            for i in 0..ABREAST {
                [re[first + i], im[first + i]] = products[i];
            }
        }
        for j in multiple..re.len() {
            let window = &samples[j * step..][..length];
            [[re[j], im[j]]] = products(simd, [window], taps);
        }
    }
}

/// Returns the inner products of each window with each set of taps, all of the same length, a multiple of [`LANES`].
pub(crate) fn inner_products<const W: usize, const N: usize>(
    windows: [&[f64]; W],
    taps: [&[f64]; N],
) -> [[f64; N]; W] {
    struct Products<'a, const W: usize, const N: usize>([&'a [f64]; W], [&'a [f64]; N]);
    impl<const W: usize, const N: usize> WithSimd for Products<'_, W, N> {
        type Output = [[f64; N]; W];

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            products(simd, self.0, self.1)
        }
    }
    Arch::new().dispatch(Products(windows, taps))
}

#[inline(always)]
fn products<S: Simd, const W: usize, const N: usize>(
    simd: S,
    windows: [&[f64]; W],
    taps: [&[f64]; N],
) -> [[f64; N]; W] {
    let vectors = windows[0].len() / S::F64_LANES;
    let mut window_vectors = [&[][..]; W];
    for w in 0..W {
        window_vectors[w] = &S::as_simd_f64s(windows[w]).0[..vectors];
    }
    let mut tap_vectors = [&[][..]; N];
    for n in 0..N {
        tap_vectors[n] = &S::as_simd_f64s(taps[n]).0[..vectors];
    }
    let mut sums = [[simd.splat_f64s(0.0); N]; W];
    for i in 0..vectors {
        for w in 0..W {
            for n in 0..N {
                sums[w][n] =
                    simd.mul_add_e_f64s(window_vectors[w][i], tap_vectors[n][i], sums[w][n]);
            }
        }
    }
    let mut products = [[0.0; N]; W];
    for w in 0..W {
        for n in 0..N {
            products[w][n] = simd.reduce_sum_f64s(sums[w][n]);
        }
    }
    products
}

/// Multiplies samples by turn·fine, element by element.
pub(crate) fn rotate(
    re: &mut [f64],
    im: &mut [f64],
    fine_re: &[f64],
    fine_im: &[f64],
    turn: Complex64,
) {
    for (((re, im), fine_re), fine_im) in re.iter_mut().zip(im).zip(fine_re).zip(fine_im) {
        let rotation = [
            turn.re * fine_re - turn.im * fine_im,
            turn.re * fine_im + turn.im * fine_re,
        ];
        [*re, *im] = [
            *re * rotation[0] - *im * rotation[1],
            *re * rotation[1] + *im * rotation[0],
        ];
    }
}

/// Appends one channel of interleaved samples. False when any of them is NaN or reaches `level` in magnitude.
pub(crate) struct Deinterleave<'a> {
    pub(crate) interleaved: &'a [f32],
    pub(crate) stride: usize,
    pub(crate) channel: usize,
    pub(crate) level: f32,
    pub(crate) column: &'a mut Vec<f64>,
}

impl Deinterleave<'_> {
    pub(crate) fn run(self) -> bool {
        Arch::new().dispatch(self)
    }
}

impl WithSimd for Deinterleave<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let Self {
            interleaved,
            stride,
            channel,
            level,
            column,
        } = self;
        // Common layouts are handled separately, because the compiler shuffles them instead of gathering.
        let (pairs, _) = interleaved.as_chunks::<2>();
        match (stride, channel) {
            (1, _) => take_column(interleaved.iter().copied(), level, column),
            (2, 0) => take_column(pairs.iter().map(|pair| pair[0]), level, column),
            (2, _) => take_column(pairs.iter().map(|pair| pair[1]), level, column),
            _ => {
                let frames = interleaved.chunks_exact(stride);
                take_column(frames.map(|frame| frame[channel]), level, column)
            }
        }
    }
}

#[inline(always)]
fn take_column(
    column: impl ExactSizeIterator<Item = f32> + Clone,
    level: f32,
    values: &mut Vec<f64>,
) -> bool {
    values.extend(column.clone().map(f64::from));
    // Magnitudes have the order of their bits, with infinity and NaN at the top.
    column.fold(0, |most, x| x.abs().to_bits().max(most)) < level.to_bits()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use pulp::Scalar;

    fn wave(n: usize, step: f64) -> Vec<f64> {
        (0..n).map(|i| (i as f64 * step).sin()).collect()
    }

    #[test]
    fn inner_products_agree_with_plain_sums_on_any_processor() {
        for length in [LANES, 2 * LANES, 10 * LANES] {
            let windows = [wave(length, 0.3), wave(length, 0.4)];
            let taps = [wave(length, 0.7), wave(length, 1.1), wave(length, 1.3)];
            let plain: [[f64; 3]; 2] = windows.each_ref().map(|window| {
                let product = |taps: &Vec<f64>| taps.iter().zip(window).map(|(t, x)| t * x).sum();
                taps.each_ref().map(product)
            });
            let (windows, taps) = (
                windows.each_ref().map(Vec::as_slice),
                taps.each_ref().map(Vec::as_slice),
            );
            for fast in [
                inner_products(windows, taps),
                products(Scalar, windows, taps),
            ] {
                for (fast, plain) in fast.as_flattened().iter().zip(plain.as_flattened()) {
                    assert_relative_eq!(fast, plain, epsilon = 1e-13);
                }
            }
        }
    }

    #[test]
    fn columns_are_taken_and_flaws_seen_in_every_layout() {
        for stride in 1..=5 {
            let take = |interleaved: &[f32], channel, column: &mut Vec<f64>| {
                let level = 0.5;
                Deinterleave {
                    interleaved,
                    stride,
                    channel,
                    level,
                    column,
                }
                .run()
            };
            let interleaved: Vec<f32> = (0..stride * 33).map(|i| i as f32 / 1000.0).collect();
            for channel in 0..stride {
                let mut column = vec![];
                assert!(take(&interleaved, channel, &mut column));
                let expected: Vec<f64> = (0..33)
                    .map(|k| f64::from(((k * stride + channel) as f32) / 1000.0))
                    .collect();
                assert_eq!(column, expected);
                for flaw in [f32::NAN, f32::NEG_INFINITY, 0.5, -0.5] {
                    let mut flawed = interleaved.clone();
                    flawed[20 * stride + channel] = flaw;
                    assert!(!take(&flawed, channel, &mut vec![]));
                    for neighbour in (0..stride).filter(|&neighbour| neighbour != channel) {
                        assert!(take(&flawed, neighbour, &mut vec![]));
                    }
                }
            }
        }
    }
}
