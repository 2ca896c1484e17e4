//! Described quantities, and their values in an instance.

use analysis::Analysis;
use analysis::estimate::InstanceAnalysis;
use analysis::findings::RecordingFindings;
use analysis::method::Method;

/// Described quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Measured friction over the first 5 ms of an instance, where the amplitude is least.
    MuAtRest,
    /// Measured friction over its last 5 ms, where the amplitude is greatest.
    MuAtCrest,
    /// Fall of the measured friction from rest to crest, relative to its value at rest.
    Fall,
    /// Levitation gap at the crest, m.
    Gap,
    /// Normal force, mean of the instance, N.
    Force,
    /// Vibration amplitude under the finger at the crest, peak, m.
    Amplitude,
}

/// Names of a quantity's mean and of the ends of its interval in files, each with its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Names {
    /// Name of the value.
    pub value: &'static str,
    /// Name of the lower end of its 95 % interval.
    pub low95: &'static str,
    /// Name of the upper end.
    pub high95: &'static str,
}

impl Quantity {
    /// All quantities, in the order of their display.
    pub const ALL: [Self; 6] = [
        Self::MuAtRest,
        Self::MuAtCrest,
        Self::Fall,
        Self::Gap,
        Self::Force,
        Self::Amplitude,
    ];

    /// Returns its names in files.
    #[must_use]
    pub fn names(self) -> Names {
        let names = |value, low95, high95| Names {
            value,
            low95,
            high95,
        };
        match self {
            Self::MuAtRest => names("mu_at_rest", "mu_at_rest_low95", "mu_at_rest_high95"),
            Self::MuAtCrest => names("mu_at_crest", "mu_at_crest_low95", "mu_at_crest_high95"),
            Self::Fall => names("fall_of_mu", "fall_of_mu_low95", "fall_of_mu_high95"),
            Self::Gap => names(
                "gap_at_crest_m",
                "gap_at_crest_low95_m",
                "gap_at_crest_high95_m",
            ),
            Self::Force => names("normal_n", "normal_low95_n", "normal_high95_n"),
            Self::Amplitude => names(
                "amplitude_at_crest_m",
                "amplitude_at_crest_low95_m",
                "amplitude_at_crest_high95_m",
            ),
        }
    }

    /// Returns its SI unit.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::MuAtRest | Self::MuAtCrest | Self::Fall => "1",
            Self::Gap | Self::Amplitude => "m",
            Self::Force => "N",
        }
    }

    /// Returns its meaning in a phrase.
    #[must_use]
    pub fn meaning(self) -> &'static str {
        match self {
            Self::MuAtRest => {
                "measured friction at rest: mean of the first 5 ms of the instance, where the amplitude is least"
            }
            Self::MuAtCrest => {
                "measured friction at the crest: mean of the last 5 ms of the instance, where the amplitude is greatest"
            }
            Self::Fall => {
                "fall of the measured friction, (mu_at_rest − mu_at_crest)/mu_at_rest of the instance"
            }
            Self::Gap => "estimated levitation gap at the crest",
            Self::Force => "normal force, mean of the instance",
            Self::Amplitude => {
                "vibration amplitude under the finger at the crest, peak; that at the pickup if the plate's profile is not known"
            }
        }
    }

    /// Returns its heading for people, with the unit.
    #[must_use]
    pub fn heading(self) -> &'static str {
        match self {
            Self::MuAtRest => "μ at rest",
            Self::MuAtCrest => "μ at crest",
            Self::Fall => "fall of μ (%)",
            Self::Gap => "gap (µm)",
            Self::Force => "force (N)",
            Self::Amplitude => "amplitude (µm)",
        }
    }

    /// Returns the factor from the SI unit to the unit of its heading.
    #[must_use]
    pub fn factor(self) -> f64 {
        match self {
            Self::Fall => 100.0,
            Self::Gap | Self::Amplitude => 1e6,
            Self::MuAtRest | Self::MuAtCrest | Self::Force => 1.0,
        }
    }

    /// Returns the number of its decimals for people.
    #[must_use]
    pub fn decimals(self) -> usize {
        match self {
            Self::Fall => 1,
            Self::MuAtCrest => 3,
            Self::MuAtRest | Self::Gap | Self::Force | Self::Amplitude => 2,
        }
    }

    /// Returns its value in an instance of a recording, with the gap by `gap_method`; NaN if the instance does not have it, and for
    /// the gap by `trial` where its model does not hold.
    #[must_use]
    pub fn value(
        self,
        recording: &RecordingFindings,
        instance: &InstanceAnalysis,
        gap_method: Method,
    ) -> f64 {
        let mu = instance.mu;
        match self {
            Self::MuAtRest => mu.first,
            Self::MuAtCrest => mu.last,
            Self::Fall => (mu.first - mu.last) / mu.first,
            Self::Gap => {
                let is_in_doubt = gap_method == Method::Trial
                    && recording.trial.as_ref().is_some_and(|fit| !fit.holds());
                let estimate = instance.estimate_by(gap_method).filter(|_| !is_in_doubt);
                estimate.map_or(f64::NAN, |estimate| estimate.estimate.gap_at_crest_m)
            }
            Self::Force => instance.normal_n,
            Self::Amplitude => instance.amplitude_at_crest_m,
        }
    }
}

/// Returns the method of the described gap, the same for all instances: `trial` if any instance has an estimate by it, otherwise
/// `dynamic`.
#[must_use]
pub fn gap_method(analysed: &Analysis) -> Method {
    let mut instances = analysed.instances();
    let has_trial = instances.any(|(_, instance)| instance.estimate(Method::Trial).is_some());
    if has_trial {
        Method::Trial
    } else {
        Method::Dynamic
    }
}
