//! `LowPass::zero_phase` in a program that is one codegen unit and calls it once: rustc 1.95 (LLVM 22.1.2) compiled an earlier
//! form of it, a collected chain of three iterators, into writes past the end of the vector. The release's profile
//! compiles this package accordingly; other callers in this program would hide the fault.

use std::hint::black_box;

use impedance::smoothing::LowPass;
use num_complex::Complex64;

/// Number of values, even.
const COUNT: usize = 3400;

#[test]
fn nothing_is_written_past_the_extended_values() {
    // The value must be unknown to the compiler.
    let count = black_box(COUNT);
    let values: Vec<Complex64> = (0..count)
        .map(|k| Complex64::new(5.9 + 0.01 * (k as f64 * 0.37).sin(), -0.1))
        .collect();
    let low_pass = LowPass::new(100.0, 2000.0).unwrap();
    let smooth = low_pass.zero_phase(&values).unwrap();
    // The allocator's own records follow an allocation: damaging them ends the program here.
    let neighbours: Vec<Vec<u8>> = (0..=200)
        .map(|k| vec![k; 100 + 37 * usize::from(k)])
        .collect();
    assert_eq!((smooth.len(), neighbours.len()), (count, 201));
    assert!(smooth.iter().all(|value| (value - values[0]).norm() < 0.02));
}
