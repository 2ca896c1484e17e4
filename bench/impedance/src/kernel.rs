//! The inner loops, compiled for several instruction sets and chosen at run time.
//!
//! The chosen version is the same for every call on a machine, so results repeat bit for bit there;
//! between machines with and without fused multiply-add the last bits may differ.

use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// Sums kept apart so that the additions do not wait for one another.
const LANES: usize = 8;

/// Decimating FIR with complex taps over real samples: output j is Σ taps[n]·samples[j·step + n].
/// The number of outputs is the length of `re` and `im`.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2+fma"))]
pub(crate) fn mix_and_decimate(
    samples: &[f64],
    step: usize,
    taps_re: &[f64],
    taps_im: &[f64],
    re: &mut [f64],
    im: &mut [f64],
) {
    if target_cfg_f!(any(target_feature = "fma", target_feature = "avx512f")) {
        mix_and_decimate_as::<true>(samples, step, taps_re, taps_im, re, im);
    } else {
        mix_and_decimate_as::<false>(samples, step, taps_re, taps_im, re, im);
    }
}

#[inline(always)]
fn mix_and_decimate_as<const FUSED: bool>(
    samples: &[f64],
    step: usize,
    taps_re: &[f64],
    taps_im: &[f64],
    re: &mut [f64],
    im: &mut [f64],
) {
    for (j, (re, im)) in re.iter_mut().zip(im.iter_mut()).enumerate() {
        let window = &samples[j * step..][..taps_re.len()];
        [*re, *im] = dot::<FUSED, 2>(window, [taps_re, taps_im]);
    }
}

/// The inner products of one window with the value, slope and curvature taps.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2+fma"))]
pub(crate) fn three_dots(window: &[f64], taps: [&[f64]; 3]) -> [f64; 3] {
    if target_cfg_f!(any(target_feature = "fma", target_feature = "avx512f")) {
        dot::<true, 3>(window, taps)
    } else {
        dot::<false, 3>(window, taps)
    }
}

#[inline(always)]
fn dot<const FUSED: bool, const N: usize>(window: &[f64], taps: [&[f64]; N]) -> [f64; N] {
    let mut sums = [[0.0; LANES]; N];
    let whole = window.len() / LANES * LANES;
    let mut at = 0;
    while at < whole {
        let x: &[f64] = &window[at..at + LANES];
        for (sum, taps) in sums.iter_mut().zip(taps) {
            let h = &taps[at..at + LANES];
            for lane in 0..LANES {
                sum[lane] = multiply_add::<FUSED>(x[lane], h[lane], sum[lane]);
            }
        }
        at += LANES;
    }
    let mut out = [0.0; N];
    for ((out, sum), taps) in out.iter_mut().zip(sums).zip(taps) {
        let pairs = [
            sum[0] + sum[4],
            sum[1] + sum[5],
            sum[2] + sum[6],
            sum[3] + sum[7],
        ];
        *out = (pairs[0] + pairs[2]) + (pairs[1] + pairs[3]);
        for (x, h) in window[whole..].iter().zip(&taps[whole..]) {
            *out = multiply_add::<FUSED>(*x, *h, *out);
        }
    }
    out
}

#[inline(always)]
fn multiply_add<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}
