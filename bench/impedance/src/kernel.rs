//! The inner loops, compiled for several instruction sets and chosen at run time.
//!
//! The chosen version is the same for every call on a machine, so results repeat bit for bit there;
//! between machines with and without fused multiply-add the last bits may differ.

use multiversion::multiversion;
use multiversion::target::target_cfg_f;
use num_complex::Complex64;

/// Sums kept apart so that the additions do not wait for one another. Taps come in multiples of this.
pub(crate) const LANES: usize = 8;
type Lanes = [f64; LANES];

/// Outputs that are summed side by side, so that each load of the taps serves them all.
const ABREAST: usize = 4;

/// Decimating FIR with complex taps over real samples: output j is Σ taps\[n\]·samples\[j·step + n\].
/// The number of outputs is the length of `re` and `im`; the taps' length is a multiple of [`LANES`].
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2+fma"))]
pub(crate) fn mix_and_decimate(
    samples: &[f64],
    step: usize,
    taps_re: &[f64],
    taps_im: &[f64],
    re: &mut [f64],
    im: &mut [f64],
) {
    let fused = target_cfg_f!(any(target_feature = "fma", target_feature = "avx512f"));
    let taps = [taps_re, taps_im];
    let length = taps_re.len();
    let whole = re.len() / ABREAST * ABREAST;
    for first in (0..whole).step_by(ABREAST) {
        let mut windows = [samples; ABREAST];
        for i in 0..ABREAST {
            windows[i] = &samples[(first + i) * step..][..length];
        }
        let products = all_products(fused, windows, taps);
        for i in 0..ABREAST {
            [re[first + i], im[first + i]] = products[i];
        }
    }
    for j in whole..re.len() {
        let window = &samples[j * step..][..length];
        [[re[j], im[j]]] = all_products(fused, [window], taps);
    }
}

/// The inner products of each window with each set of taps, all of one length, a multiple of [`LANES`].
#[multiversion(
    targets("x86_64+avx512f+avx512vl", "x86_64+avx2+fma"),
    dispatcher = "direct"
)]
pub(crate) fn inner_products<const W: usize, const N: usize>(
    windows: [&[f64]; W],
    taps: [&[f64]; N],
) -> [[f64; N]; W] {
    let fused = target_cfg_f!(any(target_feature = "fma", target_feature = "avx512f"));
    all_products(fused, windows, taps)
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
        let by = [
            turn.re * fine_re - turn.im * fine_im,
            turn.re * fine_im + turn.im * fine_re,
        ];
        [*re, *im] = [*re * by[0] - *im * by[1], *re * by[1] + *im * by[0]];
    }
}

/// Appends one channel of interleaved samples. False when any of them is NaN or reaches `level` in magnitude.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2+fma"))]
pub(crate) fn deinterleave(
    interleaved: &[f32],
    stride: usize,
    channel: usize,
    level: f32,
    out: &mut Vec<f64>,
) -> bool {
    match stride {
        // The common layouts, for which the compiler shuffles instead of gathering.
        1 => take_column(
            interleaved.as_chunks::<1>().0.iter().map(|f| f[0]),
            level,
            out,
        ),
        2 if channel == 0 => take_column(
            interleaved.as_chunks::<2>().0.iter().map(|f| f[0]),
            level,
            out,
        ),
        2 => take_column(
            interleaved.as_chunks::<2>().0.iter().map(|f| f[1]),
            level,
            out,
        ),
        _ => take_column(
            interleaved.chunks_exact(stride).map(|f| f[channel]),
            level,
            out,
        ),
    }
}

#[inline(always)]
fn take_column(
    column: impl ExactSizeIterator<Item = f32> + Clone,
    level: f32,
    out: &mut Vec<f64>,
) -> bool {
    out.extend(column.clone().map(f64::from));
    // Magnitudes order as their bits do, with infinity and NaN at the top.
    column.fold(0, |most, x| x.abs().to_bits().max(most)) < level.to_bits()
}

#[inline(always)]
fn all_products<const W: usize, const N: usize>(
    fused: bool,
    windows: [&[f64]; W],
    taps: [&[f64]; N],
) -> [[f64; N]; W] {
    let chunks = windows[0].len() / LANES;
    let taps = taps.map(|taps| &taps.as_chunks::<LANES>().0[..chunks]);
    let windows = windows.map(|window| &window.as_chunks::<LANES>().0[..chunks]);
    let mut sums = [[[0.0; LANES]; N]; W];
    for i in 0..chunks {
        for w in 0..W {
            for n in 0..N {
                sums[w][n] = multiply_add(fused, &windows[w][i], &taps[n][i], &sums[w][n]);
            }
        }
    }
    // Loops instead of `map`, whose closures would not be compiled for the instruction set.
    let mut products = [[0.0; N]; W];
    for w in 0..W {
        for n in 0..N {
            products[w][n] = total(&sums[w][n]);
        }
    }
    products
}

#[inline(always)]
fn total(sums: &Lanes) -> f64 {
    let mut quarters = [0.0; LANES / 2];
    for i in 0..LANES / 2 {
        quarters[i] = sums[i] + sums[i + LANES / 2];
    }
    (quarters[0] + quarters[2]) + (quarters[1] + quarters[3])
}

#[inline(always)]
fn multiply_add(fused: bool, a: &Lanes, b: &Lanes, c: &Lanes) -> Lanes {
    let mut sums = *c;
    for i in 0..LANES {
        sums[i] = if fused {
            a[i].mul_add(b[i], c[i])
        } else {
            a[i] * b[i] + c[i]
        };
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn wave(n: usize, step: f64) -> Vec<f64> {
        (0..n).map(|i| (i as f64 * step).sin()).collect()
    }

    #[test]
    fn inner_products_agree_with_plain_sums() {
        for length in [LANES, 2 * LANES, 10 * LANES] {
            let windows = [wave(length, 0.3), wave(length, 0.4)];
            let taps = [wave(length, 0.7), wave(length, 1.1), wave(length, 1.3)];
            let ours = inner_products(
                windows.each_ref().map(Vec::as_slice),
                taps.each_ref().map(Vec::as_slice),
            );
            for (window, ours) in windows.iter().zip(ours) {
                for (taps, ours) in taps.iter().zip(ours) {
                    let plain: f64 = taps.iter().zip(window).map(|(t, x)| t * x).sum();
                    assert_relative_eq!(ours, plain, epsilon = 1e-13);
                }
            }
        }
    }

    #[test]
    fn columns_are_taken_and_flaws_seen_in_every_layout() {
        for stride in 1..=5 {
            let interleaved: Vec<f32> = (0..stride * 33).map(|i| i as f32 / 1000.0).collect();
            for channel in 0..stride {
                let mut out = vec![];
                assert!(deinterleave(&interleaved, stride, channel, 0.5, &mut out));
                let expected: Vec<f64> = (0..33)
                    .map(|k| f64::from(((k * stride + channel) as f32) / 1000.0))
                    .collect();
                assert_eq!(out, expected);
                for flaw in [f32::NAN, f32::NEG_INFINITY, 0.5, -0.5] {
                    let mut flawed = interleaved.clone();
                    flawed[20 * stride + channel] = flaw;
                    assert!(!deinterleave(&flawed, stride, channel, 0.5, &mut vec![]));
                    for other in (0..stride).filter(|&other| other != channel) {
                        assert!(deinterleave(&flawed, stride, other, 0.5, &mut vec![]));
                    }
                }
            }
        }
    }
}
