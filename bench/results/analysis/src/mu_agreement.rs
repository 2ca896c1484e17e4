//! Agreement of estimated with measured friction over all samples of an analysis.

use std::sync::Arc;

use crate::findings::Analysis;
use crate::method::Method;
use crate::recording_series::RecordingSeries;
use crate::sample_statistics::{ByMethod, MuAgreement, estimated_samples};

/// Sums over the samples so far, in their order: first for the mean, then about it.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    samples: usize,
    /// Number of the samples in which both are finite.
    finite: f64,
    mean: f64,
    total_squares: f64,
    residual_squares: f64,
}

/// Reads the agreement by each method, in two passes over the series.
///
/// # Errors
/// The first error of `read`, which returns the series of a recording by its number.
pub(crate) fn read<E>(
    analysed: &Analysis,
    read: &impl Fn(usize) -> Result<Arc<RecordingSeries>, E>,
) -> Result<ByMethod<MuAgreement>, E> {
    let mut sums = ByMethod::<Sums>::default();
    each_pair(analysed, read, |method, (measured, estimated)| {
        let sums = sums.get_mut(method);
        sums.samples += 1;
        if measured.is_finite() && estimated.is_finite() {
            sums.finite += 1.0;
            sums.mean += (measured - sums.mean) / sums.finite;
        }
    })?;
    each_pair(analysed, read, |method, (measured, estimated)| {
        let sums = sums.get_mut(method);
        if measured.is_finite() && estimated.is_finite() {
            sums.total_squares += (measured - sums.mean).powi(2);
            sums.residual_squares += (measured - estimated).powi(2);
        }
    })?;
    Ok(ByMethod::new(|method| {
        let sums = sums.get(method);
        let r2 = 1.0 - sums.residual_squares / sums.total_squares;
        MuAgreement {
            r2: (sums.total_squares > 0.0).then_some(r2),
            samples: sums.samples,
        }
    }))
}

/// Calls `take` with measured and estimated friction of each sample.
fn each_pair<E>(
    analysed: &Analysis,
    read: &impl Fn(usize) -> Result<Arc<RecordingSeries>, E>,
    mut take: impl FnMut(Method, (f64, f64)),
) -> Result<(), E> {
    for (number, findings) in analysed.numbered_findings() {
        if findings.instances.is_empty() {
            continue;
        }
        let series = read(number)?;
        for method in Method::ALL {
            for estimated in estimated_samples(&findings.instances, &series.instances, method) {
                let measured = estimated.instance.samples.mu().iter().copied();
                let pairs = measured.zip(estimated.estimate.contact.mu.iter().copied());
                pairs.for_each(|pair| take(method, pair));
            }
        }
    }
    Ok(())
}
