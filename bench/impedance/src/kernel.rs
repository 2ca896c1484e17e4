//! The inner loops, compiled for several instruction sets and chosen at run time.
//!
//! The chosen version is the same for every call on a machine, so results repeat bit for bit there;
//! between machines with and without fused multiply-add the last bits may differ.

use multiversion::multiversion;
use multiversion::target::target_cfg_f;

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
    let window = |j: usize| &samples[j * step..][..taps_re.len()];
    let whole = re.len() / ABREAST * ABREAST;
    for first in (0..whole).step_by(ABREAST) {
        let windows: [&[f64]; ABREAST] = std::array::from_fn(|i| window(first + i));
        let sums = if fused {
            partial_sums::<true, ABREAST, 2>(windows, taps)
        } else {
            partial_sums::<false, ABREAST, 2>(windows, taps)
        };
        for (i, sums) in sums.into_iter().enumerate() {
            [re[first + i], im[first + i]] = sums.map(total);
        }
    }
    for j in whole..re.len() {
        let [sums] = if fused {
            partial_sums::<true, 1, 2>([window(j)], taps)
        } else {
            partial_sums::<false, 1, 2>([window(j)], taps)
        };
        [re[j], im[j]] = sums.map(total);
    }
}

/// The inner products of one window with several sets of taps, which are filled up with zeros to a multiple of [`LANES`].
pub(crate) fn inner_products<const N: usize>(window: &[f64], taps: [&[f64]; N]) -> [f64; N] {
    lanewise_products(window, taps).map(total)
}

#[multiversion(
    targets("x86_64+avx512f+avx512vl", "x86_64+avx2+fma"),
    dispatcher = "direct"
)]
fn lanewise_products<const N: usize>(window: &[f64], taps: [&[f64]; N]) -> [Lanes; N] {
    if target_cfg_f!(any(target_feature = "fma", target_feature = "avx512f")) {
        partial_sums::<true, 1, N>([window], taps)[0]
    } else {
        partial_sums::<false, 1, N>([window], taps)[0]
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
fn partial_sums<const FUSED: bool, const W: usize, const N: usize>(
    windows: [&[f64]; W],
    taps: [&[f64]; N],
) -> [[Lanes; N]; W] {
    let taps = taps.map(|taps| taps.as_chunks::<LANES>().0);
    let windows = windows.map(|window| window.as_chunks::<LANES>());
    let chunks = windows.map(|(chunks, _)| chunks);
    let whole = chunks.map(<[Lanes]>::len).into_iter().min().unwrap_or(0);
    let mut sums = [[[0.0; LANES]; N]; W];
    for i in 0..whole {
        for w in 0..W {
            for n in 0..N {
                sums[w][n] = multiply_add::<FUSED>(&chunks[w][i], &taps[n][i], &sums[w][n]);
            }
        }
    }
    for w in 0..W {
        let rest = windows[w].1;
        if !rest.is_empty() {
            let mut x = [0.0; LANES];
            x[..rest.len()].copy_from_slice(rest);
            for n in 0..N {
                sums[w][n] = multiply_add::<FUSED>(&x, &taps[n][whole], &sums[w][n]);
            }
        }
    }
    sums
}

fn total(sums: Lanes) -> f64 {
    let quarters: [f64; 4] = std::array::from_fn(|i| sums[i] + sums[i + 4]);
    (quarters[0] + quarters[2]) + (quarters[1] + quarters[3])
}

#[inline(always)]
fn multiply_add<const FUSED: bool>(a: &Lanes, b: &Lanes, c: &Lanes) -> Lanes {
    std::array::from_fn(|i| {
        if FUSED {
            a[i].mul_add(b[i], c[i])
        } else {
            a[i] * b[i] + c[i]
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn wave(n: usize, step: f64) -> Vec<f64> {
        (0..n).map(|i| (i as f64 * step).sin()).collect()
    }

    #[test]
    fn inner_products_agree_with_plain_sums_at_any_length() {
        for length in [1, 7, 8, 9, 79, 99] {
            let window = wave(length, 0.3);
            let mut taps = [wave(length, 0.7), wave(length, 1.1)];
            let plain = taps
                .each_ref()
                .map(|t| t.iter().zip(&window).map(|(t, x)| t * x).sum::<f64>());
            taps.iter_mut()
                .for_each(|t| t.resize(length.next_multiple_of(LANES), 0.0));
            let ours = inner_products(&window, taps.each_ref().map(Vec::as_slice));
            for (ours, plain) in ours.into_iter().zip(plain) {
                assert_relative_eq!(ours, plain, epsilon = 1e-13);
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
