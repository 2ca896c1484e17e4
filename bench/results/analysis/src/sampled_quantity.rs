//! Quantities of the samples of an instance, and their extents.

use serde::{Deserialize, Serialize};

use crate::instance::PreparedInstance;
use crate::method::Method;
use crate::recording_series::EstimateSeries;

/// Quantity of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampledQuantity {
    /// Measured friction.
    Mu,
    /// |Z_m|, N·s/m.
    AbsZM,
    /// Re Z_m, N·s/m.
    ReZM,
    /// |Im Z_m|, N·s/m.
    AbsImZM,
    /// Amplitude of the finger's reaction force (Eq. 10), N.
    ReactionForce,
    /// Mean force of the squeeze film (Eq. 14), N.
    FilmForce,
    /// Contact stiffness, N/m.
    Stiffness,
    /// Levitation gap, m.
    Gap,
    /// Estimated friction.
    MuEstimated,
}

impl SampledQuantity {
    const ALL: [Self; 9] = [
        Self::Mu,
        Self::AbsZM,
        Self::ReZM,
        Self::AbsImZM,
        Self::ReactionForce,
        Self::FilmForce,
        Self::Stiffness,
        Self::Gap,
        Self::MuEstimated,
    ];

    /// Returns its value in the samples of an instance, one by one, as estimated by a method.
    pub fn values<'a>(
        self,
        samples: &'a PreparedInstance,
        method: Method,
        estimate: &'a EstimateSeries,
    ) -> impl Iterator<Item = f64> + 'a {
        let z_m = samples.z_m(method);
        let value = move |k: usize| match self {
            Self::Mu => samples.mu()[k],
            Self::AbsZM => z_m[k].norm(),
            Self::ReZM => z_m[k].re,
            Self::AbsImZM => z_m[k].im.abs(),
            Self::ReactionForce => estimate.motion.reaction_force_n[k].norm(),
            Self::FilmForce => estimate.film_force_n[k],
            Self::Stiffness => estimate.contact.k_c_n_per_m[k],
            Self::Gap => estimate.contact.gap_m[k],
            Self::MuEstimated => estimate.contact.mu[k],
        };
        (0..samples.mu().len()).map(value)
    }
}

/// Least and greatest finite value; NaN without any.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Extent {
    /// Least value.
    pub least: f64,
    /// Greatest value.
    pub greatest: f64,
}

impl Default for Extent {
    fn default() -> Self {
        Self {
            least: f64::NAN,
            greatest: f64::NAN,
        }
    }
}

impl Extent {
    /// Returns the extent of both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            least: other.least.min(self.least),
            greatest: other.greatest.max(self.greatest),
        }
    }

    /// Returns the greatest minus the least value.
    #[must_use]
    pub fn range(self) -> f64 {
        self.greatest - self.least
    }
}

/// Extents of all quantities over the samples of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Extents([Extent; SampledQuantity::ALL.len()]);

impl Extents {
    /// Returns the extents over the samples of an instance, as estimated by a method.
    pub(crate) fn new(
        samples: &PreparedInstance,
        method: Method,
        estimate: &EstimateSeries,
    ) -> Self {
        Self(SampledQuantity::ALL.map(|quantity| {
            let values = quantity.values(samples, method, estimate);
            let finite = values.filter(|value| value.is_finite());
            let point = |value| Extent {
                least: value,
                greatest: value,
            };
            finite.map(point).fold(Extent::default(), Extent::union)
        }))
    }

    /// Returns the extent of a quantity.
    #[must_use]
    pub fn get(&self, quantity: SampledQuantity) -> Extent {
        self.0[quantity as usize]
    }
}
